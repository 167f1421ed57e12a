"""Hostile values and hostile traffic: whatever Python can hand over, and whatever a road, a car, a radar or a clock says at its worst."""

from __future__ import annotations

import contextlib
import dataclasses
import math
import random
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from hypothesis import strategies as st

from benchmarks.attack.records import HOST
from mcdas_opt import Coverage, HostState, Mounting, RadarDetection, Request, Road, Scan, Sector, Situation, Track
from mcdas_opt.domain.destination import Destination
from mcdas_opt.domain.lane import Lane
from mcdas_opt.domain.measurement import BodyDetection
from mcdas_opt.domain.sensor import Beam
from mcdas_opt.domain.situation import MOST_TRACKS
from mcdas_opt.domain.vocabulary import BodyKind, Side
from mcdas_opt.errors import McdasError

R = TypeVar("R")
EXTREMES = (0.0, -0.0, 5e-324, -5e-324, 1e-300, 1e-9, 0.1, 1.0, -1.0, 90.0, 400.0, 1e4, 1e6, 1e9, -1e9, 1e16, 1e300, 1e308, -1e308)
_WHEELBASE_M = 2.7
NOT_FINITE = (math.nan, math.inf, -math.inf)

floats = st.one_of(st.sampled_from(EXTREMES + NOT_FINITE), st.floats(), st.floats(-100.0, 100.0))
_scalars = st.one_of(
    floats, st.none(), st.booleans(), st.integers(), st.text(max_size=20), st.binary(max_size=20), st.complex_numbers(),
    st.sampled_from([10**400, -(10**400), 2**63, object, len, np.float64(3.0), np.timedelta64(5, "s")]),
    st.sampled_from([np.array([1.0, 2.0]), np.array(["a"]), np.zeros((4, 4))]),
)  # fmt: skip
anything = st.recursive(
    _scalars,
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.tuples(inner, inner), st.dictionaries(st.text(max_size=5), inner, max_size=3)),
    max_leaves=6,
)


def _mostly(low: float, high: float) -> st.SearchStrategy[float]:
    """A number of traffic, and now and then one that is none."""
    usual = st.floats(low, high)
    return st.one_of(usual, usual, usual, usual, st.floats(10.0 * low - 1.0, 10.0 * high + 1.0), st.sampled_from(EXTREMES))


_CURVATURES = st.one_of(st.just(0.0), st.floats(-0.02, 0.02), st.floats(-2.0, 2.0), st.sampled_from(EXTREMES))


def with_what_it_takes(record: R, **hostile: Any) -> R:
    """The record with each of these values that its constructor takes."""
    for name, value in hostile.items():
        with contextlib.suppress(McdasError):
            record = dataclasses.replace(record, **{name: value})
    return record


_PLACES = st.one_of(st.floats(-200.0, 500.0), st.floats(-200.0, 500.0), st.sampled_from(EXTREMES))


@st.composite
def _lanes(draw: st.DrawFn, right: int, left: int) -> tuple[Lane, ...]:
    """Those that begin, end, narrow, are closed or limited, each on its own."""
    numbers = draw(st.lists(st.integers(-right, left), max_size=3, unique=True))

    def knots(values: st.SearchStrategy[float]) -> tuple[tuple[float, float], ...]:
        return tuple((place, draw(values)) for place in sorted(draw(st.lists(_PLACES, max_size=4, unique=True))))

    closed = [sorted(pair) for pair in draw(st.lists(st.tuples(_PLACES, _PLACES), max_size=2))]
    return tuple(
        with_what_it_takes(
            Lane(lane=number),
            merges=draw(st.sampled_from(Side)),
            width_m=knots(_mostly(0.0, 4.5)),
            speed_limit_mps=knots(_mostly(1.0, 50.0)),
            closed_m=tuple(closed),
            oncoming=draw(st.integers(0, 9)) == 0,
            shoulder=draw(st.integers(0, 9)) == 0,
        )
        for number in numbers
    )


def _pair(low: float, wide: float) -> tuple[float, float]:
    return low, low + wide


@st.composite
def destinations(draw: st.DrawFn, time_s: float) -> Destination:
    begin_m, begin_s = draw(_mostly(-50.0, 500.0)), time_s + draw(_mostly(0.0, 30.0))
    return with_what_it_takes(
        Destination(lane=0),
        lane=draw(st.one_of(st.none(), st.integers(-3, 3))),
        s_m=draw(st.one_of(st.none(), st.just((begin_m, begin_m + draw(_mostly(0.1, 50.0)))))),
        time_s=draw(st.one_of(st.none(), st.just((begin_s, begin_s + draw(_mostly(0.1, 30.0)))))),
        d_m=draw(st.one_of(st.none(), st.just(_pair(draw(_mostly(-8.0, 8.0)), draw(_mostly(0.1, 4.0)))))),
        speed_mps=draw(st.one_of(st.none(), st.just(_pair(draw(_mostly(0.0, 40.0)), draw(_mostly(0.1, 10.0)))))),
        heading_rad=draw(st.one_of(st.none(), st.just(_pair(draw(_mostly(-1.0, 1.0)), draw(_mostly(0.01, 1.0)))))),
    )


@st.composite
def roads(draw: st.DrawFn) -> Road:
    places = draw(st.lists(st.one_of(st.floats(-200.0, 500.0), st.sampled_from(EXTREMES)), min_size=1, max_size=5, unique=True))
    left, right = draw(st.integers(0, 3)), draw(st.integers(0, 3))
    return with_what_it_takes(
        Road(lanes_left=left, lanes_right=right),
        lane_width_m=draw(_mostly(2.5, 4.5)),
        shoulder_left_m=draw(_mostly(0.0, 3.0)),
        shoulder_right_m=draw(_mostly(0.0, 3.0)),
        friction=draw(_mostly(0.05, 1.0)),
        speed_limit_mps=draw(_mostly(5.0, 60.0)),
        curvature=tuple((place, draw(_CURVATURES)) for place in sorted(places)),
        road_end_s_m=draw(st.one_of(st.none(), _mostly(-10.0, 300.0))),
        lanes=draw(_lanes(right, left)) if draw(st.booleans()) else (),
    )


@st.composite
def hosts(draw: st.DrawFn) -> HostState:
    """One that drives as a car can, or, one in four, that is said to be anything."""
    if draw(st.integers(0, 3)):
        speed_mps, lateral_mps2 = draw(st.floats(0.0, 45.0)), draw(st.floats(-4.0, 4.0))
        return HostState(
            s_m=draw(st.floats(-100.0, 1000.0)),
            d_m=draw(st.floats(-2.0, 2.0)),
            heading_rad=draw(st.floats(-0.1, 0.1)),
            speed_mps=speed_mps,
            acceleration_mps2=draw(st.floats(-6.0, 3.0)),
            steering_rad=_WHEELBASE_M * lateral_mps2 / max(speed_mps, 5.0) ** 2,
        )
    return with_what_it_takes(
        HostState(),
        s_m=draw(_mostly(-100.0, 1000.0)),
        d_m=draw(_mostly(-2.0, 2.0)),
        heading_rad=draw(_mostly(-0.2, 0.2)),
        speed_mps=draw(_mostly(0.0, 45.0)),
        acceleration_mps2=draw(_mostly(-6.0, 3.0)),
        steering_rad=draw(_mostly(-0.1, 0.1)),
        sideslip_rad=draw(st.one_of(st.just(0.0), _mostly(-0.2, 0.2))),
    )


@st.composite
def tracks(draw: st.DrawFn, from_s_m: float) -> tuple[Track, ...]:
    spreads = st.sampled_from((0.0, 1e-6, 0.1, 3.0, 1e3, 1e9))
    return tuple(
        with_what_it_takes(
            Track(id=str(k), s_m=30.0 * k + 10.0, d_m=0.0, speed_s_mps=10.0),
            s_m=from_s_m + draw(_mostly(-80.0, 120.0)),
            d_m=draw(_mostly(-8.0, 8.0)),
            speed_s_mps=draw(_mostly(-2.0, 45.0)),
            speed_d_mps=draw(_mostly(-2.0, 2.0)),
            covariance=np.diag([draw(spreads)] * 4),
            length_m=draw(_mostly(0.5, 18.0)),
            width_m=draw(_mostly(0.3, 2.6)),
            age_s=draw(_mostly(0.0, 5.0)),
            coasting=draw(st.booleans()),
            acceleration_s_mps2=draw(_mostly(-9.0, 3.0)),
            acceleration_s_sd_mps2=draw(st.one_of(st.none(), _mostly(0.0, 2.0))),
            acceleration_d_mps2=draw(_mostly(-5.0, 5.0)),
            acceleration_d_sd_mps2=draw(st.one_of(st.none(), _mostly(0.0, 2.0))),
            turn_rate_radps=draw(_mostly(-1.5, 1.5)),
            turn_rate_sd_radps=draw(st.one_of(st.none(), _mostly(0.0, 0.3))),
            heading_rad=draw(st.one_of(st.none(), st.none(), _mostly(-3.2, 3.2))),
            kind=draw(st.sampled_from((None, None, *BodyKind))),
            lane_path_m=draw(st.one_of(st.none(), st.lists(st.tuples(_mostly(-80.0, 120.0), _mostly(-30.0, 30.0)), max_size=6))),
        )
        for k in range(draw(st.integers(0, 6)))
    )


@st.composite
def situations(draw: st.DrawFn) -> tuple[Situation, ...]:
    """Each of two hosts in each of two traffics on each of two roads: to draw them takes as long as to plan for one."""
    given = Situation(
        time_s=draw(st.sampled_from((0.0, 1.0, -5.0, 1.7e9, 1e15))),
        host=HOST,
        coverage=Coverage(**{sector.value: draw(st.integers(0, 5)) > 0 for sector in Sector}),
        request=draw(st.sampled_from(Request)),
    )
    wanted = draw(st.one_of(st.none(), _mostly(0.0, 50.0)))
    destination = draw(destinations(given.time_s)) if draw(st.integers(0, 3)) == 0 else None
    asked = with_what_it_takes(given, desired_speed_mps=wanted, destination=destination)
    drawn = [(draw(roads()), draw(hosts()), draw(tracks(0.0))) for _ in range(2)]
    return tuple(
        with_what_it_takes(
            asked, road=road, host=host, tracks=tuple(with_what_it_takes(track, s_m=track.s_m + host.s_m) for track in others)
        )
        for road, _, _ in drawn
        for _, host, _ in drawn
        for _, _, others in drawn
    )


@st.composite
def crowds(draw: st.DrawFn, cycles: int) -> tuple[Situation, ...]:
    """Cycles of hundreds of bodies, of whom all are seen again in the next, or none."""
    numbers = np.random.default_rng(draw(st.integers(0, 2**32)))
    road, host, asked = draw(roads()), draw(hosts()), []
    centre_m, along_m, across_m = (
        draw(st.floats(-50.0, 100.0)),
        draw(st.sampled_from((0.0, 1.0, 30.0, 300.0, 3000.0))),
        draw(_mostly(0.0, 8.0)),
    )
    turned, quick, long_m = draw(st.booleans()), draw(st.sampled_from((0.0, 1.0, 40.0))), draw(st.sampled_from((0.5, 4.5, 18.0)))
    for k in range(cycles):
        named = f"{k} " if draw(st.booleans()) else ""
        now = dataclasses.replace(host, s_m=host.s_m + 0.1 * k * min(host.speed_mps, 100.0))
        bodies = tuple(
            with_what_it_takes(
                Track(id=f"{named}{i}", s_m=30.0 * i, d_m=0.0, speed_s_mps=10.0, length_m=long_m),
                s_m=now.s_m + centre_m + along_m * along,
                d_m=across_m * across,
                speed_s_mps=host.speed_mps + quick * fast,
                heading_rad=math.pi * heading if turned else None,
            )
            for i, (along, across, fast, heading) in enumerate(
                numbers.uniform(-1.0, 1.0, (draw(st.sampled_from((50, 150, MOST_TRACKS))), 4))
            )
        )
        coverage = Coverage(**{sector.value: draw(st.booleans()) for sector in Sector})
        asked.append(with_what_it_takes(Situation(time_s=0.1 * k, host=HOST, coverage=coverage), road=road, host=now, tracks=bodies))
    return tuple(asked)


@dataclass(frozen=True, slots=True, kw_only=True)
class Heard:
    """What a planner is told in one cycle."""

    now_s: float
    scans: tuple[Scan, ...]
    host: HostState


_STEPS_S = st.one_of(
    st.just(0.1), st.just(0.1), st.floats(0.0, 0.3), st.sampled_from((0.0, 1e-9, 1.0, 60.0, 3600.0, 1e9, -0.1, -1.0, -3600.0, -1e9))
)
_LAGS_S = st.one_of(st.just(0.0), st.floats(0.0, 0.3), st.sampled_from((1.0, 3600.0, -1.0, -3600.0, math.nan, math.inf, 1e300)))


_told = st.one_of(floats, floats, st.sampled_from((10**400, -(10**400), 3, np.float32(3.0), np.int8(-7))))  # by a sensor


_CROWDED = st.sampled_from((*(0,) * 14, 40, 300))  # returns besides


@st.composite
def _bodies(draw: st.DrawFn) -> tuple[BodyDetection, ...]:
    return tuple(
        BodyDetection(
            name=str(draw(st.integers(0, 3))),
            s_m=draw(st.one_of(st.floats(-100.0, 200.0), _told)),
            d_m=draw(st.one_of(st.floats(-8.0, 8.0), _told)),
            speed_s_mps=draw(st.one_of(st.floats(0.0, 40.0), _told)),
            speed_d_mps=draw(st.one_of(st.just(0.0), _told)),
            length_m=draw(st.one_of(st.just(4.5), _told)),
            width_m=draw(st.one_of(st.just(1.8), _told)),
        )
        for _ in range(draw(st.integers(0, 4)))
    )


def _crowd(count: int, seed: int) -> tuple[RadarDetection, ...]:
    """So many returns from anywhere: drawn one by one they would take longer than to be planned for."""
    numbers = random.Random(seed)
    places = [(numbers.uniform(0.5, 170.0), numbers.uniform(-0.8, 0.8), numbers.uniform(-60.0, 20.0)) for _ in range(count)]
    return tuple(RadarDetection(range_m=r, azimuth_rad=phi, range_rate_mps=rate) for r, phi, rate in places)


@st.composite
def _scans(draw: st.DrawFn, now_s: float) -> tuple[Scan, ...]:
    found = []
    for _ in range(draw(st.integers(0, 3))):
        sector = draw(st.sampled_from(Sector))
        detections = tuple(
            RadarDetection(
                range_m=draw(st.one_of(st.floats(0.5, 170.0), _told)),
                azimuth_rad=draw(st.one_of(st.floats(-0.8, 0.8), _told)),
                range_rate_mps=draw(st.one_of(st.floats(-60.0, 20.0), _told)),
                range_sd_m=draw(st.one_of(st.just(0.25), _told)),
            )
            for _ in range(draw(st.integers(0, 6)))
        )
        detections += _crowd(draw(_CROWDED), draw(st.integers(0, 3)))
        yaw_rad = draw(st.sampled_from((0.0, math.pi))) if draw(st.integers(0, 9)) == 0 else math.pi * (sector is Sector.REAR)
        mounting = Mounting(x_m=draw(st.one_of(st.just(2.0), _told)), yaw_rad=yaw_rad)
        t_s, working = now_s - draw(_LAGS_S), draw(st.integers(0, 9)) > 0
        blind = draw(st.sampled_from((None, Beam(name="blind", range_max_m=4.0, half_angle_rad=0.8))))
        bodies = draw(_bodies()) if draw(st.integers(0, 3)) == 0 else ()
        name = f"radar-{sector.value}"
        found.append(
            Scan(sensor=name, sector=sector, t_s=t_s, mounting=mounting, radar=detections, bodies=bodies, working=working, blind=blind)
        )
    return tuple(found)


@st.composite
def streams(draw: st.DrawFn) -> tuple[tuple[Road, ...], list[Heard]]:
    """Some cycles of scans under a clock that jitters, stops, jumps and runs back, and of a host whose state glitches; on each of three
    roads, since to draw them takes as long as to plan."""
    now_s = draw(st.sampled_from((0.0, 1.7e9, -1e6)))
    host, heard = HostState(speed_mps=draw(st.floats(0.0, 40.0))), []
    for _ in range(draw(st.integers(2, 8))):
        now_s += draw(_STEPS_S)
        glitch = draw(hosts()) if draw(st.integers(0, 4)) == 0 else None
        heard.append(Heard(now_s=now_s, scans=draw(_scans(now_s)), host=glitch or host))
        host = dataclasses.replace(host, s_m=host.s_m + 0.1 * host.speed_mps)
    return (draw(roads()), draw(roads()), draw(roads())), heard
