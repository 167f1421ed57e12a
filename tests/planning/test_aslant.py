"""Who stands or creeps turned by a few degrees does not straighten there: a lorry across the line is no lorry in its lane."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import Polygon, affinity, box

from mcdas_opt import Planner
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.track import ALIGNED_RAD, Track
from mcdas_opt.domain.variant import Variant
from mcdas_opt.tracking.prediction import predict

CYCLE_S = 0.1
STATE = ("s_m", "d_m", "heading_rad", "speed_mps", "acceleration_mps2", "steering_rad")


def rectangle(s_m: float, d_m: float, heading_rad: float, length_m: float, width_m: float) -> Polygon:
    half = 0.5 * length_m, 0.5 * width_m
    turned = affinity.rotate(box(-half[0], -half[1], *half), heading_rad, origin=(0.0, 0.0), use_radians=True)
    return affinity.translate(turned, s_m, d_m)


def aslant(heading_rad: float, length_m: float = 12.0, speed_mps: float = 0.0, s_m: float = 45.0, d_m: float = 3.3) -> Track:
    return Track(
        id="lorry",
        s_m=s_m,
        d_m=d_m,
        speed_s_mps=speed_mps * math.cos(heading_rad),
        speed_d_mps=speed_mps * math.sin(heading_rad),
        length_m=length_m,
        width_m=2.5,
        heading_rad=heading_rad,
        age_s=5.0,
    )


@settings(max_examples=15, deadline=None)
@given(
    heading_rad=st.floats(0.4 * ALIGNED_RAD, 1.1 * ALIGNED_RAD),
    to_left=st.booleans(),
    backwards=st.booleans(),
    length_m=st.floats(9.0, 16.0),
    d_m=st.floats(2.6, 3.5),
    creeps_mps=st.sampled_from([0.0, 0.5, 1.2]),
    speed_mps=st.floats(5.0, 12.0),
)
def test_nobody_is_driven_into_who_stands_or_creeps_aslant(
    heading_rad: float, to_left: bool, backwards: bool, length_m: float, d_m: float, creeps_mps: float, speed_mps: float
) -> None:
    heading = (heading_rad if to_left else -heading_rad) + (math.pi if backwards else 0.0)
    first = aslant(heading, length_m, creeps_mps, d_m=d_m)
    planner, host = Planner(), HostState(s_m=0.0, d_m=0.0, speed_mps=speed_mps)
    car = planner.vehicle
    for k in range(60):
        now = first.later(k * CYCLE_S)
        situation = Situation(
            time_s=k * CYCLE_S,
            host=host,
            tracks=(now,),
            road=Road(lane_width_m=3.5, lanes_left=1),
            coverage=Coverage(),
            desired_speed_mps=speed_mps,
        )
        driven = planner.plan(situation).trajectory
        host = HostState(**{name: float(np.interp(CYCLE_S, driven.t_s, getattr(driven, name))) for name in STATE})
        own = rectangle(host.s_m, host.d_m, host.heading_rad, car.length_m, car.width_m)
        assert own.distance(rectangle(now.s_m, now.d_m, heading, length_m, 2.5)) > 0.0


@pytest.mark.parametrize("sign", [-1, 1])
def test_a_body_is_as_wide_as_it_is_turned_where_it_does_not_straighten(sign: int) -> None:
    turned = aslant(sign * math.radians(15.0))
    shape = rectangle(0.0, 0.0, sign * math.radians(15.0), 12.0, 2.5)
    left, bottom, right, top = shape.bounds
    assert (turned.along_m, turned.across_m) == pytest.approx((right - left, top - bottom))
    assert turned.follows_road
    names = [body.id for body in predict((turned,)).bodies]
    assert names == [Variant.STRAIGHT_ON.of("lorry"), "lorry"]


@pytest.mark.parametrize(
    "track", [aslant(math.radians(15.0), speed_mps=5.0), aslant(math.radians(1.0)), replace(aslant(0.3), heading_rad=None)]
)
def test_who_drives_or_is_hardly_turned_counts_as_along_the_road(track: Track) -> None:
    assert (track.along_m, track.across_m) == (12.0, 2.5)
    assert not track.lies_aslant
    assert Variant.STRAIGHT_ON.of("lorry") not in [body.id for body in predict((track,)).bodies]
