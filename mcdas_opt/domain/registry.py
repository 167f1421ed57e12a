"""Parts that are found by name: ours, and those that installed packages register by entry point."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import entry_points
from typing import Any

from mcdas_opt.errors import ParameterError, nearest


@dataclass(frozen=True, slots=True, kw_only=True)
class Registry:
    """Parts of one kind. `group` is the entry points' group, `what` the word for a part, `own` each of ours as "module:attribute", which
    loads without asking the installed packages."""

    group: str
    what: str
    own: Mapping[str, str]

    def known(self) -> tuple[str, ...]:
        """Every name, in alphabetical order."""
        return tuple(sorted({*self.own, *(point.name for point in entry_points(group=self.group))}))

    def load(self, name: str) -> Any:
        """The object behind a name. Raises `ParameterError` that names the nearest known one, and what an entry point's import raises."""
        if name in self.own:
            module, _, attribute = self.own[name].partition(":")
            return getattr(import_module(module), attribute)
        point = next((p for p in entry_points(group=self.group) if p.name == name), None)
        if point is None:
            raise ParameterError(self.what, name, f"is not a known {self.what}; {nearest(name, self.known())}")
        return point.load()
