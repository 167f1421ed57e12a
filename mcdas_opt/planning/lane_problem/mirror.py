"""Left and right are solved as one: what steers right is mirrored, so that a mirrored scene has the mirrored plan to the bit.

Without it the order in which rows are summed differs between a scene and its mirror image, and a badly conditioned problem makes of the
last bit of a sum the sixth digit of a plan.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.planning.candidate import Proposed
from mcdas_opt.planning.lane_problem.lane_parameters import ObstacleSlots
from mcdas_opt.solvers.stage_problem import StageGuess

_ODD_STATES = np.array([1.0, -1.0, -1.0, 1.0, 1.0, -1.0])  # s, d, psi, v, a, delta
_ODD_INPUTS = np.array([1.0, -1.0])  # jerk, steering rate
_ODD_PARAMETERS = frozenset({"kappa", "kappa_slope", "kappa_nose", "kappa_tail", "ref_start_d", "ref_amplitude", "ref_bend"})
_NOTHING = 1e-9


def is_mirrored(situation: Situation, others: ObstacleSlots, proposed: Proposed) -> bool:
    """Whether this is solved in the mirror: steering right, or keeping the lane with more on the right than on the left."""
    if proposed.side is not Side.NONE:
        return proposed.side is Side.RIGHT
    return next((oddness < 0.0 for oddness in _oddnesses(situation, others, proposed) if abs(oddness) > _NOTHING), False)


def _oddnesses(situation: Situation, others: ObstacleSlots, proposed: Proposed) -> Iterator[float]:
    """What changes sign in the mirror, and is not 0 where left and right are told apart: the first that is not decides."""
    host, road, centre = situation.host, situation.road, proposed.path.start_d_m
    yield host.d_m - centre
    yield host.heading_rad
    yield host.steering_rad
    yield sum(sorted((d - centre for _, d, _ in others.first), key=abs))
    yield float(road.left_edge_at(host.s_m)) + float(road.right_edge_at(host.s_m)) - 2.0 * centre
    yield _lean_m(road)
    yield float(road.knots[1].sum())


def _lean_m(road: Road) -> float:
    """How much wider the road is to the left than to the right, summed over where its edges change."""
    return 0.0 if road.edges is None else float((road.edges.table[1] + road.edges.table[2]).sum())


def mirrored_states(x: Array) -> Array:
    """States (..., 6) in the mirror."""
    return np.asarray(x * _ODD_STATES)


def mirrored_inputs(u: Array) -> Array:
    """Inputs (..., 2) in the mirror."""
    return np.asarray(u * _ODD_INPUTS)


def mirrored_guess(guess: StageGuess) -> StageGuess:
    """A cold guess in the mirror."""
    return StageGuess(x=mirrored_states(guess.x), u=mirrored_inputs(guess.u), s=guess.s)


class MirroredParameters:
    """Parameters (N + 1, np) of these names in the mirror: lateral positions and curvatures change sign, the road's edges places too."""

    def __init__(self, names: Sequence[str]) -> None:
        odd = _ODD_PARAMETERS | {"left_edge", "right_edge", "left_slope", "right_slope"}
        self._sign = np.array([-1.0 if name in odd or (name.startswith("body") and name.endswith("_d")) else 1.0 for name in names])
        pairs = (("left_edge", "right_edge"), ("left_slope", "right_slope"))
        self._swapped = [(names.index(left), names.index(right)) for left, right in pairs if left in names]

    def __call__(self, p: Array) -> Array:
        mirrored = np.asarray(p * self._sign)
        for left, right in self._swapped:
            mirrored[:, [left, right]] = mirrored[:, [right, left]]
        return mirrored
