"""Where the program is started from: the search's paths, those with one more gear, closed forms, and the answer of a longer slot."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import NamedTuple

from mcdas_opt.domain.parking import ParkingCase, ParkingTrajectory
from mcdas_opt.parking.case_variants import lengthened
from mcdas_opt.parking.closed_form import corrected, two_arc
from mcdas_opt.parking.cost import ParkingCosts
from mcdas_opt.parking.path import Arc, ArcPath, counted, merged
from mcdas_opt.parking.program.exchange import ExchangeSettings, exchange
from mcdas_opt.parking.program.manoeuvre import INTERVAL_S, Manoeuvre, from_path
from mcdas_opt.parking.program.structure import from_trajectory
from mcdas_opt.parking.world import World

GUESSES = ("search", "one-more", "two-arc", "sigmoid", "continuation")
_RETRACE_M = 0.4  # driven in the opposite gear first, and back
_LONGER_M = (0.4, 0.25, 0.1)  # slot lengths beyond the case's, one answer the guess of the next


class Guess(NamedTuple):
    """`make` costs something only for `continuation`. In `pieces` the program moves its switching times: quicker to drive, less robust."""

    name: str
    make: Callable[[], Manoeuvre | None]
    pieces: bool = False
    of_path: bool = True  # made of a path of the search as it is, or with one gear more


def guesses(
    case: ParkingCase,
    paths: list[ArcPath],
    kinds: tuple[str, ...],
    costs: ParkingCosts,
    settings: ExchangeSettings,
    interval_s: float = INTERVAL_S,
    more_first_from: int = 0,
) -> Iterator[Guess]:
    """Guesses of the wanted kinds, those that gained most first; a closed form's needs no path of the search.

    A path without a gear change is not given one: it gains 0.01 s. From `more_first_from` gear changes on the
    path with one more comes first.
    """
    for rank, path in enumerate(paths):
        plain = [Guess(counted(path.gear_changes), partial(from_path, case, path, interval_s))] if "search" in kinds else []
        more = []
        if "one-more" in kinds and rank == 0 and (path.gear_changes > 0 or not plain):
            longer = one_more(path)
            more = [Guess(f"{counted(longer.gear_changes)}, one put before", partial(from_path, case, longer, interval_s), pieces=True)]
        yield from [*more, *plain] if path.gear_changes >= more_first_from else [*plain, *more]
    if "two-arc" in kinds:
        yield Guess("two arcs", partial(_closed, case, two_arc), of_path=False)
    if "sigmoid" in kinds:
        yield Guess("reverse sigmoid", partial(_closed, case, corrected), of_path=False)
    if "continuation" in kinds and case.slot is not None and paths:
        yield Guess("a longer slot", partial(continued, case, paths[0], costs, settings), of_path=False)


def one_more(path: ArcPath) -> ArcPath:
    """The path with a little driven in the opposite gear first, and back: a gear that the program may use."""
    back = -path.arcs[0].gear * _RETRACE_M
    return ArcPath(path.start, merged([Arc(0.0, back), Arc(0.0, -back), *path.arcs]))


def continued(case: ParkingCase, path: ArcPath, costs: ParkingCosts, settings: ExchangeSettings) -> Manoeuvre | None:
    """The slot shortened step by step, every answer the next one's guess; None when a step has no answer."""
    current: Manoeuvre | None = None
    for more in _LONGER_M:
        longer = lengthened(case, more)
        if current is None:
            current = from_path(longer, ArcPath(longer.start, path.arcs))
        done = exchange(longer, World.of(longer), current, costs, settings)
        if done.best is None:
            return None
        current = done.best
    return current


def _closed(case: ParkingCase, closed_form: Callable[[ParkingCase], ParkingTrajectory]) -> Manoeuvre | None:
    driven = closed_form(case)
    return None if driven.path_m < 0.1 else from_trajectory(case, driven)
