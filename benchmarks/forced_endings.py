"""Every way in which an engine can end, forced in closed loop: what leaves is judged, finite and labelled, whatever the engines answer.

    python -m benchmarks.forced_endings --cycles 1000 --workers 2 [--kinds NAME ...]

Random sandwiches are driven through radar noise by a planner whose engines are made to answer as they are told: both of them, or, where
the kind says so, OSQP alone as the engine of choice, with the answer of its own library forged. Counted are exceptions that leave the
planner, NaN in plans, plans whose verdict is not that of a judge asked anew, and fallbacks that do not say that they are. That the car is
hit with dead engines more often than with live ones is no fault: the outcomes stand beside. The last kinds are about the clock: a
deadline long past, and engines that take longer than all of it; by how much the cycles overran it is printed.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from types import SimpleNamespace
from typing import Any

import numpy as np

from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.settings import Settings, WarningSettings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vocabulary import Status
from mcdas_opt.evaluation.families import load_family
from mcdas_opt.planning.mpc import MpcMethod
from mcdas_opt.planning.planner import Planner
from mcdas_opt.planning.solver_settings import SolverSettings
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.solvers.osqp_engine import OsqpEngine
from mcdas_opt.solvers.outcome import Ending, Outcome
from mcdas_opt.solvers.stage_problem import StageGuess
from mcdas_opt.tracking.prediction import predict_for
from mcdas_opt.verification.judge import judge

DEADLINE_S = 0.02
_QUIET = Settings(warning=WarningSettings(escapes=False))  # no engine has a say in the escape map
_ERRORS = (RuntimeError, ValueError, ZeroDivisionError, MemoryError, AssertionError, KeyError, OverflowError)

Solve = Callable[[], Outcome]
Answer = Callable[[Solve, StageGuess, np.random.Generator], Any]


class Told:
    """An engine that answers as it is told; it may ask the true one."""

    def __init__(self, true: Any, answer: Answer, rng: np.random.Generator) -> None:
        self.true, self.answer, self.rng, self.kind = true, answer, rng, getattr(true, "kind", "told")

    def solve(self, x0: Any, p: Any, steps_s: Any, guess: StageGuess, iterations: int | None = None) -> Any:
        cap = 60 if iterations is None else iterations
        return self.answer(lambda most=cap: self.true.solve(x0, p, steps_s, guess, most), guess, self.rng)

    def shifted(self, outcome: Outcome, nodes: int = 1) -> StageGuess:
        return self.true.shifted(outcome, nodes)

    def reset(self) -> None:
        self.true.reset()


def _of(ending: Ending, **columns: Callable[[StageGuess], Any]) -> Answer:
    """The guess with this ending, some of its columns replaced."""

    def answer(solve: Solve, guess: StageGuess, rng: np.random.Generator) -> Outcome:
        changed = {name: make(guess) for name, make in columns.items()}
        return Outcome(**{"ending": ending, "x": guess.x, "u": guess.u, "s": guess.s, "objective": 0.0, **changed})

    return answer


def _inaccurate(solve: Solve, guess: StageGuess, rng: np.random.Generator) -> Outcome:
    """Called solved, and off by some per cent."""
    out = solve()
    return replace(
        out, ending=Ending.CONVERGED, x=out.x * rng.normal(1.0, 0.05, out.x.shape), u=out.u + rng.normal(0.0, 0.3, out.u.shape) * [5.0, 0.2]
    )


def _raises(solve: Solve, guess: StageGuess, rng: np.random.Generator) -> Outcome:
    raise _ERRORS[rng.integers(len(_ERRORS))]("the engine is on fire")


def _slow(solve: Solve, guess: StageGuess, rng: np.random.Generator) -> Outcome:
    time.sleep(1.5 * DEADLINE_S)
    return solve()


def _late(solve: Solve, guess: StageGuess, rng: np.random.Generator) -> Outcome:
    """Ended by a clock of its own, with what it had."""
    return replace(solve(1), ending=Ending.FAILED, message="time limit")


def _at_random(solve: Solve, guess: StageGuess, rng: np.random.Generator) -> Any:
    """Half of the solves are true."""
    if rng.random() < 0.5:
        return solve()
    return ENGINES[str(rng.choice([name for name in ENGINES if name != "any of these, at random"]))](solve, guess, rng)


def _far(guess: StageGuess) -> Any:
    return np.full_like(guess.x, 2e9)


def _nan(guess: StageGuess) -> Any:
    return np.full_like(guess.x, np.nan)


ENGINES: dict[str, Answer] = {
    "solved": lambda solve, guess, rng: solve(),
    "solved inaccurately": _inaccurate,
    "solved, a wrong answer": _of(Ending.CONVERGED),
    "solved, far off": _of(Ending.CONVERGED, x=_far, u=lambda guess: np.full_like(guess.u, -1e12)),
    "iteration limit": lambda solve, guess, rng: solve(1),
    "iteration limit, far off": _of(Ending.LIMIT, x=_far),
    "time limit": _late,
    "infeasible": _of(Ending.INFEASIBLE, x=_far),
    "not finite": _of(Ending.NOT_FINITE, x=_nan),
    "failed": _of(Ending.FAILED),
    "NaN called solved": _of(Ending.CONVERGED, x=_nan),
    "NaN at the iteration limit": _of(Ending.LIMIT, u=lambda guess: np.full_like(guess.u, np.nan)),
    "NaN multipliers": lambda solve, guess, rng: replace(out := solve(), multipliers=np.full_like(out.multipliers, np.nan)),
    "multipliers of another size": lambda solve, guess, rng: replace(solve(), multipliers=np.ones(7)),
    "NaN objective": _of(Ending.LIMIT, objective=lambda guess: float("nan")),
    "exception": _raises,
    "wrong shape": _of(Ending.CONVERGED, x=lambda guess: guess.x[:2]),
    "empty": _of(Ending.CONVERGED, x=lambda guess: np.zeros((0, 0)), u=lambda guess: np.zeros((0, 0))),
    "lists": _of(Ending.CONVERGED, x=lambda guess: guess.x.tolist()),
    "nothing at all": lambda solve, guess, rng: None,
    "any of these, at random": _at_random,
}
MUTE = {  # nothing usable comes from the engines: whatever leaves is a fallback, and says so
    *("time limit", "infeasible", "not finite", "failed", "NaN called solved", "NaN at the iteration limit"),
    *("exception", "wrong shape", "empty", "lists", "nothing at all"),
}

# OSQP's own statuses (1.x), with what it returns beside them
_STATUS = {
    "solved": 1,
    "solved inaccurate": 2,
    "primal infeasible": 3,
    "primal infeasible inaccurate": 4,
    "dual infeasible": 5,
    "dual infeasible inaccurate": 6,
    "maximum iterations reached": 7,
    "time limit reached": 8,
    "problem non convex": 9,
    "interrupted": 10,
    "unsolved": 11,
}


class ToldOsqp(OsqpEngine):
    """The engine as it is, on a library whose every answer has this status and, drawn anew, one of these points."""

    def __init__(self, true: OsqpEngine, status: str, points: tuple[str, ...], rng: np.random.Generator) -> None:
        vars(self).update(vars(true))
        self.status, self.points, self.rng = status, points, rng

    def _qp(self, qp: Any, z: Any, y: Any) -> Any:
        result = super()._qp(qp, z, y)
        x, dual = np.array(result.x), np.array(result.y)
        point = str(self.rng.choice(self.points))
        if point == "off":
            x = x * self.rng.normal(1.0, 0.02, x.shape)
        elif point == "far":
            x = np.full_like(x, 2e9)
        elif point == "NaN":
            x = np.full_like(x, np.nan)
        elif point == "short":
            x = x[:5]
        elif point == "NaN dual":
            dual = np.full_like(dual, np.nan)
        info = SimpleNamespace(iter=result.info.iter, status_val=_STATUS[self.status], status=self.status)
        return SimpleNamespace(x=x, y=dual, info=info)


_READ = ("solved", "solved inaccurate", "maximum iterations reached")  # statuses whose point is looked at
LIBRARY = {
    f"OSQP: {status}": (status, ("as it is", "off", "far", "NaN", "short", "NaN dual") if status in _READ else ("as it is", "far", "NaN"))
    for status in _STATUS
}
CLOCK: dict[str, tuple[float, Answer]] = {
    "deadline long past": (1e-9, ENGINES["solved"]),
    "deadline of 20 ms": (DEADLINE_S, ENGINES["solved"]),
    "deadline of 20 ms, every solve takes 30": (DEADLINE_S, _slow),
    "deadline of 20 ms, every solve takes 30 and fails": (DEADLINE_S, lambda solve, guess, rng: (_slow(solve, guess, rng), None)[1]),
}
KINDS = (*ENGINES, *LIBRARY, *CLOCK)


@dataclass
class Found:
    """What was counted over the cycles of one kind; `late_ms` is by how much each of them overran its deadline."""

    kind: str
    counts: Counter[str] = field(default_factory=Counter)
    late_ms: list[float] = field(default_factory=list)
    told: list[str] = field(default_factory=list)

    @property
    def faults(self) -> int:
        return sum(count for name, count in self.counts.items() if name.startswith("fault"))

    def fault(self, what: str, where: str) -> None:
        self.counts[f"fault: {what}"] += 1
        self.told.append(f"{what} at {where}")


class Watched(Planner):
    """A planner whose every plan is looked at."""

    def __init__(self, found: Found, **settings: Any) -> None:
        super().__init__(**settings)
        self.found = found
        self.drive = ""

    def plan(self, situation: Situation) -> Plan:
        found, where = self.found, f"{self.drive}, {situation.time_s:.1f} s"
        started = time.perf_counter()
        try:
            plan = super().plan(situation)
        except Exception as error:
            found.fault(f"exception {type(error).__name__}", where)
            raise
        if self.deadline_s is not None:
            found.late_ms.append(1e3 * max(time.perf_counter() - started - self.deadline_s, 0.0))
        found.counts["cycles"] += 1
        found.counts[plan.status.value] += 1
        if not all(np.isfinite(column).all() for column in (plan.trajectory.t_s, plan.trajectory.states, plan.trajectory.inputs)):
            found.fault("NaN", where)
        try:
            json.dumps(plan.to_dict(), allow_nan=False)
        except ValueError:
            found.fault("NaN in the document", where)
        prediction = predict_for(situation, self.settings.prediction)
        again = judge(plan.trajectory, situation.host, self.vehicle, situation.road, prediction)
        if again != plan.verdict or again.passed == (plan.status is Status.UNAVOIDABLE):
            found.fault("unverified", where)
        if plan.status is Status.FALLBACK and not ("instead of" in plan.reason or "no safe end" in plan.reason):
            found.fault("fallback without its label", where)
        if plan.status is Status.UNAVOIDABLE and "nothing passes" not in plan.reason:
            found.fault("unavoidable without its label", where)
        if found.kind in MUTE and plan.status is Status.PLANNED:
            found.fault("planned by nobody", where)
        return plan


@lru_cache(maxsize=2)
def _true_method(solver: str) -> MpcMethod:
    """Built once a process; its engines are lent to the planners of all kinds, one after the other."""
    return MpcMethod(load_vehicle("sedan"), _QUIET, SolverSettings(solver=solver))


def planner_of(kind: str, found: Found, seed: int) -> Watched:
    """A planner whose engines do as the kind says."""
    deadline, answer = CLOCK.get(kind, (None, ENGINES.get(kind)))
    true = _true_method("osqp" if kind in LIBRARY else "interior-point")
    method = MpcMethod(true.vehicle, _QUIET, true.solvers.usual.own)
    rng = np.random.default_rng(seed)
    for slots in method.solvers.usual.own.slots:
        engines = true.solvers.usual.problems.holding(slots, true.vehicle)
        told = vars(method.solvers.usual.problems.holding(slots, true.vehicle))
        engines.osqp.reset()
        if answer is None:
            told["osqp"] = ToldOsqp(engines.osqp, *LIBRARY[kind], rng)
        else:
            told |= {name: Told(getattr(engines, name), answer, rng) for name in ("interior_point", "osqp")}
    return Watched(found, method=method, settings=_QUIET, deadline_s=deadline)


def force(kind: str, cycles: int, seed: int = 1, family: str = "sandwich") -> Found:
    """Drives scenes until so many cycles are done."""
    found = Found(kind)
    planner, scenes = planner_of(kind, found, seed), load_family(family)
    index = 0
    while (left := cycles - found.counts["cycles"] - found.faults) > 0:
        scene = scenes.scene(index, seed)
        scene = scene.model_copy(update={"duration_s": min(scene.duration_s, round(left * _QUIET.cycle_s, 9))})
        planner.drive = f"{family} {index} of seed {seed}"
        try:
            drive = simulate(scene, planner, settings=_QUIET)
            found.counts[f"drives {drive.outcome.value}"] += 1
        except Exception as error:  # told of by the planner already, where it was the planner's
            found.counts[f"drives ended by {type(error).__name__}"] += 1
        index += 1
    return found


def _task(task: tuple[str, int, int]) -> Found:
    return force(*task)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cycles", type=int, default=1000, help="of each kind")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--kinds", nargs="+", default=KINDS, metavar="NAME")
    asked = parser.parse_args()
    tasks = [(kind, asked.cycles, asked.seed) for kind in asked.kinds]
    total: Counter[str] = Counter()
    print(f"{'kind':>52} {'cycles':>7} {'faults':>7} {'planned':>8} {'fallback':>9} {'unavoidable':>12}   drives")
    with multiprocessing.get_context("spawn").Pool(asked.workers) as pool:
        for found in pool.imap(_task, tasks):
            count = found.counts
            drives = ", ".join(f"{n} {name[7:]}" for name, n in sorted(count.items()) if name.startswith("drives"))
            line = f"{found.kind:>52} {count['cycles']:>7} {found.faults:>7} {count['planned']:>8} {count['fallback']:>9}"
            print(f"{line} {count['unavoidable']:>12}   {drives}", flush=True)
            if found.late_ms:
                late = np.array(found.late_ms)
                over = " ".join(f"{value:.1f}" for value in np.percentile(late, (50, 99, 100)))
                print(f"{'':>52} cycles over the deadline: {int((late > 0.0).sum())}; by ms, median p99 max: {over}", flush=True)
            for told in found.told[:5]:
                print(f"{'':>52} {told}")
            total += count
    faults = {name: n for name, n in total.items() if name.startswith("fault")}
    print(f"{total['cycles']} cycles of {len(tasks)} kinds: {sum(faults.values())} faults {faults or ''}")


if __name__ == "__main__":
    main()
