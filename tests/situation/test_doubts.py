"""What cannot all be true is said and planned around; what merely goes wrong between others is not doubted."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse.csgraph import connected_components

from mcdas_opt.domain.doubt import Doubt, DoubtKind, SupposedTrack
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import MOST_TRACKS, Coverage, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.geometry.window import frame_near
from mcdas_opt.situation import doubts
from mcdas_opt.situation.doubts import Believed, believed

CAR = Vehicle()
KNOWN = np.diag([0.01, 0.04, 0.01, 0.04])


def car(name: str, s: float, speed: float, d: float = 0.0) -> Track:
    return Track(id=name, s_m=s, d_m=d, speed_s_mps=speed, covariance=KNOWN)


def seen(time_s: float, *tracks: Track) -> Situation:
    return Situation(time_s=time_s, host=HostState(speed_mps=15.0, d_m=-3.7), tracks=tracks, road=Road(lanes_right=1), coverage=Coverage())


def after(situation: Situation, seconds: float) -> Situation:
    """Everybody, but the host, at the same speed."""
    moved = tuple(replace(track, s_m=track.s_m + track.speed_s_mps * seconds) for track in situation.tracks)
    return replace(situation, time_s=situation.time_s + seconds, tracks=moved)


def what(now: Situation, before: Situation | None = None, supposed: Sequence[SupposedTrack] = ()) -> Believed:
    return believed(now, before.tracks if before else (), now.time_s - before.time_s if before else 0.0, supposed, CAR)


def kinds(doubts: Sequence[Doubt]) -> list[tuple[DoubtKind, tuple[str, ...]]]:
    return [(doubt.kind, doubt.tracks) for doubt in doubts]


@given(front=st.floats(0.0, 20.0), faster=st.floats(2.5, 25.0), depth=st.floats(0.6, 4.4))
def test_two_that_run_into_one_another_are_not_doubted(front: float, faster: float, depth: float) -> None:
    """Whatever they overlap by; both were known a moment ago and have come here as they were going."""
    now = seen(5.0, car("rear", 20.0 - 4.5 + depth, front + faster), car("front", 20.0, front))
    found = what(now, after(now, -0.1))
    assert found.doubts == ()
    assert found.situation is now


@given(front=st.floats(0.0, 20.0), faster=st.floats(-25.0, 25.0), depth=st.floats(1.2, 4.4))
def test_one_that_is_new_in_anothers_place_is_doubted_and_both_stay(front: float, faster: float, depth: float) -> None:
    """Nobody appears inside somebody; nor do two stay there that drive as one."""
    now = seen(5.0, car("1", 20.0 - 4.5 + depth, front + faster), car("2", 20.0, front))
    before = after(now, -0.1)
    for earlier in (None, replace(before, tracks=before.tracks[:1]), after(now, -1.5)):  # the last too old to tell
        found = what(now, earlier)
        assert kinds(found.doubts) == [(DoubtKind.ONE_PLACE, ("1", "2"))]
        assert found.situation is now
    together = seen(5.0, car("1", 20.0 - 4.5 + depth, front + 0.4), car("2", 20.0, front))
    assert kinds(what(together, after(together, -0.1)).doubts) == [(DoubtKind.ONE_PLACE, ("1", "2"))]


def test_a_lorry_as_four_reflections_is_one_doubt() -> None:
    found = what(seen(0.0, *(car(str(k), 30.0 + 3.5 * k, 20.0) for k in range(4)), car("far", 90.0, 20.0)))
    assert kinds(found.doubts) == [(DoubtKind.ONE_PLACE, ("0", "1", "2", "3"))]
    assert len(found.situation.tracks) == 5


@given(jump=st.floats(5.0, 40.0))
def test_who_jumps_is_where_it_is_and_for_a_while_where_it_was_going(jump: float) -> None:
    now = seen(5.0, car("a", 60.0, 10.0))
    before = replace(after(now, -0.1), tracks=(car("a", 59.0 - jump, 10.0),))
    found = what(now, before)
    assert kinds(found.doubts) == [(DoubtKind.JUMPED, ("a",))]
    assert [track.s_m for track in found.situation.tracks] == pytest.approx([60.0, 60.0 - jump])
    then, supposed, count = now, found.supposed, 0
    while supposed:
        later = after(then, 0.1)
        again = what(later, then, supposed)
        assert again.doubts == ()
        then, supposed, count = later, again.supposed, count + 1
    assert count == 5


@given(gap=st.floats(8.0, 60.0), faster=st.floats(-6.0, 6.0))
def test_swapped_ids_are_the_same_cars(gap: float, faster: float) -> None:
    before = seen(5.0, car("a", 20.0, 10.0), car("b", 20.0 + gap, 10.0 + faster))
    one, two = after(before, 0.1).tracks
    now = replace(after(before, 0.1), tracks=(replace(one, id="b"), replace(two, id="a")))
    found = what(now, before)
    assert kinds(found.doubts) == [(DoubtKind.IDS_SWAPPED, ("b", "a"))]  # from behind to ahead
    assert found.supposed == ()
    assert found.situation is now


def test_a_jump_of_speed_leaves_both_speeds() -> None:
    now = seen(5.0, car("a", 60.0, 10.0))
    found = what(now, replace(after(now, -0.1), tracks=(car("a", 58.0, 30.0),)))
    assert kinds(found.doubts) == [(DoubtKind.SPEED_JUMPED, ("a",))]
    assert sorted(track.speed_s_mps for track in found.situation.tracks) == [10.0, 30.0]


def test_nobody_is_faster_than_a_car() -> None:
    now = seen(5.0, car("a", 60.0, 900.0))
    (track,) = what(now).situation.tracks
    assert (track.speed_s_mps, track.s_m) == (100.0, 60.0)
    found = what(now, replace(after(now, -0.1), tracks=(car("a", 58.5, 12.0),)))
    assert kinds(found.doubts) == [(DoubtKind.TOO_FAST, ("a",))]
    assert [track.speed_s_mps for track in found.situation.tracks] == [12.0]


def test_of_equal_tracks_the_one_that_was_known_stays() -> None:
    one = car("z", 40.0, 10.0)
    now = seen(5.0, replace(one, id="a"), one)
    assert [track.id for track in what(now).situation.tracks] == ["a"]
    assert [track.id for track in what(now, after(seen(5.0, one), -0.1)).situation.tracks] == ["z"]
    assert kinds(what(now).doubts) == [(DoubtKind.DUPLICATE, ("a", "z"))]


@given(
    s=st.floats(-4.4, 4.4), d=st.floats(-1.7, 1.7), speed=st.floats(0.0, 40.0), across=st.floats(-2.0, 2.0), sd=st.floats(0.0, 1.0),
    heading=st.floats(-0.3, 0.3),
)  # fmt: skip
def test_who_is_within_the_host_is_beside_it(s: float, d: float, speed: float, across: float, sd: float, heading: float) -> None:
    """No body overlaps the host's; the other direction is as it was; whoever is deep in the host closes in no more."""
    host = HostState(speed_mps=15.0, d_m=-3.7, heading_rad=heading)
    track = Track(id="in", s_m=s, d_m=d - 3.7, speed_s_mps=speed, speed_d_mps=across, covariance=np.diag([sd, 0.1, sd, 0.1]) ** 2)
    found = what(replace(seen(0.0, track), host=host))
    (moved,) = found.situation.tracks
    assert kinds(found.doubts) == [(DoubtKind.WITHIN_HOST, ("in",))]
    assert (moved.s_m == s) is not (moved.d_m == d - 3.7)
    assert abs(moved.s_m) > 4.5 or abs(moved.d_m + 3.7) > 1.8
    if sd == 0.0 and abs(s) < 3.9 and abs(d) < 1.2:
        away = (moved.speed_s_mps - 15.0) * moved.s_m if moved.s_m != s else moved.speed_d_mps * (moved.d_m + 3.7)
        assert away >= 0.0


def test_mirrored_tracks_are_believed_mirrored() -> None:
    for s, d in ((0.3, 0.5), (-3.0, 0.0), (0.0, 0.0), (2.0, -1.6)):
        sides = [
            what(replace(seen(0.0, car("in", s, 14.0, sign * d)), host=HostState(speed_mps=15.0))).situation.tracks[0] for sign in (1, -1)
        ]
        assert (sides[0].s_m, sides[0].d_m) == (sides[1].s_m, -sides[1].d_m)


@pytest.mark.parametrize("ahead_m", [1e-9, 3e-257])
def test_the_side_of_who_is_where_the_host_is_does_not_hang_on_rounding(ahead_m: float) -> None:
    """A planner counts from a place of its own: what was ahead by 3e-257 m was behind for it and ahead for who judged the plan anew."""
    host, there = HostState(speed_mps=20.0), car("x", ahead_m, -15.0)
    at_all = believed(
        Situation(host=host, tracks=(replace(there, s_m=0.0),), coverage=Coverage()), (), 0.0, (), Vehicle()
    ).situation.tracks[0]
    by_a_hair = believed(Situation(host=host, tracks=(there,), coverage=Coverage()), (), 0.0, (), Vehicle()).situation.tracks[0]
    assert by_a_hair.s_m == pytest.approx(at_all.s_m, abs=1e-6)


@given(depth=st.floats(0.9, 4.0), closing=st.floats(2.0, 15.0), ahead=st.booleans(), aside=st.floats(-0.4, 0.4))
def test_who_has_come_nearer_into_the_host_is_a_shorter_car_that_still_closes_in(
    depth: float, closing: float, ahead: bool, aside: float
) -> None:
    """No ghost: what appears there closes in no more."""
    out = 1.0 if ahead else -1.0
    there = car("1", out * (4.5 - depth), 15.0 - out * closing, -3.7 + aside)
    now = seen(5.0, there)
    host_before_m = -15.0 * 0.1
    came = replace(there, s_m=there.s_m + (out * closing - 15.0) * 0.1)
    assert abs(came.s_m - host_before_m) > abs(there.s_m)
    (known,) = what(now, replace(now, time_s=4.9, tracks=(came,))).situation.tracks
    assert known.speed_s_mps == there.speed_s_mps
    assert out * known.s_m > 4.5
    assert known.d_m == there.d_m
    (new,) = what(now).situation.tracks
    assert new.d_m != there.d_m or new.speed_s_mps == 15.0


@given(depth=st.floats(0.05, 0.4), closing=st.floats(2.0, 15.0))
def test_who_overtakes_a_little_too_near_is_beside(depth: float, closing: float) -> None:
    there = car("1", -2.5, 15.0 + closing, -3.7 + 1.8 - depth)
    now = seen(5.0, there)
    (known,) = what(now, replace(now, time_s=4.9, tracks=(replace(there, s_m=there.s_m - (15.0 + closing) * 0.1),))).situation.tracks
    assert known.s_m == there.s_m
    assert known.d_m > there.d_m


@given(seed=st.integers(0, 2**32), count=st.integers(2, 40), wide=st.sampled_from((5.0, 40.0, 200.0)), known=st.booleans())
def test_who_are_in_one_place_are_those_whom_overlaps_link(seed: int, count: int, wide: float, known: bool) -> None:
    """scipy finds the same groups in the graph of pairs."""
    numbers = np.random.default_rng(seed)
    tracks = [car(str(k), *numbers.uniform((0.0, 0.0, -3.0), (wide, 30.0, 3.0))) for k in range(count)]
    now = replace(seen(5.0, *tracks), host=HostState(s_m=1e4, speed_mps=15.0))
    meet = np.zeros((count, count), dtype=bool)
    for i, one in enumerate(tracks):
        for j, other in enumerate(tracks):
            deep = min(4.5 - abs(one.s_m - other.s_m), 1.8 - abs(one.d_m - other.d_m)) - 3.0 * math.sqrt(0.02) >= 0.5
            meet[i, j] = i != j and deep and not (known and abs(one.speed_s_mps - other.speed_s_mps) > 2.0)
    _, group = connected_components(meet, directed=False)
    linked = {tuple(np.flatnonzero(group == k).astype(str)) for k in range(count) if (group == k).sum() > 1}
    found = what(now, after(now, -0.1) if known else None)
    assert {doubt.tracks for doubt in found.doubts if doubt.kind is DoubtKind.ONE_PLACE} == linked


def test_more_than_a_situation_holds_are_not_supposed() -> None:
    """As many as there may be jump away: the nearest of those who may still be where they were going would be one too many."""
    before = seen(0.0, *(car(str(k), 30.0 + 20.0 * k, 10.0) for k in range(MOST_TRACKS - 10)))
    now = replace(before, time_s=0.1, tracks=tuple(replace(track, d_m=300.0) for track in before.tracks))
    found = what(now, before)
    assert len(found.situation.tracks) == MOST_TRACKS
    assert sorted(float(one.track.s_m) for one in found.supposed) == pytest.approx([31.0 + 20.0 * k for k in range(10)])


@given(seed=st.integers(0, 2**32), elapsed_s=st.sampled_from((0.05, 0.1, 0.5)))
def test_who_is_found_in_arrays_is_the_first_without_an_error(seed: int, elapsed_s: float) -> None:
    numbers = np.random.default_rng(seed)
    places = numbers.uniform((0.0, 0.0, -6.0), (12.0, 30.0, 6.0), (7, 3))
    covariances = [np.diag(numbers.choice([0.0, 0.01, 0.5, 3.0], 4)) for _ in places]
    expected, *tracks = (replace(car(str(k), *row), covariance=covariances[k]) for k, row in enumerate(places))
    errors = [(doubts._place_error(track, expected), doubts._speed_error(track, expected, elapsed_s)) for track in tracks]
    first = next((k for k, error in enumerate(errors) if error == (None, None)), None)
    assert doubts._who_is(expected, doubts._rows(tracks), elapsed_s) == first


@given(st.integers(0, 10_000))
def test_who_goes_straight_on_past_a_tight_bend_has_not_jumped(seed: int) -> None:
    """Beside a bend places and speeds along the road change in no time, though the body goes straight on in the plane."""
    rng = np.random.default_rng(seed)
    road = Road(lane_width_m=3.2, curvature=((0.0, 0.0), (40.0, 0.0), (42.0, 1 / 9), (56.0, 1 / 9), (58.0, 0.0)))
    frame, (x, y, yaw, v) = frame_near(road, 0.0), rng.uniform([20.0, -40.0, -math.pi, 3.0], [80.0, 40.0, math.pi, 14.0])
    before: tuple[Track, ...] = ()
    for k in range(40):
        at = (np.array([x + 0.1 * k * v * math.cos(yaw)]), np.array([y + 0.1 * k * v * math.sin(yaw)]), np.array([yaw]))
        s, d, psi = (float(q[0]) for q in frame.to_road(*at))
        stretch = 1.0 - d * float(road.curvature_at(s))
        if stretch < 0.3:  # near a bend's centre nothing has a place along the road
            before = ()
            continue
        now = Track(
            id="1",
            s_m=s,
            d_m=d,
            speed_s_mps=v * math.cos(psi) / stretch,
            speed_d_mps=v * math.sin(psi),
            heading_rad=math.remainder(psi, math.tau),
        )
        situation = Situation(host=HostState(speed_mps=5.0), road=road, tracks=(now,), coverage=Coverage())
        assert not [one for one in believed(situation, before, 0.1, (), CAR).doubts if one.kind is DoubtKind.JUMPED]
        before = (now,)
