"""Parts that are found by name: ours, those that installed packages register by entry point, and anybody's as "module:attribute"."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import entry_points
from typing import Any

from mcdas_opt.errors import McdasError, ParameterError, nearest


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
        """The object behind a name, or behind "module:attribute". Raises `ParameterError` that names the nearest known one or says what
        cannot be imported, and what a module raises while it is imported."""
        if name in self.own:
            return imported(self.own[name])
        if ":" in name:
            return self._imported(name)
        point = next((p for p in entry_points(group=self.group) if p.name == name), None)
        if point is None:
            raise ParameterError(self.what, name, f"is not a known {self.what}; {nearest(name, self.known())}")
        try:
            return point.load()
        except McdasError:  # of a part of ours that lacks an extra
            raise
        except Exception as error:
            rule = f"is registered as {point.value!r}, which cannot be imported: {_words(error)}"
            raise ParameterError(self.what, name, rule) from error

    def _imported(self, name: str) -> Any:
        try:
            return imported(name)
        except McdasError:
            raise
        except Exception as error:
            raise ParameterError(self.what, name, f"must be module:attribute of a module that can be imported: {_words(error)}") from error


def imported(name: str) -> Any:
    """What "module:attribute" names."""
    module, _, attribute = name.partition(":")
    return getattr(import_module(module), attribute)


def _words(error: Exception) -> str:
    """What Python says; that a module raised something of its own is said too."""
    return str(error) if isinstance(error, (ImportError, AttributeError, ValueError)) else f"it raised {type(error).__name__}: {error}"


def importable(what: str, kind: type) -> str:
    """The "module:attribute" by which another process finds a class. Raises `ParameterError` for one inside a function or another class, or
    in the program that runs."""
    name = f"{kind.__module__}:{kind.__qualname__}"
    if kind.__module__ == "__main__" or "." in kind.__qualname__:
        raise ParameterError(what, name, "must be a class at the top level of a module that other processes can import: put it into a file")
    return name
