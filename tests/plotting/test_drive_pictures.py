"""Pictures of a drive: where things stand in them, and that the files are what they say."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_hex
from PIL import Image

from mcdas_opt.domain.escapes import Escape, Escapes
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.track import Track
from mcdas_opt.errors import InputError
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.plotting import style
from mcdas_opt.plotting.animation import MOST_FRAMES, draw_thumbnail, film, frames, outcome_words, sheet
from mcdas_opt.plotting.birdseye import BirdsEye, Camera, ellipse, words_at_the_edge
from mcdas_opt.plotting.export import MOVING, check_picture
from mcdas_opt.plotting.moments import View, moment_at, moments, view_of
from mcdas_opt.plotting.player import drive_page
from mcdas_opt.plotting.strips import Strip, StripChart, strips_of
from mcdas_opt.plotting.time_to_react_strip import worst
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.record import Simulation
from tests.plotting.pixels import as_bytes, at, coloured, pixels
from tests.simulation.fake_driver import FakeDriver
from tests.simulation.scene_maker import make_scene

CURVED = Road(lanes_left=1, curvature=((0.0, 0.0), (50.0, 0.02), (200.0, -0.01)))


@pytest.fixture(scope="module")
def drive() -> Simulation:
    cars = [{"name": "front", "s_m": 9.0, "speed_mps": 5.0}, {"name": "beside", "s_m": 1.0, "d_m": 3.7, "speed_mps": 11.1}]
    return simulate(make_scene(*cars, duration_s=5.0), FakeDriver())


@pytest.mark.parametrize("s", [0.0, 30.0, 120.0, 900.0])
def test_the_camera_keeps_shapes_and_puts_the_road_level_at_the_host(s: float) -> None:
    camera = Camera(CURVED, s)
    x, y, angle = camera.place(s, 1.5, 0.1)
    np.testing.assert_allclose([x, y, angle], [0.0, 1.5, 0.1], atol=1e-9)
    around = s + np.linspace(-40.0, 60.0, 11)
    seen = np.column_stack(camera.place(around, np.full(11, -1.0))[:2])
    plane = np.column_stack(FrenetFrame(road=CURVED).to_plane(around, np.full(11, -1.0), np.zeros(11))[:2])
    for k in range(10):
        assert math.dist(seen[k], seen[k + 1]) == pytest.approx(math.dist(plane[k], plane[k + 1]), abs=1e-6)


def test_the_ellipse_is_2_5_standard_deviations_away() -> None:
    p = np.diag([4.0, 1.0, 0.25, 1.0])
    p[0, 2] = p[2, 0] = 0.6
    s, d = ellipse(Track(id="1", s_m=10.0, d_m=2.0, speed_s_mps=0.0, covariance=p))
    off = np.stack([s - 10.0, d - 2.0])
    distance = np.einsum("ik,ij,jk->k", off, np.linalg.inv(p[np.ix_([0, 2], [0, 2])]), off)
    np.testing.assert_allclose(distance, 2.5**2, rtol=1e-9)


def test_moments_show_the_truth_of_their_time(drive: Simulation) -> None:
    moment = moment_at(drive, 0.53)
    assert moment.host.pose[0] == pytest.approx(11.1 * 0.53)
    assert moment.others[0].pose[0] == pytest.approx(9.0 + 5.0 * 0.53)
    assert moment.plan.time_s == 0.5
    assert moment.ended is None
    last = moments(drive)[-1]
    assert last.time_s == drive.duration_s
    assert last.struck == {"host", "front"}
    assert [m.time_s for m in moments(drive, at_most=3)] == [0.0, 0.5 * drive.duration_s, drive.duration_s]


def test_neighbours_of_the_beginning_are_in_view(drive: Simulation) -> None:
    view = view_of(drive)
    assert view.ahead_m > 9.0 + 2.25
    assert view.left_m > drive.scene.true_road.left_edge_m


@pytest.fixture(scope="module")
def passing() -> Simulation:
    """One car is passed and falls far behind, one comes from far behind and passes, one drives across the road."""
    slow = {"name": "slow", "s_m": 20.0, "d_m": -3.7, "speed_mps": 2.0}
    fast = {"name": "fast", "s_m": -90.0, "d_m": 3.7, "speed_mps": 36.0}
    across = {"name": "across", "s_m": 70.0, "d_m": 40.0, "speed_mps": 8.0, "heading_rad": -0.5 * math.pi}
    return simulate(make_scene(slow, fast, across, speed_mps=12.0, duration_s=9.0), FakeDriver())


def test_the_window_holds_who_comes_near_at_any_time(passing: Simulation) -> None:
    view = view_of(passing)
    assert (view.back_m, view.ahead_m) == (55.0, 75.0)
    assert view.left_m > 8.0
    alone = view_of(replace(passing, neighbours=()))
    assert (alone.back_m, alone.ahead_m) == (25.0, 45.0)


@pytest.mark.parametrize("time_s", [0.0, 2.0, 4.5, 7.0, 9.0])
def test_whoever_is_out_of_the_picture_is_named_at_its_edge(passing: Simulation, time_s: float) -> None:
    """Everybody nearer than 150 m is in the picture, body and name, or named at the edge with the distance."""
    view = view_of(passing)
    fig = style.figure(9.6, 9.6 * view.aspect)
    fig.set_layout_engine("none")
    axes = fig.add_axes((0.0, 0.0, 1.0, 1.0))
    bird = BirdsEye(axes, passing.scene.true_road, view, passing.trajectory)
    moment = moment_at(passing, time_s)
    bird.show(moment)
    fig.canvas.draw()
    s, d, _ = moment.host.pose
    words = {text.get_text() for text in axes.texts}
    assert len(words) == 1 + len(moment.others)
    for body in moment.others:
        x, y = body.pose[0] - s, body.pose[1]
        half = np.array([0.5 * body.length_m, 0.5 * body.width_m])[:: 1 if abs(body.pose[2]) < 0.1 else -1]
        inside = -view.back_m < x + half[0] and x - half[0] < view.ahead_m and view.right_m < y + half[1] and y - half[1] < view.left_m
        arrow = "◀" if x < -view.back_m else "▶" if x > view.ahead_m else "▲" if y > 0.0 else "▼"
        far = f"{body.name} ({math.hypot(x, y - d):.0f} m)"
        assert (body.name if inside else f"{far} {arrow}" if arrow == "▶" else f"{arrow} {far}") in words, (body.name, time_s)
    boxes = [text.get_window_extent() for text in axes.texts]
    assert all(box.x0 >= 0.0 and box.y0 >= 0.0 and box.x1 <= fig.bbox.x1 and box.y1 <= fig.bbox.y1 for box in boxes)


def test_no_name_covers_its_own_body_however_low_the_picture_is() -> None:
    ends = [{"name": name, "s_m": s, "speed_mps": 11.1} for name, s in (("front", 60.0), ("rear", -45.0))]
    first = draw_thumbnail(simulate(make_scene(*ends, duration_s=0.3, road={"lanes_left": 0, "lanes_right": 0}), FakeDriver())).axes[0]
    assert {text.get_text(): text.xy[1] for text in first.texts} == pytest.approx(dict.fromkeys(("host", "front", "rear"), 0.9), abs=0.02)


def test_words_at_the_edge_stand_apart_and_those_far_away_are_left_out() -> None:
    view = View(back_m=50.0, ahead_m=60.0, right_m=-6.0, left_m=6.0)
    away = [(80.0, -80.0, 0.0, "b"), (60.0, -60.0, 0.0, "a"), (70.0, 70.0, 0.0, "c"), (160.0, -160.0, 4.0, "far")]
    words = words_at_the_edge(away, view, 0.2)
    assert [word for word, _, _ in words] == ["◀ a (60 m)", "c (70 m) ▶", "◀ b (80 m)"]
    (_, (_, first), _), _, (_, (_, second), _) = words
    assert first == 0.0
    assert second == pytest.approx(2.0)  # a line of ten points higher
    bodies = [(-50.0, -30.0, -1.0, 3.0)]
    (word, (_, at), _), *_ = words_at_the_edge(away, view, 0.2, bodies)
    assert word == "◀ a (60 m)"
    assert at == pytest.approx(-2.0)  # below the body that stands there
    assert not words_at_the_edge(away[:1], view, 0.2, [(-50.0, -30.0, -6.0, 6.0)])


def test_a_gif_has_a_frame_a_cycle_and_one_for_the_end(drive: Simulation, tmp_path: Path) -> None:
    path = film(drive, tmp_path / "drive.gif")
    with Image.open(path) as picture:
        assert picture.n_frames == len(drive.cycles) + 1
        lengths = []
        for k in range(picture.n_frames):
            picture.seek(k)
            lengths.append(picture.info["duration"])
    assert sum(lengths[:-1]) == pytest.approx(1000.0 * drive.duration_s, abs=15.0)
    assert path.stat().st_size < 4e6


def test_a_long_drive_is_thinned(drive: Simulation) -> None:
    cycles = tuple(replace(drive.cycles[0], time_s=0.1 * k) for k in range(250))
    many: Any = replace(drive, cycles=cycles, duration_s=25.0)
    assert len(moments(many, at_most=MOST_FRAMES)) == MOST_FRAMES


def test_frames_differ_where_things_move_and_nowhere_else(drive: Simulation) -> None:
    pictures = frames(drive, moments(drive)[:6])
    first, later = (np.asarray(p).astype(int) for p in (pictures[0], pictures[5]))
    changed = np.abs(first - later).sum(axis=-1) > 0
    assert changed.any()
    labels = changed[-25:]  # the charts' axis labels stand still
    assert not labels.any()


def test_the_same_drive_is_the_same_bytes(drive: Simulation, tmp_path: Path) -> None:
    for suffix in (".gif", ".png"):
        a, b = drive.save(tmp_path / f"a{suffix}"), drive.save(tmp_path / f"b{suffix}")
        assert a.read_bytes() == b.read_bytes()


def test_the_sheet_has_a_row_a_moment_and_four_charts(drive: Simulation) -> None:
    assert len(sheet(drive, count=3).axes) == 3 + 4
    _, along, _, _ = strips_of(drive)
    assert along.title == "acceleration [m/s²]"
    assert np.allclose(np.interp(drive.trajectory.t_s, along.t_s, along.values), drive.trajectory.acceleration_mps2)
    assert outcome_words(drive) == f"collision with front at {drive.impact_speed_mps:.1f} m/s"


@pytest.mark.parametrize(("plant", "words"), [("kinematic", "seed 12"), ("dynamic", "dynamic plant, seed 12")])
def test_the_heading_says_plant_and_seed(drive: Simulation, plant: str, words: str) -> None:
    asked = replace(drive, plant=plant, seed=12)
    assert f"{drive.name} · {drive.planner} · {words}" in [text.get_text() for text in sheet(asked, count=2).texts]
    assert f"<title>{drive.name} · {drive.planner} · {words}</title>" in drive_page(asked)


def test_the_longest_heading_leaves_room_for_how_the_drive_ended(drive: Simulation) -> None:
    name = "front-braking-with-follower"
    fig = sheet(replace(drive, name=name, planner="closed-form-corrected", plant="multi-body", seed=123), count=2)
    heading, ended = (text.get_window_extent() for text in fig.texts[:2])
    assert heading.x1 < ended.x0


def test_times_to_react_are_drawn_where_the_plans_tell_them(drive: Simulation) -> None:
    told = Escapes(brake=Escape(open=True, last_moment_s=1.0), left=Escape(open=True, last_moment_s=2.0, last_comfortable_s=1.5))
    cycles = tuple(replace(cycle, plan=replace(cycle.plan, escapes=told)) for cycle in drive.cycles)
    *_, strip = sheet(replace(drive, cycles=cycles), count=3).axes
    assert [label.get_text() for label in strip.get_yticklabels()] == ["right", "left", "accelerate", "brake"]
    shown = {
        (round(box.y0), to_hex(bars.get_facecolor()[0]))
        for bars in strip.collections
        for path in bars.get_paths()
        if (box := path.get_extents()).width > 0.0
    }
    assert shown == {(3, to_hex(style.ORANGE)), (2, "#d9d9dd"), (1, to_hex(style.GREEN)), (0, "#d9d9dd")}


def test_one_cycle_that_is_closed_is_seen_for_half_a_second(drive: Simulation) -> None:
    """The thick row is the worst of the last 0.5 s, the thin one each cycle; the legend says so."""
    told = [Escapes(brake=Escape(open=True, last_moment_s=2.0, last_comfortable_s=1.0)), Escapes()]
    plans = [replace(cycle.plan, escapes=told[k == 1]) for k, cycle in enumerate(drive.cycles)]
    cycles = tuple(replace(cycle, plan=plan) for cycle, plan in zip(drive.cycles, plans, strict=True))
    *_, strip = sheet(replace(drive, cycles=cycles), count=3).axes
    end = drive.duration_s
    for tall, until in ((0.55, 0.7), (0.15, 0.2)):
        spans: dict[str, float] = {}
        for bars in strip.collections:
            for path in bars.get_paths():
                box = path.get_extents()
                if box.y0 > 2.5 and box.height == pytest.approx(tall):
                    colour = to_hex(bars.get_facecolor()[0])
                    spans[colour] = spans.get(colour, 0.0) + box.width
        assert spans == pytest.approx({to_hex(style.GREEN): end - (until - 0.1), "#d9d9dd": until - 0.1})
    legend = [text.get_text() for text in strip.get_legend().get_texts()]
    assert legend == ["comfortable", "open", "closed", "thick: worst of the last 0.5 s", "thin: each cycle"]


def test_the_worst_is_of_the_cycles_that_were_told() -> None:
    starts = [0.1 * k for k in range(8)]
    assert worst(starts, ["open", *[None] * 7]) == [*["open"] * 6, None, None]
    assert worst(starts, ["closed", "open", *["comfortable"] * 6]) == [*["closed"] * 6, "open", "comfortable"]


@pytest.mark.parametrize("level", [-7.4, -4.0, 0.0, 0.5, 2.5])
def test_the_word_of_a_limit_stands_where_no_curve_comes(level: float) -> None:
    t = np.linspace(0.0, 8.0, 81)
    values = np.full(81, level)
    limits = ((-8.0, "hardest braking"), (3.0, "most"), (0.0, "touch"))
    strip = Strip(title="acceleration [m/s²]", t_s=t, values=values, limits=limits, low=-10.4, high=5.0)
    with style.styled():
        fig = style.figure(2.1, 1.25)
        fig.set_layout_engine("none")
        axes = fig.add_axes((0.0, 0.0, 1.0, 1.0))
        StripChart(axes, strip, 8.0)
        fig.canvas.draw()
    heights = axes.transData.transform(np.array([[0.0, v] for v in (level, *(value for value, _ in limits))]))[:, 1]
    for text in axes.texts:
        box = text.get_window_extent()
        assert not any(box.y0 < height < box.y1 for height in heights), text.get_text()
        assert fig.bbox.y0 <= box.y0
        assert box.y1 <= fig.bbox.y1


def test_the_dot_is_whole_at_the_end_and_absent_off_the_chart() -> None:
    strip = Strip(title="clearance [m]", t_s=np.array([0.0, 1.0]), values=np.array([5.0, 40.0]), limits=(), low=0.0, high=30.0)
    chart = StripChart(style.figure(2.0, 1.0).add_subplot(), strip, 1.0)
    _, dot = chart.artists
    assert not dot.get_clip_on()
    chart.show(0.0)
    assert dot.get_ydata() == [5.0]
    chart.show(1.0)
    assert np.isnan(dot.get_ydata()).all()


def test_bodies_and_road_stand_in_the_sheet_where_they_are(drive: Simulation) -> None:
    """The rear of every body, off its name and its track's mark, has the body's colour, and the road's edge is where asphalt ends."""
    fig = sheet(drive, count=3)
    shown = pixels(fig)
    for axes, time_s in zip(fig.axes[:3], (0.0, 0.5 * drive.duration_s, drive.duration_s), strict=True):
        moment = moment_at(drive, time_s)
        assert axes.get_title(loc="left").startswith(f"{time_s:.1f} s   {moment.action}")
        s = moment.host.pose[0]
        assert len(moment.others) == 2
        for body in (moment.host, *moment.others):
            rear = (body.pose[0] - 0.4 * body.length_m - s, body.pose[1] - 0.25 * body.width_m)
            assert at(shown, axes, *rear) == as_bytes(body.colour), (body.name, time_s)
        road = drive.scene.true_road
        low, high = axes.get_xlim()
        for x in (low + 1.0, high - 1.0):
            assert at(shown, axes, x, road.right_edge_m - 0.5) == as_bytes("white")
            assert at(shown, axes, x, road.right_edge_m + 0.5) == as_bytes(style.ASPHALT)
    assert all("[" in axes.get_title(loc="left") for axes in fig.axes[3:])  # each chart's unit


def test_an_empty_curved_road_is_drawn_up_to_its_end(tmp_path: Path) -> None:
    """The road bends to the left: ahead of the host asphalt lies higher; at 30 m it ends in a line across."""
    scene = make_scene(duration_s=0.3, road={"curvature": [[0.0, 0.01]], "road_end_s_m": 30.0})
    drive = simulate(scene, FakeDriver())
    shown = pixels(drive.save(tmp_path / "alone.png"))
    assert coloured(shown, style.HOST).sum() > 500
    assert coloured(shown, style.VERMILION).sum() > 50
    first = sheet(drive, count=2).axes[0]
    drawn = pixels(first.figure)
    s = np.linspace(-8.0, 28.0, 10)
    x, y, _ = Camera(scene.true_road, 0.0).place(s, np.full(10, -1.5))
    colours = [at(drawn, first, *place) for place in zip(x.tolist(), y.tolist(), strict=True)]
    assert colours == [as_bytes(style.ASPHALT)] * 10
    beyond_x, beyond_y, _ = Camera(scene.true_road, 0.0).place(33.0, -1.5)
    assert at(drawn, first, float(beyond_x), float(beyond_y)) == as_bytes("white")


@pytest.mark.parametrize("name", ["drive.mp4", "drive", "no/such/folder.gif"])
def test_other_suffixes_and_missing_folders_are_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"\.png or \.html|no such folder"):
        check_picture(tmp_path / name, MOVING)
