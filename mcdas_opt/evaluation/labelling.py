"""The oracle's labels of a suite, made before any planner drives, and what they are afterwards joined to."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.evaluation.case import Case
from mcdas_opt.evaluation.oracle import REACTION_S, Avoidable, label

REACTIONS_S = (0.2, 0.75)  # the second is the competent driver's of UN R157
LETTERS = ("A", "C", "U", "?")
_LETTER = {Avoidable.YES: "A", Avoidable.BY_KNOWING: "C", Avoidable.UNKNOWN: "?"}


def wants_label(case: Case) -> bool:
    """Only scripts can be labelled: what reacts to the host is not known beforehand."""
    return case.labelled and all(part.behaviour == "scripted" for part in case.scene.neighbour)


def label_chunk(scenes: Sequence[Scene], reaction_s: float) -> list[dict[str, Any]]:
    """A letter and an onset for each scene."""
    if reaction_s != REACTION_S:
        return [{"label": "?", "onset_s": 0.0} for _ in scenes]
    found = [label(scene) for scene in scenes]
    return [{"label": _LETTER[one.avoidable], "onset_s": round(one.onset_s, 3)} for one in found]
