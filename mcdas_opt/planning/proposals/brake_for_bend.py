"""Braking harder than is comfortable before a bend that the host comes to much too fast."""

from __future__ import annotations

import math

import numpy as np

from mcdas_opt.domain.vocabulary import Mode, Side
from mcdas_opt.dynamics.axle_limits import available_mps2
from mcdas_opt.planning.candidate import Proposed
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.proposals.keep_lane import HARDER, keep_path
from mcdas_opt.reference.speed_profile import squares_in_bends

BRAKE_FOR_BEND = "brake-for-bend"
_BEARABLE = 0.5  # of the road's grip: what a bend may ask for across before it is braked for harder than is comfortable
_STEP_M, _NEAREST_M = 2.0, 5.0


def brake_for_bend(cycle: Cycle) -> Proposed | None:
    """As hard as brings the host to every bend ahead at a bearable lateral acceleration; None where late braking in comfort does."""
    situation, path, comfort = cycle.situation, keep_path(cycle), cycle.settings.comfort
    host, road, times_s = situation.host, situation.road, cycle.settings.grid.times_s
    if road.is_straight:
        return None
    bearable_mps2 = max(_BEARABLE * road.grip_mps2, comfort.on(road.grip_mps2).lateral_mps2)
    places_m = _STEP_M * np.arange(math.ceil(host.speed_mps**2 / (2.0 * comfort.late_braking_mps2 * _STEP_M)) + 1, dtype=np.float64)
    squares = squares_in_bends(road, host.s_m + places_m, path.target_d_m, bearable_mps2)
    needed = (host.speed_mps**2 - squares) / (2.0 * np.maximum(places_m, _NEAREST_M))
    worst = int(np.argmax(needed))
    if needed[worst] <= comfort.late_braking_mps2:
        return None
    rate = min(HARDER * float(needed[worst]), available_mps2(cycle.vehicle, road.friction)[0])
    speeds = np.maximum(host.speed_mps - rate * times_s, min(math.sqrt(squares[worst]), host.speed_mps))
    return Proposed(
        name=BRAKE_FOR_BEND,
        mode=Mode.BRAKE,
        side=Side.NONE,
        path=path,
        speed_mps=float(speeds[-1]),
        speeds_mps=speeds,
        relies_on_followers=True,
    )
