"""Who crosses the road, or turns off it, and clearly slows down, is predicted to go on slowing down for a second."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import FreeBody
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.domain.vocabulary import BodyKind, Status
from mcdas_opt.planning.planner import Planner
from mcdas_opt.tracking.prediction import predict

STREET = Road(lanes_left=1, speed_limit_mps=14.0)
SD_MPS2 = 0.3


def slowing(heading_rad: float, speed_mps: float, rate_mps2: float, sd_mps2: float | None = SD_MPS2, **other: object) -> Track:
    """Somebody who drives where he is turned to, and brakes by so much."""
    c, s = math.cos(heading_rad), math.sin(heading_rad)
    at = Track(id="x", s_m=40.0, d_m=-8.0, speed_s_mps=c * speed_mps, speed_d_mps=s * speed_mps, heading_rad=heading_rad)
    rates = {"acceleration_s_mps2": -c * rate_mps2, "acceleration_d_mps2": -s * rate_mps2}
    return replace(at, acceleration_s_sd_mps2=sd_mps2, acceleration_d_sd_mps2=sd_mps2, **rates, **other)


def gone_m(track: Track, after_s: float) -> float:
    """How far he is predicted to come."""
    (body,) = (body for body in predict([track], road=STREET).bodies if body.id == track.id)
    assert isinstance(body, FreeBody)
    at = body.at(after_s)
    return math.hypot(float(at.s_m) - track.s_m, float(at.d_m) - track.d_m)


@given(st.floats(0.5, 2.6), st.booleans(), st.floats(1.0, 12.0), st.floats(1.1, 7.0), st.floats(0.2, 4.0))
def test_he_slows_down_for_a_second_or_until_he_stands(heading: float, mirrored: bool, speed: float, rate: float, after_s: float) -> None:
    """At constant speed who stops in the lane would be past it, and who gives way would be in the way."""
    lasts_s = min(1.0, speed / rate)
    braked_s = min(after_s, lasts_s)
    expected = speed * after_s - rate * braked_s * (after_s - 0.5 * braked_s)
    assert gone_m(slowing(-heading if mirrored else heading, speed, rate), after_s) == pytest.approx(expected, abs=0.02 + 0.005 * rate)


@pytest.mark.parametrize(
    "steady",
    [
        slowing(1.5, 6.0, 0.9),
        slowing(1.5, 6.0, 3.0, sd_mps2=1.6),
        slowing(1.5, 6.0, 3.0, sd_mps2=None),
        slowing(1.5, 6.0, 3.0, kind=BodyKind.PEDESTRIAN, length_m=0.5, width_m=0.5),
        slowing(1.5, 6.0, -3.0),
        slowing(1.5, -6.0, 3.0),  # who reverses, ever faster
    ],
)
def test_who_does_not_clearly_slow_down_keeps_his_speed(steady: Track) -> None:
    assert gone_m(steady, 2.0) == pytest.approx(12.0, abs=1e-6)


def turning_left(t_s: float, speed_mps: float, rate_mps2: float) -> Track:
    """He comes towards the host, begins to turn across its way, on a circle of 25 m, and lets it through: braking to a standstill."""
    braked_s = min(t_s, speed_mps / rate_mps2)
    turned = (speed_mps * braked_s - 0.5 * rate_mps2 * braked_s**2) / 25.0
    arc = [(55.0 - 25.0 * math.sin(u), 3.5 - 25.0 * (1.0 - math.cos(u))) for u in (turned, *np.linspace(-0.4, 1.5, 40))]
    (s_m, d_m), heading = arc[0], turned - math.pi
    c, s, speed, rate = math.cos(heading), math.sin(heading), speed_mps - rate_mps2 * braked_s, rate_mps2 if braked_s == t_s else 0.0
    at = Track(id="x", s_m=s_m, d_m=d_m, speed_s_mps=c * speed, speed_d_mps=s * speed, heading_rad=heading)
    known = {"acceleration_s_sd_mps2": SD_MPS2, "acceleration_d_sd_mps2": SD_MPS2, "lane_path_m": tuple(arc[1:])}
    return replace(at, acceleration_s_mps2=-c * rate, acceleration_d_mps2=-s * rate, **known)


@pytest.mark.parametrize(("speed_mps", "rate_mps2"), [(7.0, 4.5), (6.0, 3.5), (8.0, 6.0), (5.0, 2.5)])
def test_the_host_does_not_brake_hard_for_who_gives_way(speed_mps: float, rate_mps2: float) -> None:
    """At his speed of each moment, ever lower, he was to be met in the middle of the host's lane."""
    planner, host, strongest = Planner(), HostState(speed_mps=13.9), 0.0
    for k in range(50):
        time_s = round(0.1 * k, 6)
        tracks = (turning_left(time_s, speed_mps, rate_mps2),)
        plan = planner.plan(Situation(time_s=time_s, host=host, tracks=tracks, coverage=Coverage(), road=STREET, desired_speed_mps=13.9))
        assert plan.status is Status.PLANNED
        at = plan.trajectory
        host = HostState.from_vector(np.array([np.interp(0.1, at.t_s, row) for row in at.states.T]))
        strongest = min(strongest, host.acceleration_mps2)
    assert strongest > -3.0
    assert host.s_m > 50.0
