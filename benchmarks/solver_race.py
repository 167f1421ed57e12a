"""Engines against one another on the same lane problems, in one process: time, iterations, cost over converged IPOPT, growth.

    python -m benchmarks.solver_race [--loops 1] [--cold 20] [--neighbours 3] [--repeats 3] [--parts replay,closed,cold,growth,others]
        [--only WORDS: solvers whose name holds them]

Other solvers (fatrop; piqp, do-mpc and acados, where they are installed) run on the same problems; a line says who is left out.

replay: noisy closed loops with two events each, recorded once; every engine solves all of their problems with its own warm starts.
closed: every engine but IPOPT drives the loops itself (a replay alone would punish whoever prefers another way round).
cold: random evasions from the cold guess, against the best of two IPOPT starts.
growth: time of a Newton step over horizon and neighbours, with the slope of the logarithms; others: of a whole solve, by every solver.
Cost of an answer: its inputs driven through the dynamics, with the least slacks. Times are a call's, from Python, with the warm start's
shift; "cpu" is the thread's own time, which other processes disturb less. acados' own clock, where it has a line, leaves Python out.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import casadi as ca
import numpy as np

from benchmarks.acados_engine import AcadosEngine
from benchmarks.do_mpc_engine import DoMpcEngine
from benchmarks.fatrop_engine import FatropEngine
from benchmarks.lane_situations import NoisyLoop, Posed, evasion, lane_problem, posed
from benchmarks.piqp_engine import PiqpEngine
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.situation import Situation
from mcdas_opt.planning.candidate import Proposed
from mcdas_opt.solvers.interior_point import InteriorPointEngine
from mcdas_opt.solvers.ipopt_engine import IpoptEngine
from mcdas_opt.solvers.linearisation import Linearisation
from mcdas_opt.solvers.osqp_engine import OsqpEngine
from mcdas_opt.solvers.outcome import Ending, Outcome
from mcdas_opt.solvers.stage_problem import StageGuess, StageProblem

NODES = 40


@dataclass(frozen=True, slots=True)
class Answer:
    """One timed solve."""

    outcome: Outcome
    wall_s: float
    cpu_s: float


class Route:
    """An engine with its own warm start; cold at events and after a solve that did not converge."""

    def __init__(self, name: str, engine: Any, problem: StageProblem, warm: int, event: int) -> None:
        self.name, self.engine, self.problem = name, engine, problem
        self.caps = warm, event
        self._last: Outcome | None = None

    def restart(self) -> None:
        self._last = None
        if hasattr(self.engine, "reset"):
            self.engine.reset()

    def step(self, situation: Situation, proposed: Proposed, event: bool) -> Answer:
        last = self._last
        warm = last is not None and not event and last.ending in (Ending.CONVERGED, Ending.LIMIT)
        wall, cpu = time.perf_counter(), time.thread_time()
        guess = self._shifted(last) if warm and last is not None else None
        wall, cpu = time.perf_counter() - wall, time.thread_time() - cpu
        q = posed(situation, proposed, self.problem, NODES, guess)
        wall_from, cpu_from = time.perf_counter(), time.thread_time()
        self._last = self.engine.solve(q.x0, q.p, q.steps, q.guess, self.caps[0 if warm else 1])
        wall, cpu = wall + time.perf_counter() - wall_from, cpu + time.thread_time() - cpu_from
        return Answer(self._last, wall, cpu)

    def _shifted(self, last: Outcome) -> StageGuess:
        if hasattr(self.engine, "shifted"):
            return self.engine.shifted(last)
        x, u, s = last.x, last.u, last.s
        return StageGuess(x=np.vstack([x[1:], 2.0 * x[-1] - x[-2]]), u=np.vstack([u[1:], 0.0 * u[-1:]]), s=np.vstack([s[1:], s[-1:]]))


class Price:
    """What inputs cost when they are driven: no gap in the dynamics, least slacks."""

    def __init__(self, problem: StageProblem, nodes: int) -> None:
        x, u, p, h = ca.SX.sym("x", problem.nx), ca.SX.sym("u", problem.nu), ca.SX.sym("p", len(problem.parameters)), ca.SX.sym("h")
        step = ca.Function("step", [x, u, p, h], [problem.dynamics(x, u, p, h)])
        self._drive, self._own, self._problem = step.mapaccum(nodes), Linearisation(problem, nodes), problem

    def of(self, u: Array, q: Posed) -> float:
        u = np.clip(u, self._problem.u_lower, self._problem.u_upper)
        x = np.vstack([q.x0, np.asarray(self._drive(q.x0, u.T, q.p[:-1].T, q.steps[None, :])).T])
        return self._own.objective(x, u, self._own.slacks(x, u, q.p), q.p)

    def realised(self, x: Array, u: Array, p: Array) -> float:
        """Of the one stage that was really driven."""
        problem = self._problem
        r, g = (np.asarray(f(x, u, p)).ravel() for f in (problem.residual, problem.inequality))
        s = np.zeros(problem.ns)
        np.maximum.at(s, list(problem.slack_of), g)
        return float(0.5 * r @ r + s @ problem.slack_linear + 0.5 * s**2 @ problem.slack_quadratic)


def routes(problem: StageProblem, only: str, ipopt: bool = True) -> list[Route]:
    """Those whose name holds the words `only`."""
    made = [
        Route("interior point, compiled", InteriorPointEngine(problem, NODES), problem, 60, 60),
        Route("interior point, interpreted", InteriorPointEngine(problem, NODES, compiled=False), problem, 60, 60),
        Route("OSQP, 3 steps, 8 at events", OsqpEngine(problem, NODES), problem, 3, 8),
        Route("OSQP, 1 step, 8 at events", OsqpEngine(problem, NODES), problem, 1, 8),
    ]
    if ipopt:
        made.append(Route("IPOPT", IpoptEngine(problem, NODES), problem, 300, 300))
    if made[0].engine.kind != "compiled":
        print(f"not compiled: {made[0].engine.reason}")
    return [route for route in made if only in route.name] + others(problem, only)


def others(problem: StageProblem, only: str) -> list[Route]:
    """Solvers that are not the package's own, as far as they are installed."""
    made = []
    for name, engine, warm, event in (
        ("piqp, 3 steps, 8 at events", PiqpEngine, 3, 8),
        ("fatrop", FatropEngine, 0, 0),
        ("do-mpc", DoMpcEngine, 0, 0),
        ("acados", AcadosEngine, 0, 0),
        ("acados, rows' curvature", partial(AcadosEngine, curved=True), 0, 0),
    ):
        if only not in name:
            continue
        try:
            made.append(Route(name, engine(problem, NODES), problem, warm, event))
        except (RuntimeError, ImportError) as error:
            print(f"{name} is left out: {error}")
    return made


def percentiles(seconds: list[float], shares: tuple[float, ...] = (50, 95, 99, 100)) -> str:
    return " ".join(f"{1e3 * v:8.3f}" for v in np.percentile(seconds, shares))


def replay(problem: StageProblem, loops: int, neighbours: int, repeats: int, only: str) -> None:
    price, driver, oracle = Price(problem, NODES), InteriorPointEngine(problem, NODES), IpoptEngine(problem, NODES)
    recorded: list[tuple[Situation, Proposed, bool]] = []
    best: list[tuple[Posed, float]] = []
    for seed in range(loops):
        loop, last = NoisyLoop(seed, neighbours), None
        for situation, proposed, event in loop.run():
            recorded.append((situation, proposed, event))
            q = posed(situation, proposed, problem, NODES, driver.shifted(last) if last is not None and not event else None)
            last = driver.solve(q.x0, q.p, q.steps, q.guess)
            cold = posed(situation, proposed, problem, NODES)
            near = StageGuess(x=last.x, u=last.u, s=last.s)
            found = [oracle.solve(q.x0, q.p, q.steps, guess) for guess in (near, cold.guess)]
            fair = posed(situation, proposed, problem, NODES, near)
            costs = [price.of(o.u, fair) for o in found if o.ending is Ending.CONVERGED]
            best.append((fair, min(costs, default=float("nan"))))
            loop.drive(last.u[0])
    known = np.array([cost for _, cost in best])
    print(
        f"\nreplay: {len(recorded)} problems of {loops} noisy loops, {neighbours} neighbours; IPOPT converged on {np.isfinite(known).sum()}"
    )
    print(f"{'':28}  ms median      p95      p99      max | cpu median     p99 | it med max | excess: sum %  worst step % | not converged")
    for route in routes(problem, only):
        answers: list[Answer] = []
        for _ in range(repeats if route.name.startswith(("interior", "OSQP")) else 1):
            route.restart()
            answers += [route.step(*recorded_step) for recorded_step in recorded]
        costs = np.array([price.of(a.outcome.u, q) for a, (q, _) in zip(answers, best, strict=False)])
        ok = np.isfinite(known)
        its = [a.outcome.iterations for a in answers]
        print(
            f"{route.name:28} {percentiles([a.wall_s for a in answers])} | {percentiles([a.cpu_s for a in answers], (50, 99))} |"
            f" {np.median(its):6.0f} {max(its):3d} | {100 * (costs[ok].sum() / known[ok].sum() - 1):13.4f} "
            f"{100 * ((costs - known)[ok] / (0.1 + known[ok])).max():14.3f} |"
            f" {sum(a.outcome.ending is not Ending.CONVERGED for a in answers)} of {len(answers)}"
        )
        if hasattr(route.engine, "seconds"):
            print(f"{'  by its own clock, no Python':28} {percentiles(route.engine.seconds)}")


def closed(problem: StageProblem, loops: int, neighbours: int, only: str) -> None:
    price = Price(problem, NODES)
    print(f"\nclosed loop: cost really paid over {loops} loops; not converged; iterations median p99 max; cpu ms median p95 p99 max")
    for route in routes(problem, only, ipopt=False):
        paid, bad, counts, times = 0.0, 0, [], []
        for seed in range(loops):
            route.restart()
            loop = NoisyLoop(seed, neighbours)
            for situation, proposed, event in loop.run():
                answer = route.step(situation, proposed, event)
                u = np.clip(np.nan_to_num(answer.outcome.u[0]), problem.u_lower, problem.u_upper)
                paid += price.realised(situation.host.to_vector(), u, posed(situation, proposed, problem, NODES).p[0])
                bad += answer.outcome.ending is not Ending.CONVERGED
                counts.append(answer.outcome.iterations)
                times.append(answer.cpu_s)
                loop.drive(u)
        its = " ".join(f"{n:3.0f}" for n in np.percentile(counts, (50, 99, 100)))
        print(f"{route.name:28} {paid:12.4f}   {bad:4d} of {len(times)}   {its}   {percentiles(times)}", flush=True)


def cold(problem: StageProblem, count: int, neighbours: int, urgency: float, only: str) -> None:
    price, oracle = Price(problem, NODES), IpoptEngine(problem, NODES)
    rng = np.random.default_rng(2024)
    problems = [posed(*evasion(rng, neighbours, urgency=urgency), problem, NODES) for _ in range(count)]
    engines = [r for r in routes(problem, only, ipopt=False) if "1 step" not in r.name]
    found: dict[str, list[Outcome]] = {}
    times: dict[str, list[float]] = {}
    for route in engines:
        for q in problems:
            route.restart()
            started = time.thread_time()
            found.setdefault(route.name, []).append(route.engine.solve(q.x0, q.p, q.steps, q.guess, route.caps[1]))
            times.setdefault(route.name, []).append(time.thread_time() - started)
    first = found[engines[0].name]
    best = np.full(count, np.inf)
    worse = 0
    for i, (q, ours) in enumerate(zip(problems, first, strict=True)):
        from_cold = oracle.solve(q.x0, q.p, q.steps, q.guess)
        near = oracle.solve(q.x0, q.p, q.steps, StageGuess(x=ours.x, u=ours.u, s=ours.s))
        best[i] = min([price.of(o.u, q) for o in (from_cold, near) if o.ending is Ending.CONVERGED], default=np.inf)
        worse += price.of(from_cold.u, q) > 1.01 * best[i]
    print(f"\ncold starts: {count} evasions, urgency {urgency:g}; IPOPT from the same guess is over 1 % above the best known in {worse}")
    for route in engines:
        costs = np.array([price.of(o.u, q) for o, q in zip(found[route.name], problems, strict=True)])
        its = [o.iterations for o in found[route.name]]
        converged = sum(o.ending is Ending.CONVERGED for o in found[route.name])
        print(
            f"{route.name:28} converged {converged} of {count}, within 0.1 % of the best {np.sum(costs <= 1.001 * best)}, within 1 % "
            f"{np.sum(costs <= 1.01 * best)}; iterations median {np.median(its):.0f} max {max(its)}; "
            f"cpu ms {percentiles(times[route.name])}"
        )


def growth() -> None:
    print("\ngrowth: us of processor time of a Newton step of a cold start (least of 20 solves, over its iterations)")

    def each(name: str, values: list[int], make: Callable[[int], tuple[InteriorPointEngine, Posed]]) -> None:
        cost = []
        for value in values:
            engine, q = make(value)
            times = []
            for _ in range(20):
                started = time.thread_time()
                outcome = engine.solve(q.x0, q.p, q.steps, q.guess)
                times.append((time.thread_time() - started) / outcome.iterations)
            cost.append(1e6 * min(times))
        slope = np.polyfit(np.log(values), np.log(cost), 1)[0]
        print(f"{name:28} " + "  ".join(f"{v}: {c:.1f}" for v, c in zip(values, cost, strict=True)) + f"   slope {slope:.2f}")

    case = evasion(np.random.default_rng(4), 3)
    for compiled in (True, False):
        kind = "compiled" if compiled else "interpreted"

        def by_nodes(nodes: int, compiled: bool = compiled) -> tuple[InteriorPointEngine, Posed]:
            problem = lane_problem(3)
            return InteriorPointEngine(problem, nodes, compiled=compiled), posed(*case, problem, nodes)

        def by_slots(slots: int, compiled: bool = compiled) -> tuple[InteriorPointEngine, Posed]:
            problem = lane_problem(slots)
            rng = np.random.default_rng(4)
            return InteriorPointEngine(problem, NODES, compiled=compiled), posed(*evasion(rng, slots), problem, NODES)

        each(f"{kind}, N =", [20, 40, 80, 160], by_nodes)
        each(f"{kind}, neighbours =", [1, 2, 4, 8, 12], by_slots)


def growth_of_others(repeats: int = 5) -> None:
    """A whole cold solve, because steps of different methods do not compare."""
    print(f"\ngrowth of all: ms of processor time of a cold solve (least of {repeats})")
    makers: dict[str, Callable[[StageProblem, int], Any]] = {
        "interior point, compiled": InteriorPointEngine,
        "OSQP, 8 steps": OsqpEngine,
        "piqp, 8 steps": PiqpEngine,
        "IPOPT": IpoptEngine,
        "fatrop": FatropEngine,
        "do-mpc": DoMpcEngine,
        "acados": AcadosEngine,
    }
    sizes = {"N": [(n, 3) for n in (20, 40, 80, 160)], "neighbours": [(NODES, slots) for slots in (1, 2, 4, 8, 12)]}
    for name, make in makers.items():
        cap = 8 if "8 steps" in name else 300
        for what, pairs in sizes.items():
            values, cost, missed = [n if what == "N" else slots for n, slots in pairs], [], 0
            try:
                for nodes, slots in pairs:
                    problem = lane_problem(slots)
                    engine, q = make(problem, nodes), posed(*evasion(np.random.default_rng(4), slots), problem, nodes)
                    times, ending = [], Ending.FAILED
                    for _ in range(repeats):
                        started = time.thread_time()
                        ending = engine.solve(q.x0, q.p, q.steps, q.guess, cap).ending
                        times.append(time.thread_time() - started)
                    cost.append(1e3 * min(times))
                    missed += ending is not Ending.CONVERGED
            except (RuntimeError, ImportError) as error:
                print(f"{name} is left out: {error}")
                break
            slope = np.polyfit(np.log(values), np.log(cost), 1)[0]
            shown = "  ".join(f"{value}: {ms:.2f}" for value, ms in zip(values, cost, strict=True))
            print(f"{name:28} {what} =  {shown}   slope {slope:.2f}{f'   ({missed} not converged)' if missed else ''}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--loops", type=int, default=1)
    parser.add_argument("--cold", type=int, default=20, help="number of cold starts")
    parser.add_argument("--urgency", type=float, default=1.0, help="of the cold starts: at 2 many of them end in a scrape")
    parser.add_argument("--neighbours", type=int, default=3)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--only", default="", help="words in the names of the solvers that run")
    parser.add_argument("--parts", default="replay,closed,cold,growth,others")
    asked = parser.parse_args()
    problem = lane_problem(asked.neighbours)
    parts = asked.parts.split(",")
    if "replay" in parts:
        replay(problem, asked.loops, asked.neighbours, asked.repeats, asked.only)
    if "closed" in parts:
        closed(problem, asked.loops, asked.neighbours, asked.only)
    if "cold" in parts:
        cold(problem, asked.cold, asked.neighbours, asked.urgency, asked.only)
    if "growth" in parts:
        growth()
    if "others" in parts:
        growth_of_others()


if __name__ == "__main__":
    main()
