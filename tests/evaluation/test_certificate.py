"""The certificate: what it says nobody can do, nobody does; what it must see, it sees."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.catalogue.scenes import Scene, scene_from_document
from mcdas_opt.evaluation.certificate import closes_at
from mcdas_opt.evaluation.evasive_profiles import drive_profiles, evasive_profiles
from mcdas_opt.evaluation.families import load_family
from mcdas_opt.evaluation.oracle import finer_witness_from, witness_from
from mcdas_opt.evaluation.relaxed_vehicle import STEP_S, RelaxedVehicle
from mcdas_opt.evaluation.speed_sets import at_least, at_most, hull, moved
from mcdas_opt.manoeuvres.clearance import clearance
from mcdas_opt.simulation.neighbours import known_bodies

GRIP = 1.05 * 0.9 * 9.80665


def scene(*neighbours: dict[str, Any], speed: float = 20.0, duration: float = 6.0, **road: Any) -> Scene:
    document = {"duration_s": duration, "road": road, "host": {"speed_mps": speed}, "neighbour": list(neighbours)}
    return scene_from_document(document, Path("scene.toml"))


def closes(it: Scene) -> float | None:
    return closes_at(it.host_state, it.vehicle, it.true_road, known_bodies(it), it.duration_s)


def standing(gap_m: float) -> dict[str, Any]:
    return {"s_m": gap_m + 4.5, "speed_mps": 0.0}


@pytest.mark.parametrize("speed", [10.0, 20.0, 30.0])
def test_a_standing_car_on_one_lane_is_unavoidable_within_the_stopping_distance(speed: float) -> None:
    """One lane: v^2 / (2 x 8.08), less what a car could gain by weaving between the edges, and what the brakes' build-up costs."""
    stopping = speed**2 / (2.0 * 8.08)
    assert closes(scene(standing(0.9 * stopping), speed=speed)) is not None
    assert closes(scene(standing(stopping + 0.2 * speed), speed=speed)) is None


def test_a_lane_to_the_side_opens_what_is_closed_and_a_car_in_front_of_the_mirror_too() -> None:
    near = standing(18.0)
    assert closes(scene(near)) is not None
    for side in ({"lanes_left": 1}, {"lanes_right": 1}, {"shoulder_left_m": 2.2}, {"shoulder_right_m": 2.2}):
        assert closes(scene(near, **side)) is None
    assert closes(scene(near, shoulder_left_m=0.7)) is not None  # 0.95 + 0.7 m beside it: no room for a car of 1.8 m
    assert closes(scene(standing(2.0), lanes_left=1, speed=30.0)) is not None  # too near to steer


def test_boxed_in_is_unavoidable_although_either_alone_is_not() -> None:
    front = {"s_m": 14.5, "speed_mps": 12.0}
    rear = {"s_m": -9.5, "speed_mps": 27.0}
    assert closes(scene(front)) is None
    assert closes(scene(rear, speed=25.0)) is None
    assert closes(scene(front, rear)) is not None


def test_nobody_in_the_way_closes_nothing() -> None:
    assert closes(scene()) is None
    assert closes(scene({"s_m": 8.0, "d_m": 3.7, "speed_mps": 0.0}, lanes_left=1)) is None
    assert closes(scene({"s_m": 30.0, "speed_mps": 20.0})) is None


@pytest.mark.parametrize("name", ["sandwich", "striking-rear"])
def test_no_library_member_is_safe_where_the_certificate_holds(name: str) -> None:
    certified = 0
    for it in load_family(name).scenes(24, seed=31):
        if closes(it) is None:
            continue
        certified += 1
        for search in (witness_from, finer_witness_from):
            assert search(it, 0.0, known_bodies(it))[0] is None
    assert certified >= 3


def test_the_same_on_bends() -> None:
    rng = np.random.default_rng(35)
    certified = 0
    for _ in range(20):
        speed = float(rng.uniform(8.0, 25.0))
        front = {"s_m": 4.5 + float(rng.uniform(4.0, 25.0)), "speed_mps": float(rng.uniform(0.0, speed))}
        rear = {"s_m": -4.5 - float(rng.uniform(3.0, 20.0)), "speed_mps": speed + float(rng.uniform(0.0, 12.0))}
        bend = [[0.0, float(rng.uniform(-0.006, 0.006))]]
        it = scene(front, rear, speed=speed, curvature=bend, lanes_left=int(rng.integers(2)), friction=0.6)
        if closes(it) is not None:
            certified += 1
            assert witness_from(it, 0.0, known_bodies(it))[0] is None
    assert certified >= 3


@pytest.mark.parametrize("name", ["sandwich", "striking-rear"])
def test_mirrored_scenes_close_alike(name: str) -> None:
    for it in load_family(name).scenes(6, seed=32):
        assert closes(mirrored(it)) == closes(it)


def mirrored(it: Scene) -> Scene:
    road = it.road.model_copy(update={"lanes_left": it.road.lanes_right, "lanes_right": it.road.lanes_left})
    parts = [part.model_copy(update={"d_m": -(part.d_m or 0.0)}) for part in it.neighbour]
    return it.model_copy(update={"road": road, "neighbour": parts})


@given(gap=st.floats(1.0, 60.0), rear=st.floats(1.0, 60.0), slower=st.floats(0.0, 20.0), faster=st.floats(0.0, 15.0))
@settings(max_examples=15)
def test_more_room_never_closes_what_was_open(gap: float, rear: float, slower: float, faster: float) -> None:
    def box(more: float) -> Scene:
        front = {"s_m": 4.5 + gap + more, "speed_mps": 20.0 - slower}
        return scene(front, {"s_m": -4.5 - rear - more, "speed_mps": 20.0 + faster}, lanes_left=1, duration=4.0)

    if closes(box(0.0)) is None:
        assert closes(box(1.5)) is None


@pytest.mark.parametrize(("speed", "friction", "kappa"), [(8.0, 0.9, 0.0), (15.0, 0.25, 0.0), (30.0, 0.9, 0.0), (15.0, 0.9, 0.008)])
def test_every_member_of_the_finer_library_lies_within_the_relaxed_vehicles_bounds(speed: float, friction: float, kappa: float) -> None:
    """Thousands of drives at the limit: speeds, heading, both bumpers' ways aside, and the trade between along and across."""
    bend = [[0.0, kappa]]
    it = scene(speed=speed, duration=3.0, friction=friction, lanes_left=1, lanes_right=1, curvature=bend)
    host, car, road = it.host_state, it.vehicle, it.true_road
    relaxed = RelaxedVehicle(host=host, vehicle=car, road=road, duration_s=3.0)
    t = relaxed.times_s
    tried = drive_profiles(evasive_profiles(road, car, 0.0), t, host, car, road)
    states = tried.states[tried.on_road(car, road)]
    s, d, psi, v = (states[..., k] for k in range(4))
    assert np.all(v <= relaxed.fastest_mps + 1e-6)
    assert np.all(v >= relaxed.slowest_mps - 1e-6)
    assert np.all(np.abs(psi) <= relaxed.heading_rad + 1e-6)
    rear_s, rear_d = s - car.centre_m * np.cos(psi), d - car.centre_m * np.sin(psi)
    nose = rear_d + (car.wheelbase_m + car.front_overhang_m) * np.sin(psi)
    tail = rear_d - car.rear_overhang_m * np.sin(psi)
    assert np.all(np.abs(nose) <= relaxed.front.most_m + 1e-6)
    assert np.all(np.abs(tail) <= relaxed.rear.most_m + 1e-6)
    if kappa:
        return
    for k in (12, 24, 40):
        ahead = rear_s[:, k] + car.centre_m - speed * t[k]
        for bumper, aside in ((relaxed.front, nose), (relaxed.rear, tail)):
            for needed in (0.4, 1.0, 1.8):
                reached = np.abs(aside[:, k]) >= needed
                least, most = relaxed.along_m(k, bumper, needed)
                assert np.all(ahead[reached] <= most + 1e-6)
                assert np.all(ahead[reached] >= least - 1e-6)
        fastest = relaxed.rear.most_m[k]
        assert np.abs(tail[:, k]).max() > (0.75 if k > 12 else 0.5) * min(fastest, 1.8)  # a bound that is of use


@given(
    start=st.tuples(st.floats(-5.0, 5.0), st.floats(0.0, 30.0)),
    pieces=st.lists(st.floats(0.0, 1.0), min_size=5, max_size=5),
)
@settings(max_examples=50)
def test_a_step_holds_every_acceleration_within_its_bounds(start: tuple[float, float], pieces: list[float]) -> None:
    """Any acceleration that changes five times within the step ends inside the polygon; so does every point cut out of it."""
    low, high = -8.0, 3.0
    polygon = moved(np.array([start]), STEP_S, low, high)
    s, v = start
    for share in pieces:
        a, h = low + share * (high - low), STEP_S / 5.0
        s, v = s + v * h + 0.5 * a * h * h, v + a * h
    assert _inside(polygon, s, v)
    assert _inside(at_most(polygon, 0, s + 1e-6), s, v)
    assert _inside(at_least(polygon, 1, v - 1e-6), s, v)
    assert len(at_most(polygon, 0, float(polygon[:, 0].min()) - 1.0)) == 0


def _inside(polygon: np.ndarray[Any, Any], s: float, v: float) -> bool:
    a, b = polygon, np.roll(polygon, -1, axis=0)
    cross = (b[:, 0] - a[:, 0]) * (v - a[:, 1]) - (b[:, 1] - a[:, 1]) * (s - a[:, 0])
    return bool(np.all(cross >= -1e-7))


def test_the_hull_is_convex_and_holds_its_points() -> None:
    points = np.random.default_rng(1).normal(size=(60, 2))
    shape = hull(points)
    assert all(_inside(shape, *point) for point in points)
    assert 3 <= len(shape) < 30


def test_the_fastest_evasion_is_near_the_best_that_grip_allows() -> None:
    """At 30 m/s the steering's rate hardly counts: the finer library is 2.1 m aside within 1.2 times sqrt(2 y / (mu g))."""
    it = scene(speed=30.0, duration=2.0, lanes_left=1)
    grid = np.round(np.arange(41) * 0.05, 9)
    tried = drive_profiles(evasive_profiles(it.true_road, it.vehicle, 0.0), grid, it.host_state, it.vehicle, it.true_road)
    when = np.where((tried.states[..., 1] >= 2.1).any(-1), grid[(tried.states[..., 1] >= 2.1).argmax(-1)], np.inf).min()
    assert when <= 1.2 * math.sqrt(2.0 * 2.1 / (0.9 * 9.80665)) + 0.05
    assert clearance(tried.paths(), grid, known_bodies(it), it.vehicle, it.true_road).separation_m.min() > 1.0
