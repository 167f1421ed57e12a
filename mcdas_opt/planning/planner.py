"""The planner: tracker, method, fallback ladder; from raw measurements to a judged plan."""

from __future__ import annotations

import time
import warnings
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.arithmetic import usual_arithmetic
from mcdas_opt.domain.destination import Destination
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import Scan
from mcdas_opt.domain.plan import Plan, Timing
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import all_of, finite, not_a_class, positive, require_type, require_type_if_given
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Request, Side
from mcdas_opt.errors import ParameterError, PlannerFaultWarning, told
from mcdas_opt.native.library import Held, library
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.deadline import Deadline
from mcdas_opt.planning.fallback.ladder import NothingPasses, fall_back, host_refused, remainder_instead
from mcdas_opt.planning.measurement.sensing import Sensing
from mcdas_opt.planning.memory import Memory
from mcdas_opt.planning.method import AskedMethod, Method, PlannerName, build_method
from mcdas_opt.planning.one_thread import OneThread
from mcdas_opt.planning.reporting.loss_of_grip import with_loss_of_grip
from mcdas_opt.planning.reporting.reported_mode import with_reported_mode
from mcdas_opt.planning.reporting.time_to_react import with_time_to_react
from mcdas_opt.tracking.tracker import Tracker

_LONGEST_DEADLINE_S = 10.0


class Planner:
    """Builds its solver once; remembers its tracks and its last plan; belongs to one thread at a time
    (`SharedPlannerError`).

    `vehicle` is a `Vehicle`, a shipped name or a path; `method` a registered name or an object with `plan(situation, previous)`, whose
    `settings`, where it has them, are the planner's too.
    `road` is what `step` drives on unless it is told another. With `deadline_s` an answer is due after that much wall-clock
    time, the ladder's too (then runs do not repeat to the byte); without, work is bounded by counted iterations alone.
    Raises `InputError` or `ParameterError` for what it does not know. A planner can be pickled, and copied with `copy.deepcopy`, to go
    on from here in two ways: the copy knows what it knew, and its solver begins cold.
    """

    @usual_arithmetic
    def __init__(
        self,
        vehicle: str | Vehicle = "sedan",
        method: PlannerName | str | Method = "mpc",
        *,
        settings: Settings | None = None,
        road: Road | None = None,
        deadline_s: float | None = None,
        name: str | None = None,
    ) -> None:
        if deadline_s is not None:
            positive("deadline_s", deadline_s, "s")
            if deadline_s > _LONGEST_DEADLINE_S:
                raise ParameterError("deadline_s", deadline_s, f"must be at most {_LONGEST_DEADLINE_S:g}: seconds, not milliseconds?", "s")
        require_type("vehicle", vehicle, str, Vehicle)
        not_a_class("method", method)
        if not isinstance(method, str) and not callable(getattr(method, "plan", None)):
            raise ParameterError("method", method, "must be the name of a planner, or have a method plan(situation, previous)")
        require_type_if_given("settings", settings, Settings)
        require_type_if_given("road", road, Road)
        require_type_if_given("name", name, str)
        self.vehicle = load_vehicle(vehicle) if isinstance(vehicle, str) else vehicle
        own = None if isinstance(method, str) else getattr(method, "settings", None)
        if isinstance(own, Settings) and settings not in (None, own):
            raise ParameterError("settings", "others", "must be left out, or be those of the method, which was built with its own")
        self.settings = settings or (own if isinstance(own, Settings) else Settings())
        library()
        built = build_method(method, self.vehicle, self.settings) if isinstance(method, str) else method
        self._asked = AskedMethod(name or (method if isinstance(method, str) else type(method).__name__), built, deadline_s)
        self.sensing = Sensing(self.vehicle, road or Road())
        self.memory = Memory()
        self._one_thread = OneThread()

    @property
    def name(self) -> str:
        """What its plans are signed with: as given, else the registered name of the method, or its class's."""
        return self._asked.name

    @property
    def method(self) -> Method:
        return self._asked.method

    @property
    def deadline_s(self) -> float | None:
        return self._asked.deadline_s

    @property
    def road(self) -> Road:
        return self.sensing.road

    @property
    def tracker(self) -> Tracker:
        return self.sensing.tracker

    @property
    def previous(self) -> Plan | None:
        """The last plan that left."""
        return self._asked.previous

    @property
    def situation(self) -> Situation | None:
        """What it was made for."""
        return self.memory.situation

    takes_zero_sideslip_point = True

    def set_zero_sideslip_point(self, point_m: float) -> None:
        """Plans from now on about this point ahead of the rear axle (`Vehicle.zero_sideslip_point_m`). Whatever keeps a `vehicle` is
        told; a method that keeps none plans about the rear axle."""
        with self._one_thread.inside():
            if self.vehicle.zero_sideslip_point_m != point_m:
                self.vehicle = self.tracker.vehicle = replace(self.vehicle, zero_sideslip_point_m=point_m)
            own = getattr(self.method, "vehicle", None)
            if isinstance(own, Vehicle) and own.zero_sideslip_point_m != point_m:
                self.method.vehicle = replace(own, zero_sideslip_point_m=point_m)

    def set_destination(self, destination: Destination | None) -> None:
        """Where `step` is to go from now on; None: along the road. Whoever asks `plan` says it in the situation."""
        require_type_if_given("destination", destination, Destination)
        with self._one_thread.inside():
            self.sensing.destination = destination

    def reset(self) -> None:
        """Forgets tracks and the last plan."""
        with self._one_thread.inside():
            self.sensing.reset()
            self.memory, self._asked.previous = Memory(), None

    @usual_arithmetic
    def plan(self, situation: Situation) -> Plan:
        """One plan for a situation, judged. Never raises in traffic: a refusal is answered by the fallback, and so is an exception of a
        method with a ladder, with a `PlannerFaultWarning`.

        A situation that is not later than the last one begins without memory. Tracks that cannot all be true stop no planning
        (`Plan.doubts`). A host's state that no car can have is answered from one that the car can have (`HostPlausibility`): for a moment
        by the remainder of the previous plan, then by a stop, each judged.
        """
        require_type("situation", situation, Situation)
        if situation.vehicle not in (None, self.vehicle.name) and Path(situation.vehicle).stem != self.vehicle.name:
            rule = f"is not the car of this planner, {self.vehicle.name!r}, which a situation names by vehicle={self.vehicle.name!r}"
            raise ParameterError("situation.vehicle", situation.vehicle, rule)
        with self._one_thread.inside(), Held():
            return self._believing(situation)

    def _believing(self, situation: Situation) -> Plan:
        host, fault = self.sensing.believed(situation.host, situation.time_s, situation.road, self.previous)
        if not fault:
            return self._plan(situation, "", 0.0)
        wanted = None if situation.desired_speed_mps == situation.host.speed_mps else situation.desired_speed_mps  # None: as now
        return self._plan(replace(situation, host=host, desired_speed_mps=wanted), fault, self.sensing.faulty_s(situation.time_s))

    def _plan(self, situation: Situation, fault: str, faulty_s: float) -> Plan:
        """`fault` says what is wrong with the host's state as it was measured, and that for so long; the situation's is one that can be."""
        started = time.perf_counter()
        cycle = self._cycle(situation, self._asked.deadline(started))
        if fault and self._asked.has_ladder:
            plan, reported = with_reported_mode(host_refused(cycle, fault, faulty_s), cycle)
        else:
            plan, reported = with_reported_mode(self._answered(cycle), cycle)
            plan = with_time_to_react(plan, cycle)
        plan = with_loss_of_grip(plan, situation.host, self.vehicle, situation.road)
        self.memory = cycle.remember(plan, reported)
        indicator = plan.indicator if plan.side is Side.NONE else plan.side
        timing = Timing(total=1e3 * (time.perf_counter() - started), solve=plan.timing_ms.solve, verify=plan.timing_ms.verify)
        self._asked.previous = cycle.given_from(
            plan,
            planner=self.name,
            solver=plan.solver or self._asked.solver,
            indicator=indicator,
            destination=cycle.destination,
            timing_ms=timing,
            memory=self._carried(plan),
            situation=cycle.given,
            believed=cycle.believed,
            vehicle=self.vehicle,
        )
        return self._asked.previous

    def _cycle(self, situation: Situation, deadline: Deadline | None) -> Cycle:
        """Where nothing can be asked for what is remembered, which would be a fault of ours, that is forgotten, with a
        `PlannerFaultWarning`."""
        try:
            return Cycle.of(situation, self.vehicle, self.settings, self.memory, deadline)
        except Exception as error:
            if self.memory.is_empty:
                raise
            warnings.warn(f"what was remembered is forgotten: {told(error)}", PlannerFaultWarning, stacklevel=2)
            return Cycle.of(situation, self.vehicle, self.settings, Memory(), deadline)

    def _carried(self, plan: Plan) -> object:
        """What the plan takes along: the planner's memory, or what a method of another kind left for itself."""
        return plan.memory if plan.memory is not None and not isinstance(plan.memory, Memory) else self.memory

    def _answered(self, cycle: Cycle) -> Plan:
        """The method's answer, or the fallback's where that does not pass, or to no safe end."""
        answer = self._asked.answer(cycle)
        if isinstance(answer, NothingPasses):
            return fall_back(cycle, answer)
        if not self._asked.has_ladder:
            return answer
        if not answer.verdict.passed:
            rows, iterations = answer.candidates, answer.iterations
            return fall_back(
                cycle, NothingPasses(reason=answer.verdict.reason, candidates=rows, iterations=iterations, memory=cycle.memory)
            )
        if answer.safe_end is not None and not answer.safe_end.safe:
            return remainder_instead(cycle, answer)
        return answer

    @usual_arithmetic
    def step(
        self,
        measurements: Sequence[Scan],
        host: HostState,
        now: float,
        *,
        road: Road | None = None,
        desired_speed_mps: float | None = None,
        request: Request = Request.DRIVE,
        stop_line_s_m: float | None = None,
    ) -> Plan:
        """The whole pipeline: scans (each with its own time stamp) and the host's state at `now` [s] in, a judged plan out.

        `desired_speed_mps` left out is the host's speed now, of each cycle anew: who was slowed down stays slow. Say it in each cycle, as
        `stop_line_s_m`, where the front bumper is to wait now.
        What nobody can be tracked by (a clock that does not go on, a host whose place moves otherwise than its speed says, a radar whose
        returns never become a track) is said once, by a `MeasurementWarning`; its sectors count as not watched, but for a radar whose range
        rates alone are wrong.
        """
        now, measurements = finite("now", now, "s"), all_of("measurements", measurements, Scan)
        require_type("host", host, HostState)
        require_type_if_given("road", road, Road)
        with self._one_thread.inside():
            believed, _ = self.sensing.believed(host, now, road, self.previous)
            situation = self.sensing.situation(measurements, believed, now, road=road, desired_speed_mps=desired_speed_mps, request=request)
            return self.plan(situation if stop_line_s_m is None else replace(situation, stop_line_s_m=stop_line_s_m))
