"""A car parked half in the lane is driven past, slowly and within the lane; the host stood behind it for good."""

from __future__ import annotations

import pytest

from mcdas_opt import Scene, load_scene, simulate
from mcdas_opt.domain.vocabulary import Alert

SCENE = load_scene("parked-car")
HALF_M = 0.5 * SCENE.road.lane_width_m
PARKED_M = SCENE.neighbour[0].s_m


def parked(d_m: float) -> Scene:
    """The first one alone, there."""
    document = SCENE.model_dump(exclude_none=True)
    document["neighbour"] = [document["neighbour"][0] | {"d_m": d_m}]
    return Scene.model_validate(document)


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("d_m", [-2.4, -2.0, -1.7, 1.9])
def test_is_passed_by_radar(d_m: float, seed: int) -> None:
    drive = simulate(parked(d_m), seed=seed)
    assert drive.outcome == "safe"
    assert drive.trajectory.s_m[-1] > PARKED_M + 20.0
    assert drive.min_clearance_m > 0.5
    assert abs(drive.trajectory.d_m).max() + 0.9 < HALF_M
    assert drive.fallbacks == 0
    assert drive.trajectory.speed_mps.min() < 11.0  # it is slowed down for
    assert drive.trajectory.acceleration_mps2.min() > -3.5


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_two_at_different_sides_are_passed_one_after_the_other(seed: int) -> None:
    drive = simulate(SCENE, seed=seed)
    assert drive.outcome == "safe"
    assert drive.min_clearance_m > 0.5
    assert drive.trajectory.s_m[-1] > SCENE.neighbour[1].s_m
    assert drive.trajectory.d_m.max() > 0.3
    assert drive.trajectory.d_m.min() < -0.1
    assert drive.fallbacks == 0
    assert all(cycle.plan.alert is Alert.NONE for cycle in drive.cycles)
    assert drive.max_lateral_acceleration_mps2 < 1.5  # it goes from one side to the other gradually
    assert drive.trajectory.speed_mps.max() < SCENE.host.speed_mps + 0.1


def test_who_leaves_no_room_is_stopped_behind() -> None:
    drive = simulate(parked(-1.2))
    assert drive.outcome == "safe"
    assert drive.trajectory.speed_mps[-1] < 0.1
    assert abs(drive.trajectory.d_m).max() < 0.1
