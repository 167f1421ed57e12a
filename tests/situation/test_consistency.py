"""What cannot be believed is said; what merely goes wrong between others is not called unbelievable."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.situation.consistency import contradiction

CAR = Vehicle()
KNOWN = np.diag([0.01, 0.04, 0.01, 0.04])


def car(name: str, s: float, speed: float, d: float = 0.0) -> Track:
    return Track(id=name, s_m=s, d_m=d, speed_s_mps=speed, covariance=KNOWN)


def seen(time_s: float, *tracks: Track) -> Situation:
    return Situation(time_s=time_s, host=HostState(speed_mps=15.0, d_m=-3.7), tracks=tracks, road=Road(lanes_right=1))


def after(situation: Situation, seconds: float) -> Situation:
    """Everybody, but the host, at the same speed."""
    moved = tuple(replace(track, s_m=track.s_m + track.speed_s_mps * seconds) for track in situation.tracks)
    return replace(situation, time_s=situation.time_s + seconds, tracks=moved)


@given(front=st.floats(0.0, 20.0), faster=st.floats(2.5, 25.0), depth=st.floats(0.6, 4.4))
def test_two_that_run_into_one_another_are_no_contradiction(front: float, faster: float, depth: float) -> None:
    """Whatever they overlap by; both were known a moment ago and have come here as they were going."""
    now = seen(5.0, car("rear", 20.0 - 4.5 + depth, front + faster), car("front", 20.0, front))
    before = after(now, -0.1)
    assert contradiction(now, before, CAR) == ""


@given(front=st.floats(0.0, 20.0), faster=st.floats(-25.0, 25.0), depth=st.floats(1.2, 4.4))
def test_one_that_is_new_in_anothers_place_is(front: float, faster: float, depth: float) -> None:
    """Nobody appears inside somebody; nor do two stay there that drive as one."""
    now = seen(5.0, car("1", 20.0 - 4.5 + depth, front + faster), car("2", 20.0, front))
    words = "tracks 1 and 2 are in one place"
    assert contradiction(now, None, CAR) == words
    assert contradiction(now, replace(after(now, -0.1), tracks=after(now, -0.1).tracks[:1]), CAR) == words
    assert contradiction(now, after(now, -1.5), CAR) == words  # too old to tell
    together = seen(5.0, car("1", 20.0 - 4.5 + depth, front + 0.4), car("2", 20.0, front))
    assert contradiction(together, after(together, -0.1), CAR) == words


@given(jump=st.floats(5.0, 40.0), faster=st.floats(4.0, 25.0))
def test_a_jump_into_one_another_is_still_a_jump(jump: float, faster: float) -> None:
    now = seen(5.0, car("rear", 17.0, 5.0 + faster), car("front", 20.0, 5.0))
    before = after(now, -0.1)
    rear, front = before.tracks
    before = replace(before, tracks=(replace(rear, s_m=rear.s_m - jump), front))
    assert "track rear jumped" in contradiction(now, before, CAR)


def test_nobody_is_where_the_host_is_however_he_came_there() -> None:
    now = seen(5.0, car("rear", -2.0, 25.0, d=-3.7))
    assert contradiction(now, after(now, -0.1), CAR) == "track rear is where the host is"
