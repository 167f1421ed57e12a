"""A glance before the judge: whatever plainly hits somebody needs no exact verdict, unless it is to leave."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.verdict import Verdict, Violation
from mcdas_opt.planning.selection import Nearness, nearness
from mcdas_opt.verification.judge import judge_all

PLAINLY_M = 0.1  # an overlap at a drive's own samples that no rounding explains


def verdicts(
    drives: Sequence[Trajectory], situation: Situation, vehicle: Vehicle, prediction: Prediction, near: Sequence[Nearness] | None = None
) -> list[Verdict]:
    """The judge's verdicts on drives that are sampled at the same times, but for those that plainly hit somebody: of these the collisions
    at their samples, and nothing else that may be wrong with them. Nothing passes but what the judge passes.

    `near` is their `nearness`, where that is known already.
    """
    near = nearness(drives, vehicle, situation.road, prediction) if near is None else near
    seen = [_collisions(drive, one, prediction) for drive, one in zip(drives, near, strict=True)]
    open_questions = [drive for drive, verdict in zip(drives, seen, strict=True) if verdict.passed]
    answers = iter(judge_all(open_questions, situation.host, vehicle, situation.road, prediction))
    return [next(answers) if verdict.passed else verdict for verdict in seen]


def _collisions(drive: Trajectory, near: Nearness, prediction: Prediction) -> Verdict:
    """Whom it plainly hits, since when, and how deep."""
    deepest = near.separation_m.min(axis=-1)
    if not deepest.size or deepest.min() >= -PLAINLY_M:
        return Verdict()
    return Verdict(
        violations=tuple(
            Violation(
                name=f"collision with {prediction.bodies[i].id}",
                t_s=float(drive.t_s[int(np.argmax(near.separation_m[i] < 0.0))]),
                value=float(deepest[i]),
                limit=0.0,
                unit="m",
            )
            for i in np.flatnonzero(deepest < -PLAINLY_M).tolist()
        )
    )
