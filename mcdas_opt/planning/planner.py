"""The planner: tracker, method, ladder; from raw measurements to a judged plan."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import Scan
from mcdas_opt.domain.plan import Plan, Refusal
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import positive
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Request, Status
from mcdas_opt.planning.ladder import Ladder
from mcdas_opt.planning.method import Method, build_method
from mcdas_opt.planning.pose_history import PoseHistory
from mcdas_opt.situation.consistency import contradiction
from mcdas_opt.time_to_react.assessment import time_to_react
from mcdas_opt.tracking.tracker import Tracker


class Planner:
    """Builds its solver once; remembers its tracks and its last plan; belongs to one thread.

    `vehicle` is a `Vehicle`, a shipped name or a path; `method` a registered name or an object with `plan(situation, previous)`.
    `road` is what `step` drives on unless it is told another. With `deadline_s` the method is asked to begin no further candidate
    after that much wall-clock time (then runs do not repeat to the byte); without, work is bounded by counted iterations alone.
    Raises `InputError` or `ParameterError` for what it does not know.
    """

    def __init__(
        self,
        vehicle: str | Vehicle = "sedan",
        method: str | Method = "mpc",
        *,
        settings: Settings | None = None,
        road: Road | None = None,
        deadline_s: float | None = None,
    ) -> None:
        if deadline_s is not None:
            positive("deadline_s", deadline_s, "s")
        self.deadline_s = deadline_s
        self.vehicle = load_vehicle(vehicle) if isinstance(vehicle, str) else vehicle
        self.settings = settings or Settings()
        self.name = method if isinstance(method, str) else type(method).__name__
        self.method = build_method(method, self.vehicle, self.settings) if isinstance(method, str) else method
        self.road = road or Road()
        self.tracker = Tracker(vehicle=self.vehicle)
        self._poses = PoseHistory()
        self.ladder = Ladder(self.vehicle, self.settings)
        self.previous: Plan | None = None
        self.situation: Situation | None = None

    def rolls_about(self, point_m: float) -> None:
        """From now on the car moves along its own axis at this point ahead of its rear axle (`Vehicle.rolling_point_m`): whoever keeps a
        `vehicle` is told. A method that keeps none goes on about the rear axle."""
        parts: tuple[Any, ...] = (self, self.method, self.ladder, self.tracker)
        for part in parts:
            car = getattr(part, "vehicle", None)
            if isinstance(car, Vehicle) and car.rolling_point_m != point_m:
                part.vehicle = replace(car, rolling_point_m=point_m)

    def reset(self) -> None:
        """Forgets tracks and the last plan."""
        self.tracker.reset()
        self._poses = PoseHistory()
        self.previous = None
        self.situation = None

    def plan(self, situation: Situation) -> Plan:
        """One plan for a situation, judged. Never raises in traffic: a refusal is answered by the ladder."""
        started = time.perf_counter()
        if self.deadline_s is not None and hasattr(self.method, "stop_at"):
            self.method.stop_at = started + self.deadline_s
        has_ladder = getattr(self.method, "has_ladder", True)
        wrong = contradiction(situation, self.situation, self.vehicle) if has_ladder else ""
        if wrong:
            answer: Plan | Refusal = Refusal(reason=f"the situation contradicts itself: {wrong}")
        else:
            answer = self.method.plan(situation, self.previous)
        if isinstance(answer, Refusal):
            fallback = self.ladder.answer(situation, self.previous, answer)
            answer = replace(fallback, candidates=answer.candidates + fallback.candidates, iterations=answer.iterations)
        elif has_ladder and not answer.verdict.passed:
            answer = self.ladder.answer(situation, self.previous, Refusal(reason=answer.verdict.reason))
        elif has_ladder and answer.safe_end is not None and not answer.safe_end.safe:
            answer = self._without_safe_end(situation, answer)
        told = {} if wrong else time_to_react(answer, situation, self.previous, self.vehicle, self.settings)
        timing = replace(answer.timing_ms, total=1e3 * (time.perf_counter() - started))
        self.previous = replace(answer, planner=self.name, timing_ms=timing, **told)
        self.situation = situation
        return self.previous

    def _without_safe_end(self, situation: Situation, answer: Plan) -> Plan:
        """The rest of the last plan where that still comes to a safe end, else the answer as a fallback that says that it does not."""
        rest = self.ladder.rest_of(situation, self.previous)
        if rest is not None:
            return replace(rest, candidates=answer.candidates + rest.candidates, iterations=answer.iterations)
        reason = f"{answer.reason}; passes for {answer.trajectory.t_s[-1]:.1f} s, but comes to no safe end"
        return replace(answer, status=Status.FALLBACK, reason=reason)

    def step(
        self,
        measurements: Sequence[Scan],
        host: HostState,
        now: float,
        *,
        road: Road | None = None,
        desired_speed_mps: float | None = None,
        request: Request = Request.DRIVE,
    ) -> Plan:
        """The whole pipeline: scans (each with its own time stamp) and the host's state at `now` [s] in, a judged plan out."""
        on = road or self.road
        self._poses.note(now, host)
        for scan in sorted(measurements, key=lambda scan: scan.t_s if math.isfinite(scan.t_s) else math.inf):
            seen_from = self._poses.at(scan.t_s) if math.isfinite(scan.t_s) else host
            self.tracker.update([scan], seen_from, on, now)
        if not measurements:
            self.tracker.update([], host, on, now)
        situation = Situation(
            time_s=now,
            host=host,
            tracks=self.tracker.tracks(now),
            coverage=self.tracker.coverage(now),
            road=on,
            vehicle=self.vehicle.name,
            desired_speed_mps=desired_speed_mps,
            request=request,
        )
        return self.plan(situation)
