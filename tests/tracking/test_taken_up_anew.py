"""A body that is not of the size assumed is seen elsewhere than expected: its track is taken up anew, and not lost meanwhile."""

from __future__ import annotations

from itertools import pairwise

import pytest

from mcdas_opt import Scene, simulate

LENGTH_M, WIDTH_M, LANE_M = 16.5, 2.55, 3.7


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("seed", [1, 4, 7, 11])
def test_a_lorry_that_is_overtaken_is_seen_in_every_cycle_but_one(seed: int, side: float) -> None:
    """By radars that take everybody for a car. It was lost for 1.1 s at a time, its track drifting into the host's lane."""
    radars = {"front": "delphi_esr", "rear": "delphi_esr", "left": "corner_radar", "right": "corner_radar"}
    lorry = {
        "name": "lorry",
        "kind": "lorry",
        "s_m": 20.0,
        "d_m": side * LANE_M,
        "speed_mps": 24.0,
        "length_m": LENGTH_M,
        "width_m": WIDTH_M,
    }
    scene = Scene.model_validate(
        {
            "name": "overtaken",
            "duration_s": 4.0,
            "seed": seed,
            "road": {"lane_width_m": LANE_M, "lanes_left": 1, "lanes_right": 1},
            "host": {"speed_mps": 27.8},
            "neighbour": [lorry],
            "sensors": radars,
        }
    )
    unseen = [all(track.coasting for track in cycle.tracks) for cycle in simulate(scene).cycles]
    assert not any(now and then for now, then in pairwise(unseen))
