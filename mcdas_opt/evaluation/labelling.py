"""The oracle's labels of a suite's scripted scenes, as records of the run that asks for them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.evaluation.case import Case
from mcdas_opt.evaluation.labels import label_scene


def wants_label(case: Case) -> bool:
    """Only scripts can be labelled: what reacts to the host is not known beforehand."""
    return case.labelled and all(part.behaviour == "scripted" for part in case.scene.neighbour)


def label_chunk(scenes: Sequence[Scene], reaction_s: float) -> list[dict[str, Any]]:
    """A letter and an onset for each scene."""
    found = (label_scene(scene, reaction_s) for scene in scenes)
    return [{"label": one.kind.value, "onset_s": round(one.onset_s, 3)} for one in found]
