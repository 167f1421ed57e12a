"""The nonlinear program from several starts: then its best answer without its shortest phases, then on a finer grid."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.parking.case_variants import lengthened
from mcdas_opt.parking.path import ArcPath
from mcdas_opt.parking.program.exchange import Exchanged, ExchangeSettings, exchange
from mcdas_opt.parking.program.guesses import Guess, guesses
from mcdas_opt.parking.program.manoeuvre import INTERVAL_S, PIECE, Manoeuvre, from_path
from mcdas_opt.parking.program.structure import finer, finer_places, in_pieces, phase_lengths, without
from mcdas_opt.parking.program.windows import WHOLE_UP_TO, improve
from mcdas_opt.parking.run import Run
from mcdas_opt.parking.search.resolution_refinement import MANY
from mcdas_opt.parking.settings import ParkSettings
from mcdas_opt.parking.world import World

_TIGHT_FROM = (3, 5)  # gear changes from which one answer has to do, and one gear more comes first: the first number ...
_TIGHT_LENGTH_M = 2.5  # ... where a gear is driven for less than this
_FINE_FOR = (7, 10)  # gear changes for which the grid is fine from the beginning: that costs less than a second solution
_FINE_S = 0.2  # its interval
_LOOSE_FOR = (7, 12)  # gear changes for which the solver's tolerance is loose ...
_LOOSE = (1e-5, 1e-4)  # ... in the first and in later rounds
# Work is iterations times intervals.
_WORK = 36_000  # once there is an answer, no other start begins that is expected to end beyond this
_WORK_UNANSWERED = 80_000  # a start without an answer ends here
_WORK_POLISHING = 46_000  # beyond this there is no finer grid, and nothing is left out
_LONG_FROM = 17  # gear changes from which these caps do not hold
_LEFT_OUT_M = 0.06  # phases shorter than this are tried without
_POLISH_M = 0.2  # trust region on the finer grid
_POLISH_ITERATIONS = 160  # expected of it
_SHARES_OF_RELIEF = (1.0, 0.75, 0.5, 0.25)


def improve_paths(run: Run, settings: ParkSettings, paths: list[ArcPath]) -> None:
    """Offer what the program makes of the search's paths."""
    if any(not path.arcs for path in paths):
        return  # the car is there already
    fewest = min((path.gear_changes for path in paths), default=0)
    tight_from = _TIGHT_FROM[0 if paths and paths[0].gear_length_m < _TIGHT_LENGTH_M else 1]
    most = settings.starts if fewest < tight_from else 1
    interval_s = _FINE_S if _FINE_FOR[0] <= fewest <= _FINE_FOR[1] else INTERVAL_S
    chosen = list(guesses(run.case, paths, settings.guesses, settings.costs, settings.exchange, interval_s, tight_from))
    best: Exchanged | None = None
    for number, guess in enumerate([*[g for g in chosen if g.of_path][: settings.starts], *[g for g in chosen if not g.of_path]]):
        if run.late():
            return
        if best is None or not guess.of_path or (number < most and _another_start(run, best, number)):
            best = _tried(run, settings, guess, best)
    if best is None or best.best is None or best.best.gear_changes > WHOLE_UP_TO:
        return
    for _ in range(settings.left_out):
        shorter = _without_shortest(run, settings, best)
        if shorter is best:
            break
        best = shorter
    _polished(run, settings, best)


def approach(run: Run, settings: ParkSettings, relieved: ParkingCase, path: ArcPath) -> str:
    """From a relieved case's answer towards the case itself; says how near it came, and offers what it ends with."""
    case = run.case
    solve = replace(settings.exchange, rounds=4, rounds_unsound=6)
    current = from_path(relieved, path)
    said = ""
    spare = relieved.slot.length_m - case.slot.length_m if relieved.slot is not None and case.slot is not None else 0.0
    if current.gear_changes > MANY:
        return said
    for share in _SHARES_OF_RELIEF:
        if run.late():
            break
        step = lengthened(case, share * spare) if spare > 1e-6 else relieved
        done = exchange(step, World.of(step), current, settings.costs, solve)
        if done.best is None:
            break
        current = done.best
        if spare > 1e-6:
            said = f"{100.0 * share * spare:.0f} cm more length would do"
        else:
            break
    _offered(run, "nlp from a relieved case", lambda: exchange(case, run.world, current, settings.costs, solve))
    return said


def _another_start(run: Run, best: Exchanged, number: int) -> bool:
    """Whether one more start is expected to end within the work; the third one not at the cost of the finer grid, which gains more."""
    after = run.work + run.dearest
    if best.best is None or number < 2:
        return after <= _WORK
    finer_grid = _POLISH_ITERATIONS * 2 * len(best.best.steps)
    spoils = run.work + finer_grid <= _WORK_POLISHING < after + finer_grid
    return after <= _WORK and not spoils


def _tried(run: Run, settings: ParkSettings, guess: Guess, best: Exchanged | None) -> Exchanged | None:
    """The better of the best so far and what the program makes of a guess."""
    begin = time.perf_counter()
    first = guess.make()
    if first is None:
        run.timing["solve"] += 1e3 * (time.perf_counter() - begin)
        return best
    before = run.value
    manoeuvre = in_pieces(first, PIECE) if guess.pieces else first
    loop = settings.exchange
    if _LOOSE_FOR[0] <= manoeuvre.gear_changes <= _LOOSE_FOR[1]:
        loop = replace(loop, tolerance=_LOOSE)
    bounded = _within_work(run, manoeuvre, loop, answered=best is not None)
    done = _offered(run, f"nlp from {guess.name}", lambda: improve(run.case, run.world, manoeuvre, settings.costs, bounded))
    return done if done is not None and (best is None or run.value < before) else best


def _without_shortest(run: Run, settings: ParkSettings, best: Exchanged) -> Exchanged:
    """The best manoeuvre without its shortest phase but the first, where that is short and the program gains; else the best itself.

    A short first phase was put in on purpose, or the path has none.
    """
    manoeuvre = best.best
    if manoeuvre is None or run.late():
        return best
    if manoeuvre.gear_changes < _LONG_FROM and run.work + run.dearest > _WORK_POLISHING:
        return best
    driven = phase_lengths(manoeuvre)
    if len(driven) < 2:
        return best
    shortest = 1 + int(np.argmin(driven[1:]))
    if driven[shortest] > _LEFT_OUT_M:
        return best
    before, fewer = run.value, without(manoeuvre, shortest)
    bounded = _within_work(run, manoeuvre, settings.exchange)
    done = _offered(run, "nlp, a phase left out", lambda: exchange(run.case, run.world, fewer, settings.costs, bounded))
    return done if done is not None and run.value < before else best


def _polished(run: Run, settings: ParkSettings, best: Exchanged) -> None:
    """The best manoeuvre on a grid of half the spacing, with checks from the first round on where it needed them before."""
    manoeuvre = best.best
    if manoeuvre is None or len(manoeuvre.steps) > settings.polish_up_to or run.late():
        return
    halved = in_pieces(finer(run.case, manoeuvre), PIECE)
    expected = run.work + _POLISH_ITERATIONS * len(halved.steps)
    if manoeuvre.gear_changes < _LONG_FROM and expected > _WORK_POLISHING:
        return
    closely = replace(settings.exchange, trust_region_m=_POLISH_M, trust_region_rad=0.5 * _POLISH_M)
    closely = _within_work(run, manoeuvre, closely)
    where = finer_places(best.checked)
    _offered(run, "nlp, finer grid", lambda: exchange(run.case, run.world, halved, settings.costs, closely, checked=where))


def _within_work(run: Run, manoeuvre: Manoeuvre, loop: ExchangeSettings, *, answered: bool = True) -> ExchangeSettings:
    """What one more program may take; long zigzags take what they take."""
    if manoeuvre.gear_changes >= _LONG_FROM:
        return loop
    if not answered:
        return replace(loop, work_unsound=_WORK_UNANSWERED)
    rest = max(_WORK_POLISHING - run.work, 0)
    return replace(loop, work=min(loop.work, rest), work_unsound=rest)


def _offered(run: Run, name: str, solve: Callable[[], Exchanged]) -> Exchanged | None:
    """Solve, and offer what came of it; it comes back when it is sound."""
    begin = time.perf_counter()
    done = solve()
    seconds = time.perf_counter() - begin
    run.timing["solve"] += 1e3 * seconds
    run.iterations += done.iterations
    work = done.iterations * len(done.last.steps)
    run.work, run.dearest = run.work + work, max(run.dearest, work)
    note = f"{done.rounds} rounds, {done.iterations} iterations"
    driven = (done.best if done.best is not None else done.last).trajectory(run.case)
    if run.offer(name, driven, note, seconds):
        return done
    run.failed(name, done.lacking_m, driven)
    return None
