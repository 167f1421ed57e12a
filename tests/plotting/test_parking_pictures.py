"""Parking pictures show obstacles, bodies and limits where they are, and closed forms have some too."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.colors import to_hex, to_rgb
from PIL import Image

from benchmarks.parking import slot_sweep
from mcdas_opt.errors import ParameterError
from mcdas_opt.parking.case_file import load_parking_case, slot_case
from mcdas_opt.parking.park import park
from mcdas_opt.plotting import parking as parking_pictures
from mcdas_opt.plotting import style
from mcdas_opt.plotting.parking import film, frames, sheet
from tests.plotting.pixels import as_bytes, at, coloured, pixels


def test_a_sheet_and_an_animation(tmp_path, monkeypatch):
    monkeypatch.setattr(parking_pictures, "_MOST_FRAMES", 5)
    case = slot_case(8.5)
    answer = park(case, "two-arc")
    pictures, milliseconds = frames(answer)
    assert len(pictures) == len(milliseconds)
    assert sum(milliseconds[:-1]) == pytest.approx(1e3 * (answer.duration_s or 0.0), rel=0.05)
    with Image.open(film(answer, tmp_path / "two.gif")) as moving:
        assert moving.n_frames == len(pictures)
    first, last = (np.argwhere(coloured(pixels(pictures[k]), _seen(style.ORANGE), 25))[:, 1].mean() for k in (0, -1))
    assert np.sign(last - first) == np.sign(case.goal[0] - case.start[0])


def _seen(colour, alpha=0.55):
    """A body's colour on white."""
    return to_hex([1.0 - alpha * (1.0 - part) for part in to_rgb(colour)])


def test_the_sheet_shows_obstacles_start_goal_and_limits(tmp_path):
    case = slot_case(8.5)
    answer = park(case, "two-arc")
    figure = sheet(answer)
    above, curvature, speed = figure.axes
    shown = pixels(figure)
    pieces = [np.clip(outline, *np.array([above.get_xlim(), above.get_ylim()]).T) for outline in case.obstacles]
    pieces = [piece for piece in pieces if np.ptp(piece, axis=0).min() > 0.2]
    assert len(pieces) == 2  # the car ahead and the kerb
    for in_view in pieces:
        assert at(shown, above, *in_view.mean(axis=0)) == as_bytes("#c9c9ce")
    for pose, colour in ((case.start, style.GREY), (case.goal, style.GREEN)):
        ahead = 0.75 * case.vehicle.wheelbase_m * np.array([np.cos(pose[2]), np.sin(pose[2])])
        assert np.abs(np.array(at(shown, above, *(pose[:2] + ahead + [0.0, 0.3]))) - as_bytes(_seen(colour))).max() < 40
    assert (above.get_xlabel(), above.get_ylabel()) == ("x [m]", "y [m]")
    assert (curvature.get_ylabel(), speed.get_ylabel()) == ("curvature [1/m]", "speed [m/s]")
    top = np.tan(case.vehicle.steering_max_rad) / case.vehicle.wheelbase_m
    assert [line.get_ydata()[0] for line in curvature.lines[1:]] == pytest.approx([top, -top])
    assert np.abs(curvature.lines[0].get_ydata()).max() <= top + 1e-9
    assert speed.lines[0].get_xdata()[-1] == pytest.approx(answer.trajectory.path_m, rel=1e-3)
    kept = pixels(answer.save(tmp_path / "two.png"))
    assert kept.shape[:2] == tuple(int(150 * inches) for inches in figure.get_size_inches()[::-1])
    assert coloured(kept, "#c9c9ce", 2).mean() == pytest.approx(coloured(shown, "#c9c9ce", 2).mean(), rel=0.05)


def test_axes_say_what_was_subtracted_from_the_files_coordinates(tmp_path):
    file = tmp_path / "Case1.csv"
    file.write_text("4484378811.24645,-354286007.239762,0,4484378817.24645,-354286007.239762,0,0\n")
    case = load_parking_case(file)
    answer = park(case, "search")
    above = sheet(answer).axes[0]
    assert (above.get_xlabel(), above.get_ylabel()) == ("x - 4484378811.24645 m [m]", "y + 354286007.239762 m [m]")
    rear_axle = np.concatenate([line.get_xdata() for line in above.lines if line.get_label().startswith("rear axle")])
    assert np.nanmin(rear_axle) + 4484378811.24645 == pytest.approx(answer.trajectory.x_m[0], abs=1e-6, rel=0)


def test_a_refusal_cannot_be_drawn():
    case = slot_case(4.55)
    with pytest.raises(ParameterError, match="refused"):
        sheet(park(case))


def test_the_sweep_names_every_planner():
    rows = [
        {"case": f"{r} L", "planner": p, "status": "planned", "duration_s": str(d)}
        for r, p, d in (("1.6", "nlp", 6.5), ("1.2", "nlp", 31.0), ("1.6", "search", 13.0))
    ]
    figure = slot_sweep(rows, {"two-arc": 6.47, "closed-form": 11.7, "closed-form-corrected": None}, 4.5)
    labels = {text.get_text() for text in figure.axes[0].get_legend().get_texts()}
    assert {"nlp", "search", "two-arc needs 1.44 L"} <= labels


@pytest.mark.parametrize("turn_rad", [0.0, 0.645, 2.6, 3.0])  # the last two are wider than high
def test_the_legend_stands_whole_in_the_picture_whatever_way_the_yard_is_turned(turn_rad):
    """As in coordinates of a map: far from the origin, and turned."""
    answer = park(slot_case(8.5), "two-arc")
    figure = sheet(turned(answer, turn_rad, (690998.0, 5334000.0)))
    figure.canvas.draw()
    (legend,) = [*figure.legends, *(axes.get_legend() for axes in figure.axes if axes.get_legend())]
    inside, whole = legend.get_window_extent(), figure.bbox
    assert whole.x0 <= inside.x0 < inside.x1 <= whole.x1
    assert whole.y0 <= inside.y0 < inside.y1 <= whole.y1


def turned(answer, turn_rad, origin_m):
    """The answer in a frame that is turned and moved."""
    c, s = np.cos(turn_rad), np.sin(turn_rad)
    turn = np.array([[c, s], [-s, c]])

    def pose(at):
        return np.array([*(at[:2] @ turn + origin_m), at[2] + turn_rad])

    case, driven = answer.case, answer.trajectory
    x_m, y_m = (np.column_stack([driven.x_m, driven.y_m]) @ turn + origin_m).T
    moved = replace(
        case,
        start=pose(case.start),
        goal=pose(case.goal),
        obstacles=tuple(outline @ turn + origin_m for outline in case.obstacles),
        slot=None,
    )
    there = replace(driven, x_m=x_m, y_m=y_m, heading_rad=driven.heading_rad + turn_rad)
    return replace(answer, case=moved, trajectory=there)
