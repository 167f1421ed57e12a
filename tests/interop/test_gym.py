"""Gymnasium's own checks on our environment; and between highway-env's frame and ours, against its own vehicle."""

from __future__ import annotations

import math
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.dynamics.bicycle import road_bicycle
from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.interop.gym.registration import ID, register_envs
from mcdas_opt.interop.gym.road_side import RoadSide, highway_vehicle, road_of

gymnasium = pytest.importorskip("gymnasium")
mid_vehicle = pytest.importorskip("mcdas_opt.interop.gym.mid_vehicle")

SHARP = np.array([0.0, 0.0], dtype=np.float32)


def make(**options: Any) -> Any:
    register_envs()
    return gymnasium.make(ID, **options)


def test_gymnasiums_checker_passes() -> None:
    from gymnasium.utils.env_checker import check_env

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(make().unwrapped, skip_render_check=True)


def test_registering_twice_changes_nothing() -> None:
    register_envs()
    before = gymnasium.registry[ID]
    register_envs()
    assert gymnasium.registry[ID] is before


@settings(max_examples=15)
@given(seed=st.integers(0, 2**31), actions=st.lists(st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)), min_size=5, max_size=30))
def test_the_same_seed_and_actions_give_the_same_episode(seed: int, actions: list[tuple[float, float]]) -> None:
    env = mid_vehicle.MidVehicle("sandwich-60-40")

    def episode() -> list[Any]:
        seen: list[Any] = [env.reset(seed=seed)[0].tolist()]
        for action in actions:
            observation, reward, ended, truncated, info = env.step(np.array(action, dtype=np.float32))
            assert env.observation_space.contains(observation)
            assert math.isfinite(reward)
            seen.append((observation.tolist(), reward, ended, truncated, info))
            if ended or truncated:
                break
        return seen

    assert episode() == episode()


def test_an_observation_says_what_is_there() -> None:
    env = mid_vehicle.MidVehicle("sandwich-60-40", spread=0.0)
    values = env.reset(seed=1)[0] * mid_vehicle.SCALES
    road, vehicle = env.scene.true_road, env.scene.vehicle
    assert values[:5] == pytest.approx([0.0, 0.0, 11.1, 0.0, 0.0], abs=1e-5)
    assert values[5:7] == pytest.approx([road.left_edge_m, -road.right_edge_m], abs=1e-5)
    slots = values[7:].reshape(-1, 6)
    assert sorted(slot[1] for slot in slots[:2]) == pytest.approx([-29.5, 29.5], abs=1e-4)
    rear = min(slots[:2], key=lambda slot: slot[1])
    assert rear[3] == pytest.approx(16.7 - 11.1, abs=1e-4)
    assert not slots[2:].any()
    assert vehicle.name == "sedan"


def test_who_has_left_is_in_no_slot(tmp_path: Path) -> None:
    (tmp_path / "gone.csv").write_text("t_s,s_m,d_m,heading_rad,speed_mps\n0,30,0,0,20\n0.5,40,0,0,20\n", "utf-8")
    scene = tmp_path / "scene.toml"
    scene.write_text(
        'duration_s = 3.0\n[host]\nspeed_mps = 15.0\n[[neighbour]]\nname = "gone"\ntrajectory = "gone.csv"\nleaves = true\n'
        '[[neighbour]]\nname = "stays"\ns_m = 80.0\nspeed_mps = 15.0\n',
        "utf-8",
    )
    env = mid_vehicle.MidVehicle(str(scene), spread=0.0)
    there = [int((env.reset(seed=1)[0][7:].reshape(-1, 6)[:, 0]).sum())]
    for _ in range(10):
        slots = env.step(np.zeros(2, dtype=np.float32))[0][7:].reshape(-1, 6)
        there.append(int(slots[:, 0].sum()))
    assert there == [2] * 6 + [1] * 5
    assert slots[0, 1] * 150.0 == pytest.approx(80.0, abs=0.1)
    assert not slots[1:].any()


def test_doing_nothing_in_the_sandwich_is_a_collision_and_ends() -> None:
    env = mid_vehicle.MidVehicle("sandwich-60-40", spread=0.0)
    env.reset(seed=1)
    rewards, ended = [], False
    for _ in range(80):
        _, reward, ended, truncated, info = env.step(SHARP)
        rewards.append(reward)
        if ended or truncated:
            break
    assert ended
    assert info["outcome"] == "collision"
    assert rewards[-1] == -10.0
    with pytest.raises(ParameterError, match="the episode has ended"):
        env.step(SHARP)


def test_full_left_leaves_the_road_and_full_right_mirrors_it() -> None:
    ends = []
    for sign in (1.0, -1.0):
        env = mid_vehicle.MidVehicle("benign-following", spread=0.0)
        env.reset(seed=1)
        ended = False
        while not ended:
            _, _, ended, truncated, info = env.step(np.array([0.0, sign], dtype=np.float32))
            assert not truncated
        ends.append((env.host.d_m, info["outcome"]))
    assert ends[0][1] in ("left_road", "collision")
    assert ends[0][0] > 0.0 > ends[1][0]


def test_an_episode_that_nothing_ends_is_truncated_at_the_scenes_end() -> None:
    env = mid_vehicle.MidVehicle("benign-following", spread=0.0)
    env.reset(seed=1)
    steps, truncated = 0, False
    while not truncated:
        _, _, ended, truncated, _ = env.step(SHARP)
        assert not ended
        steps += 1
    assert steps == math.ceil(env.scene.duration_s / mid_vehicle.CYCLE_S - 1e-9)


def test_resets_draw_different_scenes_unless_told_not_to() -> None:
    env = mid_vehicle.MidVehicle("sandwich-60-40")
    drawn = {env.reset(seed=seed)[1]["t_s"] + env.scene.neighbour[0].s_m for seed in range(8)}
    assert len(drawn) == 8
    assert all(abs(s - 29.5) <= 5.0 for s in drawn)


def test_bad_input_is_named() -> None:
    with pytest.raises(InputError, match="no-such-scene"):
        mid_vehicle.MidVehicle("no-such-scene")
    with pytest.raises(ParameterError, match="plant = 'flying'"):
        mid_vehicle.MidVehicle(plant="flying")
    with pytest.raises(ParameterError, match="spread"):
        mid_vehicle.MidVehicle(spread=-1.0)
    with pytest.raises(ParameterError, match="render_mode"):
        mid_vehicle.MidVehicle(render_mode="human")
    env = mid_vehicle.MidVehicle()
    env.reset(seed=0)
    with pytest.raises(ParameterError, match="two finite numbers"):
        env.step(np.array([np.nan, 0.0], dtype=np.float32))


# ---- highway-env's frame


@given(
    x=st.floats(0.0, 500.0),
    y=st.floats(-2.0, 14.0),
    heading=st.floats(-0.3, 0.3),
    speed=st.floats(1.0, 40.0),
    acceleration=st.floats(-5.0, 5.0),
    steering=st.floats(-0.5, 0.5),
)
def test_its_car_moves_as_ours_does(x: float, y: float, heading: float, speed: float, acceleration: float, steering: float) -> None:
    """A short step of its own vehicle, seen through the flip, is our bicycle's: left stays left, and so does everything else."""
    kinematics = pytest.importorskip("highway_env.vehicle.kinematics")
    h, side, car = 1e-4, RoadSide(x_m=30.0, y_m=4.0), highway_vehicle()

    def seen(its: Any) -> np.ndarray:
        state = side.host(
            x=its.position[0], y=its.position[1], heading=its.heading, speed=its.speed, acceleration=acceleration, steering=steering
        )
        return state.to_vector()

    its = kinematics.Vehicle(None, [x, y], heading, speed)
    before = seen(its)
    asked, turned = side.action(before[4], before[5])
    assert (asked, turned) == pytest.approx((acceleration, steering))
    its.act({"acceleration": asked, "steering": turned})
    its.step(h)
    rates = (seen(its) - before) / h
    ours = road_bicycle(before.tolist(), (0.0, 0.0), 0.0, car.wheelbase_m, car.centre_m, math)
    assert rates[:2] == pytest.approx(ours[:2], abs=0.05 + 0.01 * speed * abs(steering))
    assert rates[2] == pytest.approx(ours[2], rel=0.01, abs=1e-3)  # 0.4 %: our car has a centimetre of bumper
    assert rates[3] == pytest.approx(acceleration * math.cos(math.atan(0.5 * math.tan(steering))), abs=1e-6)


@given(lane=st.integers(0, 3), lanes=st.integers(4, 5), offset=st.floats(-1.9, 1.9), car=st.integers(0, 3))
def test_lanes_and_edges_are_where_it_has_them(lane: int, lanes: int, offset: float, car: int) -> None:
    """Lane 0 there is the leftmost; a car in a lane with a smaller number is to the left of one in ours."""
    network = pytest.importorskip("highway_env.road.road").RoadNetwork.straight_road_network(lanes)
    width = network.get_lane(("0", "1", 0)).width
    road = road_of(lanes, lane, width, speed_limit_mps=30.0)
    side = RoadSide(x_m=0.0, y_m=lane * width)
    x, y = network.get_lane(("0", "1", car)).position(50.0, offset)
    track = side.track("a", x=float(x), y=float(y), heading=0.1, speed=20.0)
    assert road.lane_of(track.d_m, track.s_m) == lane - car
    assert track.s_m == pytest.approx(50.0)
    assert track.speed_d_mps < 0.0  # its positive heading turns right
    top = network.get_lane(("0", "1", 0)).position(0.0, -0.5 * width)[1]
    bottom = network.get_lane(("0", "1", lanes - 1)).position(0.0, 0.5 * width)[1]
    assert (side.y_m - float(top), side.y_m - float(bottom)) == pytest.approx((road.left_edge_m, road.right_edge_m))


def test_the_planner_drives_an_episode_and_so_does_idm() -> None:
    pytest.importorskip("highway_env")
    from mcdas_opt.interop.gym.highway import EpisodeSettings, HighwayDriver, episode, make_highway

    wanted = EpisodeSettings(duration_s=3.0, vehicles=8, frequency_hz=10)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of its own making
        env, driver = make_highway(wanted), HighwayDriver()
        ours, again, theirs = (episode(env, 3, who) for who in (driver, driver, None))
        env.reset(seed=3)
        driver.reset()
        situation = driver.situation(env)
    assert ours == again
    assert (ours.agent, theirs.agent) == ("mpc", "idm-mobil")
    assert ours.duration_s == pytest.approx(3.0)
    for one in (ours, theirs):  # the time gaps are of the same drive
        assert one.ordinary.duration_s == pytest.approx(one.duration_s)
        assert one.ordinary.mean_speed_mps == pytest.approx(one.mean_speed_mps, rel=0.02)
        assert one.ordinary.lane_changes == one.lane_changes
    assert not ours.collided
    assert ours.on_road
    assert ours.unverified_plans == 0
    assert theirs.unverified_plans is None
    assert (situation.host.s_m, situation.host.d_m) == (0.0, 0.0)
    assert all(track.s_m > 0.0 for track in situation.tracks)  # everybody begins ahead of the ego
    assert situation.road.lanes_left + situation.road.lanes_right == 3


def test_episode_settings_are_checked() -> None:
    pytest.importorskip("highway_env")
    from mcdas_opt.interop.gym.highway import EpisodeSettings

    with pytest.raises(ParameterError, match="frequency_hz = 15 Hz: must be a multiple of 10"):
        EpisodeSettings(frequency_hz=15)
    with pytest.raises(ParameterError, match="vehicles"):
        EpisodeSettings(vehicles=0)
