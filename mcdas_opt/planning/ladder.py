"""The fallback ladder: what answers when a method has no plan that passes."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace

from mcdas_opt.actuation.path_following import SpeedLaw, follow
from mcdas_opt.domain.plan import Candidate, Plan, Timing
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.verdict import Verdict
from mcdas_opt.domain.vocabulary import Mode, Side, Status
from mcdas_opt.planning.closed_form import CorrectedMethod
from mcdas_opt.planning.selection import severity
from mcdas_opt.reference.lane_centre import LaneCentre
from mcdas_opt.tracking.prediction import predict
from mcdas_opt.verification.judge import judge

_BRAKING_SHARES = (0.25, 0.5, 0.75, 1.0)
_ACCELERATING_SHARES = (0.5, 1.0)


class Ladder:
    """Corrected sigmoid, driven -> keep the lane, braking or accelerating -> the least severe. Keeps no memory of its own."""

    def __init__(self, vehicle: Vehicle, settings: Settings) -> None:
        self.vehicle, self.settings = vehicle, settings

    def answer(self, situation: Situation, previous: Plan | None, refusal: str) -> Plan:
        """A plan that passed (status `fallback`), else the least severe (`unavoidable`); the reason says what was refused before."""
        started = time.perf_counter()
        corrected = CorrectedMethod(self.vehicle, self.settings).plan(situation, previous)
        if isinstance(corrected, Plan) and corrected.verdict.passed:
            why = f"corrected sigmoid, driven, instead of the planner's own: {refusal}"
            return replace(corrected, status=Status.FALLBACK, reason=why)
        prediction = predict(situation.tracks, self.settings.prediction)
        tried: list[Candidate] = list(corrected.candidates)
        failed: list[tuple[str, Mode, Trajectory, Verdict]] = []
        for name, mode, trajectory in self._keeping(situation):
            verdict = judge(trajectory, situation.host, self.vehicle, situation.road, prediction)
            tried.append(Candidate(name=name, cost=None, passed=verdict.passed, refusal="" if verdict.passed else verdict.reason))
            if verdict.passed:
                why = f"{name} in the lane, instead of the planner's own: {refusal}"
                return self._plan(situation, prediction, mode, Side.NONE, trajectory, verdict, Status.FALLBACK, why, tried, started)
            failed.append((name, mode, trajectory, verdict))
        # nothing passes: the lightest impact; of equals the latest; the corrected sigmoid's own first choice competes
        options = [(severity(t, self.vehicle, situation.road, prediction), n, m, Side.NONE, t, v) for n, m, t, v in failed]
        if isinstance(corrected, Plan):
            hurt = severity(corrected.trajectory, self.vehicle, situation.road, prediction)
            options.append((hurt, corrected.mode.value, corrected.mode, corrected.side, corrected.trajectory, corrected.verdict))
        worst, name, mode, side, trajectory, verdict = min(options, key=lambda option: option[0])
        why = f"nothing passes; least severe is {name}, impact at {worst[0]:.1f} m/s; before: {refusal}"
        return self._plan(situation, prediction, mode, side, trajectory, verdict, Status.UNAVOIDABLE, why, tried, started)

    def _keeping(self, situation: Situation) -> Iterator[tuple[str, Mode, Trajectory]]:
        """In the lane: hold, brake ever harder to a stop, accelerate."""
        grip = situation.road.friction * GRAVITY_MPS2
        vehicle = self.vehicle
        laws = [("hold", Mode.HOLD, SpeedLaw(speed_mps=situation.host.speed_mps, acceleration_mps2=1.0))]
        for share in _BRAKING_SHARES:
            most = share * min(-vehicle.acceleration_min_mps2, grip)
            laws.append((f"brake {most:.1f} m/s^2", Mode.BRAKE, SpeedLaw(speed_mps=0.0, acceleration_mps2=most)))
        for share in _ACCELERATING_SHARES:
            most = share * min(vehicle.acceleration_max_mps2, grip)
            law = SpeedLaw(speed_mps=0.98 * vehicle.speed_max_mps, acceleration_mps2=most)
            laws.append((f"accelerate {most:.1f} m/s^2", Mode.ACCELERATE, law))
        for name, mode, law in laws:
            trajectory = follow(
                situation.host,
                LaneCentre(d_m=situation.road.lane_centre_m(situation.road.lane_of(situation.host.d_m))),
                law,
                vehicle=vehicle,
                road=situation.road,
                duration_s=float(self.settings.grid.times_s[-1]),
                lateral_acceleration_mps2=0.5 * grip,
            )
            yield name, mode, trajectory

    def _plan(
        self,
        situation: Situation,
        prediction: Prediction,
        mode: Mode,
        side: Side,
        trajectory: Trajectory,
        verdict: Verdict,
        status: Status,
        reason: str,
        tried: list[Candidate],
        started: float,
    ) -> Plan:
        return Plan(
            planner="ladder",
            mode=mode,
            side=side,
            warning=True,
            status=status,
            reason=reason,
            verdict=verdict,
            prediction=prediction.name,
            trajectory=trajectory,
            candidates=tuple(tried),
            timing_ms=Timing(solve=1e3 * (time.perf_counter() - started)),
            time_s=situation.time_s,
        )
