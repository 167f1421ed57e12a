"""The judge of parking: planted violations are found, sound drives pass, scipy and shapely agree."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mcdas_opt.domain.parking import ParkingTrajectory
from mcdas_opt.geometry.clearance import Body, body_corners
from mcdas_opt.parking.case_file import load_parking_case, slot_case
from mcdas_opt.parking.closed_form import two_arc
from mcdas_opt.parking.trajectory_file import load_parking_trajectory
from mcdas_opt.verification.parking_judge import judge_parking

TPCAP = Path(__file__).parents[2] / ".." / "shared" / "data" / "tpcap"
CASE = slot_case(8.5)
SOUND = two_arc(CASE)


def changed(**columns: np.ndarray) -> ParkingTrajectory:
    kept = {k: getattr(SOUND, k) for k in ("t_s", "x_m", "y_m", "heading_rad", "speed_mps", "steering_rad")}
    return ParkingTrajectory.from_columns({**kept, **columns})


def names(trajectory: ParkingTrajectory, case=CASE) -> list[str]:
    return [v.name for v in judge_parking(case, trajectory).verdict.violations]


def test_a_sound_drive_passes():
    assert judge_parking(CASE, SOUND).verdict.passed


@pytest.mark.parametrize(
    ("columns", "found"),
    [
        ({"x_m": SOUND.x_m + np.linspace(0.0, 0.02, len(SOUND))}, "pose is not the integral"),
        ({"x_m": SOUND.x_m + 0.05}, "start position"),
        ({"heading_rad": SOUND.heading_rad + 0.02}, "start heading"),
        ({"steering_rad": SOUND.steering_rad + 0.05}, "start steering"),
        ({"speed_mps": SOUND.speed_mps - 0.05}, "start speed"),
        ({"speed_mps": SOUND.speed_mps * 1.05}, "reverse speed"),
        ({"steering_rad": SOUND.steering_rad * 1.05}, "steering angle"),
        ({"t_s": SOUND.t_s / 1.1}, "steering rate"),
        ({"t_s": SOUND.t_s * 2.0}, "sampling"),
        ({"speed_mps": np.where(SOUND.t_s == SOUND.t_s[-1], -0.01, SOUND.speed_mps)}, "end speed"),
        ({"t_s": np.where(SOUND.t_s == SOUND.t_s[5], SOUND.t_s[3], SOUND.t_s)}, "time not monotone"),
        ({"x_m": np.where(SOUND.t_s == SOUND.t_s[5], np.nan, SOUND.x_m)}, "not finite"),
    ],
)
def test_planted_violations_are_found(columns, found):
    assert found in names(changed(**columns))


@pytest.mark.parametrize("name", SOUND.columns())
def test_every_column_must_be_finite(name):
    for wrong in (np.nan, np.inf):
        column = np.where(SOUND.t_s < SOUND.t_s[5], getattr(SOUND, name), wrong)
        (found,) = judge_parking(CASE, replace(SOUND, **{name: column})).verdict.violations
        assert (found.name, found.value) == ("not finite", len(SOUND) - 5)


@pytest.mark.parametrize("count", [0, 1])
def test_too_few_samples_are_told_as_that(count):
    few = ParkingTrajectory(**{name: column[:count] for name, column in SOUND.columns().items()})
    (found,) = judge_parking(CASE, few).verdict.violations
    assert (found.name, found.value, found.limit, found.unit) == ("sampling", count, 2.0, "samples")


def test_acceleration_is_read_from_the_slope_whatever_the_column_says():
    quick = changed(t_s=SOUND.t_s / 1.05, acceleration_mps2=np.zeros(len(SOUND)))
    assert "acceleration" in names(quick)


def test_a_shorter_slot_is_hit_and_a_moved_goal_is_missed():
    shorter = slot_case(7.9)
    moved = replace(shorter, start=CASE.start, goal=CASE.goal)
    assert any(name.startswith("clearance: ") and "car" in name for name in names(SOUND, moved))
    assert "end position" in names(SOUND, replace(CASE, goal=CASE.goal + [0.03, 0.0, 0.0]))
    assert "end heading" in names(SOUND, replace(CASE, goal=CASE.goal + [0.0, 0.0, 0.02]))


def test_the_integral_agrees_with_scipy_and_the_clearance_with_shapely():
    from shapely.geometry import Polygon

    rng = np.random.default_rng(3)
    t = np.cumsum(np.concatenate([[0.0], rng.uniform(0.02, 0.05, 60)]))
    v = np.concatenate([[0.0], rng.uniform(-1.0, 1.0, 59), [0.0]])
    delta = rng.uniform(-0.5, 0.5, 61)
    driven = ParkingTrajectory.from_controls(t, np.tile(CASE.start, (61, 1)), v, delta)
    found = judge_parking(CASE, driven)

    def right_side(now, x):
        speed, steering = np.interp(now, t, v), np.interp(now, t, delta)
        return [speed * np.cos(x[2]), speed * np.sin(x[2]), speed * np.tan(steering) / CASE.vehicle.wheelbase_m]

    true = CASE.start
    for ends in pairwise(t):  # speed and steering are smooth between two nodes
        true = solve_ivp(right_side, ends, true, rtol=1e-9, atol=1e-10).y[:, -1]
    assert found.poses[-1] == pytest.approx(true, abs=1e-6)
    bodies = [Polygon(c) for c in body_corners(found.poses, Body.of(CASE.vehicle))]
    least = min(body.distance(Polygon(outline)) for body in bodies for outline in CASE.obstacles)
    assert found.min_clearance_m == pytest.approx(least, abs=1e-9)


def test_a_published_solutions_faults_are_found_in_its_file(tmp_path):
    """A sound drive written as the competition's entrants write theirs, then with a steering angle that jumps: how far off the goal."""

    def rejected(driven):
        """A row's t is the time of the row after it."""
        names = ("x_m", "y_m", "heading_rad", "speed_mps", "acceleration_mps2", "steering_rad", "steering_rate_radps")
        next_t = [*driven.t_s[1:].tolist(), float(driven.t_s[-1]) + 0.05]
        rows = zip(*(getattr(driven, name).tolist() for name in names), next_t, strict=True)
        path = tmp_path / "solution.csv"
        text = "".join("\t".join(map(repr, (k, *row))) + "\n" for k, row in enumerate(rows))
        path.write_text("\tx\ty\ttheta\tv\ta\tsigma\tomega\tt\n" + text)
        return judge_parking(CASE, load_parking_trajectory(path))

    assert rejected(SOUND).verdict.passed
    jumping = changed(steering_rad=np.where(SOUND.t_s > 0.5 * SOUND.t_s[-1], -SOUND.steering_rad, SOUND.steering_rad))
    found = rejected(jumping)
    values = {violation.name: violation.value for violation in found.verdict.violations}
    assert values["steering rate"] > 2.0
    assert values["end position"] == pytest.approx(float(np.hypot(*(found.poses[-1, :2] - CASE.goal[:2]))), abs=1e-9)
    assert values["end position"] > 0.1


@pytest.mark.published(TPCAP)
@pytest.mark.parametrize(
    ("number", "off_m", "overlap"), [(1, 0.69, ""), (2, 0.49, "integrated"), (3, 0.24, ""), (4, 1.56, "both"), (5, 6.57, "published")]
)
def test_the_published_tpcap_solutions_are_rejected_and_why(number, off_m, overlap):
    case = load_parking_case(TPCAP / f"Case{number}.csv")
    driven = load_parking_trajectory(TPCAP / f"Solution_Case{number}.csv").moved(-case.origin_m[0], -case.origin_m[1])
    found = {v.name: v for v in judge_parking(case, driven).verdict.violations}
    assert found["end position"].value == pytest.approx(off_m, abs=0.005)
    assert found["steering rate"].value > 2.0
    assert any(name.startswith("clearance: overlap") for name in found) == (overlap in ("integrated", "both"))
    assert any(name.startswith("clearance as published: overlap") for name in found) == (overlap in ("published", "both"))
