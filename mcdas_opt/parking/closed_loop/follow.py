"""Parking in closed loop: a plan with something in reserve, a tracker, a noisy pose, and a judged stop in every cycle."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mcdas_opt.domain.parking import ParkingCase, ParkingTrajectory
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.verdict import Verdict
from mcdas_opt.dynamics.rollout import roll_out
from mcdas_opt.geometry.clearance import Body, PolygonField, obstacle_field
from mcdas_opt.parking.closed_loop.plant import HOLD_BELOW_MPS, STEP_S, ParkingPlant
from mcdas_opt.parking.closed_loop.pose_filter import PoseFilter
from mcdas_opt.parking.closed_loop.record import ParkingDrive, ParkingEvent, ParkingOutcome
from mcdas_opt.parking.closed_loop.replanning import plan_from
from mcdas_opt.parking.closed_loop.settings import FollowSettings
from mcdas_opt.parking.closed_loop.sight import Sight, Visitor, standing_by
from mcdas_opt.parking.closed_loop.stopping import braking
from mcdas_opt.parking.closed_loop.tracker import ParkingTracker, TrackingError, design_parking_tracker
from mcdas_opt.verification.parking_judge import wrapped
from mcdas_opt.verification.parking_stop import judge_stop

_ROOM_TO_BRAKE = 1.5


def follow_parking(
    case: ParkingCase,
    planner: str = "nlp",
    seed: int = 0,
    *,
    truth: ParkingCase | None = None,
    visitors: tuple[Visitor, ...] = (),
    plan: ParkingTrajectory | None = None,
    settings: FollowSettings | None = None,
) -> ParkingDrive:
    """Drive a case as it is believed to be, among the obstacles of `truth` (default: the same) and the visitors, to the true goal.

    `plan` (in the case's coordinates relative to its origin) saves making the first one; `planner` makes the others. Noise comes from
    `seed` alone: the same arguments give the same drive.
    """
    return _Drive(case, truth or case, planner, seed, visitors, settings or FollowSettings()).run(plan)


class _Drive:
    """One drive. Times are simulated; planning takes `pause_s` of them."""

    def __init__(
        self, case: ParkingCase, truth: ParkingCase, planner: str, seed: int, visitors: tuple[Visitor, ...], settings: FollowSettings
    ) -> None:
        self.case, self.truth, self.planner, self.seed = case, truth, planner, seed
        self.visitors, self.settings = visitors, settings
        self.sight = Sight(case, truth, visitors, settings.sight_m)
        self.body = Body.of(case.vehicle)
        self.plant = ParkingPlant(case.vehicle, case.limits, settings.actuators, case.start, case.start_steering_rad)
        gains = design_parking_tracker(settings.actuators, settings.weights, settings.step_s)
        self.tracker = ParkingTracker(gains, settings.actuators, case.vehicle, case.limits.acceleration_mps2)
        self.filter = PoseFilter(case.start, case.vehicle.wheelbase_m, settings.pose_gain)
        self.rng = np.random.default_rng(seed)
        noise = settings.noise
        self.scale = 1.0 + noise.speed_scale * float(self.rng.standard_normal())
        self.offset = noise.steering_offset_rad * float(self.rng.standard_normal())
        self.now = 0.0
        self.rows: list[list[float]] = []
        self.events: list[ParkingEvent] = []
        self.references: list[ParkingTrajectory] = []
        self.reference: ParkingTrajectory | None = None
        self.since = 0.0
        self.standby: ParkingTrajectory | None = None
        self.standby_age = 0.0
        self.stopping = False
        self.replans = self.judged = self.unsound = self.driven = 0
        self.worst = np.zeros(3)
        self.least = np.inf
        self.struck: str | None = None
        self.measured_speed, self.measured_steering = 0.0, case.start_steering_rad
        self._fields: dict[tuple[bool, ...], tuple[PolygonField, list[str]]] = {}

    def run(self, plan: ParkingTrajectory | None) -> ParkingDrive:
        cfg = self.settings
        self._note("sees", self.sight.look(self.now, self.filter.pose))
        refusal = ""
        if plan is None:
            plan, refusal = self._planned()
        self._record()
        if plan is not None:
            self._follow(plan)
        waited = 0.0
        while self.struck is None and self.now < cfg.longest_s:
            if self.reference is not None:
                self._drive_cycle()
                if self.struck is None and self._at_rest():
                    self.reference, waited = None, 0.0
                continue
            if not self.stopping and plan is not None and self._arrived(self.sight.belief, self.filter.pose):
                break
            if self.replans >= cfg.replans:
                refusal = refusal or "no replans left"
                break
            news = self._stand(cfg.pause_s)
            if refusal and not news:
                waited += cfg.pause_s
                if waited >= cfg.patience_s:
                    break
                continue
            if self.struck is None:
                self.replans += 1
                plan, refusal = self._planned()
                self._say(refusal or "plans anew")
                if plan is not None:
                    self._follow(plan)
        return self._result(refusal)

    def _planned(self) -> tuple[ParkingTrajectory | None, str]:
        """From where the car believes to stand; people get their berth where it can be had."""
        refusal = ""
        for berth in dict.fromkeys((self.settings.berth_m, 0.0)):
            case = self.sight.with_visitors(berth)
            steering = float(np.clip(self.measured_steering, -case.vehicle.steering_max_rad, case.vehicle.steering_max_rad))
            plan, refusal = plan_from(case, self.filter.pose, steering, self.planner, self.settings.reserve)
            if plan is not None or len(case.obstacles) == len(self.sight.belief.obstacles):
                return plan, refusal
        return None, refusal

    def _follow(self, trajectory: ParkingTrajectory, stopping: bool = False) -> None:
        lead = 0.0 if stopping else self.settings.actuators.delay_s + self.settings.actuators.drive_lag_s  # commands go ahead
        self.reference, self.since, self.stopping, self.standby = trajectory, -lead, stopping, None
        self.references.append(trajectory)
        self.tracker.aim_at(trajectory)
        self.tracker.acceleration_mps2 = self.case.limits.acceleration_mps2

    def _at_rest(self) -> bool:
        assert self.reference is not None
        return self.since > self.reference.duration_s + 0.5 and self.plant.speed_mps == 0.0

    def _drive_cycle(self) -> None:
        """Look, keep a stop at hand or use it, then drive for one cycle."""
        cfg, reference = self.settings, self.reference
        assert reference is not None
        news = self.sight.look(self.now, self.filter.pose)
        self._note("sees", news)
        if self.since < reference.duration_s:
            if news and (self.stopping or not self._still_clear(reference)):
                self._stop_now("the way is blocked")
            elif not self.stopping:
                self._keep_a_stop(fresh=bool(news))
        for _ in range(round(cfg.cycle_s / cfg.step_s)):
            self._control(drive=True)
            if self.struck is not None:
                return

    def _keep_a_stop(self, fresh: bool) -> None:
        """Judge the stop that would begin after this cycle. Lost or without one: the last sound one begins now, if it still counts."""
        cfg, reference = self.settings, self.reference
        assert reference is not None
        off = self.tracker.error(self.tracker.aim(self.since), self.filter.pose, self.measured_speed)
        lost = max(abs(off.across_m), abs(off.along_m)) > cfg.tracked_m
        stop, verdict = self._judged_stop(self.case.limits.acceleration_mps2, cfg.cycle_s)
        if lost:
            self._stop_now("the path is lost")
        elif verdict.passed:
            self.standby = stop
        elif fresh or self.standby is None:
            self._stop_now("no stop after this cycle")
        else:
            self._say(f"no stop after this cycle: {verdict.reason}")
            self._stop(self.standby, cfg.cycle_s, self.case.limits.acceleration_mps2)

    def _stop_now(self, why: str) -> None:
        """The case's braking where that is sound, hard braking otherwise: it is never later at rest."""
        hard = max(self.settings.hard_braking_mps2, self.case.limits.acceleration_mps2)
        for braking_mps2 in dict.fromkeys((self.case.limits.acceleration_mps2, hard)):
            stop, verdict = self._judged_stop(braking_mps2, 0.0)
            if verdict.passed or braking_mps2 == hard:
                self._say(f"{why}: stops with {braking_mps2:g} m/s^2, {'sound' if verdict.passed else verdict.reason}")
                self._stop(stop, 0.0, braking_mps2)
                return

    def _judged_stop(self, braking_mps2: float, after_s: float) -> tuple[ParkingTrajectory, Verdict]:
        """The stop from here that begins `after_s` from now, in what is believed now."""
        cfg, reference = self.settings, self.reference
        assert reference is not None
        belief = self.sight.with_visitors(0.0)
        belief = replace(belief, limits=replace(belief.limits, acceleration_mps2=braking_mps2))
        late = cfg.actuators.delay_s + cfg.actuators.drive_lag_s + after_s
        stop = braking(belief, reference, self.since, late, self.filter.pose, self.measured_speed, self.measured_steering)
        verdict = judge_stop(belief, stop, cfg.stop_clearance_m).verdict
        self.judged += 1
        self.unsound += not verdict.passed
        return stop, verdict

    def _stop(self, stop: ParkingTrajectory, since_s: float, braking_mps2: float) -> None:
        self.driven += 1
        self._follow(stop, stopping=True)
        self.tracker.acceleration_mps2 = _ROOM_TO_BRAKE * braking_mps2  # or nothing is left for the feedback
        self.since = since_s

    def _still_clear(self, reference: ParkingTrajectory) -> bool:
        """Whether the rest of the path keeps the clearance of the case in what is believed now, and still leads to the goal."""
        belief = self.sight.with_visitors(self.settings.berth_m)
        if not self._arrived(belief, reference.poses[-1]):
            return False
        k = max(int(np.searchsorted(reference.t_s - reference.t_s[0], self.since)) - 1, 0)
        rest = slice(k, None)
        _, poses, _ = roll_out(
            reference.poses[k],
            reference.t_s[rest],
            reference.speed_mps[rest],
            reference.steering_rad[rest],
            belief.vehicle.wheelbase_m,
            0.01,
        )
        apart = obstacle_field(belief.obstacles)[0].clearance(poses, self.body)
        return bool(apart.min() >= belief.limits.clearance_m - 1e-3)

    def _stand(self, seconds: float) -> bool:
        """At rest for a while; whether anything new was seen."""
        news: tuple[str, ...] = ()
        for _ in range(round(seconds / self.settings.step_s)):
            self._control(drive=False)
            if self.struck is not None:
                return False
            seen = self.sight.look(self.now, self.filter.pose)
            self._note("sees", seen)
            news += seen
        return bool(news)

    def _control(self, drive: bool) -> None:
        """One command, and the plant's steps under it; then a measurement."""
        h = self.settings.step_s
        if drive and self.reference is not None:
            command = self.tracker.command(self.since, self.filter.pose, self.measured_speed, self.measured_steering)
            aim = self.tracker.aim(self.since)
            if self.since < self.reference.duration_s and not self.stopping:
                self._compare(self.tracker.error(aim, self.plant.pose, self.plant.speed_mps))
            hold = self.since >= self.reference.duration_s
        else:
            command, hold = (0.0, self.plant.steering_rad), True
        poses = []
        for _ in range(round(h / STEP_S)):
            self.plant.step(*command, hold=hold)
            poses.append(self.plant.pose)
        self.now = round(self.now + h, 9)
        self.since += h
        self._measure(h)
        self._record()
        self._touch(np.array(poses))

    def _compare(self, off: TrackingError) -> None:
        self.worst = np.maximum(self.worst, np.abs([off.across_m, off.heading_rad, off.along_m]))

    def _measure(self, h: float) -> None:
        noise, plant = self.settings.noise, self.plant
        draw = self.rng.standard_normal(5)
        before = self.measured_speed
        standing = plant.speed_mps == 0.0  # wheel pulses do not tick
        self.measured_speed = 0.0 if standing else self.scale * plant.speed_mps + noise.speed_mps * float(draw[3])
        before_steering = self.measured_steering
        self.measured_steering = plant.steering_rad + self.offset + noise.steering_rad * float(draw[4])
        measured = plant.pose + np.array([noise.position_m, noise.position_m, noise.heading_rad]) * draw[:3]
        mean = 0.0 if standing else 0.5 * (before + self.measured_speed)
        self.filter.update(mean, 0.5 * (before_steering + self.measured_steering), h, measured)

    def _touch(self, poses: Array) -> None:
        seen = tuple(v.there(self.now) for v in self.visitors)
        if seen not in self._fields:
            case = standing_by(self.truth, [v for v, there in zip(self.visitors, seen, strict=True) if there])
            field, owner = obstacle_field(case.obstacles)
            self._fields[seen] = (field, [case.names[k] for k in owner])
        around, names = self._fields[seen]
        apart = around.separation(poses, self.body)
        if not apart.size:
            return
        part = int(np.argmin(apart.min(axis=0)))
        self.least = min(self.least, float(apart.min()))
        if apart.min() < 0.0:
            self.struck = names[part]

    def _arrived(self, case: ParkingCase, pose: Array) -> bool:
        off = pose - case.goal
        near = float(np.hypot(off[0], off[1])) <= case.tolerance.position_m
        return near and abs(float(wrapped(off[2]))) <= case.tolerance.heading_rad

    def _say(self, text: str) -> None:
        self.events.append(ParkingEvent(time_s=self.now, text=text))

    def _note(self, verb: str, news: tuple[str, ...]) -> None:
        for text in news:
            self._say(f"{verb}: {text}")

    def _record(self) -> None:
        self.rows.append([self.now, *self.plant.pose, self.plant.speed_mps, self.plant.steering_rad])

    def _result(self, refusal: str) -> ParkingDrive:
        rows = np.array(self.rows)
        pose = self.plant.pose
        off = pose - self.truth.goal
        if self.struck is not None:
            outcome, reason = ParkingOutcome.COLLISION, f"touched {self.struck}"
        elif self._arrived(self.truth, pose) and abs(self.plant.speed_mps) < HOLD_BELOW_MPS:
            outcome, reason = ParkingOutcome.PARKED, "at rest within the tolerance"
        else:
            outcome, reason = ParkingOutcome.STOPPED, refusal or "at rest beside the goal"
        return ParkingDrive(
            name=self.case.name,
            planner=self.planner,
            seed=self.seed,
            outcome=outcome,
            reason=reason,
            duration_s=self.now,
            end_position_error_m=float(np.hypot(off[0], off[1])),
            end_heading_error_rad=abs(float(wrapped(off[2]))),
            min_clearance_m=float(self.least) if np.isfinite(self.least) else None,
            collided_with=self.struck,
            replans=self.replans,
            stops_judged=self.judged,
            stops_unsound=self.unsound,
            stops_driven=self.driven,
            max_across_m=float(self.worst[0]),
            max_heading_rad=float(self.worst[1]),
            max_along_m=float(self.worst[2]),
            trajectory=ParkingTrajectory.from_controls(rows[:, 0], rows[:, 1:4], rows[:, 4], rows[:, 5]),
            events=tuple(self.events),
            visitors=self.visitors,
            references=tuple(self.references),
        )
