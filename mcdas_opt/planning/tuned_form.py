"""The tuned closed form: the corrected method on the gain schedule's paths."""

from __future__ import annotations

from dataclasses import replace

from mcdas_opt.catalogue.schedules import schedule_of
from mcdas_opt.domain.assessment import Assessment
from mcdas_opt.domain.gain_schedule import GainSchedule
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.errors import ParameterError
from mcdas_opt.planning.closed_form import CorrectedMethod
from mcdas_opt.planning.ways import Manoeuvre, Way, lateral_bound_mps2
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

    def groups(self, situation: Situation, assessment: Assessment, going: Manoeuvre | None) -> list[list[Way]]:
        return [[self._tuned(situation, assessment, way, going) for way in group] for group in super().groups(situation, assessment, going)]

    def _tuned(self, situation: Situation, assessment: Assessment, way: Way, going: Manoeuvre | None) -> Way:
        if way.manoeuvre is None or way.manoeuvre == going:
            return way
        host, sigmoid = situation.host, self.settings.sigmoid
        path = tuned_path(
            self.schedule,
            start_s_m=host.s_m,
            start_d_m=host.d_m,
            target_d_m=way.manoeuvre.target_d_m,
            speed_mps=max(host.speed_mps, way.speed_mps),
            offset_m=assessment.offset_m if way.side is Side.LEFT else -assessment.offset_m,
            friction=situation.road.friction,
            lateral_acceleration_mps2=lateral_bound_mps2(situation, sigmoid),
        )
        return replace(way, path=path, manoeuvre=replace(way.manoeuvre, path=path))
