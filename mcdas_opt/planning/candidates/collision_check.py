"""The collision pre-check before the judge: whatever plainly hits somebody needs no exact verdict, unless it is to leave."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.verdict import Verdict, Violation, ViolationKind
from mcdas_opt.planning.candidate import Checked
from mcdas_opt.planning.candidates.nearness import Nearness, nearness
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.verification.judge import judge, judge_all

CERTAIN_M = 0.1  # an overlap at a drive's own samples that no rounding explains


def verdicts(drives: Sequence[Trajectory], cycle: Cycle, near: Nearness | None = None) -> list[Verdict]:
    """The judge's verdicts on drives that are sampled at the same times, but for those that plainly hit somebody: of these the collisions
    at their samples, and nothing else that may be wrong with them. Nothing passes but what the judge passes.

    `near` is their `nearness`, where that is known already.
    """
    if not drives:
        return []
    near = nearness(drives, cycle) if near is None else near
    hit_somebody = [any(depth < -CERTAIN_M for depth in deepest) for deepest in near.deepest_m.tolist()]
    open_questions = [drive for drive, hit in zip(drives, hit_somebody, strict=True) if not hit]
    situation, prediction = cycle.situation, cycle.prediction
    answers = iter(judge_all(open_questions, situation.host, cycle.vehicle, situation.road, prediction))
    return [_collisions(drives[i], i, near, prediction) if hit else next(answers) for i, hit in enumerate(hit_somebody)]


def judged(drive: Trajectory, cycle: Cycle) -> Verdict:
    """The judge's own verdict, whatever it plainly hits."""
    return judge(drive, cycle.situation.host, cycle.vehicle, cycle.situation.road, cycle.prediction)


def exact(checked: Checked, cycle: Cycle) -> Checked:
    """With that verdict: until then the pre-check was enough."""
    return replace(checked, verdict=judged(checked.trajectory, cycle))


def hits(drive: Trajectory, cycle: Cycle, samples: int) -> bool:
    """Whether a drive plainly hits somebody within its first so many samples."""
    return bool((nearness((drive,), cycle).separation_m[..., :samples] < -CERTAIN_M).any())


def _collisions(drive: Trajectory, which: int, near: Nearness, prediction: Prediction) -> Verdict:
    """Whom it plainly hits, since when, and how deep."""
    separation, deepest = near.separation_m[which], near.deepest_m[which]
    found = [
        Violation(
            kind=ViolationKind.COLLISION,
            body=prediction.bodies[i].id,
            t_s=float(drive.t_s[int(np.argmax(separation[i] < 0.0))]),
            value=float(deepest[i]),
            limit=0.0,
            unit="m",
        )
        for i in np.flatnonzero(deepest < -CERTAIN_M).tolist()
    ]
    return Verdict(violations=tuple(sorted(found, key=lambda one: (one.t_s, one.value))))
