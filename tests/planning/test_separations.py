"""Drives from bodies: the compiled separations are those of the array operations, to the bit."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.geometry.rectangle import corners, separation
from mcdas_opt.native.form import SWITCH
from mcdas_opt.planning.candidates.nearness import nearness
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.traffic.separations import Rectangles, separations

HALF = (2.25, 0.9)
numbers = st.integers(0, 2**32 - 1)


Poses = tuple[np.ndarray, np.ndarray, np.ndarray]


def poses(rng: np.random.Generator, count: int, n: int) -> Poses:
    return rng.normal(0.0, 8.0, (count, n)), rng.normal(0.0, 2.0, (count, n)), rng.normal(0.0, 0.5, (count, n))


def both(mine: Poses, others: Poses, halves: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    own, their = Rectangles.of(*mine, np.array([HALF])), Rectangles.of(*others, halves)
    compiled = separations(own, their)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(SWITCH, "0")
        return compiled, separations(own, their)


@settings(deadline=None)
@given(numbers, st.integers(1, 4), st.integers(0, 5), st.integers(1, 45))
def test_both_forms_give_the_same_bits(seed: int, count: int, many: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    halves = rng.uniform(0.3, 6.0, (many, 2))
    compiled, arrays = both(poses(rng, count, n), poses(rng, many, n), halves)
    assert compiled.shape == (count, many, n)
    assert compiled.tobytes() == np.ascontiguousarray(arrays).tobytes()


@given(numbers)
@settings(deadline=None, max_examples=30)
def test_what_is_no_number_stays_none_and_touches_nothing_else(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mine, others, halves = poses(rng, 2, 12), poses(rng, 3, 12), rng.uniform(0.3, 6.0, (3, 2))
    whole = both(mine, others, halves)[0]
    which, when = int(rng.integers(3)), int(rng.integers(12))
    mine[which][1, when] = np.nan
    compiled, arrays = both(mine, others, halves)
    np.testing.assert_array_equal(compiled, arrays)
    assert np.isnan(compiled[1, :, when]).all()
    compiled[1, :, when] = whole[1, :, when]
    assert compiled.tobytes() == whole.tobytes()


def test_they_are_the_separations_of_the_corners() -> None:
    rng = np.random.default_rng(3)
    mine, others, halves = poses(rng, 3, 41), poses(rng, 4, 41), rng.uniform(0.3, 6.0, (4, 2))
    one = corners(*mine, 2.0 * HALF[0], 2.0 * HALF[1])[:, None]
    other = corners(*others, 2.0 * halves[:, :1], 2.0 * halves[:, 1:])
    np.testing.assert_allclose(both(mine, others, halves)[0], separation(one, other), atol=1e-12)


def test_a_drive_that_seems_to_fly_off_near_a_bends_centre_is_measured_where_the_road_is_known() -> None:
    road = Road(lane_width_m=3.0, curvature=((0.0, 0.0), (20.0, 0.18), (40.0, 0.0)))
    cycle = Cycle.of(
        Situation(
            host=HostState(speed_mps=5.0), tracks=(Track(id="a", s_m=12.0, d_m=0.0, speed_s_mps=0.0),), road=road, coverage=Coverage()
        ),
        Vehicle(),
    )
    states = np.zeros((11, 6))
    states[:, 0], states[:, 3] = np.linspace(0.0, 5000.0, 11), 5.0
    far = Trajectory.from_states(0.1 * np.arange(11), states, np.zeros((10, 2)))
    near = nearness([far], cycle)
    assert np.isfinite(near.separation_m).all()
    assert near.separation_m[0, 0, -1] > 100.0
