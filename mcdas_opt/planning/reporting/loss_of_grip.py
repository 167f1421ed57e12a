"""A car whose rear tyres slide: its plan is labelled as what it is."""

from __future__ import annotations

from dataclasses import replace

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Alert, Status
from mcdas_opt.verification.sideslip import sideslip


def with_loss_of_grip(plan: Plan, host: HostState, vehicle: Vehicle, road: Road) -> Plan:
    """The plan itself while the rear tyres grip. Else it is `unavoidable`, with the judge's violation and the alert `act`: it is the plan
    of a car without slip that moves as this one does now, and nobody can say what the car makes of it, nor how it ends."""
    found = sideslip(host, vehicle, road)
    if found is None:
        return plan
    why = f"the rear tyres slide ({found}), and the car follows no plan; this one is of a car that grips"
    return replace(
        plan,
        status=Status.UNAVOIDABLE,
        verdict=replace(plan.verdict, violations=(found, *plan.verdict.violations)),
        safe_end=None,
        alert=Alert.ACT,
        warning=True,
        reason=f"{why}: {plan.reason}",
    )
