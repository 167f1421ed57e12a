"""The fallback ladder: what answers when a method has no plan that passes."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import replace

from mcdas_opt.actuation.path_following import SpeedLaw
from mcdas_opt.domain.plan import Attempt, Candidate, Plan, Refusal, Timing
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.vocabulary import Mode, Side, Status
from mcdas_opt.planning.closed_form import CorrectedMethod
from mcdas_opt.planning.continuation import Ended, to_safe_end
from mcdas_opt.planning.glance import verdicts
from mcdas_opt.planning.path_driving import follow
from mcdas_opt.planning.selection import severities, severity_in_words
from mcdas_opt.planning.simple_policies import Policy, steering_out
from mcdas_opt.planning.tail import tail
from mcdas_opt.planning.trust import relying
from mcdas_opt.reference.lane_centre import LaneCentre
from mcdas_opt.tracking.prediction import predict_for
from mcdas_opt.verification.judge import judge

_BRAKING_SHARES = (0.25, 0.5, 0.75, 1.0)
_ACCELERATING_SHARES = (0.5, 1.0)
_STEERING_OUT_MPS = 0.5
_CORRECTED = "corrected sigmoid, driven,"


class Ladder:
    """The rest of the last judged plan -> the corrected sigmoid, driven -> keep the lane, braking or accelerating -> steer out hard -> the
    least severe. Keeps no memory of its own.
    """

    def __init__(self, vehicle: Vehicle, settings: Settings) -> None:
        self.vehicle, self.settings = vehicle, settings

    def answer(self, situation: Situation, previous: Plan | None, refusal: Refusal) -> Plan:
        """A plan that passed (status `fallback`), else the least severe (`unavoidable`); the reason says what was refused before.

        Of the drives that pass, the first that comes to a safe end; where none does, the first. What the method itself drove and the
        judge failed for a collision alone competes for the least severe.
        """
        started = time.perf_counter()
        prediction = predict_for(situation, self.settings.prediction)
        tried: list[Candidate] = []
        options: list[Attempt] = []
        first: tuple[Attempt, Ended] | None = None
        for drive in self._drives(situation, previous, prediction, tried):
            if not drive.verdict.passed:
                options.append(drive)
                continue
            ended = to_safe_end(drive.trajectory, drive.verdict, situation, self.vehicle, prediction, self.settings.safe_end)
            if ended.sound:
                return self._passed(situation, prediction, drive, ended, refusal, tried, started)
            first = first or (drive, ended)
        if first is not None:
            return self._passed(situation, prediction, *first, refusal, tried, started)
        own = len(options)
        options += [a for a in refusal.attempts if _only_collides(a)]
        hurt = severities([option.trajectory for option in options], self.vehicle, situation.road, prediction)
        # nobody is relied on in a drive that, should that fail, is more severe than the closed form, which relies on nobody
        forms = [speed for one, (speed, _) in zip(options, hurt, strict=True) if one.name == _CORRECTED]
        most = min(forms, default=math.inf) + _STEERING_OUT_MPS
        mild = [one for one, (speed, _) in zip(options, hurt, strict=True) if speed <= most]
        found = relying(mild, situation, previous, prediction, self.vehicle, self.settings.safe_end)
        if found is not None:
            drive, trust = found
            asked = self.settings.safe_end.attentive_braking_mps2
            why = f"nothing passes unless {trust} brakes; {drive.name} asks less than {asked:.1f} m/s^2 of it; before: {refusal.reason}"
            drive = replace(drive, reference=drive.reference or trust)
            return self._plan(
                situation, prediction, self._exact(situation, prediction, drive), None, Status.UNAVOIDABLE, why, tried, started
            )
        going = Side.NONE if previous is None else previous.side

        def rank(i: int) -> tuple[float, float]:
            """Steering out must be better than staying in the lane by a margin, unless it has begun: dithering is worst of all."""
            speed, when = hurt[i]
            return (speed if options[i].side in (Side.NONE, going) else speed + _STEERING_OUT_MPS, when)

        for least in sorted(range(len(options)), key=rank):
            drive = self._exact(situation, prediction, options[least])
            if least < own or _only_collides(drive):
                break
        why = f"nothing passes; least severe is {drive.name} ({severity_in_words(hurt[least][0])}); before: {refusal.reason}"
        return self._plan(situation, prediction, drive, None, Status.UNAVOIDABLE, why, tried, started)

    def _exact(self, situation: Situation, prediction: Prediction, drive: Attempt) -> Attempt:
        """With the judge's own verdict: until then a glance was enough."""
        return replace(drive, verdict=judge(drive.trajectory, situation.host, self.vehicle, situation.road, prediction))

    def rest_of(self, situation: Situation, previous: Plan | None) -> Plan | None:
        """What is left of the last judged plan, where it still passes and comes to a safe end."""
        started = time.perf_counter()
        prediction = predict_for(situation, self.settings.prediction)
        drive = self._tail(situation, previous, prediction)
        if drive is None:
            return None
        ended = to_safe_end(drive.trajectory, drive.verdict, situation, self.vehicle, prediction, self.settings.safe_end)
        if not ended.sound:
            return None
        tried = [_candidate(drive)]
        return self._passed(situation, prediction, drive, ended, Refusal(reason="no way out with a safe end"), tried, started)

    def _passed(
        self,
        situation: Situation,
        prediction: Prediction,
        drive: Attempt,
        ended: Ended,
        refusal: Refusal,
        tried: list[Candidate],
        started: float,
    ) -> Plan:
        why = f"{drive.name} instead of: {refusal.reason}"
        return self._plan(situation, prediction, drive, ended, Status.FALLBACK, why, tried, started)

    def _drives(self, situation: Situation, previous: Plan | None, prediction: Prediction, tried: list[Candidate]) -> Iterator[Attempt]:
        """The rungs, each driven only when it is reached: the last plan's tail, the corrected sigmoid, keeping the lane."""
        rest = self._tail(situation, previous, prediction)
        if rest is not None:
            tried.append(_candidate(rest))
            yield rest
        form = CorrectedMethod(self.vehicle, self.settings, exact=False).plan(situation, previous)
        tried.extend(form.candidates)
        if isinstance(form, Plan):
            yield Attempt(
                name=_CORRECTED,
                mode=form.mode,
                side=form.side,
                trajectory=form.trajectory,
                verdict=form.verdict,
                reference=form.reference,
            )
        last = [
            *self._keeping(situation),
            *self._steering(situation),
        ]  # judged in one go: what many fail costs little more than what one does
        seen = verdicts([drive for *_, drive in last], situation, self.vehicle, prediction)
        for (policy, trajectory), verdict in zip(last, seen, strict=True):
            drive = Attempt(name=policy.name, mode=policy.mode, side=policy.side, trajectory=trajectory, verdict=verdict)
            tried.append(_candidate(drive))
            yield drive if policy.side is not Side.NONE else replace(drive, name=f"{drive.name} in the lane")

    def _tail(self, situation: Situation, previous: Plan | None, prediction: Prediction) -> Attempt | None:
        trajectory = tail(previous, situation, self.vehicle)
        if trajectory is None or previous is None:
            return None
        return Attempt(
            name="the rest of the last plan",
            mode=previous.mode,
            side=previous.side,
            trajectory=trajectory,
            verdict=verdicts((trajectory,), situation, self.vehicle, prediction)[0],
            reference=previous.reference,
        )

    def _keeping(self, situation: Situation) -> Iterator[tuple[Policy, Trajectory]]:
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
            yield Policy(name, mode, Side.NONE), trajectory

    def _steering(self, situation: Situation) -> Iterator[tuple[Policy, Trajectory]]:
        """Out to either side, as hard as the tyres allow."""
        return steering_out(situation, self.vehicle, self.settings)

    def _plan(
        self,
        situation: Situation,
        prediction: Prediction,
        drive: Attempt,
        ended: Ended | None,
        status: Status,
        reason: str,
        tried: list[Candidate],
        started: float,
    ) -> Plan:
        return Plan(
            planner="ladder",
            mode=drive.mode,
            side=drive.side,
            warning=True,
            status=status,
            reason=reason,
            verdict=drive.verdict if ended is None else ended.verdict,
            prediction=prediction.name,
            trajectory=drive.trajectory if ended is None else ended.trajectory,
            safe_end=None if ended is None else ended.end,
            candidates=tuple(tried),
            timing_ms=Timing(solve=1e3 * (time.perf_counter() - started)),
            time_s=situation.time_s,
            reference=drive.reference,
        )


def _only_collides(drive: Attempt) -> bool:
    return drive.verdict.only_collides


def _candidate(drive: Attempt) -> Candidate:
    passed = drive.verdict.passed
    return Candidate(name=drive.name, cost=None, passed=passed, refusal="" if passed else drive.verdict.reason)
