"""Suites: the same seed gives the same scenes, shares are even, and what a protocol says is what the scenes hold."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from mcdas_opt.catalogue.data_files import models_folder
from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.vehicle import GRAVITY_MPS2
from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.evaluation.case import Traffic
from mcdas_opt.evaluation.families import load_family, shipped_suites, suites_folder
from mcdas_opt.evaluation.spread import Spread
from mcdas_opt.evaluation.suites import Suite, _of_file, allot, expand
from mcdas_opt.simulation.neighbours import Traffic as Neighbours

DATA = Path(__file__).resolve().parents[2].parent / "shared" / "data"
OWN = [name for name in shipped_suites() if name != "recorded"]


@pytest.fixture(scope="module", params=OWN)
def suite(request: pytest.FixtureRequest) -> Suite:
    return expand(request.param, 40, seed=5)


def test_every_suite_of_the_benchmark_is_shipped() -> None:
    wanted = {"sandwich", "striking-rear", "offset", "euro-ncap-aeb", "un-r157", "openpilot-manoeuvres", "benign", "curved"}
    assert wanted | {"all-lanes-blocked", "recorded", "mid-vehicle", "ordinary", "followed"} <= set(shipped_suites())


def test_expansion_is_a_function_of_file_count_and_seed(suite: Suite) -> None:
    again = expand(suite.name, 40, seed=5)
    assert again.hash == suite.hash
    assert expand(suite.name, 40, seed=6).hash != suite.hash
    assert [case.index for case in suite.cases] == list(range(len(suite.cases)))
    assert len({case.scene.name for case in suite.cases}) == len(suite.cases)


def test_nobody_brakes_beyond_the_grip(suite: Suite) -> None:
    for case in suite.cases:
        grip = case.scene.road.friction * GRAVITY_MPS2
        times = np.arange(0.0, case.scene.duration_s, 0.05)
        neighbours = Neighbours(case.scene)
        for part, motion in zip(case.scene.neighbour, neighbours.motions(times), strict=True):
            if part.behaviour == "scripted":
                along = np.gradient(motion.speed_s_mps, times)
                across = np.gradient(motion.speed_d_mps, times)
                assert np.hypot(along, across).max() < grip + 1e-6


def test_followers_react_where_suites_say_so_and_labels_go_to_scripts(suite: Suite) -> None:
    for case in suite.cases:
        reacts = any(part.behaviour == "idm" for part in case.scene.neighbour)
        assert (case.traffic is Traffic.REACTING) == reacts
        if suite.name == "benign":
            assert reacts
            assert case.nominal
        if suite.name in ("sandwich", "striking-rear", "offset", "un-r157", "curved", "all-lanes-blocked"):
            assert not reacts
            assert case.labelled


def test_somebody_follows_in_every_scene_of_followed() -> None:
    for case in expand("followed", None, 5).cases:
        behind = [part for part in case.scene.neighbour if part.s_m < 0.0]
        assert [part.behaviour for part in behind] == ["idm"]
        assert any(part.s_m > 0.0 for part in case.scene.neighbour)


@given(st.lists(st.integers(0, 60), min_size=1, max_size=8).filter(any), st.data())
@settings(max_examples=60)
def test_shares_add_up_and_follow_the_sizes(sizes: list[int], data: st.DataObject) -> None:
    total = data.draw(st.integers(1, 3 * sum(sizes)))
    shares = allot(total, sizes)
    assert sum(shares) == total
    assert all(abs(share - total * size / sum(sizes)) < 1.0 for share, size in zip(shares, sizes, strict=True))


def test_fewer_scenes_of_a_family_are_the_first_of_more() -> None:
    few, many = expand("sandwich", 5, seed=2), expand("sandwich", 9, seed=2)
    assert [case.scene for case in few.cases] == [case.scene for case in many.cases[:5]]


def test_euro_ncap_is_its_104_cases_and_eight_with_a_follower() -> None:
    suite = expand("euro-ncap-aeb")
    counts = Counter(case.family for case in suite.cases)
    assert counts == {"ncap-ccrs": 45, "ncap-ccrm": 55, "ncap-ccrb": 4, "ncap-ccrb-followed": 8}
    assert len({_case_facts(case.scene) for case in suite.cases}) == 112
    for case in suite.cases:
        scene = case.scene
        front = scene.neighbour[0]
        assert front.s_m is not None
        assert front.speed_mps is not None
        gap = front.s_m - 0.5 * (front.length_m + scene.vehicle.length_m)
        if case.family in ("ncap-ccrs", "ncap-ccrm"):
            assert gap / (scene.host.speed_mps - front.speed_mps) == pytest.approx(6.0)
            covered = 0.5 * (front.width_m + scene.vehicle.width_m) - abs(front.d_m or 0.0)
            assert any(covered / scene.vehicle.width_m == pytest.approx(share, abs=0.03) for share in (0.5, 0.75, 1.0))
        if case.family == "ncap-ccrb-followed":
            rear = scene.neighbour[1]
            assert rear.behaviour == "idm"
            assert -(rear.s_m or 0.0) - scene.vehicle.length_m == pytest.approx(12.0) or (
                -(rear.s_m or 0.0) - scene.vehicle.length_m == pytest.approx(40.0)
            )


def _case_facts(scene: Scene) -> str:
    return scene.model_copy(update={"name": "", "seed": 0}).model_dump_json()


def test_a_cut_in_happens_where_and_as_fast_as_drawn() -> None:
    suite = expand("un-r157", 60, seed=3)
    for case in suite.cases:
        if case.family != "r157-cut-in":
            continue
        scene = case.scene
        car = next(part for part in scene.neighbour if part.name == "cut-in")
        event = car.motion[0].start_s
        k = [part.name for part in scene.neighbour].index("cut-in")
        times = np.arange(0.0, scene.duration_s, 0.01)
        motion = Neighbours(scene).motions(times)[k]
        at = float(np.interp(event, times, motion.s_m)) - scene.host.speed_mps * event
        gap = at - 0.5 * (car.length_m + scene.vehicle.length_m)
        assert gap == pytest.approx(10.0 * round(gap / 10.0), abs=0.05)
        peak = float(np.abs(motion.speed_d_mps).max())
        assert peak == pytest.approx(0.5 * round(peak / 0.5), rel=0.02)
        assert float(motion.d_m[-1]) == pytest.approx(0.0, abs=1e-9) or motion.d_m[-1] * motion.d_m[0] > 0.0


def test_a_car_that_cuts_out_passes_whoever_stands_there() -> None:
    suite = expand("un-r157", 80, seed=4)
    seen = 0
    for case in suite.cases:
        if case.family != "r157-cut-out":
            continue
        seen += 1
        scene = case.scene
        names = [part.name for part in scene.neighbour]
        times = np.arange(0.0, scene.duration_s, 0.02)
        motions = Neighbours(scene).motions(times)
        front, stands = motions[names.index("front")], motions[names.index("revealed")]
        beside = np.abs(front.s_m - stands.s_m) < 4.5
        assert np.all(np.abs(front.d_m - stands.d_m)[beside] > 1.8)
    assert seen >= 15


def test_in_a_bend_the_host_begins_along_it() -> None:
    """Rolling on with the steering that it has, the body's centre stays in the middle of its lane."""
    from mcdas_opt.dynamics.bicycle import bicycle

    for case in expand("curved", 12, seed=1).cases:
        scene, host = case.scene, case.scene.host_state
        kappa = float(scene.true_road.curvature_at(0.0))
        assert kappa != 0.0
        radius, back = 1.0 / kappa, scene.vehicle.centre_m
        # rear axle in the plane, the bend's centre at (0, radius)
        x = np.array(
            [-back * np.cos(host.heading_rad), -back * np.sin(host.heading_rad), host.heading_rad, host.speed_mps, host.steering_rad]
        )
        for _ in range(2000):
            x = x + 1e-3 * np.array(bicycle(x, (0.0, 0.0), scene.vehicle.wheelbase_m, np))
        middle = x[:2] + back * np.array([np.cos(x[2]), np.sin(x[2])])
        assert np.hypot(middle[0], middle[1] - radius) == pytest.approx(abs(radius), abs=0.02)


@pytest.mark.parametrize(
    ("spread", "speed", "wanted"),
    [
        ({"first": 10.0, "last": 50.0, "step": 20.0, "unit": "km/h"}, 0.0, {10.0 / 3.6, 30.0 / 3.6, 50.0 / 3.6}),
        ({"one_of": [1.0, 2.0]}, 0.0, {1.0, 2.0}),
        ({"by_speed": [[0.0, 1.0], [10.0, 2.0]]}, 5.0, {1.5}),
        ({"by_speed": [[0.0, 1.0], [10.0, 2.0]]}, 50.0, {2.0}),
    ],
)
def test_spreads(spread: dict[str, object], speed: float, wanted: set[float]) -> None:
    rng = np.random.default_rng(1)
    drawn = {round(Spread.model_validate(spread).draw(rng, speed), 9) for _ in range(60)}
    assert drawn == {round(value, 9) for value in wanted}


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ('name = "x"\n[[part]]\nsuite = "nowhere"\n', "no such file"),
        (f'name = "x"\n[[part]]\nsuite = "{"a" * 3000}"\n', "no such file"),
        ('name = "x"\n[[part]]\nsuite = "sandwich"\nscene = 3\n', "did you mean 'scenes'"),
        ('name = "x"\n[[manoeuvre]]\nname = "m"\nduration_s = 3.0\nhost_mps = 3.0\ndesired_mps = 3.0\ngap_m = 5.0\n', "belong together"),
        ('name = "x"\nhost = { speed_mps = { low = 3.0 } }\n', "host.speed_mps"),
        ('name = "x"\nhost = { speed_mps = 3.0 }\nside = { cars = 999999999999999 }\n', "cars must be at most"),
        ('name = "x"\nhost = { speed_mps = 3.0 }\nroad = { lanes_left = { low = 0.0, high = 1e18 } }\n', "lanes_left must be at most"),
        ('name = "x"\nhost = { speed_mps = 1e200 }\nroad = { bend_mps2 = 1.0 }\n', "speed_mps must be at most 10000"),
        ('name = "x"\nhost = { speed_mps = 0.0 }\nroad = { bend_mps2 = 1.0 }\n', "too tight"),
        ('name = "x"\ncount = 99999999999\nhost = { speed_mps = 3.0 }\n', "count"),
        (
            'name = "x"\ngrid = true\n[host.speed_mps]\nfirst = 1.0\nlast = 9.0\nstep = 0.001\n[front]\ngap_m = 3.0\n[front.slower_mps]\n'
            "first = 0.0\nlast = 9.0\nstep = 0.001\n",
            "at most 1000000 combinations",
        ),
        ('name = "x"\nhost = { speed_mps = 3.0 }\ncut_out = { ahead_m = 3.0, lateral_mps = 1.0 }\n', "need a front"),
    ],
)
def test_a_bad_suite_is_told(tmp_path: Path, text: str, key: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=key):
        expand(path)


def test_a_suite_that_holds_itself_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(f'name = "x"\n[[part]]\nsuite = "{path}"\nscenes = 4\n', encoding="utf-8")
    with pytest.raises(InputError, match="part of itself"):
        expand(path)


def test_an_unknown_suite_lists_the_known_ones() -> None:
    with pytest.raises(InputError, match=r"sandwich.*striking-rear"):
        expand("sandwitch")


def test_more_scenes_than_anybody_drives_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="scenes = 1000000000000"):
        expand("sandwich", scenes=10**12)
    path = tmp_path / "endless.toml"
    path.write_text('name = "endless"\n[[part]]\nsuite = "sandwich"\nscenes = 999999999999\n')
    with pytest.raises(InputError, match=r"scenes = 999999999999: .*1000000"):
        expand(path)


def test_recordings_need_a_folder_and_say_what_it_lacks(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="--data"):
        expand("recorded")
    with pytest.raises(InputError, match="cats_platoon"):
        expand("recorded", data=tmp_path)


def made_recordings(folder: Path) -> Path:
    """Five cars 20 m apart on a winding road whose speeds swing, and triples of the same motion, laid out as the published ones are."""
    t = np.arange(0.0, 60.0, 0.1)
    swing = 15.0 + 3.0 * np.sin(2.0 * np.pi * t / 17.0)
    along = np.cumsum(swing) * 0.1
    bend = 0.3 * np.sin(np.arange(-200.0, 1200.0) / 60.0)
    plane = np.cumsum(np.column_stack([np.cos(bend), np.sin(bend)]), axis=0)
    places = [np.column_stack([np.interp(along - 20.0 * k + 200.0, np.arange(len(plane)), column) for column in plane.T]) for k in range(5)]
    (folder / "cats_platoon").mkdir(parents=True)
    heads = ["t", *(f"veh{k + 1}_{c}" for k in range(5) for c in "xyv")]
    rows = np.column_stack([t, *(np.column_stack([place, swing]) for place in places)])
    np.savetxt(folder / "cats_platoon" / "made.csv", rows, fmt="%.4f", delimiter=",", header=",".join(heads), comments="")
    cars = [np.column_stack([place, np.zeros(len(t)), swing])[:50].tolist() for place in places]
    dims = {who: [4.8, 1.9] for who in ("front", "host", "rear")}
    triples = [{"front": cars[k], "host": cars[k + 1], "rear": cars[k + 2], "dims": dims} for k in range(3)]
    (folder / "us101_triples_odd.json").write_text(json.dumps({"triples": triples}))
    return folder


@pytest.mark.parametrize(
    "data", [made_recordings, pytest.param(lambda _: DATA, id="published", marks=pytest.mark.published(DATA / "cats_platoon"))]
)
def test_recordings_begin_as_recorded_and_the_rear_car_reacts(data: Callable[[Path], Path], tmp_path: Path) -> None:
    suite = expand("recorded", 30, seed=1, data=data(tmp_path))
    assert {case.family for case in suite.cases} == {"platoon", "us101"}
    for case in suite.cases:
        front, rear = case.scene.neighbour
        assert case.traffic is Traffic.RECORDED
        assert rear.behaviour == "idm"
        assert (front.s_m or 0.0) > 0.0 > (rear.s_m or 0.0)
        times = np.arange(0.0, case.scene.duration_s, 0.1)
        speeds = Neighbours(case.scene).motions(times)[0].speed_s_mps
        assert np.abs(np.diff(speeds)).max() <= 0.1 * case.scene.road.friction * GRAVITY_MPS2
        assert speeds.min() >= -1e-9


def test_a_recording_is_the_same_whenever_it_began_and_however_often_it_looked(tmp_path: Path) -> None:
    """In Unix time; triples at 25 Hz and at 10 Hz of the same motion, whose speed is linear."""
    at_first, later = made_recordings(tmp_path / "a"), made_recordings(tmp_path / "b")
    table = later / "cats_platoon" / "made.csv"
    heads, *rows = table.read_text().splitlines()
    moved = [f"{float(row.partition(',')[0]) + 1.7e9:.4f},{row.partition(',')[2]}" for row in rows]
    table.write_text("\n".join([heads, *moved]))
    dims = {who: [4.8, 1.9] for who in ("front", "host", "rear")}
    for folder, dt in ((at_first, 0.1), (later, 0.04)):
        t = np.arange(0.0, 6.0 + 1e-9, dt)
        cars = [np.column_stack([20.0 * t + t**2 - s, 0.0 * t, 0.0 * t, 20.0 + 2.0 * t]).tolist() for s in (0.0, 25.0, 50.0)]
        triple = {"dt": dt, "dims": dims, **dict(zip(("front", "host", "rear"), cars, strict=True))}
        (folder / "us101_triples_odd.json").write_text(json.dumps({"triples": [triple]}))
    one, two = (expand("recorded", seed=1, data=folder).cases for folder in (at_first, later))
    assert [case.scene.name for case in one] == [case.scene.name for case in two]
    assert {case.family for case in one} == {"platoon", "us101"}
    for case, other in zip(one, two, strict=True):
        assert case.scene.duration_s == other.scene.duration_s
        t = np.arange(0.0, case.scene.duration_s, 0.1)
        speeds = [Neighbours(scene).motions(t)[0].speed_s_mps for scene in (case.scene, other.scene)]
        assert speeds[0] == pytest.approx(speeds[1], abs=1e-3)
    assert one[-1].scene.duration_s == pytest.approx(6.0)


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("us101_triples_odd.json", '[{"front": []}]', r"json: triples: must be a list in an object"),
        ("us101_triples_odd.json", '{"triples": [[1]]}', r"triples\[0\]: is no triple: must be an object"),
        ("us101_triples_odd.json", '{"triples": [{"dt": 0, DIMS}]}', r"triples\[0\]: is no triple: dt = 0 must be positive"),
        ("us101_triples_odd.json", '{"triples": [{"dt": 0.01, DIMS}]}', r"lasts 0.02 s: must last at least 0.1 s"),
        ("us101_triples_odd.json", '{"triples": [{"dt": 1e12, DIMS}]}', r"and at most 3600 s"),
        ("us101_triples_odd.json", '{"triples": [{"rear": [[0, 0, 0, 1]], DIMS}]}', r"must have as many rows"),
        ("us101_triples_odd.json", '{"triples": [{"rear": [[0, 0, 0]], DIMS}]}', r"must be rows of four finite numbers"),
        ("cats_platoon/made.csv", "HEADS\n0,ROW\n0.1,ROW\n0.1,ROW", r"made\.csv: row 3: t = 0\.1: must increase"),
        ("cats_platoon/made.csv", "HEADS\n0,ROW\n0.1", r"made\.csv: row 2 = '0\.1': must have 16 cells"),
        ("cats_platoon/made.csv", "HEADS\n0,ROW", r"made\.csv: needs at least two rows"),
        ("cats_platoon/made.csv", "HEADS\n0,ROW\nnan,ROW", r"made\.csv: t: must be finite numbers"),
    ],
)
def test_a_recording_that_is_none_is_one_line(tmp_path: Path, name: str, text: str, said: str) -> None:
    folder = made_recordings(tmp_path / "data")
    heads = (folder / "cats_platoon" / "made.csv").read_text().splitlines()[0]
    whole = json.dumps({who: [[k, 0.0, 0.0, 9.0] for k in range(3)] for who in ("front", "host", "rear")})[1:-1]
    dims = f'{whole}, "dims": {json.dumps({who: [4.8, 1.9] for who in ("front", "host", "rear")})}'
    if '"rear"' in text:
        dims = dims.replace('"rear": [[0', '"rest": [[0', 1)
    text = text.replace("HEADS", heads).replace("ROW", ",".join("1" * 15)).replace("DIMS", dims)
    (folder / name).write_text(text)
    with pytest.raises(InputError, match=said):
        expand("recorded", data=folder)


def test_a_family_file_is_a_suite_of_one() -> None:
    family = load_family(suites_folder() / "offset.toml")
    assert len(expand("offset").cases) == family.size


def test_ordinary_reaches_from_walking_pace_to_40_mps_with_leaders_of_three_kinds() -> None:
    suite = expand("ordinary")
    speeds = [case.scene.host.speed_mps for case in suite.cases]
    assert (min(speeds) < 5.0, max(speeds)) == (True, 40.0)
    families = {"following", "cut-in", "merge", "overtaking", "bends", "manoeuvres"}
    assert {case.family for case in suite.cases} == families
    recorded = next(case.scene for case in suite.cases if case.scene.name.startswith("recorded-11"))
    assert len(recorded.neighbour[0].motion) == 120
    lines = (suites_folder() / "leaders" / "motorway-11.csv").read_text("utf-8").splitlines()
    assert recorded.neighbour[0].speed_mps == pytest.approx(float(lines[1 + 60].split(",")[1]))
    between = next(case.scene for case in suite.cases if case.scene.name.startswith("waves-idm"))
    assert [(one.name, one.behaviour) for one in between.neighbour] == [("between", "idm"), ("lead", "scripted")]


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ('lead_file = "nowhere.csv"', r"nowhere\.csv: cannot be read"),
        ('lead_file = "short.csv"', r"manoeuvre\[0\].*: lead_file ends after 2 s: lead_from_s and duration_s ask for 10 s"),
        ('lead_file = "bad.csv"', r"bad\.csv: line 3: .*"),
        ('lead_file = "short.csv"\nlead_mps = [1.0]', "lead_file and lead_mps exclude each other"),
    ],
)
def test_a_leader_that_is_missing_or_too_short_is_one_line(change: str, told: str, tmp_path: Path) -> None:
    (tmp_path / "short.csv").write_text("t_s,speed_mps\n0,20\n2,21\n", "utf-8")
    (tmp_path / "bad.csv").write_text("t_s,speed_mps\n0,20\nx,21\n20,20\n", "utf-8")
    text = f'name = "own"\n[[manoeuvre]]\nname = "a"\nduration_s = 10.0\nhost_mps = 20.0\ndesired_mps = 25.0\ngap_m = 20.0\n{change}\n'
    (tmp_path / "own.toml").write_text(text, "utf-8")
    with pytest.raises(InputError, match=told) as caught:
        expand(tmp_path / "own.toml")
    assert "\n" not in str(caught.value)


def test_a_spread_that_is_a_point_is_that_point() -> None:
    assert Spread.model_validate({"low": 0.0, "high": -0.0}).draw(np.random.default_rng(1), 0.0) == 0.0


@pytest.mark.parametrize(
    ("spread", "said"),
    [({"low": -1.7e308, "high": 1.7e308}, "finite"), ({"first": 0.0, "last": 1e300, "step": 5e-324}, "step must be large enough")],
)
def test_a_spread_beyond_all_numbers_is_refused(spread: dict[str, float], said: str) -> None:
    with pytest.raises(ValidationError, match=said):
        Spread.model_validate(spread)


BRAKES = "must lie in [0, 15] m/s^2: braking is positive"
UNITS = "unit = '{}' is a speed's: only keys that end in _mps take one"


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("[host]\nspeed_mps = { low = 60, high = 30 }", "host.speed_mps: high = 30 must be at least low = 60"),
        ("[host]\nspeed_mps = { low = 8, high = 30, unit = 'kmh' }", "host.speed_mps.unit = 'kmh': input should be 'km/h' or 'mph'"),
        ("[host]\nspeed_mps = 8\n[road]\nfriction = { low = 0.9, high = 1.0, unit = 'mph' }", f"road.friction: {UNITS.format('mph')}"),
        ("[host]\nspeed_mps = 8\n[rear]\ngap_m = { one_of = [5, 9], unit = 'km/h' }", f"rear.gap_m: {UNITS.format('km/h')}"),
        ("event_s = { low = 0, high = 1, unit = 'km/h' }\n[host]\nspeed_mps = 8", f"event_s: {UNITS.format('km/h')}"),
        ("[host]\nspeed_mps = 8\n[front]\ngap_m = 9\nbraking_mps2 = -5", f"front.braking_mps2 = -5: {BRAKES}"),
        ("[host]\nspeed_mps = 8\n[front]\ngap_m = 9\nbraking_mps2 = { low = -1, high = 5 }", f"front.braking_mps2: {BRAKES}"),
        ("[host]\nspeed_mps = 8\n[rear]\ngap_m = 9\nbraking_mps2 = { one_of = [3, 60] }", f"rear.braking_mps2: {BRAKES}"),
        ("[host]\nspeed_mps = 8\n[rear]\ngap_m = 9\nbraking_mps2 = { by_speed = [[5, 2], [9, 20]] }", f"rear.braking_mps2: {BRAKES}"),
        ("[host]\nspeed_mps = { low = 8 }", "host.speed_mps: needs low and high, or one_of, or first, last and step, or by_speed"),
        ("[host]\nspeed_mps = [8, 40]", "host.speed_mps: must be a number, or a table with a range, as { low = 1.0, high = 2.0 }"),
        ("[host]\nspeed_mps = { one_of = [] }", "host.speed_mps.one_of: list should have at least 1 item after validation, not 0"),
        ("[host]\nspeed_mps = nan", "host.speed_mps = nan: must be a finite number"),
        ("[host]\nspeed_mps = 8\n[rear]\ngap_m = { lo = 8, high = 40 }", "rear.gap_m.lo: unknown key; did you mean 'low'?"),
        ("[host]\nspeed_mps = 8\n[road]\nlane_width_m = 90", "scene van-1-0: road: lane_width_m = 90.0 m: must lie in [0.1, 20]"),
        ("[host]\nspeed_mps = 8\nvehicle = 'vann'", "vann: no such file, and no shipped vehicle of that name; known: "),
    ],
)
def test_a_fault_of_a_range_is_told_by_the_rule_that_it_breaks_and_names_the_suite(body: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / "m.toml"
    path.write_text(f'name = "van"\ncount = 2\n{body}\n', encoding="utf-8")
    with pytest.raises(InputError) as told:
        expand(path)
    assert str(told.value).startswith(f"{path}: {said}")


CAR, RADAR = 'vehicle = "../cars/van.toml"\n', '[sensors]\nfront = "../radar.toml"\n'


@pytest.mark.parametrize(
    "text",
    [
        f"[host]\nspeed_mps = 10.0\n{CAR}{RADAR}",
        f'[[family]]\nname = "one"\n[family.host]\nspeed_mps = 10.0\n{CAR}{RADAR}',
        f'[[manoeuvre]]\nname = "one"\nduration_s = 5.0\nhost_mps = 10.0\ndesired_mps = 10.0\n{CAR}{RADAR}',
        '[[part]]\nsuite = "inner/part.toml"\n',
    ],
)
def test_files_that_a_suite_names_are_beside_it(text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for folder in ("suites/inner", "cars", "elsewhere"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "cars" / "van.toml").write_bytes((models_folder() / "vehicles" / "lincoln_mkz.toml").read_bytes())
    (tmp_path / "radar.toml").write_bytes((models_folder() / "sensors" / "delphi_esr.toml").read_bytes())
    (tmp_path / "suites" / "inner" / "part.toml").write_text('name = "part"\n[host]\nvehicle = "../../cars/van.toml"\nspeed_mps = 10.0\n')
    (tmp_path / "suites" / "mine.toml").write_text(f'name = "mine"\n{text}')
    monkeypatch.chdir(tmp_path / "elsewhere")
    (case,) = expand("../suites/mine.toml", 1).cases
    assert replace(case.scene.vehicle, name="") == replace(load_vehicle("lincoln_mkz"), name="")


def test_a_file_that_is_not_beside_the_suite_is_sought_nowhere_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "suites").mkdir()
    (tmp_path / "van.toml").write_bytes((models_folder() / "vehicles" / "lincoln_mkz.toml").read_bytes())
    (tmp_path / "suites" / "mine.toml").write_text('name = "mine"\n[host]\nvehicle = "van.toml"\nspeed_mps = 10.0\n')
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=r"suites/mine\.toml: .*van\.toml: no such file"):
        expand("suites/mine.toml", 1)


def test_a_fault_of_a_family_whose_name_is_too_long_for_a_file_is_the_suites(tmp_path: Path) -> None:
    """Found by the attack on files: a scene called so was looked for on the disk."""
    path = tmp_path / "long.toml"
    with pytest.raises(InputError, match="duration_s = -1"), _of_file(path, "aaa"):
        raise InputError(f"{'a' * 5000}.toml", "duration_s", -1, "must be greater than 0")
