"""Was it avoidable? A label for every scene, before any planner has driven it; and as records of the run that asks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from functools import partial
from typing import Any

from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.domain.prediction import PredictedBody
from mcdas_opt.domain.rules import non_negative
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.evaluation.case import Case
from mcdas_opt.evaluation.certificate import closes_at
from mcdas_opt.evaluation.optimised_witness import optimised_witness_from
from mcdas_opt.evaluation.oracle import (
    REACTION_S,
    finer_witness_from,
    lane_kept_until,
    onset_s,
    refuse_reacting,
    seen_from,
    start_s,
    unbraked,
    witness_from,
)
from mcdas_opt.simulation.neighbours import known_bodies

REACTIONS_S = (0.2, 0.75)  # an alert automaton; the competent driver of UN R157
ROOM_M = 0.1  # about what the suites' radars are unsure of somebody's place across the road
_LIBRARY: tuple[tuple[str, _Search], ...] = (("library", witness_from),)
_FINER: tuple[tuple[str, _Search], ...] = (("finer library", finer_witness_from),)
_LAST: tuple[tuple[str, _Search], ...] = (("nonlinear program", optimised_witness_from),)


class Kind(StrEnum):
    """`A`: a witness that acts no earlier than the reaction time after onset is safe whether the rear car brakes later or not. `C`:
    nobody could do that, but who knows the script could avoid it. `U`: nobody could at all. `?`: neither found nor refuted."""

    A = "A"
    C = "C"
    U = "U"
    UNDECIDED = "?"


@dataclass(frozen=True, slots=True, kw_only=True)
class Label:
    """`how` names the stage that decided, `reason` says it in words. `witness` is the drive from the scene's start that proves A (or
    the half of C that can be shown by driving), None otherwise; it does not take part in comparisons nor in documents."""

    kind: Kind
    reaction_s: float
    onset_s: float
    how: str
    reason: str
    witness: Trajectory | None = field(default=None, repr=False, compare=False)


_Bodies = tuple[PredictedBody, ...]
_Search = Callable[[Scene, float, _Bodies], tuple[Trajectory | None, int]]


def label_scene(scene: Scene, reaction_s: float = REACTION_S) -> Label:
    """The label of one scene of scripted or recorded neighbours, judged with the true friction. Raises `ParameterError` when somebody
    reacts to the host."""
    refuse_reacting(scene)
    non_negative("reaction_s", reaction_s, "s")
    onset = onset_s(scene)
    scripted, every = known_bodies(scene), (*known_bodies(scene), *unbraked(scene))
    finish = partial(Label, reaction_s=reaction_s, onset_s=onset)
    start = start_s(scene, onset, reaction_s)

    def avoidable(how: str, acts_s: float, witness: Trajectory) -> Label:
        return finish(kind=Kind.A, how=how, reason=f"a drive that changes nothing before {acts_s:.2f} s is safe", witness=witness)

    found = _first(_LIBRARY, scene, start, every)
    if found is not None:
        return avoidable(found[0], start, found[1])
    closes = closes_at(scene.host_state, scene.vehicle, scene.true_road, scripted, scene.duration_s)
    if closes is not None:
        return finish(kind=Kind.U, how="certificate", reason=f"by {closes:.2f} s even a point mass with more grip has met somebody")
    later = closes_at(lane_kept_until(scene, start), scene.vehicle, scene.true_road, seen_from(every, start), scene.duration_s - start)
    if later is None:
        later_starts = [start_s(scene, onset, reaction) for reaction in REACTIONS_S if reaction > reaction_s]
        for acts_s, stages in ((start, _FINER), *((late, _LIBRARY + _FINER) for late in later_starts), (start, _LAST)):
            found = _first(stages, scene, acts_s, every)
            if found is not None:
                return avoidable(found[0], acts_s, found[1])
    known = _first(_LIBRARY + _FINER + _LAST, scene, 0.0, scripted)
    if later is None:
        how = "by reacting neither found nor refuted; by knowing the script " + ("found" if known else "not found either")
        return finish(kind=Kind.UNDECIDED, how="none", reason=how)
    if known is None:
        return finish(kind=Kind.UNDECIDED, how="none", reason="not avoidable by reacting; by knowing the script neither found nor refuted")
    how = f"who acts at {start:.2f} s has met somebody by {start + later:.2f} s; who acts at once and knows the script has not"
    return finish(kind=Kind.C, how=f"certificate and {known[0]}", reason=how, witness=known[1])


def with_room(scene: Scene, room_m: float = ROOM_M) -> Scene:
    """The scene with everybody larger by so much on each side: a drive that is safe in it leaves that much room in the scene."""
    more = 2.0 * room_m
    larger = [part.model_copy(update={"length_m": part.length_m + more, "width_m": part.width_m + more}) for part in scene.neighbour]
    return scene.model_copy(update={"neighbour": larger})


def _first(stages: tuple[tuple[str, _Search], ...], scene: Scene, acts_s: float, bodies: _Bodies) -> tuple[str, Trajectory] | None:
    """The first stage that finds a witness, and the witness."""
    for name, search in stages:
        witness, _ = search(scene, acts_s, bodies)
        if witness is not None:
            return name, witness
    return None


def wants_label(case: Case) -> bool:
    """Only scripts can be labelled: what reacts to the host is not known beforehand."""
    return case.labelled and all(part.behaviour == "scripted" for part in case.scene.neighbour)


def label_chunk(scenes: Sequence[Scene], reaction_s: float) -> list[dict[str, Any]]:
    """A letter and an onset for each scene; of the lesser reaction time, the letter with room besides."""
    found = []
    for scene in scenes:
        label = label_scene(scene, reaction_s)
        record = {"label": label.kind.value, "onset_s": round(label.onset_s, 3)}
        if reaction_s == REACTIONS_S[0]:
            record["with_room"] = (label_scene(with_room(scene), reaction_s) if label.kind is Kind.A else label).kind.value
        found.append(record)
    return found
