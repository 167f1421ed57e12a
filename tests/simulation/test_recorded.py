"""Recorded neighbours: who comes towards the host or across its road moves, and is seen to move, as the samples say."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.simulation.neighbours import body_at
from mcdas_opt.simulation.recorded import RecordedMotion
from mcdas_opt.simulation.sensors import ideal_detections

STRAIGHT = Road()
CORNER = Road(curvature=((0.0, 0.0), (20.0, 0.0), (25.0, 0.12), (38.0, 0.12), (43.0, 0.0)))  # nearly a right angle to the left


def line(road: Road, x: float, y: float, yaw: float, speed: float, count: int = 31) -> np.ndarray:
    """Samples of a straight drive in the plane, 0.1 s apart."""
    t = 0.1 * np.arange(count)
    s, d, psi = FrenetFrame(road=road).to_road(x + speed * t * math.cos(yaw), y + speed * t * math.sin(yaw), np.full(count, yaw))
    return np.column_stack([t, s, d, psi, np.full(count, speed)])


@given(st.floats(-math.pi, math.pi), st.floats(0.5, 20.0))
def test_a_body_is_seen_to_move_as_it_moves(heading: float, speed: float) -> None:
    motion = RecordedMotion(samples=line(STRAIGHT, 30.0, 8.0, heading, speed), road=STRAIGHT)
    body = body_at("other", motion(np.array(0.5)), 4.5, 1.8, STRAIGHT)
    assert body.speed_mps == pytest.approx(speed)
    (seen,) = ideal_detections(Sector.LEFT, HostState(s_m=float(motion(np.array(0.5)).s_m), d_m=-30.0), [body], Vehicle())
    later = motion(np.array(0.6))
    assert seen.speed_s_mps * 0.1 == pytest.approx(float(later.s_m) - body.s_m, abs=1e-6)
    assert seen.speed_d_mps * 0.1 == pytest.approx(float(later.d_m) - body.d_m, abs=1e-6)


def test_across_a_bend_the_place_in_the_plane_does_not_jump() -> None:
    """Through the inside of a right angle: nearest to the road before it, then to the road after it, and never in between."""
    frame = FrenetFrame(road=CORNER)
    motion = RecordedMotion(samples=line(CORNER, 12.0, 12.0, math.pi / 4.0, 10.0), road=CORNER)
    t = np.linspace(0.0, 3.0, 301)
    at = motion(t)
    x, y, yaw = frame.to_plane(at.s_m, at.d_m, at.heading_rad)
    np.testing.assert_allclose(np.hypot(np.diff(x), np.diff(y)), 10.0 * np.diff(t), atol=1e-6)
    np.testing.assert_allclose(np.cos(yaw - math.pi / 4.0), 1.0, atol=1e-9)
    assert np.abs(np.diff(at.s_m)).max() > 1.0


@given(st.sampled_from([0.0, math.pi]), st.floats(1.0, 20.0))
def test_after_its_last_sample_a_body_goes_on_in_its_direction(heading: float, speed: float) -> None:
    motion = RecordedMotion(samples=line(STRAIGHT, 30.0, 3.0, heading, speed), road=STRAIGHT)
    before, after = motion(np.array(2.9)), motion(np.array(4.0))
    assert float(after.s_m - before.s_m) == pytest.approx(1.1 * speed * math.cos(heading))
    assert float(after.d_m) == pytest.approx(3.0, abs=1e-6)


def test_who_crosses_goes_on_across_after_its_last_sample() -> None:
    motion = RecordedMotion(samples=line(STRAIGHT, 30.0, -8.0, math.pi / 2.0, 4.0), road=STRAIGHT)
    after = motion(np.array(4.0))
    assert (float(after.s_m), float(after.d_m)) == pytest.approx((30.0, 8.0))
