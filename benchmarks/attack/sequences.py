"""Traffic from cycle to cycle, as somebody's own tracker may tell of it at its worst: what a planner remembers must never be in its way."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np
from hypothesis import strategies as st

from benchmarks.attack.campaign import cycles
from benchmarks.attack.records import HOST
from benchmarks.attack.strategies import destinations, hosts, roads, tracks, with_what_it_takes
from benchmarks.attack.tally import Tally
from mcdas_opt import Coverage, HostState, Request, Road, Sector, Situation, Track
from mcdas_opt.domain.destination import Destination
from mcdas_opt.domain.vocabulary import BodyKind

_CYCLES = 12  # of a sequence
_STEPS_S = (*[0.1] * 8, 0.05, 0.2, 0.01, 0.9, 1.5, 1e-7, 0.0, -0.1)
_MOST = 40  # tracks: who doubles in each cycle is many


def attack(tally: Tally, count: int, seed: int) -> None:
    cycles(sequences(), tally, max(count // _CYCLES, 1), seed)


@st.composite
def sequences(draw: st.DrawFn) -> tuple[Situation, ...]:
    """Begun from hostile traffic on one of two hostile roads; what happens then is drawn by numpy, which takes less time than to plan."""
    numbers = np.random.default_rng(draw(st.integers(0, 2**32)))
    begun, others, host = (draw(roads()), draw(roads())), draw(tracks(0.0)), draw(hosts())
    wanted = draw(st.one_of(st.none(), destinations(0.0))), draw(st.one_of(st.none(), destinations(0.0)))
    near = tuple(with_what_it_takes(track, s_m=track.s_m + host.s_m) for track in others)
    return tuple(_driven(numbers, begun, wanted, host, near))


def _driven(
    numbers: np.random.Generator,
    on: tuple[Road, ...],
    towards: tuple[Destination | None, ...],
    host: HostState,
    traffic: tuple[Track, ...],
) -> Iterator[Situation]:
    there, gone, watched = {track.id: track for track in traffic}, dict[str, Track](), dict.fromkeys(Sector, True)
    road, destination, request, time_s = on[0], towards[0], Request.DRIVE, 0.0

    def rarely(of: int) -> bool:
        return bool(numbers.integers(of) == 0)

    for _ in range(_CYCLES):
        step_s = float(numbers.choice(_STEPS_S))
        time_s += step_s
        host = with_what_it_takes(host, s_m=host.s_m + host.speed_mps * step_s, d_m=host.d_m + 0.1 * float(numbers.normal()))
        if rarely(12):
            host = with_what_it_takes(host, s_m=host.s_m + float(numbers.choice((-60.0, 3.0, 900.0, 1e5))))
        if rarely(8):
            host = with_what_it_takes(host, speed_mps=float(numbers.choice((0.0, 5e-324, 20.0, 60.0, 130.0))))
        for sector in Sector:
            watched[sector] ^= rarely(6)
        road = on[int(numbers.integers(len(on)))] if rarely(8) else road
        destination = towards[int(numbers.integers(len(towards)))] if rarely(6) else destination
        request = Request(numbers.choice([one.value for one in Request])) if rarely(10) else request
        there, gone = _told(numbers, there, gone, step_s)
        names = numbers.permutation(sorted(there)).tolist()
        now = Situation(time_s=time_s, host=HOST, coverage=Coverage(**{sector.value: bool(seen) for sector, seen in watched.items()}))
        yield with_what_it_takes(
            now, road=road, host=host, tracks=tuple(there[name] for name in names), destination=destination, request=request
        )


def _told(
    numbers: np.random.Generator, there: dict[str, Track], gone: dict[str, Track], step_s: float
) -> tuple[dict[str, Track], dict[str, Track]]:
    """Who is told of next, and who is not any more: they go on, vanish, come back, jump, double, swap names, or turn out as others."""
    now: dict[str, Track] = {}
    for name, track in there.items():
        on = with_what_it_takes(track, s_m=track.s_m + track.speed_s_mps * step_s, d_m=track.d_m + track.speed_d_mps * step_s)
        match int(numbers.integers(24)):
            case 0 | 1:
                gone[name] = on
                continue
            case 2:
                on = with_what_it_takes(on, s_m=on.s_m + float(numbers.normal(0.0, 20.0)), d_m=on.d_m + float(numbers.normal(0.0, 3.0)))
            case 3 | 4:
                twin = f"{name} {numbers.choice(('again', 'before its jump', 'changing'))}"
                now[twin] = dataclasses.replace(on, id=twin)
            case 5:
                on = with_what_it_takes(on, speed_s_mps=float(numbers.choice((0.0, -15.0, 30.0, 99.0, 400.0))))
            case 6:
                on = with_what_it_takes(on, length_m=float(numbers.choice((0.5, 18.0, 400.0, 5e-324))))
            case 7:
                on = with_what_it_takes(on, heading_rad=float(numbers.uniform(-3.2, 3.2)))
            case 8:
                on = with_what_it_takes(on, kind=numbers.choice(BodyKind))
            case 9:
                on = with_what_it_takes(on, covariance=float(numbers.choice((0.0, 0.1, 10.0))) * np.eye(4))
        now[name] = on
    for name in [name for name in gone if numbers.integers(4) == 0]:
        now.setdefault(name, gone.pop(name))
    if len(now) > 1 and numbers.integers(6) == 0:
        one, other = numbers.choice(sorted(now), 2, replace=False).tolist()
        now[one], now[other] = dataclasses.replace(now[other], id=one), dataclasses.replace(now[one], id=other)
    return dict(list(now.items())[:_MOST]), gone
