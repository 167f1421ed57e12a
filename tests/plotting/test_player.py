"""Pages that play and scrub: self-contained, true to the drive, and harmless whatever a scene is called."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from mcdas_opt.domain.road import Road
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.parking.case_file import load_parking_case
from mcdas_opt.parking.park import park
from mcdas_opt.planning.planner import Planner
from mcdas_opt.plotting.birdseye import ellipse
from mcdas_opt.plotting.export import MOVING, check_picture, save_picture
from mcdas_opt.plotting.moments import moment_at
from mcdas_opt.plotting.plane import Ground, rounded
from mcdas_opt.plotting.player import drive_document, parking_document
from mcdas_opt.plotting.web import PLANNERS, in_script, look_of, page, palette
from mcdas_opt.simulation.first_situation import situation_of
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.record import Simulation
from tests.simulation.fake_driver import FakeDriver
from tests.simulation.scene_maker import make_scene
from tests.studio.browser import chromium

NASTY = "</script><script>window.hacked = true</script><!--"
CURVED = Road(lanes_left=1, lanes_right=2, curvature=((0.0, 0.0), (50.0, 0.02), (200.0, -0.01)))


@pytest.fixture(scope="module")
def drive() -> Simulation:
    cars = [{"name": NASTY, "s_m": 9.0, "speed_mps": 5.0}, {"name": "beside", "s_m": 1.0, "d_m": 3.7, "speed_mps": 11.1}]
    return replace(simulate(make_scene(*cars, duration_s=5.0), FakeDriver()), name=NASTY)


def test_the_page_shows_the_truth_of_every_moment(drive: Simulation) -> None:
    document = drive_document(drive)
    json.dumps(document, allow_nan=False)
    assert document["duration"] == drive.duration_s
    assert (document["safe"], document["struck"]) == (False, ["host", NASTY])
    for k in range(0, len(document["poses_t"]), 7):
        moment = moment_at(drive, document["poses_t"][k])
        np.testing.assert_allclose(document["host"]["poses"][k], moment.host.pose, atol=2e-3)
        for shown, body in zip(document["others"], moment.others, strict=True):
            assert (shown["name"], shown["colour"]) == (body.name, body.colour)
            np.testing.assert_allclose(shown["poses"][k], body.pose, atol=2e-3)
    assert document["t"] == [round(cycle.time_s, 3) for cycle in drive.cycles]
    assert len(document["cycles"]) == len(drive.cycles)
    lengths = {len(document["poses_t"]), len(document["camera"]), len(document["speed"]), len(document["host"]["poses"])}
    assert len(lengths) == 1


@given(st.floats(-90.0, 400.0), st.floats(-7.0, 5.0), st.floats(-0.5, 0.5))
def test_the_ground_is_the_road_in_the_plane(s: float, d: float, psi: float) -> None:
    ground = Ground(CURVED, -100.0, 420.0)
    wanted = np.stack(FrenetFrame(road=CURVED).to_plane(np.array([s]), np.array([d]), np.array([psi])), axis=-1)
    np.testing.assert_allclose(ground.place(s, d, psi), wanted, atol=1e-6)


def test_edges_and_markings_lie_where_the_road_has_them() -> None:
    ground = Ground(replace(CURVED, road_end_s_m=300.0), -50.0, 420.0)
    document = ground.document()
    frame = FrenetFrame(road=CURVED, s_min_m=-100.0, s_max_m=440.0)  # no further: the road comes round again
    lines = {CURVED.left_edge_m: document["left"], CURVED.right_edge_m: document["right"]}
    lines |= dict(zip([-1.5 * 3.7, -0.5 * 3.7, 0.5 * 3.7], document["marks"], strict=True))
    for d, line in lines.items():
        x, y = np.array(line).T
        _, found, _ = frame.to_road(x, y, np.zeros_like(x))
        np.testing.assert_allclose(found, d, atol=0.02)
    s, _, _ = frame.to_road(*np.array(document["end"]).T, np.zeros(2))
    np.testing.assert_allclose(s, 300.0, atol=0.02)


def test_an_ellipse_in_the_plane_is_the_ellipse_on_the_road() -> None:
    p = np.diag([4.0, 1.0, 0.25, 1.0])
    p[0, 2] = p[2, 0] = 0.6
    track = Track(id="1", s_m=10.0, d_m=2.0, speed_s_mps=8.0, speed_d_mps=-0.5, covariance=p)
    x, y, vx, vy, a, b, angle = Ground(Road(), -50.0, 100.0).track(track)
    assert (x, y, vx, vy) == (10.0, 2.0, 8.0, -0.5)
    u = np.linspace(0.0, 2.0 * np.pi, 400)
    ring = np.stack([a * np.cos(u), b * np.sin(u)])
    turned = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) @ ring
    spread = np.linalg.inv(p[np.ix_([0, 2], [0, 2])])
    np.testing.assert_allclose(np.einsum("ik,ij,jk->k", turned, spread, turned), 2.5**2, rtol=5e-3)
    assert a == pytest.approx(np.abs(ellipse(track)[0] - 10.0).max(), rel=0.1)


@given(st.recursive(st.text() | st.floats(allow_nan=False, allow_infinity=False) | st.none(), lambda part: st.lists(part, max_size=3)))
def test_no_text_ends_a_script(document: Any) -> None:
    text = in_script(document)
    assert not set("<>&") & set(text)
    assert json.loads(text) == document


def test_numbers_that_are_none_become_null() -> None:
    assert rounded([[1.0049, np.nan], [np.inf, -2.0]]) == [[1.0, None], [None, -2.0]]
    assert rounded([1e308, -1.239]) == [1e308, -1.24]
    with pytest.raises(ValueError, match="JSON"):
        in_script([float("nan")])


def self_contained(text: str) -> None:
    """Nothing is loaded from anywhere: no address but SVG's namespace, no element that names a source."""
    assert set(re.findall(r"https?://[^\s\"'<)]+", text)) <= {"http://www.w3.org/2000/svg"}
    assert not re.search(r"<(script|img|link|iframe)[^>]+(src|href)", text)
    assert text.count("<script>") == text.count("</script>") == 2
    assert "default-src 'none'" in text


def test_pages_are_self_contained_and_small(drive: Simulation, tmp_path: Path) -> None:
    case = load_parking_case("parallel")
    situation, vehicle = situation_of("curved-road")
    plan = Planner(vehicle=vehicle, method="closed-form-corrected").plan(situation)
    pages = (
        save_picture(drive, tmp_path / "drive.html"),
        save_picture(park(case, "two-arc"), tmp_path / "park.html"),
        save_picture(plan, tmp_path / "plan.html"),
    )
    for file in pages:
        text = file.read_text(encoding="utf-8")
        self_contained(text)
        assert len(text) < 400_000
    assert save_picture(plan, tmp_path / "plan.png").read_bytes().startswith(b"\x89PNG")


def test_a_plan_moves_in_real_time(tmp_path: Path) -> None:
    situation, vehicle = situation_of("sandwich-60-40")
    plan = Planner(vehicle, "closed-form-corrected").plan(situation)
    end = int(np.searchsorted(plan.trajectory.t_s, 0.5)) + 1
    x = plan.trajectory
    begun = replace(plan, trajectory=Trajectory.from_states(x.t_s[:end], x.states[:end], x.inputs[: end - 1]))
    with Image.open(save_picture(begun, tmp_path / "plan.gif")) as moving:
        lengths = []
        for k in range(moving.n_frames):
            moving.seek(k)
            lengths.append(moving.info["duration"])
    assert sum(lengths[:-1]) == pytest.approx(1000.0 * float(begun.trajectory.t_s[-1]), abs=15.0)


def test_the_same_drive_is_the_same_page(drive: Simulation, tmp_path: Path) -> None:
    first, second = (save_picture(drive, tmp_path / name).read_bytes() for name in ("a.html", "b.html"))
    assert first == second


def test_a_refusal_has_a_page_and_no_picture(tmp_path: Path) -> None:
    case = load_parking_case("parallel", clearance_m=0.6)
    refused = park(case, "search")
    assert refused.trajectory is None
    document = parking_document(case, refused)
    assert (document["manoeuvre"], document["sound"], document["words"]) == (None, False, refused.reason)
    assert refused.reason in save_picture(refused, tmp_path / "no.html").read_text("utf-8")
    with pytest.raises(ParameterError, match="refused"):
        save_picture(refused, tmp_path / "no.png")
    assert not (tmp_path / "no.png").exists()


@pytest.mark.parametrize(("name", "suffixes"), [("a.mp4", MOVING), ("a", MOVING), ("a.json", MOVING), ("nowhere/a.png", MOVING)])
def test_other_files_are_refused_before_anything_is_computed(tmp_path: Path, name: str, suffixes: tuple[str, ...]) -> None:
    with pytest.raises(InputError, match=r"must end in|no such folder"):
        check_picture(tmp_path / name, suffixes)


def test_every_planner_has_a_look_of_its_own() -> None:
    others = ["x", "y", "z", "u", "v"]
    looks = [look_of(name, others) for name in (*PLANNERS, *others)]
    assert len({(look["colour"], look["dash"]) for look in looks}) == len(looks)
    assert len({look["dash"] for look in looks[: len(PLANNERS)]}) == len(PLANNERS), "told apart without any colour"
    assert all(re.fullmatch(r"#[0-9A-Fa-f]{6}", colour) for colour in palette().values())


def test_a_page_plays_scrubs_and_runs_no_foreign_script(drive: Simulation, tmp_path: Path) -> None:
    file = save_picture(drive, tmp_path / "drive.html")
    assert file.read_text(encoding="utf-8") == page(f"{NASTY} · {drive.planner} · seed {drive.seed}", "Drive", drive_document(drive))
    with chromium() as browser:
        tab = browser.new_page(viewport={"width": 1000, "height": 700})
        faults: list[str] = []
        tab.on("pageerror", lambda error: faults.append(str(error)))
        asked: list[str] = []
        tab.on("request", lambda request: asked.append(request.url))
        tab.goto(file.as_uri())
        assert tab.locator("h1").inner_text().startswith(NASTY)
        tab.keyboard.press("End")
        assert tab.locator(".mcdas-words").inner_text() == drive_document(drive)["outcome"]
        tab.keyboard.press("Home")
        tab.keyboard.press("ArrowRight")
        assert tab.evaluate("view.transport.time") == pytest.approx(0.1)
        tab.keyboard.press(" ")
        tab.get_by_role("button", name="Pause").click()
        assert tab.evaluate("view.transport.time") > 0.1
        tab.get_by_label("time", exact=True).fill("0.5")
        assert tab.evaluate("view.transport.time") == pytest.approx(0.5)
        tab.get_by_label("time", exact=True).focus()
        tab.keyboard.press("ArrowRight")
        assert tab.evaluate("view.transport.time") == pytest.approx(0.6)
        assert tab.evaluate("window.hacked === undefined")
        assert (faults, asked) == ([], [file.as_uri()])


def test_a_page_names_at_its_edge_who_is_out_of_the_picture(tmp_path: Path) -> None:
    ahead, behind = ({"name": name, "s_m": s, "speed_mps": 11.1} for name, s in (("ahead", 120.0), ("behind", -80.0)))
    lone = simulate(make_scene(ahead, behind, {"name": "far", "s_m": 400.0, "speed_mps": 11.1}, duration_s=0.3), FakeDriver())
    file = save_picture(lone, tmp_path / "lone.html")
    with chromium() as browser:
        tab = browser.new_page(viewport={"width": 1000, "height": 700})
        tab.goto(file.as_uri())
        tab.wait_for_selector(".mcdas-away")
        assert sorted(tab.locator(".mcdas-away").all_text_contents()) == ["ahead (120 m) ▶", "◀ behind (80 m)"]
        road = tab.locator(".mcdas-bird").bounding_box()
        for word in tab.locator(".mcdas-away").all():
            box = word.bounding_box()
            assert road["x"] <= box["x"]
            assert box["x"] + box["width"] <= road["x"] + road["width"]
