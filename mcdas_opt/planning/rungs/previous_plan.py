"""The remainder of the previous plan: judged once, it often still passes."""

from __future__ import annotations

from collections.abc import Iterator

from mcdas_opt.domain.plan import Candidate
from mcdas_opt.planning.candidate import Checked, Costed, Driven, Proposed
from mcdas_opt.planning.candidates.collision_check import verdicts
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.proposals.keep_lane import keep_path
from mcdas_opt.planning.rungs.remainder import remainder

NAME = "the remainder of the previous plan"


def previous_plan(cycle: Cycle, rows: list[Candidate]) -> Iterator[Checked]:
    """At most one."""
    previous, active = cycle.memory.previous, cycle.memory.active
    trajectory = remainder(previous, cycle.situation, cycle.vehicle)
    if previous is None or trajectory is None:
        return
    proposed = Proposed(
        name=NAME,
        mode=previous.mode,
        side=previous.side,
        path=keep_path(cycle) if active is None else active.path,
        speed_mps=float(trajectory.speed_mps[-1]),
        manoeuvre=active,
    )
    (verdict,) = verdicts((trajectory,), cycle)
    checked = Checked(driven=Driven(proposed=proposed, trajectory=trajectory), verdict=verdict)
    rows.append(Costed(checked=checked, cost=None).row())
    yield checked
