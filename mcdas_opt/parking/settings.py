"""The settings of `park`."""

from __future__ import annotations

from dataclasses import dataclass, field

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.rules import non_negative, positive, require
from mcdas_opt.errors import ParameterError, nearest
from mcdas_opt.parking.cost import COSTS, ParkingCosts
from mcdas_opt.parking.program.exchange import ExchangeSettings
from mcdas_opt.parking.program.guesses import GUESSES
from mcdas_opt.parking.search.arc_search import Resolution
from mcdas_opt.parking.search.resolution_refinement import RESOLUTIONS


@dataclass(frozen=True, slots=True, kw_only=True)
class ParkSettings:
    """All caps are counts, so that the same case gives the same answer.

    A time budget is an extra cap. The answer says when it was reached.
    """

    costs: ParkingCosts = COSTS["time"]
    exchange: ExchangeSettings = field(default_factory=ExchangeSettings)
    resolutions: tuple[Resolution, ...] = RESOLUTIONS
    guesses: tuple[str, ...] = ("search", "one-more")  # of `GUESSES`
    starts: int = 3  # guesses that the program is started from at most; so many anyhow until one has an answer
    left_out: int = 2  # times that the program tries to do without its shortest phase
    polish_up_to: int = 260  # intervals: what has at most so many is solved once more on a grid of half the spacing
    time_budget_s: float | None = None

    def __post_init__(self) -> None:
        require_types(self)
        for name in self.guesses:
            if name not in GUESSES:
                raise ParameterError("guesses", name, f"is unknown; {nearest(name, GUESSES)}")
        positive("starts", self.starts)
        require(self, non_negative, "left_out", "polish_up_to")
        if self.time_budget_s is not None:
            non_negative("time_budget_s", self.time_budget_s, "s")
