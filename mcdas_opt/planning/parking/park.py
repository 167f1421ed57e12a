"""`park`: from a case to a judged answer. The search's answer stands until the program beats it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from mcdas_opt.domain.parking import Parking, ParkingAttempt, ParkingCase, ParkingTrajectory
from mcdas_opt.domain.verdict import Verdict, Violation
from mcdas_opt.errors import ParameterError, nearest
from mcdas_opt.ocp.parking import ParkingCosts
from mcdas_opt.planning.parking.closed_form import CLOSED_FORMS
from mcdas_opt.planning.parking.costs import PathCost
from mcdas_opt.planning.parking.exchange import ExchangeSettings
from mcdas_opt.planning.parking.ladder import LEVELS, Level, beyond_the_wall, climb
from mcdas_opt.planning.parking.manoeuvre import standing_start
from mcdas_opt.planning.parking.path import ArcPath, drive
from mcdas_opt.planning.parking.search import SearchSettings, search
from mcdas_opt.planning.parking.windows import WindowSettings, improve
from mcdas_opt.planning.parking.world import World
from mcdas_opt.verification.parking_judge import Judgement, judge_parking

_SHORT_M = 5e-5
PLANNERS = ("nlp", "search", *CLOSED_FORMS)


@dataclass(frozen=True, slots=True, kw_only=True)
class ParkSettings:
    """All caps are counts, so that the same case gives the same answer; a time budget is an extra cap and is reported when it bit."""

    costs: ParkingCosts = field(default_factory=ParkingCosts)
    search: SearchSettings = field(default_factory=SearchSettings)
    exchange: ExchangeSettings = field(default_factory=ExchangeSettings)
    windows: WindowSettings = field(default_factory=WindowSettings)
    levels: tuple[Level, ...] = LEVELS
    starts: int = 3  # guesses that the program is started from
    starts_tight: int = 1  # the same, for paths with more gear changes than ...
    tight_from: int = 7
    time_budget_s: float | None = None


@dataclass(slots=True)
class _Run:
    """What one call gathers on its way."""

    case: ParkingCase
    settings: ParkSettings
    began: float
    attempts: list[ParkingAttempt] = field(default_factory=list)
    best: tuple[ParkingTrajectory, Judgement] | None = None
    nodes: int = 0
    iterations: int = 0
    timing: dict[str, float] = field(default_factory=lambda: {"total": 0.0, "search": 0.0, "solve": 0.0, "verify": 0.0, "first": 0.0})
    out_of_time: bool = False

    def offer(self, name: str, trajectory: ParkingTrajectory, note: str, seconds: float) -> bool:
        """Judge a trajectory and keep it when it is sound and the fastest so far."""
        begin = time.perf_counter()
        judgement = judge_parking(self.case, trajectory)
        self.timing["verify"] += 1e3 * (time.perf_counter() - begin)
        least, asked = judgement.min_clearance_m, self.case.limits.clearance_m
        short = least is not None and least < asked - _SHORT_M  # the judge's tolerance is not ours to use
        passed = judgement.verdict.passed and not short
        said = note if passed else f"clearance {least:.4f} m, {asked:g} m asked" if judgement.verdict.passed else judgement.verdict.reason
        self.attempts.append(
            ParkingAttempt(
                name=name,
                duration_s=trajectory.duration_s,
                gear_changes=trajectory.gear_changes,
                passed=passed,
                note=said,
                seconds=round(seconds, 3),
            )
        )
        if passed and (self.best is None or trajectory.duration_s < self.best[0].duration_s):
            if self.best is None:
                self.timing["first"] = 1e3 * (time.perf_counter() - self.began)
            self.best = (trajectory, judgement)
        return passed

    def late(self) -> bool:
        budget = self.settings.time_budget_s
        if budget is not None and time.perf_counter() - self.began > budget:
            self.out_of_time = True
        return self.out_of_time


def park(case: ParkingCase, planner: str = "nlp", *, settings: ParkSettings | None = None) -> Parking:
    """One parking plan, judged. `planner` is one of `PLANNERS`; a case without an answer gives a refusal, which is a value.

    Raises `ParameterError` for an unknown planner.
    """
    if planner not in PLANNERS:
        raise ParameterError("planner", planner, f"is unknown; {nearest(planner, PLANNERS)}")
    run = _Run(case, settings or ParkSettings(), time.perf_counter())
    if planner in CLOSED_FORMS:
        return _closed_form(run, planner, CLOSED_FORMS[planner])
    world = World.of(case)
    tight = _too_tight(case, world)
    if tight is not None:
        return _refused(run, planner, tight[0], tight[1])
    paths, exhausted = _searched(run, world)
    if planner == "nlp":
        _programs(run, world, paths)
    if run.best is None:
        reason = "every cell was searched and none leads home" if exhausted else "the search's cap on nodes was reached without a path"
        if beyond_the_wall(case):
            reason += "; the slot is shorter than the car's diagonal and two clearances, so that only vanishing zigzags are left"
        return _refused(run, planner, f"{reason}; {_what_would_help(run)}", None)
    return _answer(run, planner, *run.best, status="planned", reason=_story(run))


def _searched(run: _Run, world: World) -> tuple[list[ArcPath], bool]:
    """Sound paths, quickest first, one for each number of gear changes, and whether the last search saw everything."""
    begin = time.perf_counter()
    settings = run.settings
    quickest: dict[int, tuple[float, ArcPath]] = {}

    def offer(path: ArcPath) -> bool:
        driven = drive(run.case, path)
        sound = run.offer(f"search, {path.gear_changes} gear changes", driven, "stops for every change of steering", 0.0)
        if sound and driven.duration_s < quickest.get(path.gear_changes, (np.inf, path))[0]:
            quickest[path.gear_changes] = (driven.duration_s, path)
        return sound

    done = climb(run.case, world, settings.levels, settings.search, settings.windows.whole_up_to, offer, run.late)
    run.nodes += done.nodes
    run.timing["search"] += 1e3 * (time.perf_counter() - begin)
    return [path for _, path in sorted(quickest.values(), key=lambda entry: entry[0])], done.exhausted


def _programs(run: _Run, world: World, paths: list[ArcPath]) -> None:
    """The nonlinear program from several paths; every sound result is offered."""
    settings = run.settings
    many = bool(paths) and min(path.gear_changes for path in paths) > settings.tight_from
    for path in paths[: settings.starts_tight if many else settings.starts]:
        if run.late() or not path.arcs:
            break
        begin = time.perf_counter()
        done = improve(run.case, world, standing_start(run.case, path), settings.costs, settings.exchange, settings.windows)
        seconds = time.perf_counter() - begin
        run.timing["solve"] += 1e3 * seconds
        run.iterations += done.iterations
        outcome = done.best if done.best is not None else done.last
        note = f"{done.rounds} rounds, {done.iterations} iterations"
        run.offer(f"nlp from {path.gear_changes} gear changes", outcome.trajectory(run.case), note, seconds)


def _too_tight(case: ParkingCase, world: World) -> tuple[str, Violation] | None:
    """A proof that no path exists: the start or the goal itself is nearer to an obstacle than asked."""
    asked = case.limits.clearance_m
    for key, pose in (("start", case.start), ("goal", case.goal)):
        apart = world.whole.separation(pose[None], world.body)[0]
        if apart.size == 0:
            continue
        worst = int(np.argmin(apart))
        least = float(apart[worst])
        if least < asked - 1e-9:
            name = case.names[world.owner[worst]]
            text = f"proved impossible: at the {key} the body is {100 * least:.1f} cm from {name}, {100 * asked:.1f} cm asked"
            if case.slot is not None and key == "goal" and name in ("rear car", "front car"):
                text += f": {200 * (asked - least):.0f} cm more length"
            return text, Violation(name=f"clearance at the {key}: distance to {name}", t_s=0.0, value=least, limit=asked, unit="m")
    return None


def _what_would_help(run: _Run) -> str:
    """The least of a few reliefs that lets a quick search through: a longer slot, else less clearance."""
    case, settings = run.case, run.settings
    quick = replace(settings.search, cell_m=0.03, cell_rad=0.015, max_nodes=20_000)
    reliefs: list[tuple[str, ParkingCase]] = []
    if case.slot is not None:
        for more in (0.05, 0.1, 0.15, 0.2, 0.3, 0.5, 0.8):
            slot = replace(case.slot, length_m=case.slot.length_m + more)
            shift = np.array([0.5 * more, 0.0, 0.0])
            obstacles = (*slot.obstacles, *case.obstacles[4:])
            longer = replace(case, slot=slot, obstacles=obstacles, goal=case.goal + shift, start=case.start + 2.0 * shift)
            reliefs.append((f"{100 * more:.0f} cm more length would do", longer))
    for share in (0.5, 0.2, 0.0):
        limits = replace(case.limits, clearance_m=share * case.limits.clearance_m)
        reliefs.append((f"a clearance of {100 * limits.clearance_m:.1f} cm would do", replace(case, limits=limits)))
    for text, relieved in reliefs:
        if run.late():
            break
        if search(relieved, World.of(relieved), quick, PathCost.of(relieved)).paths:
            return text
    return "no small relief was found that helps"


def _closed_form(run: _Run, planner: str, make: Callable[[ParkingCase], ParkingTrajectory]) -> Parking:
    trajectory = make(run.case)
    judgement = judge_parking(run.case, trajectory)
    run.offer(planner, trajectory, "", 0.0)
    status = "planned" if judgement.verdict.passed else "refused"
    return _answer(run, planner, trajectory, judgement, status=status, reason=judgement.verdict.reason)


def _story(run: _Run) -> str:
    sound = [a for a in run.attempts if a.passed]
    text = f"{len(sound)} of {len(run.attempts)} attempts are sound, {min(a.duration_s or 0.0 for a in sound):.2f} s is the quickest"
    return text + ("; the time budget bit" if run.out_of_time else "")


def _answer(run: _Run, planner: str, trajectory: ParkingTrajectory, judgement: Judgement, *, status: str, reason: str) -> Parking:
    case = run.case
    run.timing["total"] = 1e3 * (time.perf_counter() - run.began)
    dx, dy = case.origin_m
    return Parking(
        planner=planner,
        status=status,
        reason=reason,
        verdict=judgement.verdict,
        duration_s=trajectory.duration_s,
        path_m=trajectory.path_m,
        gear_changes=trajectory.gear_changes,
        min_clearance_m=judgement.min_clearance_m,
        obstacles=tuple(outline + np.array([dx, dy]) for outline in case.obstacles),
        trajectory=trajectory.moved(dx, dy),
        attempts=tuple(run.attempts),
        notes=case.notes,
        timing_ms=run.timing,
        nodes=run.nodes,
        iterations=run.iterations,
    )


def _refused(run: _Run, planner: str, reason: str, violation: Violation | None) -> Parking:
    case = run.case
    run.timing["total"] = 1e3 * (time.perf_counter() - run.began)
    found = violation or Violation(name="no path found", t_s=0.0, value=0.0, limit=1.0, unit="")
    return Parking(
        planner=planner,
        status="refused",
        reason=reason + ("; the time budget bit" if run.out_of_time else ""),
        verdict=Verdict(violations=(found,)),
        duration_s=None,
        path_m=None,
        gear_changes=None,
        min_clearance_m=None,
        obstacles=tuple(outline + np.array(case.origin_m) for outline in case.obstacles),
        trajectory=None,
        attempts=tuple(run.attempts),
        notes=case.notes,
        timing_ms=run.timing,
        nodes=run.nodes,
        iterations=run.iterations,
    )
