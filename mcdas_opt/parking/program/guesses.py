"""Where the program is standing_start from: the search's paths, those with one more gear, closed forms, and the answer of a longer slot."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import NamedTuple

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.parking.closed_form import corrected, two_arc
from mcdas_opt.parking.path import Arc, ArcPath, counted, merged
from mcdas_opt.parking.program.exchange import ExchangeSettings, exchange
from mcdas_opt.parking.program.manoeuvre import INTERVAL_S, Manoeuvre, standing_start
from mcdas_opt.parking.program.records import ParkingCosts
from mcdas_opt.parking.program.structure import from_trajectory
from mcdas_opt.parking.refusal import lengthened
from mcdas_opt.parking.world import World

GUESSES = ("search", "one-more", "two-arc", "sigmoid", "continuation")
_RETRACE_M = 0.4  # driven the other way first, and back
_STEPS_M = (0.4, 0.25, 0.1, 0.0)  # slot lengths beyond the case's, one answer the guess of the next


class Guess(NamedTuple):
    """`make` costs something only for `continuation`. In `pieces` the program moves its switching times: quicker to drive, less robust."""

    name: str
    make: Callable[[], Manoeuvre | None]
    pieces: bool = False


def guesses(
    case: ParkingCase,
    paths: list[ArcPath],
    kinds: tuple[str, ...],
    costs: ParkingCosts,
    settings: ExchangeSettings,
    interval_s: float = INTERVAL_S,
    more_first_from: int = 0,
) -> Iterator[Guess]:
    """Guesses of the wanted kinds, most promising first; a closed form's needs no path of the search.

    A path without a gear change is not given one: what that gains is not worth a driver's while. From `more_first_from` gear changes on the
    path with one more comes first.
    """
    for rank, path in enumerate(paths):
        plain = [Guess(counted(path.gear_changes), partial(standing_start, case, path, interval_s))] if "search" in kinds else []
        more = []
        if "one-more" in kinds and rank == 0 and (path.gear_changes > 0 or not plain):
            longer = one_more(path)
            more = [
                Guess(f"{counted(longer.gear_changes)}, one put before", partial(standing_start, case, longer, interval_s), pieces=True)
            ]
        yield from [*more, *plain] if path.gear_changes >= more_first_from else [*plain, *more]
    if "two-arc" in kinds:
        yield Guess("two arcs", partial(_closed, case, "two arcs"))
    if "sigmoid" in kinds:
        yield Guess("reverse sigmoid", partial(_closed, case, "reverse sigmoid"))
    if "continuation" in kinds and case.slot is not None and paths:
        yield Guess("a longer slot", partial(continued, case, paths[0], costs, settings))


def one_more(path: ArcPath) -> ArcPath:
    """A little the other way first, and back: a gear that the program may make use of."""
    first = path.arcs[0]
    way = -_RETRACE_M if first.length > 0.0 else _RETRACE_M
    return ArcPath(path.start, merged([Arc(0.0, way), Arc(0.0, -way), *path.arcs]), path.name)


def continued(case: ParkingCase, path: ArcPath, costs: ParkingCosts, settings: ExchangeSettings) -> Manoeuvre | None:
    """The slot shortened step by step, every answer the next one's guess; None when a step has no answer."""
    current: Manoeuvre | None = None
    for more in _STEPS_M[:-1]:
        longer = lengthened(case, more)
        if current is None:
            current = standing_start(longer, ArcPath(longer.start, path.arcs, path.name))
        done = exchange(longer, World.of(longer), current, costs, settings)
        if done.best is None:
            return None
        current = done.best
    return current


def _closed(case: ParkingCase, name: str) -> Manoeuvre | None:
    driven = (two_arc if name == "two arcs" else corrected)(case)
    if driven.path_m < 0.1:
        return None
    return from_trajectory(case, driven, name)
