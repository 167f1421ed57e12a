"""The corrected sigmoid as a method: no optimiser, no fallback."""

from __future__ import annotations

import time

from mcdas_opt.domain.plan import Plan, Refusal, Timing
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Request
from mcdas_opt.planning.candidates.collision_check import exact
from mcdas_opt.planning.candidates.driven_closed_form import Groups, closed_form, groups
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.memory import Memory, carried


class CorrectedMethod:
    """The corrected sigmoid, driven: the first candidate, gentle ones first, that the judge passes.

    Order of trial: the active manoeuvre; keep the lane when nothing threatens; of the two sides the one that costs less (equal ones by the
    tie-break), braking, accelerating. When none passes, the first tried leaves with its failed verdict.
    """

    has_ladder = False
    name = "closed-form-corrected"

    def __init__(self, vehicle: Vehicle, settings: Settings | None = None) -> None:
        self.vehicle, self.settings = vehicle, settings or Settings()

    def plan(self, situation: Situation, previous: Plan | None) -> Plan | Refusal:
        if situation.request is Request.PARK:
            return Refusal(reason="parking is planned by park, not by the lane planner")
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
