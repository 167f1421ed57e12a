"""Parking cases that nobody would draw: an answer that passes the judge anew, a refusal, or one sentence."""

from __future__ import annotations

import contextlib
from typing import Any

import numpy as np

from benchmarks.attack.strategies import EXTREMES, NOT_FINITE
from benchmarks.attack.tally import Tally, all_finite
from mcdas_opt import ParkingCase, ParkSettings, park
from mcdas_opt.domain.parking import ParkingLimits, ParkingTolerance
from mcdas_opt.domain.rules import Array
from mcdas_opt.errors import McdasError
from mcdas_opt.parking.park import PLANNERS
from mcdas_opt.verification.parking_judge import judge_parking

_BUDGET_S, _MOST_S = 2.0, 20.0  # of a search; of an answer: its last step may take a while
_HOSTILE = (*EXTREMES, *NOT_FINITE)


def attack(tally: Tally, count: int, seed: int) -> None:
    for k in range(count):
        numbers = np.random.default_rng([seed, k])
        with np.errstate(all="ignore"):
            asked, planner = _case(numbers), str(numbers.choice(PLANNERS))
        case = tally.ask(lambda asked=asked: ParkingCase(**asked), lambda asked=asked: repr(asked))
        if case is None:
            continue
        parking = tally.ask(
            lambda case=case, planner=planner: park(case, planner, settings=ParkSettings(time_budget_s=_BUDGET_S)),
            lambda case=case, planner=planner: f"{planner}: {case!r}",
            most_s=_MOST_S,
        )
        if parking is None:
            continue
        if not all_finite(parking.to_dict()):
            tally.non_finite += 1
            tally.note(f"{planner}: a number that is not finite left", repr(case))
        elif parking.status == "planned" and not judge_parking(case, parking.trajectory.moved(*(-q for q in case.origin_m))).verdict.passed:
            tally.unverified += 1
            tally.note(f"{planner}: unverified, called planned", repr(case))


def _case(numbers: np.random.Generator) -> dict[str, Any]:
    def number(low: float, high: float) -> float:
        return float(numbers.choice(_HOSTILE)) if numbers.integers(40) == 0 else float(numbers.uniform(low, high))

    def obstacle() -> Array:
        x, y, long, wide = number(-12.0, 12.0), number(-8.0, 8.0), number(0.0, 6.0), number(0.0, 3.0)
        box = np.array([(x, y), (x + long, y), (x + long, y + wide), (x, y + wide)])
        match int(numbers.integers(6)):
            case 0:
                return np.array([(number(-12.0, 12.0), number(-8.0, 8.0)) for _ in range(int(numbers.integers(1, 7)))])
            case 1:
                return box[::-1]
            case 2:
                return np.repeat(box[:1], 4, axis=0)
            case 3:
                turn = np.linspace(0.0, 2.0 * np.pi, int(numbers.integers(3, 60)), endpoint=False)
                return box[:1] + long * np.column_stack([np.cos(turn), np.sin(turn)])
            case _:
                return box

    asked: dict[str, Any] = {
        "start": [number(-8.0, 8.0), number(-5.0, 5.0), number(-3.5, 3.5)],
        "goal": [number(-4.0, 4.0), number(-3.0, 3.0), number(-3.5, 3.5)],
        "obstacles": tuple(obstacle() for _ in range(int(numbers.integers(0, 6)))),
        "start_steering_rad": number(-0.5, 0.5),
        "origin_m": (number(-10.0, 10.0), number(-10.0, 10.0)),
    }
    for name, record in (("limits", ParkingLimits), ("tolerance", ParkingTolerance)):
        if numbers.integers(4) == 0:
            with contextlib.suppress(McdasError):
                asked[name] = record(**{str(numbers.choice(sorted(record.__dataclass_fields__))): number(1e-3, 3.0)})
    return asked
