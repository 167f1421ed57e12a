"""`park`: from a case to a judged answer. The search's answer stands until the program beats it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from mcdas_opt.domain.parking import Parking, ParkingCase, ParkingTrajectory
from mcdas_opt.domain.verdict import Verdict, Violation, ViolationKind
from mcdas_opt.errors import ParameterError, nearest
from mcdas_opt.parking.closed_form import CLOSED_FORMS
from mcdas_opt.parking.path import ArcPath, counted, drive, way_per_gear
from mcdas_opt.parking.program.exchange import Exchanged, ExchangeSettings, exchange
from mcdas_opt.parking.program.guesses import GUESSES, Guess, guesses
from mcdas_opt.parking.program.manoeuvre import INTERVAL_S, PIECE, Manoeuvre, standing_start
from mcdas_opt.parking.program.records import COSTS, ParkingCosts
from mcdas_opt.parking.program.structure import finer, finer_places, in_pieces, ways, without
from mcdas_opt.parking.program.windows import WindowSettings, improve
from mcdas_opt.parking.refusal import lengthened, relief, too_tight
from mcdas_opt.parking.run import Run
from mcdas_opt.parking.search.arc_search import SearchSettings
from mcdas_opt.parking.search.resolution_refinement import LEVELS, Climb, Level, beyond_the_wall, climb
from mcdas_opt.parking.world import World
from mcdas_opt.verification.parking_judge import judge_parking

PLANNERS = ("nlp", "search", *CLOSED_FORMS)


@dataclass(frozen=True, slots=True, kw_only=True)
class ParkSettings:
    """All caps are counts, so that the same case gives the same answer; a time budget is an extra cap and is reported when it bit."""

    costs: ParkingCosts = COSTS["time"]
    search: SearchSettings = field(default_factory=SearchSettings)
    exchange: ExchangeSettings = field(default_factory=ExchangeSettings)
    windows: WindowSettings = field(default_factory=WindowSettings)
    levels: tuple[Level, ...] = LEVELS
    guesses: tuple[str, ...] = ("search", "one-more")  # of `GUESSES`
    starts: int = 3  # guesses that the program is started from at most; so many anyhow until one has an answer
    tight_from: tuple[int, int] = (3, 5)  # from so many gear changes on, one answer has to do, and one gear more is tried first, ...
    tight_way_m: float = 2.5  # ... from the first of them where a gear's way is shorter than this
    fine_for: tuple[int, int] = (7, 10)  # gear changes for which the grid is fine from the beginning, which costs less ...
    fine_s: float = 0.2  # ... than a second solution: its interval [s]
    loose: tuple[float, float] = (1e-5, 1e-4)  # the solver's tolerance in the first and in later rounds ...
    loose_for: tuple[int, int] = (7, 12)  # ... for so many gear changes
    work: int = 36_000  # iterations times intervals: once there is an answer, no other start that is expected to end beyond, ...
    work_unanswered: int = 80_000  # the same of one start that has no answer yet
    work_polishing: int = 46_000  # ... and no finer grid and nothing left out either, ...
    long_from: int = 17  # ... below so many gear changes
    free_poses: int = 10_000  # of the searches; every pose beyond counts as one of that work, which takes as long
    many: int = 14  # a search's path with more gear changes asks for another search of finer cells
    left_out_m: float = 0.06  # phases shorter than this are tried without ...
    left_out: int = 2  # ... at most so many times
    polish_up_to: int = 260  # intervals: what has at most so many is solved once more on a grid of half the spacing
    polish_m: float = 0.2  # trust of that
    polish_iterations: int = 160  # expected of it
    time_budget_s: float | None = None

    def __post_init__(self) -> None:
        for name in self.guesses:
            if name not in GUESSES:
                raise ParameterError("guesses", name, f"is unknown; {nearest(name, GUESSES)}")


def park(case: ParkingCase, planner: str = "nlp", *, settings: ParkSettings | None = None) -> Parking:
    """One parking plan, judged. `planner` is one of `PLANNERS`; a case without an answer gives a refusal, which is a value.

    Raises `ParameterError` for an unknown planner.
    """
    if planner not in PLANNERS:
        raise ParameterError("planner", planner, f"is unknown; {nearest(planner, PLANNERS)}")
    settings = settings or ParkSettings()
    world = World.of(case)
    run = Run(case, world, settings.costs, settings.time_budget_s)
    if planner in CLOSED_FORMS:
        return _closed_form(run, planner, CLOSED_FORMS[planner])
    tight = too_tight(case, world)
    if tight is not None:
        return run.answer(planner, None, Verdict(violations=(tight[1],)), None, status="refused", reason=tight[0])
    paths, climbed = _searched(run, settings)
    if planner == "nlp":
        _programs(run, settings, paths)
    if run.best is None:
        return _refused(run, settings, planner, climbed)
    trajectory, judgement = run.best
    return run.answer(planner, trajectory, judgement.verdict, judgement.min_clearance_m, status="planned", reason=_story(run))


def _searched(run: Run, settings: ParkSettings) -> tuple[list[ArcPath], Climb]:
    """Sound paths, cheapest first, one for each number of gear changes, and what the searches saw."""
    begin = time.perf_counter()
    cheapest: dict[int, tuple[float, ArcPath]] = {}

    def offer(path: ArcPath) -> bool:
        driven = drive(run.case, path)
        sound = run.offer(f"search, {counted(path.gear_changes)}", driven, "stops for every change of steering", 0.0)
        value = driven.duration_s + settings.costs.gear_changes * path.gear_changes
        if sound and value < cheapest.get(path.gear_changes, (np.inf, path))[0]:
            cheapest[path.gear_changes] = (value, path)
        return sound

    done = climb(run.case, run.world, settings.levels, settings.search, settings.many, offer, run.late)
    run.nodes += done.nodes
    run.work += max(done.nodes - settings.free_poses, 0)
    run.timing["search"] += 1e3 * (time.perf_counter() - begin)
    return [path for _, path in sorted(cheapest.values(), key=lambda entry: entry[0])], done


def _programs(run: Run, settings: ParkSettings, paths: list[ArcPath]) -> None:
    """The nonlinear program from several guesses side by side, then the best without its shortest phases, then on a finer grid."""
    if any(not path.arcs for path in paths):
        return  # the car is there already
    fewest = min((path.gear_changes for path in paths), default=0)
    tight_from = settings.tight_from[0 if paths and way_per_gear(paths[0]) < settings.tight_way_m else 1]
    most = settings.starts if fewest < tight_from else 1
    interval_s = settings.fine_s if settings.fine_for[0] <= fewest <= settings.fine_for[1] else INTERVAL_S
    chosen = list(guesses(run.case, paths, settings.guesses, settings.costs, settings.exchange, interval_s, tight_from))
    extra = [guess for guess in chosen if guess.name in ("two arcs", "reverse sigmoid", "a longer slot")]
    best: Exchanged | None = None
    for number, guess in enumerate([*[g for g in chosen if g not in extra][: settings.starts], *extra]):
        if run.late():
            return
        if best is None or guess in extra or (number < most and _another_start(run, settings, best, number)):
            best = _tried(run, settings, guess, best)
    if best is None or best.best is None or best.best.gear_changes > settings.windows.whole_up_to:
        return
    for _ in range(settings.left_out):
        shorter = _without_shortest(run, settings, best)
        if shorter is best:
            break
        best = shorter
    _polished(run, settings, best)


def _another_start(run: Run, settings: ParkSettings, best: Exchanged, number: int) -> bool:
    """Whether one more start is expected to end within the work; the third one not at the cost of the finer grid, which gains more."""
    after = run.work + run.dearest
    if best.best is None or number < 2:
        return after <= settings.work
    finer_grid = settings.polish_iterations * 2 * len(best.best.steps)
    spoils = run.work + finer_grid <= settings.work_polishing < after + finer_grid
    return after <= settings.work and not spoils


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
    if settings.loose_for[0] <= manoeuvre.gear_changes <= settings.loose_for[1]:
        loop = replace(loop, tolerance=settings.loose)
    bounded = _within_work(run, settings, manoeuvre, loop, answered=best is not None)
    done = _offered(
        run, f"nlp from {guess.name}", lambda: improve(run.case, run.world, manoeuvre, settings.costs, bounded, settings.windows)
    )
    return done if done is not None and (best is None or run.value < before) else best


def _without_shortest(run: Run, settings: ParkSettings, best: Exchanged) -> Exchanged:
    """The best manoeuvre without its shortest phase but the first, where that is short and the program gains; else the best itself.

    A short first phase was put in on purpose, or the path has none.
    """
    manoeuvre = best.best
    if manoeuvre is None or manoeuvre.gear_changes < 1 or run.late():
        return best
    if manoeuvre.gear_changes < settings.long_from and run.work + run.dearest > settings.work_polishing:
        return best
    driven = ways(manoeuvre)
    shortest = 1 + int(np.argmin(driven[1:]))
    if driven[shortest] > settings.left_out_m:
        return best
    before, fewer = run.value, without(manoeuvre, shortest)
    bounded = _within_work(run, settings, manoeuvre, settings.exchange)
    done = _offered(run, "nlp, a phase left out", lambda: exchange(run.case, run.world, fewer, settings.costs, bounded))
    return done if done is not None and run.value < before else best


def _polished(run: Run, settings: ParkSettings, best: Exchanged) -> None:
    """The best manoeuvre on a grid of half the spacing, looking from the first round on where it had to look before."""
    manoeuvre = best.best
    if manoeuvre is None or len(manoeuvre.steps) > settings.polish_up_to or run.late():
        return
    halved = in_pieces(finer(run.case, manoeuvre), PIECE)
    expected = run.work + settings.polish_iterations * len(halved.steps)
    if manoeuvre.gear_changes < settings.long_from and expected > settings.work_polishing:
        return
    closely = replace(settings.exchange, trust_m=settings.polish_m, trust_rad=0.5 * settings.polish_m)
    closely = _within_work(run, settings, manoeuvre, closely)
    places = finer_places(best.checked, settings.exchange.per_interval)
    _offered(run, "nlp, finer grid", lambda: exchange(run.case, run.world, halved, settings.costs, closely, checked=places))


def _within_work(
    run: Run, settings: ParkSettings, manoeuvre: Manoeuvre, loop: ExchangeSettings, *, answered: bool = True
) -> ExchangeSettings:
    """What one more program may take; long zigzags take what they take."""
    if manoeuvre.gear_changes >= settings.long_from:
        return loop
    if not answered:
        return replace(loop, work_unsound=settings.work_unanswered)
    rest = max(settings.work_polishing - run.work, 0)
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


def _refused(run: Run, settings: ParkSettings, planner: str, climbed: Climb) -> Parking:
    """A last attempt from the answer of a relieved case; else why not, how near the best attempt came, and what would help."""
    case = run.case
    seen = f"{climbed.nodes:,} poses of {climbed.searches} searches, cells down to {100.0 * climbed.finest_m:g} cm"
    reason = "every cell was searched and none leads home" if climbed.exhausted else "the search's cap on nodes was reached without a path"
    reason += f" ({seen})" if climbed.searches else ""
    if np.isfinite(climbed.left_m):
        reason += f"; from the {climbed.ends[0]} the search came within {climbed.left_m:.1f} m of the {climbed.ends[1]} (a radian as 3 m)"
    if beyond_the_wall(case):
        reason += "; the slot is shorter than the car's diagonal and two clearances, so that only vanishing zigzags are left"
    helps = "no small relief was found that helps; larger caps (`levels`), another start or another goal might"
    found = relief(case, settings.search, run.late)
    if found is not None:
        helps, relieved, path = found
        borrowed = drive(relieved, path).moved(*(case.start - relieved.start)[:2])
        lacking = case.limits.clearance_m - float(run.world.clearance(borrowed.poses).min())
        run.failed("the path of a case with that relief", lacking, borrowed)
        if planner == "nlp":
            helps = _approached(run, settings, relieved, path) or helps
            if run.best is not None:
                trajectory, judgement = run.best
                return run.answer(planner, trajectory, judgement.verdict, judgement.min_clearance_m, status="planned", reason=_story(run))
    violation = Violation(kind=ViolationKind.NO_PATH, t_s=0.0, value=0.0, limit=1.0, unit="")
    if run.nearest is not None:
        lacking, name, violation = run.nearest
        reason += f"; the best attempt ({name}) lacks {100.0 * lacking:.1f} cm: {violation.name} {100.0 * violation.value:.1f} cm"
    return run.answer(planner, None, Verdict(violations=(violation,)), None, status="refused", reason=f"{reason}; {helps}")


def _approached(run: Run, settings: ParkSettings, relieved: ParkingCase, path: ArcPath) -> str:
    """From a relieved case's answer towards the case itself; says how near it came, and offers what it ends with."""
    case = run.case
    solve = replace(settings.exchange, rounds=4, rounds_unsound=6)
    current = standing_start(relieved, path)
    said = ""
    spare = relieved.slot.length_m - case.slot.length_m if relieved.slot is not None and case.slot is not None else 0.0
    if current.gear_changes > settings.many:
        return said
    for share in (1.0, 0.75, 0.5, 0.25):
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


def _closed_form(run: Run, planner: str, make: Callable[[ParkingCase], ParkingTrajectory]) -> Parking:
    trajectory = make(run.case)
    judgement = judge_parking(run.case, trajectory)
    run.offer(planner, trajectory, "", 0.0)
    status = "planned" if judgement.verdict.passed else "refused"
    least = judgement.min_clearance_m
    return run.answer(planner, trajectory, judgement.verdict, least, status=status, reason=judgement.verdict.reason)


def _story(run: Run) -> str:
    sound = [a for a in run.attempts if a.passed]
    programs = [a for a in run.attempts if a.name.startswith("nlp")]
    text = f"{len(sound)} of {len(run.attempts)} attempts are sound"
    if programs:
        converged = sorted(a.duration_s or 0.0 for a in programs if a.passed)
        text += f"; {len(converged)} of {len(programs)} programs converged"
        text += f", to {', '.join(f'{d:.2f}' for d in converged)} s" if converged else ""
    return text + f"; {min(a.duration_s or 0.0 for a in sound):.2f} s is the quickest"
