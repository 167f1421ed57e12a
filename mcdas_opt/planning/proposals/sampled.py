"""What competes with the basic four: the best few of the sampled family, and what else is in the list."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from mcdas_opt.domain.vocabulary import Mode, Sector, Side
from mcdas_opt.manoeuvres.kinds import best_of_kind
from mcdas_opt.planning.candidate import Proposed
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.lanes.manoeuvre import Manoeuvre
from mcdas_opt.planning.proposals.keep_lane import keep_path
from mcdas_opt.planning.proposals.sound_proposals import sound_proposals
from mcdas_opt.planning.proposals.unwatched import begins_unwatched
from mcdas_opt.reference.offset_path import corrected


def sampled(cycle: Cycle) -> tuple[Proposed, ...]:
    """The best few of different kind out of the sampled family: side, early or late, slower or faster, each with its own guess."""
    situation = cycle.situation
    host, proposals = situation.host, []
    for choice in best_of_kind(situation, cycle.vehicle, cycle.prediction, grid=cycle.settings.grid):
        name = f"{'keep' if choice.side is Side.NONE else choice.side.value}-{choice.pace}{'' if choice.early else '-late'}"
        if choice.side is Side.NONE:
            path, manoeuvre, mode = keep_path(cycle), None, Mode.BRAKE
        else:
            mode = Mode.EVADE
            path = corrected(
                start_s_m=host.s_m + host.speed_mps * choice.delay_s,
                start_d_m=host.d_m,
                target_d_m=choice.target_d_m,
                speed_mps=host.speed_mps,
                lateral_acceleration_mps2=choice.lateral_mps2,
                b=choice.softness,
            )
            manoeuvre = Manoeuvre(side=choice.side, path=path, target_d_m=choice.target_d_m, speed_mps=choice.end_speed_mps)
        refusal = begins_unwatched(cycle, choice.side)
        if choice.side is Side.NONE and choice.pace == "faster" and not situation.coverage.sees(Sector.FRONT):
            refusal = "nobody watches the front"
        proposals.append(
            Proposed(
                name=name,
                mode=mode,
                side=choice.side,
                path=path,
                speed_mps=choice.end_speed_mps,
                manoeuvre=manoeuvre,
                refusal=refusal,
                guess=choice.states,
                is_delayed=not choice.early,
            )
        )
    return tuple(proposals)


def further(cycle: Cycle) -> tuple[Proposed, ...]:
    """What competes with the basic four, in this order."""
    return sound_proposals(FURTHER, keep_path(cycle), cycle)


FURTHER: tuple[Callable[[Cycle], Iterable[Proposed]], ...] = (sampled,)
