"""What one call of `park` gathers: attempts, the best answer so far, without the legs that a program left behind, and what it took."""

from __future__ import annotations

import time
from dataclasses import dataclass, field

import numpy as np

from mcdas_opt.domain.parking import LEAST_LEG_M, Parking, ParkingAttempt, ParkingCase, ParkingTrajectory
from mcdas_opt.domain.verdict import Verdict, Violation, ViolationKind
from mcdas_opt.parking.cost import ParkingCosts, trajectory_cost
from mcdas_opt.parking.path import sampled
from mcdas_opt.parking.soundness import close_fits, is_sound
from mcdas_opt.parking.world import World
from mcdas_opt.verification.parking_judge import Judgement, judge_parking

_SHORT_LEGS_M = (0.01, LEAST_LEG_M)  # legs shorter than this are taken out together, if that is sound


@dataclass(slots=True)
class Run:
    """The search's answer stands until the program beats it."""

    case: ParkingCase
    world: World
    costs: ParkingCosts
    budget_s: float | None
    began: float = field(default_factory=time.perf_counter)
    attempts: list[ParkingAttempt] = field(default_factory=list)
    best: tuple[ParkingTrajectory, Judgement] | None = None
    value: float = np.inf
    nearest: tuple[float, str, Violation] | None = None  # the least violation of an attempt that failed, and whose
    nodes: int = 0
    iterations: int = 0
    work: int = 0  # iterations times intervals, of all programs, and poses of a long search ...
    dearest: int = 0  # ... and of the one that took most
    timing: dict[str, float] = field(default_factory=lambda: {"total": 0.0, "search": 0.0, "solve": 0.0, "verify": 0.0, "first": 0.0})
    out_of_time: bool = False

    def offer(self, name: str, trajectory: ParkingTrajectory, note: str, seconds: float) -> bool:
        """Judge a trajectory and keep it when it is sound and the cheapest so far."""
        begin = time.perf_counter()
        judgement = judge_parking(self.case, trajectory)
        self.timing["verify"] += 1e3 * (time.perf_counter() - begin)
        least, asked = judgement.min_clearance_m, self.case.limits.clearance_m
        passed = is_sound(judgement, asked)
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
        if passed:
            value = trajectory_cost(trajectory, self.costs, self.world, asked)
            if self.best is None:
                self.timing["first"] = 1e3 * (time.perf_counter() - self.began)
            if value < self.value:
                self.best, self.value = (trajectory, judgement), value
        return passed

    def failed(self, name: str, lacking_m: float, trajectory: ParkingTrajectory) -> None:
        """Remember an attempt of the program that ended `lacking_m` short of what was asked."""
        if self.nearest is not None and self.nearest[0] <= lacking_m:
            return
        found = judge_parking(self.case, trajectory).verdict.violations
        too_near = (v for v in found if v.kind in (ViolationKind.CLEARANCE, ViolationKind.PUBLISHED_CLEARANCE))
        worst = next(too_near, found[0] if found else None)
        if worst is not None and np.isfinite(lacking_m):
            self.nearest = (lacking_m, name, worst)

    def late(self) -> bool:
        if self.budget_s is not None and time.perf_counter() - self.began > self.budget_s:
            self.out_of_time = True
        return self.out_of_time

    def planned(self, planner: str) -> Parking:
        """The best answer so far, which there must be, without legs of next to no length."""
        self._take_out_short_legs()
        assert self.best is not None
        trajectory, judgement = self.best
        return self.answer(
            planner, trajectory, judgement.verdict, judgement.min_clearance_m, status="planned", reason=_story(self.attempts)
        )

    def _take_out_short_legs(self) -> None:
        """A program cannot leave a gear out, only shorten its leg: to some micrometres, which no driver drives."""
        if self.best is None:
            return
        for shorter_than_m in _SHORT_LEGS_M:
            begin = time.perf_counter()
            driven = standing_instead(self.case, self.best[0], shorter_than_m)
            if driven is None:
                return
            judgement = judge_parking(self.case, driven)
            seconds = time.perf_counter() - begin
            self.timing["verify"] += 1e3 * seconds
            if is_sound(judgement, self.case.limits.clearance_m):
                self.best = driven, judgement
                self.value = trajectory_cost(driven, self.costs, self.world, self.case.limits.clearance_m)
                self.attempts.append(
                    ParkingAttempt(
                        name=f"the best, without legs shorter than {1e3 * shorter_than_m:g} mm",
                        duration_s=driven.duration_s,
                        gear_changes=driven.gear_changes,
                        passed=True,
                        note="stands and steers instead",
                        seconds=round(seconds, 3),
                    )
                )
                return

    def answer(
        self, planner: str, trajectory: ParkingTrajectory | None, verdict: Verdict, least_m: float | None, *, status: str, reason: str
    ) -> Parking:
        """In the coordinates of the case's file."""
        self.timing["total"] = 1e3 * (time.perf_counter() - self.began)
        dx, dy = self.case.origin_m
        return Parking(
            planner=planner,
            status=status,
            reason=reason + ("; the time budget was reached" if self.out_of_time else ""),
            verdict=verdict,
            duration_s=None if trajectory is None else trajectory.duration_s,
            path_m=None if trajectory is None else trajectory.path_m,
            gear_changes=None if trajectory is None else trajectory.gear_changes,
            min_clearance_m=least_m,
            asked_clearance_m=self.case.limits.clearance_m,
            obstacles=tuple(outline + np.array([dx, dy]) for outline in self.case.obstacles),
            trajectory=None if trajectory is None else trajectory.moved(dx, dy),
            attempts=tuple(self.attempts),
            notes=(*self.case.notes, *close_fits(self.case)),
            timing_ms=self.timing,
            nodes=self.nodes,
            iterations=self.iterations,
            case=self.case,
        )


def _story(attempts: list[ParkingAttempt]) -> str:
    """How many attempts are sound, what the programs came to, and which is the quickest."""
    sound = [a for a in attempts if a.passed]
    programs = [a for a in attempts if a.name.startswith("nlp")]
    text = f"{len(sound)} of {len(attempts)} attempts are sound"
    if programs:
        converged = sorted(a.duration_s or 0.0 for a in programs if a.passed)
        text += f"; {len(converged)} of {len(programs)} programs converged"
        text += f", to {', '.join(f'{d:.2f}' for d in converged)} s" if converged else ""
    return text + f"; {min(a.duration_s or 0.0 for a in sound):.2f} s is the quickest"


def standing_instead(case: ParkingCase, driven: ParkingTrajectory, shorter_than_m: float) -> ParkingTrajectory | None:
    """The manoeuvre without its legs shorter than that [m]; None where it has none, or no others.

    In their place the car stands as long as steering takes; after the last leg that is left there is nothing. Every pose that follows is
    moved by what is not driven: the judge says whether that can be.
    """
    legs = driven.legs
    short = [leg for leg in legs if abs(leg.length_m) < shorter_than_m]
    if not short or len(short) == len(legs):
        return None
    t = np.unique(np.concatenate([driven.t_s, [leg.from_s for leg in short], [leg.until_s for leg in short]]))
    if legs[-1] in short:
        t = t[t <= max(leg.until_s for leg in legs if leg not in short)]
    v, delta = np.interp(t, driven.t_s, driven.speed_mps), np.interp(t, driven.t_s, driven.steering_rad)
    dt = np.diff(t)
    turning_s = np.abs(np.diff(delta)) / case.vehicle.steering_rate_max_radps
    for leg in short:
        v[(t >= leg.from_s) & (t <= leg.until_s)] = 0.0
        inside = (t[:-1] >= leg.from_s) & (t[1:] <= leg.until_s)
        dt[inside] = turning_s[inside]
    return sampled(case, np.concatenate([[0.0], np.cumsum(dt)]), v, delta)
