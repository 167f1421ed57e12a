"""How one drives among others while nothing presses."""

from __future__ import annotations

from dataclasses import dataclass

from mcdas_opt.domain.rules import bounded, measurable, require, true_or_false, word
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.errors import ParameterError


@dataclass(frozen=True, slots=True, kw_only=True)
class MannersSettings:
    """Traffic keeps to the side `drives_on`: after overtaking one goes back to the lane that one came from (`returns`), or, with
    `keeps_outer_lane`, to the outermost that is free; and faster cars pass on the other side alone (`passes_inside`), but in queues up to
    `queue_mps`, and from a lane that ends.

    A lane change that nothing forces (`changes_lanes`) is announced for `announced_s`, takes `changing_s`, and asks nobody behind for more
    braking than `follower_braking_mps2` (the safety criterion of MOBIL: Kesting, Treiber, Helbing, Transp. Res. Rec. 1999 (2007) 86, eq 2).
    It has to bring `advantage_mps`; back, once that lane has been free for `lingering_s`, it may cost `loss_mps`.
    """

    drives_on: Side = Side.RIGHT
    changes_lanes: bool = True
    returns: bool = True
    keeps_outer_lane: bool = False
    passes_inside: bool = True
    queue_mps: float = 17.0
    announced_s: float = 1.5
    lingering_s: float = 4.0
    changing_s: float = 5.0
    follower_braking_mps2: float = 2.0
    advantage_mps: float = 2.0
    loss_mps: float = 0.5

    def __post_init__(self) -> None:
        if type(self.drives_on) is not Side:
            object.__setattr__(self, "drives_on", word("manners.drives_on", self.drives_on, Side))
        if self.drives_on is Side.NONE:
            raise ParameterError("manners.drives_on", self.drives_on, "must be left or right")
        true_or_false("manners.changes_lanes", self.changes_lanes)
        true_or_false("manners.returns", self.returns)
        true_or_false("manners.keeps_outer_lane", self.keeps_outer_lane)
        true_or_false("manners.passes_inside", self.passes_inside)
        require(self, measurable, "changing_s", "follower_braking_mps2", "advantage_mps")
        require(self, bounded, "queue_mps", "announced_s", "lingering_s", "loss_mps")

    @property
    def inside(self) -> Side:
        """The side on which one overtakes."""
        return Side.LEFT if self.drives_on is Side.RIGHT else Side.RIGHT
