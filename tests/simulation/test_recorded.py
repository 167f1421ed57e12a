"""Recorded neighbours: who comes towards the host or across its road moves, and is seen to move, as the samples say."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.catalogue.scenes import load_scene
from mcdas_opt.domain.document import to_document
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.errors import InputError
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.neighbours import Traffic, body_at
from mcdas_opt.simulation.record import Outcome, Simulation
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


@given(st.sampled_from([STRAIGHT, CORNER]), st.floats(1.0, 20.0))
def test_who_leaves_is_nowhere_near_after_its_last_sample(road: Road, speed: float) -> None:
    samples = line(road, 5.0, 0.0, 0.0, speed)
    stays, leaves = RecordedMotion(samples=samples, road=road), RecordedMotion(samples=samples, road=road, leaves=True)
    during, after = np.linspace(-1.0, 3.0, 41), np.array([3.01, 20.0])
    assert to_document(stays(during)) == to_document(leaves(during))
    assert np.abs(leaves(after).d_m).min() > 1e3
    assert np.abs(leaves(after).speed_s_mps).max() == 0.0
    assert not leaves.is_gone(3.0)
    assert leaves.is_gone(3.01)
    assert not stays.is_gone(20.0)


def test_who_leaves_is_not_driven_into_and_not_seen(tmp_path: Path) -> None:
    """A car that stands in the lane, recorded for half a second: gone, or in the way for ever."""
    (tmp_path / "gone.csv").write_text("t_s,s_m,d_m,heading_rad,speed_mps\n0.0,18.0,0.0,0.0,0.0\n0.5,18.0,0.0,0.0,0.0\n", "utf-8")
    text = 'duration_s = 7.0\n[road]\n[host]\nspeed_mps = 5.0\n[[neighbour]]\nname = "gone"\ntrajectory = "gone.csv"\n'
    ends: dict[bool, Simulation] = {}
    for leaves in (False, True):
        file = tmp_path / f"{leaves}.toml"
        file.write_text(text + f"leaves = {str(leaves).lower()}\n", "utf-8")
        scene = load_scene(file)
        ends[leaves] = simulate(scene, "mpc")
        assert [body.name for body in Traffic(scene).bodies(0.6)] == ([] if leaves else ["gone"])
    assert float(ends[False].trajectory.s_m[-1]) < 15.0
    assert float(ends[True].trajectory.s_m[-1]) > 16.0
    assert ends[True].outcome is Outcome.SAFE
    assert not ends[True].cycles[-1].tracks
    before, after = ends[False].min_ttc_front_s, ends[True].min_ttc_front_s
    assert before is not None
    assert after == pytest.approx((18.0 - 4.5) / 5.0, abs=0.6)  # when it was last there


def test_only_who_is_recorded_can_leave(tmp_path: Path) -> None:
    file = tmp_path / "scene.toml"
    file.write_text("[road]\n[host]\nspeed_mps = 5.0\n[[neighbour]]\ns_m = 20.0\nspeed_mps = 5.0\nleaves = true\n", "utf-8")
    with pytest.raises(InputError, match="leaves needs a trajectory"):
        load_scene(file)
