"""The closed forms: the paper as published, never repaired, and the corrected path driven by the bicycle."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain, islice

import numpy as np

from mcdas_opt.actuation.path_following import SpeedLaw
from mcdas_opt.domain.assessment import Assessment
from mcdas_opt.domain.plan import Candidate, Plan, Refusal, Timing
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.verdict import Verdict
from mcdas_opt.domain.vocabulary import Mode, Request, Side
from mcdas_opt.errors import ParameterError
from mcdas_opt.planning.glance import verdicts
from mcdas_opt.planning.path_driving import follow
from mcdas_opt.planning.selection import WorthSettings, worth
from mcdas_opt.planning.ways import Manoeuvre, Way, continued, keeping_way, lateral_bound_mps2, shorter_side, ways_out
from mcdas_opt.reference.literal import LiteralPath, literal_path
from mcdas_opt.situation.assess import assess
from mcdas_opt.tracking.prediction import predict_for
from mcdas_opt.verification.judge import judge

_PUBLISHED_SAMPLE_S = 0.5  # eq 11 reaches the rear vehicle's speed within one sample of the paper


@dataclass(frozen=True, slots=True, kw_only=True)
class LiteralManoeuvre:
    """The published path from where it was begun."""

    side: Side
    path: LiteralPath


class LiteralMethod:
    """MCDAS as published: eq 11's speed and eq 22-23's path whenever a threat exists. The verdict is what it is."""

    has_ladder = False

    def __init__(self, vehicle: Vehicle, settings: Settings | None = None) -> None:
        self.vehicle, self.settings = vehicle, settings or Settings()
        if self.settings.sigmoid.given is not None:
            raise ParameterError("planner", "closed-form", "is the paper as published: it takes no parameters")
        self._assessment: Assessment | None = None

    def plan(self, situation: Situation, previous: Plan | None) -> Plan | Refusal:
        if situation.request is Request.PARK:
            return Refusal(reason="parking is planned by park, not by the lane planner")
        assessment = assess(situation, self.vehicle, self.settings.selector, self._assessment if previous is not None else None)
        self._assessment = assessment
        prediction = predict_for(situation, self.settings.prediction)
        host = situation.host
        going = previous.reference if previous is not None and isinstance(previous.reference, LiteralManoeuvre) else None
        if going is not None and host.s_m > going.path.end_s_m:
            going = None
        mode, side, speed = Mode.HOLD, Side.NONE, host.speed_mps
        if assessment.threatened and assessment.rear_speed_mps is not None:
            speed = assessment.rear_speed_mps  # eq 11: D_H = D_(H-1) + (V_Tr / V_HM - D_(H-1)), also when the rear car is slower
        if going is None and assessment.threatened and assessment.front_id is not None:
            left, right = abs(self.settings.sigmoid.y_max_m + assessment.offset_m), abs(self.settings.sigmoid.y_max_m - assessment.offset_m)
            tie = assessment.side if assessment.side is not Side.NONE else self.settings.selector.tie_break
            side = tie if abs(left - right) < 1e-9 else (Side.LEFT if left < right else Side.RIGHT)
            path = literal_path(
                side,
                assessment.offset_m,
                start_s_m=host.s_m,
                start_d_m=host.d_m,
                y_max_m=self.settings.sigmoid.y_max_m,
                a_per_m=self.settings.sigmoid.a_per_m,
                b=self.settings.sigmoid.b,
            )
            going = LiteralManoeuvre(side=side, path=path)
        if going is not None:
            mode, side = Mode.EVADE, going.side
        elif assessment.threatened:
            mode = Mode.ACCELERATE if speed > host.speed_mps else Mode.HOLD
        started = time.perf_counter()
        trajectory = self._differentiated(situation, going, speed)
        solved = time.perf_counter()
        verdict = judge(trajectory, host, self.vehicle, situation.road, prediction)
        judged = time.perf_counter()
        name = side.value if mode is Mode.EVADE else mode.value
        return Plan(
            planner="closed-form",
            mode=mode,
            side=side,
            warning=assessment.warning,
            reason=f"as published; Table 1 literally: {assessment.literal_mode or 'no mode'}",
            verdict=verdict,
            prediction=prediction.name,
            trajectory=trajectory,
            candidates=(Candidate(name=name, cost=None, passed=verdict.passed, refusal="" if verdict.passed else verdict.reason),),
            timing_ms=Timing(solve=1e3 * (solved - started), verify=1e3 * (judged - solved)),
            literal_mode=assessment.literal_mode,
            time_s=situation.time_s,
            reference=going,
        )

    def _differentiated(self, situation: Situation, going: LiteralManoeuvre | None, speed: float) -> Trajectory:
        """The published curve sampled every 0.1 s and differentiated: what a car would have to do to be there."""
        host, vehicle, t = situation.host, self.vehicle, self.settings.grid.times_s
        ramp = np.minimum(t / _PUBLISHED_SAMPLE_S, 1.0)
        v = host.speed_mps + (speed - host.speed_mps) * ramp
        a = np.where(t < _PUBLISHED_SAMPLE_S - 1e-9, (speed - host.speed_mps) / _PUBLISHED_SAMPLE_S, 0.0)
        s = host.s_m + np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t))])
        if going is None:
            d, psi, kappa = np.full_like(t, host.d_m), np.full_like(t, host.heading_rad), np.zeros_like(t)
        else:
            d, psi = np.asarray(going.path.d(s)), np.arctan(np.asarray(going.path.slope(s)))
            kappa = np.asarray(going.path.curvature(s))
        kappa = kappa + situation.road.curvature_at(s)
        delta = np.arctan(vehicle.wheelbase_m * kappa)

        def rate(values: Array) -> Array:
            differences = np.diff(values) / np.diff(t)
            return np.append(differences, differences[-1])

        return Trajectory(
            t_s=t,
            s_m=s,
            d_m=d,
            heading_rad=psi,
            speed_mps=v,
            acceleration_mps2=a,
            steering_rad=delta,
            steering_rate_radps=rate(delta),
            jerk_mps3=rate(a),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Driven:
    """A way out, driven by the bicycle and judged."""

    way: Way
    trajectory: Trajectory
    verdict: Verdict
    candidate: Candidate


class CorrectedMethod:
    """The corrected sigmoid, driven: the first way out, gentle ones first, that the judge passes.

    No optimiser. Order of trial: what is under way; keep the lane when nothing threatens; of the two sides the one that is worth more
    (equal ones by the tie-break), braking, accelerating. When none passes, the first tried leaves with its failed verdict: the judge's
    own, or, where that is not `exact`, what a glance found.
    """

    has_ladder = False
    name = "closed-form-corrected"

    def __init__(self, vehicle: Vehicle, settings: Settings | None = None, *, exact: bool = True) -> None:
        self.vehicle, self.settings, self.exact = vehicle, settings or Settings(), exact
        self._assessment: Assessment | None = None

    def plan(self, situation: Situation, previous: Plan | None) -> Plan | Refusal:
        if situation.request is Request.PARK:
            return Refusal(reason="parking is planned by park, not by the lane planner")
        started = time.perf_counter()
        assessment = assess(situation, self.vehicle, self.settings.selector, self._assessment if previous is not None else None)
        self._assessment = assessment
        prediction = predict_for(situation, self.settings.prediction)
        going = previous.reference if previous is not None and isinstance(previous.reference, Manoeuvre) else None
        if going is not None and going.finished(situation):
            going = None
        tried: list[Candidate] = []
        first: _Driven | None = None
        for driven in self._driven(situation, prediction, self.groups(situation, assessment, going), shorter_side(assessment)):
            driven.sort(key=self._price)
            tried += [one.candidate for one in driven]
            best = next((one for one in driven if one.verdict.passed), None)
            if best is not None:
                return self._plan(situation, assessment, prediction, best, tried, started)
            first = first or next(iter(driven), None)
        assert first is not None  # keeping the lane by braking is never refused
        if self.exact:
            first = replace(first, verdict=judge(first.trajectory, situation.host, self.vehicle, situation.road, prediction))
        return self._plan(situation, assessment, prediction, first, tried, started)

    def groups(self, situation: Situation, assessment: Assessment, going: Manoeuvre | None) -> list[list[Way]]:
        """In the order in which they are tried."""
        brake, accelerate, left, right = ways_out(situation, assessment, self.vehicle, self.settings.sigmoid, None)
        groups = [[left, right], [brake], [accelerate]]
        if going is not None:
            return [[continued(situation, going)], *groups]
        if not assessment.threatened:
            return [[keeping_way(situation, Mode.CRUISE if assessment.mode is Mode.CRUISE else Mode.HOLD)], *groups]
        return groups

    def _driven(self, situation: Situation, prediction: Prediction, groups: list[list[Way]], leaning: Side) -> Iterator[list[_Driven]]:
        """Each group, driven and judged: the first by itself, the others, where they are asked for, together."""
        for some in (groups[:1], groups[1:]):
            ways = [[way for way in group if not way.refusal] for group in some]
            drives = [[drive(situation, way, self.vehicle, self.settings) for way in group] for group in ways]
            judged = iter(verdicts(list(chain(*drives)), situation, self.vehicle, prediction))
            for group, driven in zip(ways, drives, strict=True):
                each = zip(group, driven, islice(judged, len(group)), strict=True)
                yield [self._priced(situation, prediction, *one, leaning) for one in each]

    def _priced(
        self, situation: Situation, prediction: Prediction, way: Way, trajectory: Trajectory, verdict: Verdict, leaning: Side
    ) -> _Driven:
        cost = worth(
            trajectory,
            vehicle=self.vehicle,
            road=situation.road,
            prediction=prediction,
            desired_speed_mps=situation.wanted_speed_mps,
            side=way.side,
            leaning=leaning,
            needless=False,
            settings=WorthSettings(),
        )
        refusal = "" if verdict.passed else verdict.reason
        candidate = Candidate(name=way.name, cost=cost, passed=verdict.passed, refusal=refusal)
        return _Driven(way=way, trajectory=trajectory, verdict=verdict, candidate=candidate)

    def _price(self, one: _Driven) -> tuple[float, int]:
        return (round(one.candidate.cost or 0.0, 5), 0 if one.way.side is self.settings.selector.tie_break else 1)

    def _plan(
        self, situation: Situation, assessment: Assessment, prediction: Prediction, one: _Driven, tried: list[Candidate], started: float
    ) -> Plan:
        return Plan(
            planner=self.name,
            mode=one.way.mode,
            side=one.way.side,
            warning=assessment.warning,
            reason=assessment.reason,
            verdict=one.verdict,
            prediction=prediction.name,
            trajectory=one.trajectory,
            candidates=tuple(tried),
            timing_ms=Timing(solve=1e3 * (time.perf_counter() - started)),
            literal_mode=assessment.literal_mode,
            time_s=situation.time_s,
            reference=one.way.manoeuvre,
        )


def drive(situation: Situation, way: Way, vehicle: Vehicle, settings: Settings) -> Trajectory:
    """The bicycle along the way's path, at most at the bound that the path was made for."""
    hard = way.mode in (Mode.BRAKE, Mode.ACCELERATE)
    most = 0.9 * situation.road.friction * GRAVITY_MPS2 if hard else 2.0
    return follow(
        situation.host,
        way.path,
        SpeedLaw(speed_mps=way.speed_mps, acceleration_mps2=most),
        vehicle=vehicle,
        road=situation.road,
        duration_s=float(settings.grid.times_s[-1]),
        lateral_acceleration_mps2=lateral_bound_mps2(situation, settings.sigmoid),
    )
