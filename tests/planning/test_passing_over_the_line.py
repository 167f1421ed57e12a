"""On a street with a lane each way the host stood for good behind a parked car, or followed a cyclist, that leaves too little room within
its lane. It goes over the line once nobody comes."""

from __future__ import annotations

import pytest

from mcdas_opt import Scene, load_scene, simulate
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.vocabulary import Alert
from mcdas_opt.simulation.record import Simulation

CAR = load_vehicle("sedan")
HALF_M, THERE_M = 1.75, 70.0
PARKED = {"name": "parked", "s_m": THERE_M, "d_m": -1.2, "speed_mps": 0.0}
CYCLIST = {"name": "cyclist", "s_m": THERE_M, "d_m": -1.0, "speed_mps": 4.0, "kind": "bicycle", "length_m": 1.8, "width_m": 0.6}
WALKER = {"name": "walker", "s_m": THERE_M, "d_m": -0.9, "speed_mps": 1.2, "kind": "pedestrian", "length_m": 0.5, "width_m": 0.5}


def street(one: dict[str, object], *coming_s_m: float, side: int = 1) -> Scene:
    """Somebody at the right, traffic on the left comes at 12 m/s; mirrored with `side` -1."""
    document = load_scene("parked-car").model_dump(exclude_none=True)
    coming = [{"name": f"{s:g}", "s_m": s, "d_m": side * 2.0 * HALF_M, "speed_mps": 12.0, "oncoming": True} for s in coming_s_m]
    lanes = {"lanes_left": int(side > 0), "lanes_right": int(side < 0), "lane": [{"lane": side, "oncoming": True}]}
    road = {"lane_width_m": 2.0 * HALF_M, "friction": 0.9, "speed_limit_mps": 14.0, **lanes}
    return Scene.model_validate(
        document | {"duration_s": 32.0, "road": road, "neighbour": [one | {"d_m": side * float(str(one["d_m"]))}, *coming]}
    )


def over_the_line_m(drive: Simulation) -> float:
    return float(abs(drive.trajectory.d_m).max()) + 0.5 * CAR.width_m - HALF_M


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("one", [PARKED, CYCLIST, WALKER], ids=lambda one: str(one["name"]))
def test_is_passed_where_nobody_comes(one: dict[str, object], side: int) -> None:
    drive = simulate(street(one, side=side), seed=3)
    assert (drive.outcome, drive.fallbacks) == ("safe", 0)
    assert drive.trajectory.s_m[-1] > THERE_M + 32.0 * float(str(one["speed_mps"])) + 20.0
    assert 0.1 < over_the_line_m(drive) < 0.9
    assert abs(drive.trajectory.d_m[-1]) < 0.1
    assert drive.min_clearance_m > 0.4
    assert drive.trajectory.acceleration_mps2.min() > -2.5


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("one", [PARKED, CYCLIST], ids=lambda one: str(one["name"]))
def test_who_comes_is_let_through_first(one: dict[str, object], seed: int) -> None:
    drive = simulate(street(one, 120.0, 165.0, 210.0), seed=seed)
    assert (drive.outcome, drive.fallbacks) == ("safe", 0)
    assert drive.trajectory.s_m[-1] > THERE_M + 20.0
    assert drive.min_clearance_m > 0.4
    beside = abs(drive.trajectory.s_m - 210.0 + 12.0 * drive.trajectory.t_s) < 5.0
    assert max(abs(drive.trajectory.d_m[beside])) + 0.5 * CAR.width_m < HALF_M  # within its lane when the last one comes by
    assert drive.trajectory.acceleration_mps2.min() > -3.5


def test_without_an_end_of_those_who_come_it_waits_with_room_to_go_round() -> None:
    drive = simulate(street(PARKED, *(100.0 + 45.0 * k for k in range(12))), seed=1)
    assert (drive.outcome, drive.fallbacks) == ("safe", 0)
    assert drive.trajectory.speed_mps[-1] < 0.1
    gap_m = THERE_M - drive.trajectory.s_m[-1] - 0.5 * (4.5 + CAR.length_m)
    assert 5.0 < gap_m < 10.0
    assert "until the lane of oncoming traffic is seen to be free" in drive.cycles[-1].plan.reason


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("coming_s_m", [140.0, 160.0, 180.0])
def test_within_the_lane_it_is_not_braked_for_who_keeps_his_own(coming_s_m: float, side: int) -> None:
    """He is met with nearly a metre between while the host goes aside: it braked to walking pace, and warned."""
    inside = PARKED | {"d_m": -1.6}
    alone, met = simulate(street(inside, side=side), seed=2), simulate(street(inside, coming_s_m, side=side), seed=2)
    assert (met.outcome, met.fallbacks) == ("safe", 0)
    assert over_the_line_m(met) < 0.1
    assert met.trajectory.speed_mps.min() > alone.trajectory.speed_mps.min() - 1.0
    assert all(cycle.plan.alert is Alert.NONE for cycle in met.cycles)


def test_the_shipped_street() -> None:
    drive = simulate(load_scene("street"), seed=2)
    assert (drive.outcome, drive.fallbacks) == ("safe", 0)
    assert all(cycle.plan.alert is Alert.NONE for cycle in drive.cycles)
    over = drive.trajectory.t_s[abs(drive.trajectory.d_m) + 0.5 * CAR.width_m > HALF_M]
    second_s = drive.trajectory.t_s[drive.trajectory.s_m > 215.0 - 12.0 * drive.trajectory.t_s][0]
    assert over.size > 0
    assert over[0] > second_s - 0.5  # whoever comes is past
    assert drive.trajectory.s_m[-1] > 60.0 + 4.5 * 30.0 + 20.0
    assert drive.min_clearance_m > 0.8
