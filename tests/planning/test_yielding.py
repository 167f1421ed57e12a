"""Who walks or drives across the host's way is let through, gently, and not passed by a hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vocabulary import BodyKind, Status
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.planner import Planner
from mcdas_opt.planning.proposals.yielding import yielding

CAR = load_vehicle("sedan")
SPEED_MPS, CYCLE_S = 13.9, 0.1


def walking(s_m: float, d_m: float = -5.0, speed_mps: float = 1.4, kind: BodyKind = BodyKind.PEDESTRIAN, size_m: float = 0.5) -> Track:
    heading = math.copysign(math.pi / 2, -d_m)
    across = math.copysign(speed_mps, -d_m)
    sizes = {"length_m": size_m, "width_m": min(size_m, 1.8)}
    return Track(id="ped", s_m=s_m, d_m=d_m, speed_s_mps=0.0, speed_d_mps=across, heading_rad=heading, kind=kind, **sizes)


def situation(*tracks: Track, host: HostState | None = None, time_s: float = 0.0) -> Situation:
    return Situation(
        time_s=time_s,
        host=host or HostState(speed_mps=SPEED_MPS),
        tracks=tracks,
        coverage=Coverage(),
        road=Road(speed_limit_mps=SPEED_MPS),
        desired_speed_mps=SPEED_MPS,
    )


def drive(track: Track, lasts_s: float = 10.0) -> tuple[list[Plan], float, Track]:
    """The plans, how near the bodies come, and where he is at the end."""
    planner, host, nearest = Planner(), HostState(speed_mps=SPEED_MPS), math.inf
    plans = []
    for k in range(round(lasts_s / CYCLE_S)):
        plans.append(planner.plan(situation(track, host=host, time_s=round(k * CYCLE_S, 6))))
        host, track = HostState.from_vector(plans[-1].trajectory.states[1]), track.later(CYCLE_S)
        along = abs(track.s_m - host.s_m) - 0.5 * (CAR.length_m + track.along_m)
        aside = abs(track.d_m - host.d_m) - 0.5 * (CAR.width_m + track.across_m)
        nearest = min(nearest, max(along, aside))
    return plans, nearest, track


@pytest.mark.parametrize("s_m", [30.0, 33.0, 35.0, 37.0, 40.0, 43.0, 45.0, 50.0, 60.0])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_who_walks_into_the_lane_is_let_through(s_m: float, side: float) -> None:
    """At 35 m he was passed by 7 cm with nothing threatening, at 40 m at 20 m/s, and at 60 m the car braked by 7 m/s^2."""
    plans, nearest_m, track = drive(walking(s_m, side * 5.0))
    assert {plan.status for plan in plans} == {Status.PLANNED}
    assert nearest_m > 1.5
    assert max(plan.trajectory.speed_mps.max() for plan in plans) < SPEED_MPS + 0.5
    assert min(plan.trajectory.acceleration_mps2[1] for plan in plans) > -5.5  # comfortable below 5 m/s
    assert track.d_m * side < -1.0  # he is across
    assert plans[-1].trajectory.speed_mps[0] > 10.0  # and the host goes on
    assert any(plan.reason.startswith("ped crosses and is let through") for plan in plans)


@pytest.mark.parametrize("comes_s", [1.5, 2.0, 2.5, 2.75, 3.0, 3.125, 3.25, 3.5])
def test_who_drives_across_goes_first_where_the_plan_says_so(comes_s: float) -> None:
    """At 3 s the first plan is to pass ahead of him; those that said that he is let through went on with it, at 16 m/s, 0.6 m from him."""
    plans, nearest_m, _ = drive(walking(45.0, -4.0 - 8.0 * comes_s, 8.0, BodyKind.CAR, 4.5), 7.0)
    assert {plan.status for plan in plans} == {Status.PLANNED}
    assert any("ped crosses and is let through" in plan.reason for plan in plans)
    assert nearest_m > 1.2
    assert max(plan.situation.host.speed_mps for plan in plans) < SPEED_MPS + 0.5
    he_is_past = next(k for k, plan in enumerate(plans) if plan.situation.track("ped").d_m > 1.75 + 2.25)
    assert plans[he_is_past].situation.host.s_m < 45.0


@pytest.mark.parametrize(
    "track",
    [
        walking(15.0),  # the host is past long before
        walking(100.0, -3.0),  # he is
        walking(40.0, speed_mps=0.0),  # stands
        walking(12.0, -2.5),  # too late to stop in comfort
        replace(walking(40.0), turn_rate_radps=0.3, turn_rate_sd_radps=0.05),  # turns off
        replace(walking(40.0), speed_d_mps=-1.4),  # walks away
    ],
)
def test_who_need_not_or_cannot_be_let_through(track: Track) -> None:
    assert not yielding(Cycle.of(situation(track), CAR), 0.0)


def test_the_later_he_has_gone_the_slower_the_host_comes() -> None:
    ends = []
    for speed_mps in (2.5, 2.2, 1.9, 1.6):
        (one,) = yielding(Cycle.of(situation(walking(45.0, speed_mps=speed_mps)), CAR), 0.0)
        assert (np.diff(one.speeds_mps[np.isfinite(one.speeds_mps)]) <= 0.0).all()
        ends.append(float(one.speeds_mps[np.isfinite(one.speeds_mps)].min()))
    assert ends == sorted(ends, reverse=True)


def pulling_away(s_m: float, t_s: float, *, is_known: bool) -> Track:
    """A car that stands beside the road, 6 m from the lane's middle, and after a second drives into it: by 2.2 m/s^2, up to 6 m/s."""
    for_s = max(t_s - 1.0, 0.0)
    speeding_s = min(for_s, 6.0 / 2.2)
    d_m = 6.0 - 0.5 * 2.2 * speeding_s**2 - 6.0 * (for_s - speeding_s)
    sds = {"acceleration_s_sd_mps2": 0.4, "acceleration_d_sd_mps2": 0.4} if is_known else {}
    speed_mps, rate_mps2 = 2.2 * speeding_s, 2.2 if 0.3 <= for_s < 6.0 / 2.2 else 0.0  # it takes a filter so long to know it
    return Track(
        id="car",
        s_m=s_m,
        d_m=d_m,
        speed_s_mps=0.0,
        speed_d_mps=-speed_mps,
        heading_rad=-0.5 * math.pi,
        acceleration_d_mps2=-rate_mps2,
        **sds,
    )


@pytest.mark.parametrize("s_m", [36.0, 38.0, 40.0, 42.0, 45.0])
def test_who_pulls_away_into_the_way_is_seen_to(s_m: float) -> None:
    """At constant speed he would come too late to be in the way: at 38, 40 and 42 m he was run into."""
    found = {}
    for is_known in (True, False):
        planner, host, nearest = Planner(), HostState(speed_mps=SPEED_MPS), math.inf
        for k in range(50):
            time_s = round(k * CYCLE_S, 6)
            plan = planner.plan(situation(pulling_away(s_m, time_s, is_known=is_known), host=host, time_s=time_s))
            host, track = HostState.from_vector(plan.trajectory.states[1]), pulling_away(s_m, time_s + CYCLE_S, is_known=is_known)
            along = abs(track.s_m - host.s_m) - 0.5 * (CAR.length_m + track.along_m)
            aside = abs(track.d_m - host.d_m) - 0.5 * (CAR.width_m + track.across_m)
            nearest = min(nearest, max(along, aside))
        found[is_known] = nearest
    assert found[True] > 0.1
    assert found[False] < 0.0 or s_m in (36.0, 45.0)
