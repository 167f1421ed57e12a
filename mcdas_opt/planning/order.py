"""The order of a whole cycle: the rounds of the search, gentlest first, then the rungs of the fallback."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from mcdas_opt.domain.plan import Candidate
from mcdas_opt.planning.candidate import Checked
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.rounds.active_manoeuvre import active_manoeuvre_alone, beside_the_active_manoeuvre
from mcdas_opt.planning.rounds.everything import everything
from mcdas_opt.planning.rounds.lane_keeping import lane_keeping
from mcdas_opt.planning.rounds.ranked_first import ranked_first
from mcdas_opt.planning.rungs.corrected_sigmoid import corrected_sigmoid
from mcdas_opt.planning.rungs.previous_plan import previous_plan
from mcdas_opt.planning.rungs.simple_drives import simple_drives, stop_in_lane
from mcdas_opt.planning.search import Rounds

Rung = Callable[[Cycle, list[Candidate]], Iterator[Checked]]  # its drives; what it tried is told in the list

SEARCH: tuple[Rounds, ...] = (
    lane_keeping,
    active_manoeuvre_alone,
    beside_the_active_manoeuvre,
    ranked_first,
    everything,
)
FALLBACK: tuple[Rung, ...] = (
    previous_plan,
    corrected_sigmoid,
    simple_drives,
)  # and the least severe of all that was driven, where none of these passes
HOST_REFUSED: tuple[Rung, ...] = (
    stop_in_lane,
    previous_plan,
    simple_drives,
)  # where nobody has known for a while how the host moves
