"""The paper as published, never repaired: what the corrected forms and the MPC are compared with."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from mcdas_opt.baselines.lane import LaneMethod
from mcdas_opt.domain.assessment import Assessment
from mcdas_opt.domain.plan import Candidate, Plan, Timing
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Mode, Side
from mcdas_opt.errors import ParameterError
from mcdas_opt.planning.memory import carried
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


@dataclass(frozen=True, slots=True, kw_only=True)
class LiteralMemory:
    """The manoeuvre that goes on, and the assessment of the cycle before."""

    active: LiteralManoeuvre | None
    assessment: Assessment


class LiteralMethod(LaneMethod):
    """MCDAS as published: eq 11's speed and eq 22-23's path whenever a threat exists. The verdict is what it is."""

    def __init__(self, vehicle: Vehicle, settings: Settings | None = None) -> None:
        super().__init__(vehicle, settings)
        if self.settings.sigmoid.given is not None:
            raise ParameterError("planner", "closed-form", "is the paper as published: it takes no parameters")

    def drive(self, situation: Situation, previous: Plan | None) -> Plan:
        memory = carried(previous, LiteralMemory)
        assessment = assess(situation, self.vehicle, self.settings.selector, None if memory is None else memory.assessment)
        prediction = predict_for(situation, self.settings.prediction)
        host = situation.host
        active = None if memory is None else memory.active
        if active is not None and host.s_m > active.path.end_s_m:
            active = None
        mode, side, speed = Mode.HOLD, Side.NONE, host.speed_mps
        if assessment.threatened and assessment.rear_speed_mps is not None:
            speed = assessment.rear_speed_mps  # eq 11: D_H = D_(H-1) + (V_Tr / V_HM - D_(H-1)), also when the rear car is slower
        if active is None and assessment.threatened and assessment.front_id is not None:
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
            active = LiteralManoeuvre(side=side, path=path)
        if active is not None:
            mode, side = Mode.EVADE, active.side
        elif assessment.threatened:
            mode = Mode.ACCELERATE if speed > host.speed_mps else Mode.HOLD
        started = time.perf_counter()
        trajectory = self._differentiated(situation, active, speed)
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
            memory=LiteralMemory(active=active, assessment=assessment),
        )

    def _differentiated(self, situation: Situation, active: LiteralManoeuvre | None, speed: float) -> Trajectory:
        """The published curve sampled every 0.1 s and differentiated: what a car would have to do to be there."""
        host, vehicle, t = situation.host, self.vehicle, self.settings.grid.times_s
        ramp = np.minimum(t / _PUBLISHED_SAMPLE_S, 1.0)
        v = host.speed_mps + (speed - host.speed_mps) * ramp
        a = np.where(t < _PUBLISHED_SAMPLE_S - 1e-9, (speed - host.speed_mps) / _PUBLISHED_SAMPLE_S, 0.0)
        s = host.s_m + np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t))])
        if active is None:
            d, psi, kappa = np.full_like(t, host.d_m), np.full_like(t, host.heading_rad), np.zeros_like(t)
        else:
            d, psi = np.asarray(active.path.d(s)), np.arctan(np.asarray(active.path.slope(s)))
            kappa = np.asarray(active.path.curvature(s))
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
