"""Parking in closed loop: a plan with something in reserve, a tracker, a noisy pose, and a judged stop in every cycle."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import numpy as np

from mcdas_opt.domain.arithmetic import usual_arithmetic
from mcdas_opt.domain.parking import ParkingCase, ParkingTrajectory
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.verdict import Verdict
from mcdas_opt.dynamics.rollout import roll_out
from mcdas_opt.errors import ParameterError
from mcdas_opt.geometry.angles import wrapped
from mcdas_opt.geometry.clearance import Body, obstacle_field
from mcdas_opt.parking.case_file import the_case
from mcdas_opt.parking.closed_loop.car import ACTUATORS, Car
from mcdas_opt.parking.closed_loop.plant import HOLD_BELOW_MPS
from mcdas_opt.parking.closed_loop.record import ParkingDrive, ParkingEvent, ParkingOutcome
from mcdas_opt.parking.closed_loop.replanning import plan_from
from mcdas_opt.parking.closed_loop.settings import FollowSettings
from mcdas_opt.parking.closed_loop.sight import Sight, Visitor
from mcdas_opt.parking.closed_loop.stopping import braking
from mcdas_opt.parking.closed_loop.tracker import STEP_S, TrackingError
from mcdas_opt.parking.soundness import arrived
from mcdas_opt.verification.parking_stop import judge_stop

CYCLE_S = 0.1
_LATE_S = ACTUATORS.delay_s + ACTUATORS.drive_lag_s  # of what is commanded
_HARD_BRAKING_MPS2 = 4.0  # only where the case's acceleration makes no sound stop
_ROOM_TO_BRAKE = 1.5  # times a stop's braking may be commanded, or nothing is left for the feedback
_PEDESTRIAN_CLEARANCE_M = 0.2  # kept to people besides the clearance
_SIGHT_M = 1.5
_PAUSE_S = 1.0  # at rest, while a new plan is made
_PATIENCE_S = 10.0  # at rest without a plan
_SETTLED_S = 0.5  # after a reference's end, at rest
_LONGEST_S = 900.0


@usual_arithmetic
def follow(
    case: str | Path | ParkingCase,
    planner: Literal["nlp", "search"] | str = "nlp",
    seed: int = 0,
    *,
    vehicle: str | Vehicle | None = None,
    truth: ParkingCase | None = None,
    visitors: tuple[Visitor, ...] = (),
    plan: ParkingTrajectory | None = None,
    settings: FollowSettings | None = None,
) -> ParkingDrive:
    """Drive a case as it is believed to be, among the obstacles of `truth` (default: the same) and the visitors, to the true goal.

    `plan` (in the case's coordinates relative to its origin) saves making the first one; `planner` makes the others. Noise comes from
    `seed` alone: the same arguments give the same drive. `case` may be a shipped name or a path; then `vehicle` (a `Vehicle`, a shipped
    name or a path) may take the place of the case's own. Raises `InputError` for a file that is no case, `ParameterError` for another
    planner, and for a vehicle beside a `ParkingCase`, which has its own.
    """
    if planner not in ("nlp", "search"):
        raise ParameterError("planner", planner, "must be nlp or search")
    case = the_case(case, vehicle)
    drive = _Drive(case, truth or case, planner, seed, visitors, settings or FollowSettings())
    refusal = drive.run(plan)
    return drive.result(seed, visitors, refusal)


@dataclass(slots=True)
class _Reference:
    """What is followed, for how long, whether it is a stop, and the last sound stop that would begin after a cycle."""

    trajectory: ParkingTrajectory
    since_s: float
    stopping: bool
    standby: ParkingTrajectory | None = None

    @property
    def is_over(self) -> bool:
        return self.since_s >= self.trajectory.duration_s


@dataclass(slots=True)
class _Tally:
    """Counts of a drive, its events, its references, and the largest tracking errors (across [m], heading [rad], along [m])."""

    replans: int = 0
    judged: int = 0
    unsound: int = 0
    stops: int = 0
    worst: Array = field(default_factory=lambda: np.zeros(3))
    events: list[ParkingEvent] = field(default_factory=list)
    references: list[ParkingTrajectory] = field(default_factory=list)

    def compare(self, off: TrackingError) -> None:
        self.worst = np.maximum(self.worst, np.abs([off.across_m, off.heading_rad, off.along_m]))


class _Drive:
    """One drive. Times are simulated; planning takes `_PAUSE_S` of them."""

    def __init__(
        self, case: ParkingCase, truth: ParkingCase, planner: str, seed: int, visitors: tuple[Visitor, ...], settings: FollowSettings
    ) -> None:
        self.case, self.truth, self.planner, self.settings = case, truth, planner, settings
        self.sight = Sight(case, truth, visitors, _SIGHT_M)
        self.car = Car(case, truth, visitors, settings.noise, seed)
        self.tally = _Tally()
        self.reference: _Reference | None = None

    def run(self, plan: ParkingTrajectory | None) -> str:
        """Drive until the car is parked, has touched something, or stands without a plan; the reason why there is none, if so."""
        self._look()
        refusal = ""
        if plan is None:
            plan, refusal = self._planned()
        if plan is not None:
            self._follow(plan, -_LATE_S)  # commands go ahead
        waited, was_stop = 0.0, False
        while not self._has_struck and self.car.now_s < _LONGEST_S:
            if self.reference is not None:
                current = self._drive_cycle(self.reference)
                settled = current.since_s > current.trajectory.duration_s + _SETTLED_S
                if settled and not self._has_struck and self.car.plant.speed_mps == 0.0:
                    self.reference, was_stop, waited = None, current.stopping, 0.0
                continue
            if not was_stop and plan is not None and arrived(self.sight.belief, self.car.sensors.pose):
                break
            if self.tally.replans >= self.settings.replans:
                refusal = refusal or "no replans left"
                break
            news = self._stand(_PAUSE_S)
            if refusal and not news:
                waited += _PAUSE_S
                if waited >= _PATIENCE_S:
                    break
                continue
            if not self._has_struck:
                self.tally.replans += 1
                plan, refusal = self._planned()
                self._say(refusal or "plans anew")
                if plan is not None:
                    self._follow(plan, -_LATE_S)
        return refusal

    def result(self, seed: int, visitors: tuple[Visitor, ...], refusal: str) -> ParkingDrive:
        car, tally = self.car, self.tally
        off = car.plant.pose - self.truth.goal
        least = car.contacts.least_m
        outcome, reason = self._outcome(refusal)
        return ParkingDrive(
            name=self.case.name,
            planner=self.planner,
            seed=seed,
            outcome=outcome,
            reason=reason,
            duration_s=car.now_s,
            end_position_error_m=float(np.hypot(off[0], off[1])),
            end_heading_error_rad=abs(float(wrapped(off[2]))),
            min_clearance_m=float(least) if np.isfinite(least) else None,
            collided_with=car.contacts.struck,
            replans=tally.replans,
            stops_judged=tally.judged,
            stops_unsound=tally.unsound,
            stops_driven=tally.stops,
            max_across_m=float(tally.worst[0]),
            max_heading_rad=float(tally.worst[1]),
            max_along_m=float(tally.worst[2]),
            trajectory=car.driven,
            events=tuple(tally.events),
            visitors=visitors,
            references=tuple(tally.references),
            truth=self.truth,
        )

    def _outcome(self, refusal: str) -> tuple[ParkingOutcome, str]:
        plant = self.car.plant
        if self._has_struck:
            return ParkingOutcome.COLLISION, f"touched {self.car.contacts.struck}"
        if arrived(self.truth, plant.pose) and abs(plant.speed_mps) < HOLD_BELOW_MPS:
            return ParkingOutcome.PARKED, "at rest within the tolerance"
        return ParkingOutcome.STOPPED, refusal or "at rest beside the goal"

    @property
    def _has_struck(self) -> bool:
        return self.car.contacts.struck is not None

    def _planned(self) -> tuple[ParkingTrajectory | None, str]:
        """From where the car believes to stand; people get their clearance where it can be had."""
        refusal = ""
        for distance_m in (_PEDESTRIAN_CLEARANCE_M, 0.0):
            case = self.sight.with_visitors(distance_m)
            top = case.vehicle.steering_max_rad
            steering = float(np.clip(self.car.sensors.steering_rad, -top, top))
            plan, refusal = plan_from(case, self.car.sensors.pose, steering, self.planner)
            if plan is not None or len(case.obstacles) == len(self.sight.belief.obstacles):
                return plan, refusal
        return None, refusal

    def _follow(self, trajectory: ParkingTrajectory, since_s: float, *, stopping: bool = False) -> None:
        self.reference = _Reference(trajectory, since_s, stopping)
        self.tally.references.append(trajectory)
        self.car.tracker.aim_at(trajectory)
        self.car.tracker.acceleration_mps2 = self.case.limits.acceleration_mps2

    def _drive_cycle(self, reference: _Reference) -> _Reference:
        """Look, keep a stop at hand or use it, then drive for one cycle; what is followed by then."""
        news = self._look()
        if not reference.is_over:
            if news and (reference.stopping or not self._still_clear(reference)):
                reference = self._stop_now(reference, "the path is blocked")
            elif not reference.stopping:
                reference = self._keep_a_stop(reference, fresh=bool(news))
        for _ in range(round(CYCLE_S / STEP_S)):
            if not reference.is_over and not reference.stopping:
                self.tally.compare(self.car.true_error(reference.since_s))
            self.car.follow(reference.since_s, hold=reference.is_over)
            reference.since_s += STEP_S
            if self._has_struck:
                break
        return reference

    def _keep_a_stop(self, reference: _Reference, fresh: bool) -> _Reference:
        """Judge the stop that would begin after this cycle. Lost or without one: the last sound one begins now, if it still counts."""
        off = self.car.measured_error(reference.since_s)
        stop, verdict = self._judged_stop(reference, self.case.limits.acceleration_mps2, CYCLE_S)
        if max(abs(off.across_m), abs(off.along_m)) > self.settings.tracked_m:
            return self._stop_now(reference, "the path is lost")
        if verdict.passed:
            reference.standby = stop
            return reference
        if fresh or reference.standby is None:
            return self._stop_now(reference, "no stop after this cycle")
        self._say(f"no stop after this cycle: {verdict.reason}")
        return self._stop(reference.standby, CYCLE_S, self.case.limits.acceleration_mps2)

    def _stop_now(self, reference: _Reference, why: str) -> _Reference:
        """The case's braking where that is sound, hard braking otherwise: it is never later at rest."""
        gentle = self.case.limits.acceleration_mps2
        braking_mps2, hard = gentle, max(_HARD_BRAKING_MPS2, gentle)
        stop, verdict = self._judged_stop(reference, gentle, 0.0)
        if not verdict.passed and hard > gentle:
            braking_mps2 = hard
            stop, verdict = self._judged_stop(reference, hard, 0.0)
        self._say(f"{why}: stops with {braking_mps2:g} m/s^2, {'sound' if verdict.passed else verdict.reason}")
        return self._stop(stop, 0.0, braking_mps2)

    def _judged_stop(self, reference: _Reference, braking_mps2: float, after_s: float) -> tuple[ParkingTrajectory, Verdict]:
        """The stop from here that begins `after_s` from now, in what is believed now."""
        sensors = self.car.sensors
        belief = self.sight.with_visitors(0.0)
        belief = replace(belief, limits=replace(belief.limits, acceleration_mps2=braking_mps2))
        late = _LATE_S + after_s
        stop = braking(belief, reference.trajectory, reference.since_s, late, sensors.pose, sensors.speed_mps, sensors.steering_rad)
        verdict = judge_stop(belief, stop, self.settings.stop_clearance_m).verdict
        self.tally.judged += 1
        self.tally.unsound += not verdict.passed
        return stop, verdict

    def _stop(self, stop: ParkingTrajectory, since_s: float, braking_mps2: float) -> _Reference:
        self.tally.stops += 1
        self._follow(stop, since_s, stopping=True)
        self.car.tracker.acceleration_mps2 = _ROOM_TO_BRAKE * braking_mps2
        assert self.reference is not None
        return self.reference

    def _still_clear(self, reference: _Reference) -> bool:
        """Whether the rest of the path keeps the clearance of the case in what is believed now, and still leads to the goal."""
        path, belief = reference.trajectory, self.sight.with_visitors(_PEDESTRIAN_CLEARANCE_M)
        if not arrived(belief, path.poses[-1]):
            return False
        k = max(int(np.searchsorted(path.t_s - path.t_s[0], reference.since_s)) - 1, 0)
        rest = slice(k, None)
        _, poses, _ = roll_out(
            path.poses[k], path.t_s[rest], path.speed_mps[rest], path.steering_rad[rest], belief.vehicle.wheelbase_m, 0.01
        )
        apart = obstacle_field(belief.obstacles)[0].clearance(poses, Body.of(belief.vehicle))
        return bool(apart.min() >= belief.limits.clearance_m - 1e-3)

    def _stand(self, seconds: float) -> bool:
        """At rest for a while; whether anything new was seen."""
        news = False
        for _ in range(round(seconds / STEP_S)):
            self.car.stand()
            if self._has_struck:
                return False
            news = self._look() or news
        return news

    def _look(self) -> bool:
        """Whether anything new is seen."""
        news = self.sight.look(self.car.now_s, self.car.sensors.pose)
        for text in news:
            self._say(f"sees: {text}")
        return bool(news)

    def _say(self, text: str) -> None:
        self.tally.events.append(ParkingEvent(time_s=self.car.now_s, text=text))
