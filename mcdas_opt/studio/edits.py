"""Edits of a scene, as the keys of its file with new values; and what was edited, so that it can be undone."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Generic, Self, TypeVar

from mcdas_opt.catalogue.scene_file import scene_document
from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.errors import ParameterError
from mcdas_opt.studio.knobs import BY_KEY, turned

_MOST_STEPS = 100
_MOST_CARS = 100
_KEY = re.compile(r"[a-z_0-9]+(\[\d{1,4}\])?(\.[a-z_0-9]+(\[\d{1,4}\])?)*")
State = TypeVar("State")


@dataclass(frozen=True, slots=True, kw_only=True)
class History(Generic[State]):
    """What is shown, what was before (oldest first), and what was undone (next first)."""

    present: State
    past: tuple[State, ...] = ()
    future: tuple[State, ...] = ()
    stroke: object = None

    def then(self, state: State, stroke: object = None) -> Self:
        """One step on. A step of the same stroke as the last one, as of a drag, takes its place."""
        past = self.past if stroke is not None and stroke == self.stroke else (*self.past, self.present)[-_MOST_STEPS:]
        return replace(self, present=state, past=past, future=(), stroke=stroke)

    def undone(self) -> Self:
        if not self.past:
            return self
        return replace(self, present=self.past[-1], past=self.past[:-1], future=(self.present, *self.future), stroke=None)

    def redone(self) -> Self:
        if not self.future:
            return self
        return replace(self, present=self.future[0], past=(*self.past, self.present), future=self.future[1:], stroke=None)


def edited(scene: Scene, changes: Mapping[str, object]) -> dict[str, Any]:
    """The document of the scene with other values of its keys, as its file's errors name them (`neighbour[0].s_m`), or of sliders.

    None takes a key away, or one of a list; the number after a list's last adds to it. The document is not yet checked to be a scene.
    Raises `ParameterError`.
    """
    sliders = {key: value for key, value in changes.items() if key in BY_KEY}
    made = turned(scene, scene_document(scene), sliders)
    for key, value in changes.items():
        if key not in sliders:
            _put(made, key, value)
    if isinstance(made.get("neighbour"), list) and len(made["neighbour"]) > _MOST_CARS:
        raise ParameterError("neighbour", len(made["neighbour"]), f"are more cars than the studio's {_MOST_CARS}")
    return made


def _put(document: Any, key: str, value: object) -> None:
    if not isinstance(key, str) or not _KEY.fullmatch(key):
        raise ParameterError("key", key, "is no key of a scene")
    path = [int(part) if part.isdigit() else part for part in re.findall(r"[^.\[\]]+", key)]
    last, here = path[-1], document
    for part, following in pairwise(path):
        empty: Any = [] if isinstance(following, int) else {}
        if isinstance(here, dict):
            here = here.setdefault(part, empty)
        elif isinstance(here, list) and isinstance(part, int) and part < len(here):
            here = here[part]
        else:
            raise ParameterError("key", key, "is no key of this scene")
    if isinstance(here, dict) and isinstance(last, str):
        if value is None:
            here.pop(last, None)
        else:
            here[last] = value
    elif isinstance(here, list) and isinstance(last, int) and last <= len(here):
        here[last : last + 1] = [] if value is None else [value]
    else:
        raise ParameterError("key", key, "is no key of this scene")
