"""The tuned closed form: the corrected method on the gain schedule's paths."""

from __future__ import annotations

from dataclasses import replace

from mcdas_opt.baselines.corrected import CorrectedMethod
from mcdas_opt.catalogue.schedules import schedule_of
from mcdas_opt.domain.gain_schedule import GainSchedule
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import ParameterError
from mcdas_opt.planning.candidate import Proposed
from mcdas_opt.planning.candidates.driven_closed_form import Groups
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.proposals.evade import lateral_bound_mps2
from mcdas_opt.reference.tuned_path import tuned_path


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
