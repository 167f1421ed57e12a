"""What ends a drive and how near the others came: the quick answers are the thorough one's."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.domain.prediction import BodyMotion
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.simulation.contact import EDGE_SLACK_M, clearances, is_free, surroundings

CAR, SIZES = Vehicle(), ((4.5, 1.8), (9.0, 2.5))
BENT = Road(lanes_left=1, lanes_right=1, curvature=((0.0, 0.0), (60.0, 0.02), (120.0, -0.01)))
STRAIGHT = Road(lanes_left=1, lanes_right=1, road_end_s_m=400.0)


def driven(seed: int, steps: int) -> tuple[Array, tuple[BodyMotion, ...]]:
    """A host and two neighbours that wander about, near one another."""
    random = np.random.default_rng(seed)
    t = 0.01 * np.arange(steps + 1)

    def wandering(s: float) -> BodyMotion:
        speed, d, turn = random.uniform(0.0, 40.0), random.uniform(-5.0, 5.0), random.uniform(-0.3, 0.3)
        return BodyMotion(
            s_m=s + speed * t, d_m=d + 2.0 * turn * t, heading_rad=np.full_like(t, turn), speed_s_mps=0.0 * t, speed_d_mps=0.0 * t
        )

    host = wandering(random.uniform(0.0, 380.0))
    states = np.column_stack([host.s_m, host.d_m, host.heading_rad, *np.zeros((3, len(t)))])
    return states, tuple(wandering(host.s_m[0] + random.uniform(-15.0, 15.0)) for _ in SIZES)


@given(seed=st.integers(0, 10_000), bent=st.booleans())
@settings(max_examples=60, deadline=None)
def test_who_is_free_touches_nobody_and_is_on_the_road(seed: int, bent: bool) -> None:
    states, others = driven(seed, 10)
    road = BENT if bent else STRAIGHT
    around = surroundings(states, others, SIZES, CAR, road)
    ends = bool(around.touching.any() or (around.beyond_edge_m > EDGE_SLACK_M).any())
    assert not (is_free(states, others, SIZES, CAR, road) and ends)


@given(seed=st.integers(0, 10_000), bent=st.booleans())
@settings(max_examples=60, deadline=None)
def test_who_touches_is_at_no_distance_and_nobody_else(seed: int, bent: bool) -> None:
    states, others = driven(seed, 40)
    road = BENT if bent else STRAIGHT
    touching = surroundings(states, others, SIZES, CAR, road).touching
    for i, other in enumerate(others):
        alone = clearances(states, [0], (other,), SIZES[i : i + 1], CAR, road)
        assert np.array_equal(touching[i], alone == 0.0)


def test_many_of_those_who_wander_touch() -> None:
    assert sum(bool(surroundings(*driven(seed, 40), SIZES, CAR, STRAIGHT).touching.any()) for seed in range(100)) > 10


def test_most_ordinary_turns_are_free_at_a_glance() -> None:
    found = [is_free(*driven(seed, 10), SIZES, CAR, STRAIGHT) for seed in range(200)]
    touching = [surroundings(*driven(seed, 10), SIZES, CAR, STRAIGHT) for seed in range(200)]
    sound = [not one.touching.any() and one.beyond_edge_m.max() <= 0.0 for one in touching]
    assert sum(found) > 0.6 * sum(sound) > 20


@given(seed=st.integers(0, 10_000), bent=st.booleans())
@settings(max_examples=30, deadline=None)
def test_clearances_of_a_drive_are_those_of_its_turns(seed: int, bent: bool) -> None:
    states, others = driven(seed, 60)
    road, turns = (BENT if bent else STRAIGHT), [0, 10, 20, 30, 40, 50]
    whole = clearances(states, turns, others, SIZES, CAR, road)
    for first in turns:
        part = slice(first, first + 11)
        cut = _cut(others, part)
        each = clearances(states[part], [0], cut, SIZES, CAR, road)
        begin = 0 if first == 0 else 1
        assert np.array_equal(whole[first + begin : first + 11], each[begin:])


def test_nobody_is_infinitely_far_away() -> None:
    states, _ = driven(3, 20)
    assert np.isinf(clearances(states, [0, 10], (), (), CAR, STRAIGHT)).all()


def _cut(others: tuple[BodyMotion, ...], part: slice) -> tuple[BodyMotion, ...]:
    return tuple(BodyMotion(**{key: getattr(other, key)[part] for key in BodyMotion.__slots__}) for other in others)
