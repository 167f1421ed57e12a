"""The mode that a plan is reported as: what it does, and the same for a second unless something new happens."""

from __future__ import annotations

from dataclasses import replace

from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.variant import Variant, names_of
from mcdas_opt.domain.vocabulary import Mode, Sector, Side, Status
from mcdas_opt.planning.candidate import strongest_mps2
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.front.headway import ORDINARY_MPS2
from mcdas_opt.planning.memory import ReportedMode
from mcdas_opt.planning.traffic.local_situation import in_order

REPORTED_S, _ROUNDING_S = 1.0, 1e-6
_OPPOSITE_MPS2 = 0.3  # a plan that does as much of the opposite is not what it was
_BAND_MPS2 = 0.5  # beyond which a plan is clearly more than ordinary
_GENTLY_MPS2 = 0.7  # who braked, or accelerated, and still does by so much, goes on


def with_reported_mode(plan: Plan, cycle: Cycle) -> tuple[Plan, ReportedMode]:
    """The plan, and what the next cycle must know of its mode.

    It keeps the mode of the cycle before, where that is not a second old and not the opposite of what the plan does, nobody new is there,
    and the threats are the same. What was more than ordinary stays so until it is clearly less. Where it changes within a second all the
    same, the reason says what is new.
    """
    before = cycle.memory.reported
    now = ReportedMode(
        mode=plan.mode,
        side=plan.side,
        status=plan.status,
        threats=cycle.assessment.threats,
        tracks=(tracks := frozenset(track.id for track in cycle.given.tracks)),
        foreseen=frozenset(body.id for body in cycle.prediction.bodies) - tracks | _seen_to_brake(cycle),
    )
    if before is None:
        return plan, now
    age_s = before.age_s + cycle.memory.elapsed_s
    is_same = age_s < REPORTED_S and not now.is_news_after(before) and still_agrees(before.mode, plan)
    if is_same or (plan.mode in (Mode.HOLD, Mode.CRUISE) and _goes_on(before.mode, plan)):
        now = replace(now, mode=before.mode)
    if (now.mode, now.side) == (before.mode, before.side):
        now = replace(now, age_s=age_s)
    elif age_s < REPORTED_S - _ROUNDING_S:
        plan = replace(
            plan, reason=f"{plan.reason}; {now.mode.value} {age_s:.1f} s after {before.mode.value} began: {_news(now, before, cycle)}"
        )
    return plan if plan.mode is now.mode else replace(plan, mode=now.mode), now


def _seen_to_brake(cycle: Cycle) -> frozenset[str]:
    """Of those who are expected to brake, who does already."""
    attentive = (track for track in cycle.situation.tracks if track.id in cycle.observed.attentive)
    return frozenset(Variant.BRAKING.of(track.id) for track in attentive if track.braking_seen_mps2)


def _news(now: ReportedMode, before: ReportedMode, cycle: Cycle) -> str:
    """What there is now that was not, or is no more; from behind to ahead, whatever anybody is called."""
    from_behind = [name for track in in_order(cycle.given).tracks for name in names_of(track.id)]
    order = {name: k for k, name in enumerate((*sorted(Sector), *from_behind))}
    said = [f"{', '.join(sorted(there, key=lambda name: order.get(name, -1)))} {verb}" for there, verb in _changes(now, before) if there]
    if now.status is not before.status:
        said.append("a candidate passes again" if now.status is Status.PLANNED else "no candidate passes to a safe end")
    return ", ".join(said) or "by its cost alone"


def _changes(now: ReportedMode, before: ReportedMode) -> tuple[tuple[frozenset[str], str], ...]:
    gone = (before.foreseen - now.foreseen) & _names(now.tracks)
    came = (now.foreseen - before.foreseen) & _names(before.tracks)
    threats, threatened = (frozenset(sector.value for sector in one.threats) for one in (now, before))
    return (
        (now.tracks - before.tracks, "not seen before"),
        (threats - threatened, "threatens"),
        (threatened - threats, "no longer threatens"),
        (came, "foreseen now"),
        (gone, "no longer foreseen"),
    )


def _names(tracks: frozenset[str]) -> frozenset[str]:
    return frozenset(name for track in tracks for name in names_of(track))


def _goes_on(mode: Mode, plan: Plan) -> bool:
    """Whether a plan that keeps its lane brakes, or accelerates, on as it did, if more gently."""
    strongest = strongest_mps2(plan.trajectory) * (1.0 if mode is Mode.ACCELERATE else -1.0)
    return mode in (Mode.ACCELERATE, Mode.BRAKE) and plan.side is Side.NONE and strongest > _GENTLY_MPS2


def still_agrees(mode: Mode, plan: Plan) -> bool:
    """Whether a plan to the same side may go on under this mode: it does not do the opposite, nor clearly more than ordinary driving under
    one that promises no more."""
    if (mode is Mode.EVADE) != (plan.side is not Side.NONE) or (mode is Mode.PARK) != (plan.mode is Mode.PARK):
        return False
    strongest = strongest_mps2(plan.trajectory)
    if mode is Mode.BRAKE:
        return strongest < _OPPOSITE_MPS2
    if mode is Mode.ACCELERATE:
        return strongest > -_OPPOSITE_MPS2
    return mode in (Mode.EVADE, Mode.PARK) or abs(strongest) <= ORDINARY_MPS2 + _BAND_MPS2
