"""Edits of a scene, as the keys of its file with new values; and what was edited, so that it can be undone."""

from __future__ import annotations

import json
import re
from collections import deque
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Generic, Self, TypeVar

from mcdas_opt.catalogue.scene_file import scene_document
from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.errors import ParameterError
from mcdas_opt.studio.knobs import BY_KEY, turned

_MOST_STEPS = 100
_MOST_CARS = 100
LARGEST_SCENE = 100_000  # characters, as JSON; a hundred cars that each do three things need 30,000
_MOST_ACTIONS = 100  # a page that is answered has one or two
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
    return made


def check_size(document: Mapping[str, Any]) -> None:
    """Raises `ParameterError` for a scene's document with more cars, or of more text, than is quickly shown and edited; it is not yet
    checked to be a scene."""
    cars = document.get("neighbour")
    if isinstance(cars, list) and len(cars) > _MOST_CARS:
        raise ParameterError("neighbour", len(cars), f"are more cars than the studio's {_MOST_CARS}")
    size = len(json.dumps(document, default=str))
    if size > LARGEST_SCENE:
        raise ParameterError("scene", size, f"is more than the {LARGEST_SCENE} characters that the studio takes")


class WaitingEdits:
    """What a page did and is not done yet, in order. A later step of a drag takes the place of the one before, which nobody saw.

    One thread adds, another takes.
    """

    def __init__(self) -> None:
        self._actions: deque[Mapping[str, Any]] = deque()

    def __len__(self) -> int:
        return len(self._actions)

    def add(self, actions: Sequence[object]) -> None:
        """Raises `ParameterError` where there are too many; then none of them is added."""
        if len(actions) + len(self) > _MOST_ACTIONS:
            raise ParameterError("actions", len(actions) + len(self), f"are more edits than the {_MOST_ACTIONS} that may wait to be done")
        for action in actions:
            newer = action if isinstance(action, Mapping) else {}
            with suppress(IndexError):
                older = self._actions.pop()
                if not _superseded(older, newer):
                    self._actions.append(older)
            self._actions.append(newer)

    def take(self) -> Mapping[str, Any] | None:
        """The next one; None where all are done."""
        try:
            return self._actions.popleft()
        except IndexError:
            return None


def _superseded(older: Mapping[str, Any], newer: Mapping[str, Any]) -> bool:
    """Whether nothing of an edit is left after the next one: both are of one stroke and set the same keys."""
    before, after = older.get("changes"), newer.get("changes")
    if older.get("do") != "edit" or newer.get("do") != "edit" or not isinstance(before, Mapping) or not isinstance(after, Mapping):
        return False
    stroke = newer.get("stroke")
    return stroke is not None and older.get("stroke") == stroke and before.keys() == after.keys() and None not in before.values()


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
