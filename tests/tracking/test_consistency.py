"""The filter believes itself neither too much nor too little: NEES and NIS in their 95 % bands, for targets moving as its model says."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import chi2

from mcdas_opt.catalogue.motion import load_motion
from mcdas_opt.catalogue.sensors import load_sensor
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.geometry.window import frame_near
from mcdas_opt.simulation.sensors import mounting
from mcdas_opt.tracking.association import innovation
from mcdas_opt.tracking.cv_filter import ConstantVelocityFilter
from mcdas_opt.tracking.fix import Viewpoint, radar_fixes
from mcdas_opt.tracking.tracker import Tracker
from tests.tracking.worlds import BEND, CAR, ESR, STRAIGHT, body_of, host_at, model_motion, radar_scan

MOTION = load_motion("car")
PRIOR = np.diag([1.0, 4.0, 1.0, 0.25])
STEPS = 30


def squared(error: Array, covariance: Array) -> float:
    return float(error @ np.linalg.solve(covariance, error))


def runs_of(sector: Sector, start: list[float], sensor_name: str, road, runs: int, seed: int) -> tuple[Array, Array]:
    """(runs,) NEES at the end, and all NIS on the way, of runs in which the target stayed in view."""
    sensor, place = load_sensor(sensor_name), mounting(sector, CAR)
    random = np.random.default_rng(seed)
    nees, nis = [], []
    for _ in range(runs):
        first = np.array(start) + random.standard_normal(4) * np.sqrt(np.diag(PRIOR))
        kf = ConstantVelocityFilter(np.array(start), PRIOR, 0.0, MOTION)
        for step in model_motion(first, random, STEPS, sensor.period_s, 8.0, 2.0):
            host = host_at(step.t, road)
            scan = radar_scan(step.t, [body_of(step.x, road)], sector=sector, sensor=sensor, road=road, random=random)
            if not scan.radar:
                break
            frame = frame_near(road, host.s_m)
            (fix,) = radar_fixes(scan.radar, Viewpoint.of(place, host, CAR, frame), frame, (4.5, 1.8))
            nis.append(squared(*innovation(kf.at(step.t), fix)))
            kf.correct(step.t, *fix.read(kf.at(step.t)))
        else:
            nees.append(squared(kf.state - step.x, kf.covariance))
    return np.array(nees), np.array(nis)


GEOMETRIES = {
    "front": (Sector.FRONT, [30.0, 12.0, 0.3, 0.0], "delphi_esr", STRAIGHT, 100),
    "rear": (Sector.REAR, [-30.0, 12.0, -0.3, 0.0], "delphi_esr", STRAIGHT, 100),
    "far and in the next lane": (Sector.FRONT, [120.0, 12.0, 3.7, 0.0], "delphi_esr", STRAIGHT, 100),
    "alongside": (Sector.LEFT, [0.0, 12.0, 3.7, 0.0], "corner_radar", STRAIGHT, 100),
    "round a bend": (Sector.FRONT, [30.0, 12.0, 0.0, 0.0], "delphi_esr", BEND, 50),
}


@pytest.mark.parametrize("name", GEOMETRIES)
def test_nees_and_nis_lie_in_their_95_percent_band(name: str) -> None:
    nees, nis = runs_of(*GEOMETRIES[name], seed=20)
    assert len(nees) >= 0.8 * GEOMETRIES[name][4]
    low, high = chi2.ppf([0.025, 0.975], 4 * len(nees)) / len(nees)
    assert low <= nees.mean() <= high
    low, high = chi2.ppf([0.025, 0.975], 3 * len(nis)) / len(nis)  # innovations are white, so that all of them count
    assert low <= nis.mean() <= high


def test_a_turning_face_is_reckoned_with() -> None:
    """Where the line of sight meets a body's corner, 0.05 rad of heading move the point by 0.3 m, scan after scan.

    The heading is only believed, and its error is no white noise: 4.4 +- 0.2 is what comes out (10 with road-aligned bodies).
    """
    nees, nis = runs_of(Sector.FRONT, [13.0, 12.0, -3.7, 0.0], "delphi_esr", STRAIGHT, 120, seed=20)
    assert 3.4 < nees.mean() < 5.4
    low, high = chi2.ppf([0.025, 0.975], 3 * len(nis)) / len(nis)
    assert low <= nis.mean() <= high


def test_the_whole_tracker_is_consistent_too() -> None:
    """From its own first detection, with its own gate and association, two cars at once."""
    random = np.random.default_rng(5)
    nees = []
    for _ in range(60):
        tracker = Tracker()
        paths = [model_motion(start, random, STEPS, 0.05, 8.0, 2.0) for start in ([30.0, 13.0, 0.0, 0.0], [45.0, 11.0, 3.7, 0.0])]
        for near, far in zip(*paths, strict=True):
            bodies = [body_of(near.x, name="near"), body_of(far.x, name="far")]
            tracker.update([radar_scan(near.t, bodies, random=random)], host_at(near.t), STRAIGHT, near.t)
        tracks = tracker.tracks(near.t)
        assert len(tracks) == 2
        for track, truth in zip(sorted(tracks, key=lambda track: track.d_m), (near.x, far.x), strict=True):
            estimate = np.array([track.s_m, track.speed_s_mps, track.d_m, track.speed_d_mps])
            nees.append(squared(estimate - truth, track.covariance))
    low, high = chi2.ppf([0.025, 0.975], 4 * len(nees)) / len(nees)
    assert low <= np.mean(nees) <= high


@pytest.mark.parametrize(("believed", "consistent"), [(0.5, False), (8.0, True)])
def test_a_braking_target_needs_the_process_noise_of_braking(believed: float, consistent: bool) -> None:
    """At 8 m/s^2 a filter that expects 0.5 m/s^2 is sure of nonsense; one that expects 8 is not (design notes: pitfalls)."""
    random = np.random.default_rng(3)
    motion = type(MOTION)(name="believed", acceleration_along_mps2=believed, acceleration_across_mps2=2.0)
    place = mounting(Sector.FRONT, CAR)
    nees = []
    for _ in range(40):
        kf = ConstantVelocityFilter(np.array([40.0, 20.0, 0.0, 0.0]), np.diag([0.1, 0.1, 0.1, 0.1]), 0.0, motion)
        for k in range(1, 31):
            t = 0.05 * k
            x = np.array([40.0 + 20.0 * t - 4.0 * t**2, 20.0 - 8.0 * t, 0.0, 0.0])
            host = host_at(t)
            scan = radar_scan(t, [body_of(x)], random=random)
            frame = frame_near(STRAIGHT, host.s_m)
            (fix,) = radar_fixes(scan.radar, Viewpoint.of(place, host, CAR, frame), frame, (4.5, 1.8))
            kf.correct(t, *fix.read(kf.at(t)))
        nees.append(squared((kf.state - x)[:2], kf.covariance[:2, :2]))
    assert bool(np.mean(nees) < 4.0) is consistent  # 2 expected
    assert bool(np.mean(nees) > 50.0) is not consistent


def test_esr_noise_is_small_enough_not_to_debias() -> None:
    """Lerro and Bar-Shalom's criterion R sd^2 / sd_R < 0.4 holds over the whole range."""
    assert ESR.range_max_m * ESR.azimuth_sd_rad**2 / ESR.range_sd_m < 0.4
    assert ESR.range_max_m * (1.0 - math.exp(-0.5 * ESR.azimuth_sd_rad**2)) < 0.01
