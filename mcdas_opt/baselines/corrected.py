"""The corrected sigmoid as a method, its numbers its own or a schedule's: no optimiser, no fallback."""

from __future__ import annotations

import time
from dataclasses import replace

from mcdas_opt.baselines.lane import LaneMethod
from mcdas_opt.catalogue.designs import schedule_of
from mcdas_opt.domain.gain_schedule import GainSchedule
from mcdas_opt.domain.plan import Plan, Timing
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import ParameterError
from mcdas_opt.planning.candidate import Proposed
from mcdas_opt.planning.candidates.collision_check import exact
from mcdas_opt.planning.candidates.driven_closed_form import Groups, closed_form, groups
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.memory import Memory, carried
from mcdas_opt.planning.proposals.evade import lateral_bound_mps2
from mcdas_opt.reference.tuned_path import tuned_path


class CorrectedMethod(LaneMethod):
    """The corrected sigmoid, driven: the first candidate, gentle ones first, that the judge passes.

    Order of trial: the active manoeuvre; keep the lane when nothing threatens; of the two sides the one that costs less (equal ones by the
    tie-break), braking, accelerating. When none passes, the first tried leaves with its failed verdict.
    """

    name = "closed-form-corrected"

    def drive(self, situation: Situation, previous: Plan | None) -> Plan:
        started = time.perf_counter()
        cycle = Cycle.of(situation, self.vehicle, self.settings, carried(previous, Memory))
        found = closed_form(cycle, self.groups(cycle))
        checked = found.chosen.checked
        if not checked.verdict.passed:
            checked = exact(checked, cycle)
        proposed, assessment = checked.proposed, cycle.assessment
        plan = Plan(
            planner=self.name,
            mode=proposed.mode,
            side=proposed.side,
            warning=assessment.warning,
            reason=assessment.reason,
            verdict=checked.verdict,
            prediction=cycle.prediction.name,
            trajectory=checked.trajectory,
            candidates=tuple(one.row() for one in found.tried),
            timing_ms=Timing(solve=1e3 * (time.perf_counter() - started)),
            literal_mode=assessment.literal_mode,
            memory=Memory(situation=situation, origin_m=cycle.origin_m, assessment=assessment, active=proposed.manoeuvre),
        )
        return cycle.given_from(plan)

    def groups(self, cycle: Cycle) -> Groups:
        """What is tried, in order."""
        return groups(cycle)


class TunedMethod(CorrectedMethod):
    """As `closed-form-corrected`, but where steering begins a and b come from `models/tuned` by speed, offset and friction.

    The path ends in the middle of the target lane and is not bent: v^2 |kappa| of the path is proved to stay under the bound.
    """

    name = "closed-form-tuned"

    def __init__(self, vehicle: Vehicle, settings: Settings | None = None, schedule: GainSchedule | None = None) -> None:
        super().__init__(vehicle, settings)
        if self.settings.sigmoid.given is not None:
            raise ParameterError("planner", self.name, "takes its sigmoid from models/tuned, not from a file of parameters")
        self.schedule = schedule or schedule_of(vehicle.name)

    def groups(self, cycle: Cycle) -> Groups:
        return [[self._tuned(proposed, cycle) for proposed in group] for group in super().groups(cycle)]

    def _tuned(self, proposed: Proposed, cycle: Cycle) -> Proposed:
        if proposed.manoeuvre is None or proposed.manoeuvre == cycle.active:
            return proposed
        situation, sigmoid, offset_m = cycle.situation, self.settings.sigmoid, cycle.assessment.offset_m
        path = tuned_path(
            self.schedule,
            start_s_m=situation.host.s_m,
            start_d_m=situation.host.d_m,
            target_d_m=proposed.manoeuvre.target_d_m,
            speed_mps=max(situation.host.speed_mps, proposed.speed_mps),
            offset_m=proposed.side.sign * offset_m,
            friction=situation.road.friction,
            lateral_acceleration_mps2=lateral_bound_mps2(situation, sigmoid),
        )
        return replace(proposed, path=path, manoeuvre=replace(proposed.manoeuvre, path=path))
