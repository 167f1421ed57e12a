"""`park`: from a case to a judged answer. The search's answer stands until the program beats it."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from mcdas_opt.domain.arithmetic import usual_arithmetic
from mcdas_opt.domain.parking import Parking, ParkingCase, ParkingTrajectory
from mcdas_opt.domain.rules import require_type_if_given
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.verdict import Verdict, Violation, ViolationKind
from mcdas_opt.errors import ParameterError, blaming, nearest
from mcdas_opt.parking.case_file import the_case
from mcdas_opt.parking.case_variants import lengthened
from mcdas_opt.parking.closed_form import CLOSED_FORMS
from mcdas_opt.parking.path import ArcPath, counted, drive
from mcdas_opt.parking.programs import approach, improve_paths
from mcdas_opt.parking.run import Run
from mcdas_opt.parking.search.arc_search import Resolution, search
from mcdas_opt.parking.search.path_cost import PathCost
from mcdas_opt.parking.search.resolution_refinement import Searched, refine, shorter_than_diagonal, turning_length_m
from mcdas_opt.parking.settings import ParkSettings
from mcdas_opt.parking.world import World
from mcdas_opt.verification.parking_judge import judge_parking

ParkingPlannerName = Literal["nlp", "search", "closed-form", "closed-form-corrected", "two-arc"]
PLANNERS = ("nlp", "search", *CLOSED_FORMS)
_FREE_POSES = 10_000  # of the searches; every pose beyond counts as one unit of the program's work, which takes as long
_LENGTHS_M = (0.05, 0.1, 0.15, 0.2, 0.3, 0.5, 0.8)
_SHARES = (0.5, 0.2, 0.0)
_QUICK = Resolution(cell_m=0.03, max_nodes=12_000, contacts_only=True)


@usual_arithmetic
def park(
    case: str | Path | ParkingCase,
    planner: ParkingPlannerName | str = "nlp",
    *,
    vehicle: str | Vehicle | None = None,
    settings: ParkSettings | None = None,
) -> Parking:
    """One parking plan, judged. `case` may be a shipped name or a path; then `vehicle` (a `Vehicle`, a shipped name or a path) may take the
    place of the case's own. `planner` is one of `PLANNERS`; a case without an answer gives a refusal, which is a value.

    Raises `ParameterError` for an unknown planner, for a vehicle beside a `ParkingCase`, which has its own, and for a case that takes
    longer than anybody parks, or is farther to the side than a closed form reaches (`InputError` where it is a file's); `InputError` for
    a case file that is none, and for a car that does not fit into it.
    """
    check_planner(planner)
    require_type_if_given("settings", settings, ParkSettings)
    if not isinstance(case, ParkingCase):
        found = the_case(case, vehicle)
        with blaming(case):
            return park(found, planner, settings=settings)
    case = the_case(case, vehicle)
    settings = settings or ParkSettings()
    world = World.of(case)
    run = Run(case, world, settings.costs, settings.time_budget_s)
    if planner in CLOSED_FORMS:
        return _closed_form(run, planner, CLOSED_FORMS[planner])
    tight = too_tight(case, world)
    if tight is not None:
        return run.answer(planner, None, Verdict(violations=(tight[1],)), None, status="refused", reason=tight[0])
    paths, searched = _searched(run, settings)
    if planner == "nlp":
        improve_paths(run, settings, paths)
    return _refused(run, settings, planner, searched) if run.best is None else run.planned(planner)


def check_planner(planner: object) -> None:
    """Raises `ParameterError` for what is none of `PLANNERS`."""
    if not isinstance(planner, str) or planner not in PLANNERS:
        raise ParameterError("planner", planner, f"is unknown; {nearest(str(planner), PLANNERS)}")


def _searched(run: Run, settings: ParkSettings) -> tuple[list[ArcPath], Searched]:
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

    done = refine(run.case, run.world, settings.resolutions, offer, run.late)
    run.nodes += done.nodes
    run.work += max(done.nodes - _FREE_POSES, 0)
    run.timing["search"] += 1e3 * (time.perf_counter() - begin)
    return [path for _, path in sorted(cheapest.values(), key=lambda entry: entry[0])], done


def _refused(run: Run, settings: ParkSettings, planner: str, searched: Searched) -> Parking:
    """A last attempt from the answer of a relieved case; else why not, how near the best attempt came, and what would help."""
    case = run.case
    seen = f"{searched.nodes:,} poses of {searched.searches} searches, cells down to {100.0 * searched.finest_m:g} cm"
    reason = "every cell was searched and none leads home" if searched.exhausted else "the search's cap on nodes was reached without a path"
    reason += f" ({seen})" if searched.searches else ""
    if np.isfinite(searched.left_m):
        reason += (
            f"; from the {searched.ends[0]} the search came within {searched.left_m:.1f} m of the {searched.ends[1]} (a radian as 3 m)"
        )
    if shorter_than_diagonal(case):
        reason += "; the slot is shorter than the car's diagonal and two clearances, so that only vanishing zigzags are left"
    helps = "no small relief was found that helps; larger caps (`resolutions`), another start or another goal might"
    found = relief(case, run.late)
    if found is not None:
        helps, relieved, path = found
        borrowed = drive(relieved, path).moved(*(case.start - relieved.start)[:2])
        lacking = case.limits.clearance_m - float(run.world.clearance(borrowed.poses).min())
        run.failed("the path of a case with that relief", lacking, borrowed)
        if planner == "nlp":
            helps = approach(run, settings, relieved, path) or helps
            if run.best is not None:
                return run.planned(planner)
    violation = Violation(kind=ViolationKind.NO_PATH, t_s=0.0, value=0.0, limit=1.0, unit="")
    if run.nearest is not None:
        lacking, name, violation = run.nearest
        reason += f"; the best attempt ({name}) lacks {100.0 * lacking:.1f} cm: {violation.name} {100.0 * violation.value:.1f} cm"
    return run.answer(planner, None, Verdict(violations=(violation,)), None, status="refused", reason=f"{reason}; {helps}")


def _closed_form(run: Run, planner: str, make: Callable[[ParkingCase], ParkingTrajectory]) -> Parking:
    trajectory = make(run.case)
    judgement = judge_parking(run.case, trajectory)
    run.offer(planner, trajectory, "", 0.0)
    status = "planned" if judgement.verdict.passed else "refused"
    least = judgement.min_clearance_m
    return run.answer(planner, trajectory, judgement.verdict, least, status=status, reason=judgement.verdict.reason)


def too_tight(case: ParkingCase, world: World) -> tuple[str, Violation] | None:
    """A proof that no path exists: the start or the goal itself is nearer to an obstacle than asked."""
    asked = case.limits.clearance_m
    for key, kind, pose in (("start", ViolationKind.START_CLEARANCE, case.start), ("goal", ViolationKind.GOAL_CLEARANCE, case.goal)):
        apart = world.whole.separation(pose[None], world.body)[0]
        if apart.size == 0:
            continue
        worst = int(np.argmin(apart))
        least = float(apart[worst])
        if least < asked - 1e-9:
            name = case.names[world.owner[worst]]
            text = f"proved impossible: at the {key} the body is {100 * least:.1f} cm from {name}, {100 * asked:.1f} cm asked"
            if case.slot is not None and key == "goal" and name in ("rear car", "front car"):
                text += f": {_longer(case, 2.0 * (asked - least))}"
            elif case.slot is not None and key == "goal" and name == "kerb":
                deep = math.ceil(100.0 * (case.slot.depth_m + 2.0 * (asked - least)) - 1e-6) / 100.0
                text += f": the slot's depth_m must be {deep:.2f} instead of {case.slot.depth_m:.2f}"
            return text, Violation(kind=kind, t_s=0.0, value=least, limit=asked, unit="m", body=name)
    return None


def _longer(case: ParkingCase, least_m: float) -> str:
    """What a slot has to have more of: bounds, of what the goal asks for and of what the car needs to turn in it."""
    assert case.slot is not None
    turning_m = turning_length_m(case) - case.slot.length_m
    said = f"at least {math.ceil(100.0 * least_m - 1e-6)} cm more length"
    return f"{said}, for room to turn {math.ceil(100.0 * turning_m - 1e-6)} cm" if turning_m > least_m else said


def relief(case: ParkingCase, late: Callable[[], bool]) -> tuple[str, ParkingCase, ArcPath] | None:
    """The least of a few reliefs that lets a quick search through: a longer slot, else less clearance. (words, case, path)"""
    reliefs: list[tuple[str, ParkingCase]] = []
    if case.slot is not None:
        reliefs += [(f"{100 * more:.0f} cm more length would do", lengthened(case, more)) for more in _LENGTHS_M]
    for share in _SHARES:
        limits = replace(case.limits, clearance_m=share * case.limits.clearance_m)
        reliefs.append((f"a clearance of {100 * limits.clearance_m:.1f} cm would do", replace(case, limits=limits)))
    for text, relieved in reliefs:
        if late():
            return None
        found = search(relieved, World.of(relieved), _QUICK, PathCost.of(relieved)).paths
        if found:
            return text, relieved, found[0]
    return None
