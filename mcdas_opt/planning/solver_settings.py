"""What one solve may cost, and which engine answers."""

from __future__ import annotations

from dataclasses import dataclass
from operator import attrgetter

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.rules import non_negative, require_every, within
from mcdas_opt.errors import ParameterError

_MOST_SLOTS = 64
_MOST_WORK = {"newton_steps": 10_000, "newton_steps_cycle": 100_000, "newton_steps_late": 10_000, "first_candidates": 1000}


@dataclass(frozen=True, slots=True, kw_only=True)
class SolverSettings:
    """Counted work and margins of one solve.

    `solver` is "interior-point" or "osqp". Where the interior point has no answer at all, OSQP is asked at once. `cold_start` "ipopt" gives
    every solve without a warm start to IPOPT: converged, and some hundred times slower.
    """

    solver: str = "interior-point"
    cold_start: str = "same"
    slots: tuple[int, ...] = (2, 4, 8)  # problems are built for these numbers of neighbours
    newton_steps: int = 60  # of the interior point, in one solve
    newton_steps_cycle: int = 240  # in all candidates of one cycle together; once they are used up, ...
    newton_steps_late: int = 15  # ... each further solve has so many
    first_candidates: int = 4  # so many are solved first at a threat, those that rank highest; the others where none of them will do
    closer_m: float = 0.1  # clearance along and across, where nothing passes and the nearest is solved again
    near_m: float = 0.5  # only what overlaps somebody by no more is solved again
    friction_share: float = 0.97
    clearance_along_m: float = 0.5
    clearance_across_m: float = 0.25
    clearance_on_foot_m: float = 1.5  # to people, on every side, where it can be had
    weights: tuple[tuple[str, float], ...] | None = None  # of the costs, by `weight_name`; None: as they are built in
    event_position_m: float = 0.5
    event_speed_mps: float = 0.5

    def __post_init__(self) -> None:
        require_types(self)
        for name, given, known in (
            ("solver", self.solver, ("interior-point", "osqp")),
            ("cold_start", self.cold_start, ("same", "ipopt")),
        ):
            if given not in known:
                raise ParameterError(name, given, f"must be {' or '.join(known)}")
        require_every(self, non_negative)
        within("friction_share", self.friction_share, 0.1, 1.0)
        if not self.slots or not all(1 <= count <= _MOST_SLOTS for count in self.slots):
            raise ParameterError("slots", self.slots, f"must be numbers of neighbours from 1 to {_MOST_SLOTS}")
        for name, most in _MOST_WORK.items():
            within(name, attrgetter(name)(self), 1, most)
        for name, weight in self.weights or ():
            non_negative(name, weight)
