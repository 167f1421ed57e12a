"""What the laws over whole plans change in a sequence of situations, and how an answer to the changed one is brought back."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from benchmarks.law_answers import Answer
from benchmarks.random_traffic import Episode
from mcdas_opt.domain.situation import Situation

CLOCKS_S = (1e3, 1.7e9, 1e6)
SHIFTS_M = (1.0, 100.0, 9_900.0, 12_000.0, 1e5, 1e6)
JITTER_S = 1e-6


def permuted(one: Episode, situations: Sequence[Situation]) -> list[Situation]:
    """The tracks in another order."""
    r = np.random.default_rng(one.number)
    return [replace(each, tracks=tuple(each.tracks[i] for i in r.permutation(len(each.tracks)))) for each in situations]


def other_names(one: Episode, situations: Sequence[Situation]) -> dict[str, str]:
    """A bijection of all ids of the sequence onto others, in random order."""
    ids = sorted({track.id for each in situations for track in each.tracks})
    order = np.random.default_rng(one.number).permutation(len(ids))
    return {name: f"x{place:03d}{'yz'[place % 2]}" for name, place in zip(ids, order.tolist(), strict=True)}


def renamed(one: Episode, situations: Sequence[Situation]) -> list[Situation]:
    """The tracks under `other_names`."""
    names = other_names(one, situations)
    return [replace(each, tracks=tuple(replace(track, id=names[track.id]) for track in each.tracks)) for each in situations]


def clock_s(one: Episode) -> float:
    """How much later law 'clock' has this one begin."""
    return CLOCKS_S[one.number // 2 % len(CLOCKS_S)]


def later(one: Episode, situations: Sequence[Situation]) -> list[Situation]:
    """Every cycle by another clock; `earlier` brings an answer back."""
    return [replace(each, time_s=each.time_s + clock_s(one)) for each in situations]


def shift_m(one: Episode) -> float:
    """How far law 'moved' moves this one."""
    return SHIFTS_M[one.number // 2 % len(SHIFTS_M)]


def moved(situation: Situation, by_m: float) -> Situation:
    """The whole scene farther along the road."""
    return _placed(situation, lambda s_m: s_m + by_m)


def snapped(situation: Situation) -> Situation:
    """Every place along the road to 2^-20 m, so that the scene is moved without rounding: of a solve that is cut short, or hangs on a
    limit, rounding alone makes another answer, wherever s = 0 lies."""
    return _placed(situation, lambda s_m: round(s_m * 2**20) / 2**20)


def _placed(situation: Situation, place_m: Callable[[float], float]) -> Situation:
    road = situation.road
    return replace(
        situation,
        host=replace(situation.host, s_m=place_m(situation.host.s_m)),
        tracks=tuple(replace(track, s_m=place_m(track.s_m)) for track in situation.tracks),
        road=replace(
            road,
            curvature=tuple((place_m(s), kappa) for s, kappa in road.curvature),
            road_end_s_m=None if road.road_end_s_m is None else place_m(road.road_end_s_m),
        ),
    )


def farther(one: Episode, situations: Sequence[Situation]) -> list[Situation]:
    """Every cycle at another place; `nearer` brings an answer back."""
    return [moved(each, shift_m(one)) for each in situations]


def nearer(one: Episode, answer: Answer) -> Answer:
    drive = answer["trajectory"]
    return answer | {"trajectory": drive | {"s_m": [s - shift_m(one) for s in drive["s_m"]]}}


def jittered(one: Episode, situations: Sequence[Situation]) -> list[Situation]:
    """The second cycle early, every later one early or late."""
    r = np.random.default_rng(one.number)
    off = np.concatenate([[0.0, -1.0], r.uniform(-1.0, 1.0, len(situations))])[: len(situations)]
    return [replace(each, time_s=each.time_s + JITTER_S * by) for each, by in zip(situations, off.tolist(), strict=True)]


def earlier(one: Episode, answer: Answer) -> Answer:
    return answer | {"time_s": round(answer["time_s"] - clock_s(one), 1)}
