"""Traffic: recorded and following neighbours, what they did before the scene, and what the judge is told of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mcdas_opt.catalogue.scenes import load_scene, scene_from_document
from mcdas_opt.domain.prediction import BodyMotion
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.dynamics.car_following import IdmSettings, Leader, idm_acceleration
from mcdas_opt.errors import ParameterError
from mcdas_opt.plotting.animation import sheet
from mcdas_opt.simulation.idm import STEP_S, step_times
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.neighbours import Traffic, host_before, known_bodies
from mcdas_opt.simulation.record import NeighbourHistory, Simulation
from mcdas_opt.simulation.recorded import GONE_M
from tests.simulation.scene_maker import make_scene


def host_motion(s_m: Any, speed_mps: Any, d_m: float = 0.0) -> BodyMotion:
    s, v = np.broadcast_arrays(np.asarray(s_m, dtype=float), np.asarray(speed_mps, dtype=float))
    zero = np.zeros_like(s)
    return BodyMotion(s_m=s, d_m=zero + d_m, heading_rad=zero, speed_s_mps=v, speed_d_mps=zero)


def cruising(t: np.ndarray, speed: float = 11.1) -> Trajectory:
    zero = np.zeros_like(t)
    keys = ("d_m", "heading_rad", "acceleration_mps2", "steering_rad", "steering_rate_radps", "jerk_mps3")
    return Trajectory(t_s=t, s_m=speed * t, speed_mps=zero + speed, **dict.fromkeys(keys, zero))


def test_the_shipped_sandwich_stands_as_the_paper_has_it() -> None:
    traffic = Traffic(load_scene("sandwich-60-40"))
    front, rear = traffic.bodies(0.0)
    assert (front.s_m, front.speed_mps, rear.s_m, rear.speed_mps) == (29.5, 11.1, -29.5, 16.7)
    assert traffic.bodies(2.0)[1].s_m == pytest.approx(-29.5 + 2 * 16.7)


def recorded_scene(tmp_path: Path, rows: list[tuple[float, ...]]) -> Any:
    text = "t_s,s_m,d_m,heading_rad,speed_mps\n" + "\n".join(",".join(map(str, row)) for row in rows)
    (tmp_path / "other.csv").write_text(text)
    scene = tmp_path / "scene.toml"
    scene.write_text('[road]\nlanes_left = 1\n[host]\nspeed_mps = 10.0\n[[neighbour]]\nname = "other"\ntrajectory = "other.csv"\n')
    return load_scene(scene)


def test_a_recording_is_played_linearly_and_goes_on_at_its_last_speed(tmp_path: Path) -> None:
    scene = recorded_scene(tmp_path, [(0.0, 20.0, 0.0, 0.0, 10.0), (1.0, 30.0, 1.0, 0.1, 10.0), (2.0, 41.0, 2.0, 0.1, 12.0)])
    path = Traffic(scene).motions(np.array([-1.0, 0.0, 0.5, 1.5, 2.0, 3.0]))[0]
    np.testing.assert_allclose(path.s_m, [10.0, 20.0, 25.0, 35.5, 41.0, 53.0])
    np.testing.assert_allclose(path.d_m, [0.0, 0.0, 0.5, 1.5, 2.0, 2.0])
    np.testing.assert_allclose(path.heading_rad, [0.0, 0.0, 0.05, 0.1, 0.1, 0.0])
    assert path.speed_s_mps[-1] == 12.0


def test_a_recording_that_begins_late_has_come_at_its_first_speed(tmp_path: Path) -> None:
    scene = recorded_scene(tmp_path, [(2.0, 60.0, 0.0, 0.0, 10.0), (3.0, 70.0, 0.0, 0.0, 10.0)])
    assert scene.neighbour[0].initial[0] == 40.0
    np.testing.assert_allclose(Traffic(scene).motions(np.array([-1.0, 0.0, 1.0, 2.0, 2.5]))[0].s_m, [30.0, 40.0, 50.0, 60.0, 65.0])


def test_idm_formula_against_hand_computed_values() -> None:
    s = IdmSettings()
    assert idm_acceleration(20.0, 20.0, None, s) == 0.0
    assert idm_acceleration(0.0, 20.0, None, s) == pytest.approx(0.73)
    # equilibrium: at the speed of the leader, gap (s0 + vT) / sqrt(1 - (v / v0)^4) holds it
    gap = (2.0 + 10.0 * 1.6) / np.sqrt(1.0 - 0.5**4)
    assert idm_acceleration(10.0, 20.0, Leader(gap, 10.0), s) == pytest.approx(0.0, abs=1e-12)
    assert idm_acceleration(20.0, 20.0, Leader(0.0, 0.0), s) == -8.0


def follower(s_m: float, speed: float, **more: Any) -> dict[str, Any]:
    return {"name": f"idm{s_m:g}", "s_m": s_m, "speed_mps": speed, "behaviour": "idm", **more}


def test_a_follower_settles_behind_the_host_without_touching() -> None:
    scene = make_scene(follower(-40.0, 16.7, reaction_s=0.5))
    traffic = Traffic(scene)
    t = step_times(0, 6000)
    traffic.advance(host_motion(11.1 * t, 11.1))
    path = traffic.motions(t)[0]
    assert (11.1 * t - path.s_m).min() > 4.5
    assert path.speed_s_mps[-1] == pytest.approx(11.1, abs=0.02)
    gap = 11.1 * t[-1] - path.s_m[-1] - 4.5
    assert gap == pytest.approx((2.0 + 11.1 * 1.6) / np.sqrt(1.0 - (11.1 / 16.7) ** 4), rel=0.02)


def test_a_follower_reacts_after_its_reaction_time_and_not_before() -> None:
    t = step_times(0, 400)
    speed = np.where(t < 1.0, 11.1, 5.0)
    s = np.concatenate([[0.0], np.cumsum(speed[:-1] * STEP_S)])
    paths = []
    for host in (host_motion(s, speed), host_motion(11.1 * t, 11.1)):
        traffic = Traffic(make_scene(follower(-30.0, 11.1, reaction_s=0.7)))
        traffic.advance(host)
        paths.append(traffic.motions(t)[0].speed_s_mps)
    different = np.flatnonzero(paths[0] != paths[1])
    assert t[different[0]] == pytest.approx(1.7 + STEP_S)


def test_followers_follow_one_another_and_ignore_the_next_lane() -> None:
    scene = make_scene(
        follower(-30.0, 15.0),
        follower(-50.0, 15.0),
        {"name": "slow", "s_m": -20.0, "d_m": 3.7, "speed_mps": 1.0},
        follower(-80.0, 15.0, d_m=-3.7),
    )
    traffic = Traffic(scene)
    t = step_times(0, 2000)
    traffic.advance(host_motion(10.0 * t, 10.0))
    first, second, _, alone = traffic.motions(t)
    assert (first.s_m - second.s_m).min() > 4.5
    assert second.speed_s_mps[-1] < 12.0
    np.testing.assert_allclose(alone.speed_s_mps, 15.0)


def test_followers_ignore_who_is_beside_the_road() -> None:
    one_lane = {"lanes_left": 0, "lanes_right": 0}
    beside = ({"s_m": 70.0, "d_m": 15.0, "speed_mps": 0.0}, {"s_m": 90.0, "d_m": 5.0, "speed_mps": 9.0, "heading_rad": 3.14159})
    ends = []
    for others in ((), beside):
        traffic = Traffic(make_scene(follower(35.0, 12.0), *others, road=one_lane))
        traffic.advance(host_motion(11.1 * step_times(0, 800), 11.1))
        ends.append(float(traffic.motions(np.array(8.0))[0].s_m))
    assert ends[0] == ends[1] == pytest.approx(35.0 + 8.0 * 12.0)


def test_a_follower_beside_the_road_ignores_who_is_on_it() -> None:
    scene = make_scene(follower(-30.0, 15.0, d_m=15.0), speed_mps=5.0, road={"lanes_left": 0, "lanes_right": 0})
    traffic = Traffic(scene)
    traffic.advance(host_motion(5.0 * step_times(0, 600), 5.0))
    assert float(traffic.motions(np.array(6.0))[0].s_m) == pytest.approx(60.0)


def test_in_steps_or_at_once_followers_go_the_same_way() -> None:
    scene = make_scene(follower(-30.0, 15.0), {"name": "front", "s_m": 30.0, "speed_mps": 11.1})
    whole, parts = Traffic(scene), Traffic(scene)
    t = step_times(0, 300)
    whole.advance(host_motion(11.1 * t, 11.1))
    for k in range(0, 300, 10):
        parts.advance(host_motion(11.1 * t[k : k + 10], np.full(10, 11.1)))
    for a, b in zip(whole.motions(t), parts.motions(t), strict=True):
        np.testing.assert_array_equal(a.s_m, b.s_m)


def test_before_the_scene_everybody_came_at_constant_speed() -> None:
    scene = make_scene(
        {"name": "a", "s_m": 30.0, "speed_mps": 8.0, "motion": [{"start_s": 0.0, "acceleration_mps2": -6.0}]}, follower(-30.0, 15.0)
    )
    a, b = Traffic(scene).bodies(-1.0)
    assert (a.s_m, a.speed_mps, b.s_m, b.speed_mps) == (22.0, 8.0, -45.0, 15.0)
    assert float(host_before(scene, np.array(-1.0)).s_m) == -11.1


def test_known_bodies_of_followers_need_the_host() -> None:
    scene = make_scene(follower(-30.0, 15.0))
    with pytest.raises(ParameterError, match="host"):
        known_bodies(scene)
    t = np.linspace(0.0, 4.0, 41)
    body = known_bodies(scene, cruising(t))[0]
    played = Traffic(scene)
    played.advance(host_motion(11.1 * step_times(0, 400), 11.1))
    np.testing.assert_allclose(body.at(t).s_m, played.motions(t)[0].s_m, atol=1e-6)
    broken = cruising(np.array([0.0, np.nan, 0.2]))
    assert np.isfinite(known_bodies(scene, broken)[0].at(t).s_m).all()


def test_mirror_the_scene_and_the_traffic_mirrors() -> None:
    def scene(sign: float) -> Any:
        cut_in = [{"start_s": 0.5, "lateral_to_m": 0.0, "duration_s": 2.0}]
        return make_scene(
            {"name": "cutter", "s_m": -12.0, "d_m": 3.7 * sign, "speed_mps": 14.0, "motion": cut_in},
            follower(-30.0, 15.0, d_m=0.3 * sign),
            road={"lanes_left": 1, "lanes_right": 1, "curvature": [[0.0, 0.001 * sign], [50.0, 0.004 * sign]]},
        )

    left, right = Traffic(scene(1.0)), Traffic(scene(-1.0))
    t = step_times(0, 400)
    for traffic in (left, right):
        traffic.advance(host_motion(11.1 * t, 11.1))
    for a, b in zip(left.motions(t), right.motions(t), strict=True):
        np.testing.assert_array_equal(a.s_m, b.s_m)
        np.testing.assert_array_equal(a.d_m, -b.d_m)
        np.testing.assert_array_equal(a.heading_rad, -b.heading_rad)


def test_motions_by_steps_are_the_motions_at_their_times() -> None:
    script = [{"start_s": 0.3, "acceleration_mps2": -4.0}, {"start_s": 0.5, "lateral_to_m": 3.0, "duration_s": 2.0}]
    parts = [
        {"s_m": 30.0, "speed_mps": 20.0, "motion": script},
        {"s_m": -30.0, "speed_mps": 22.0, "behaviour": "idm"},
    ]
    scene = scene_from_document({"duration_s": 3.0, "host": {"speed_mps": 20.0}, "neighbour": parts}, Path("steps.toml"))
    traffic = Traffic(scene)
    traffic.advance(host_before(scene, step_times(0, 120)))
    for first, count in ((0, 11), (40, 11), (100, 20), (0, 121)):
        for ours, theirs in zip(traffic.motions_of_steps(first, count), traffic.motions(step_times(first, count)), strict=True):
            for key in BodyMotion.__slots__:
                assert np.array_equal(getattr(ours, key), getattr(theirs, key))


@pytest.mark.parametrize(("van_mps", "when_s"), [(16.0, 15.5 / 6.0), (12.0, None)])
def test_neighbours_that_a_script_sends_through_one_another_are_told_of(van_mps: float, when_s: float | None) -> None:
    lorry = {"name": "lorry", "s_m": 60.0, "d_m": 3.7, "speed_mps": 10.0}
    van = {"name": "van", "s_m": 40.0, "d_m": 3.7, "speed_mps": van_mps}
    drive = simulate(make_scene(lorry, van, duration_s=5.0), "closed-form-corrected")
    step_s = float(np.diff(drive.trajectory.t_s).max())
    assert drive.first_overlap() == (None if when_s is None else (pytest.approx(when_s + 0.5 * step_s, abs=0.5 * step_s), "lorry", "van"))
    assert step_s <= 0.1 + 1e-9
    if when_s is None:
        assert drive.among_others == ""
    else:
        assert drive.among_others == "lorry and van collide with each other at 2.6 s; the host is not involved"
        assert drive.among_others in [text.get_text() for text in sheet(drive).texts]


def history(drive: Simulation, name: str, s_m: float, d_m: float, heading_rad: float = 0.0) -> NeighbourHistory:
    there = np.zeros_like(drive.trajectory.t_s)
    return NeighbourHistory(
        name=name, length_m=4.5, width_m=1.8, s_m=there + s_m, d_m=there + d_m, heading_rad=there + heading_rad, speed_mps=there
    )


@pytest.mark.parametrize(("beside_m", "apart_m", "meet"), [(0.0, 4.2, True), (0.0, 5.0, False), (-20.0, 3.0, False), (10.0, 5.5, True)])
def test_neighbours_in_a_bend_meet_where_they_do_in_the_plane(beside_m: float, apart_m: float, meet: bool) -> None:
    """Outside a bend of 20 m radius 3 m along the road are 6 m, inside it 5.5 m are 2.8 m."""
    drive = simulate(make_scene(duration_s=0.5, road={"curvature": [[0.0, 0.05]], "lanes_left": 0, "lanes_right": 0}), "acc")
    pair = (history(drive, "one", 30.0, beside_m), history(drive, "other", 30.0 + apart_m, beside_m))
    assert (replace(drive, neighbours=pair).first_overlap() is not None) is meet


def test_neighbours_who_have_left_meet_nobody() -> None:
    drive = simulate(make_scene(duration_s=0.5), "acc")
    gone = (history(drive, "one", 30.0, GONE_M), history(drive, "other", 31.0, GONE_M))
    assert replace(drive, neighbours=gone).first_overlap() is None
