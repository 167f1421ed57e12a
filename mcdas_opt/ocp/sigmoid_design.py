"""The sigmoid's design as a nonlinear program in (a, b, y_max, K): named terms, exact derivatives, multipliers in the limits' units.

The unknowns are ln(-a), ln(b), y_max and K, so that each is of order one; the optimum satisfies every term or there is none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import lru_cache
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.ocp.design_terms import B_LEAST, DesignTerm, LateralAcceleration, LateralJerk, Length, Sigmoid
from mcdas_opt.solvers.held_interrupts import held_interrupts
from mcdas_opt.solvers.outcome import Ending
from mcdas_opt.solvers.small_nlp import SmallSolver

OBJECTIVES = {"shortest": "m", "clearance": "m", "jerk": "m/s^3"}
BOUNDED = ("a_per_m", "b", "y_max_m", "speed_mps")
_SHORTER_M = 1e-4  # clearance per metre of length: of equally clear paths the shortest
_FREE = 1e9  # a limit that never binds


@dataclass(frozen=True, slots=True, kw_only=True)
class SigmoidProblem:
    """What is wanted and what binds it: read top to bottom. Bounds are (low, high) by the names of `BOUNDED`."""

    objective: str
    terms: tuple[DesignTerm, ...]
    length: Length
    towards_m: float
    bounds: dict[str, tuple[float, float]]


@dataclass(frozen=True, slots=True, kw_only=True)
class TermReport:
    """A term at the answer; `multiplier` is what the objective's value gains per unit that the limit is relaxed, never negative."""

    name: str
    value: float
    limit: float
    unit: str
    multiplier: float
    at_least: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class SigmoidSolution:
    """`feasible` false: no point of the bounds keeps every term, as far as the solver could see; the rest is its last point."""

    feasible: bool
    a_per_m: float
    b: float
    y_max_m: float
    speed_mps: float
    value: float
    length_m: float
    terms: tuple[TermReport, ...]
    at_bounds: tuple[str, ...]
    evaluations: int
    message: str


class _Posed(NamedTuple):
    """A structure in symbols: its solver, the numbers at a point, and which term every row belongs to."""

    solver: SmallSolver
    numbers: Any  # (z, p) -> (length, objective), then the values of every term
    owner: tuple[int, ...]


def solve_sigmoid(problem: SigmoidProblem) -> SigmoidSolution:
    """From the closed form's guess; gentler starts only where that one finds nothing."""
    structure = tuple((type(term), term.name, term.at_least) for term in problem.terms)
    posed = _posed(problem.objective, structure)
    p = np.array([problem.towards_m, *(v for term in (problem.length, *problem.terms) for v in _figures(term).values())])
    low, high = _box(problem)
    evaluations = 0
    for gentler in (1.0, 0.4):
        answer = posed.solver.solve(p, low, high, _start(problem, gentler))
        evaluations += answer.evaluations
        if answer.ending is Ending.CONVERGED:
            break
    feasible = answer.ending is Ending.CONVERGED
    x = answer.x if np.all(np.isfinite(answer.x)) else _start(problem, 1.0)
    head, *values = (np.asarray(v, dtype=np.float64).ravel() for v in posed.numbers(x, p))
    owner = np.array(posed.owner)
    reports = tuple(
        TermReport(
            name=term.name,
            value=float(value.min() if term.at_least else value.max()),
            limit=term.limit,
            unit=term.unit,
            multiplier=float(answer.row_multipliers[: owner.size][owner == i].sum()) / _scale(term, term.limit) if feasible else 0.0,
            at_least=term.at_least,
        )
        for i, (term, value) in enumerate(zip(problem.terms, values, strict=True))
    )
    clearance = min((r.value for r in reports if r.at_least), default=0.0)
    return SigmoidSolution(
        feasible=feasible,
        a_per_m=-math.exp(x[0]),
        b=math.exp(x[1]),
        y_max_m=float(x[2]),
        speed_mps=float(x[3]),
        value=clearance if problem.objective == "clearance" else float(head[1]),
        length_m=float(head[0]),
        terms=reports,
        at_bounds=_at_bounds(answer.bound_multipliers, low, high) if feasible else (),
        evaluations=evaluations,
        message=answer.message,
    )


@lru_cache(maxsize=32)
@held_interrupts()
def _posed(objective: str, structure: tuple[tuple[type[DesignTerm], str, bool], ...]) -> _Posed:
    """Every figure of every term as a parameter, so that a gain schedule builds its solver once."""
    z, towards = ca.SX.sym("z", 5), ca.SX.sym("towards")
    path = Sigmoid(a=-ca.exp(z[0]), b=ca.exp(z[1]), y_max=z[2], speed=z[3], towards=towards, m=ca)
    symbols = [towards]

    def symbolic(kind: type[Any], **fixed: Any) -> Any:
        free = {f.name: ca.SX.sym(f.name) for f in fields(kind) if f.type == "float"}
        symbols.extend(free.values())
        return kind(**free, **fixed)

    length = symbolic(Length).rows(path)[0]
    terms = [symbolic(kind, name=name) for kind, name, _ in structure]
    rows: list[Any] = []
    owner: list[int] = []
    values = [list(term.rows(path)) for term in terms]
    for i, (term, found, (_, _, at_least)) in enumerate(zip(terms, values, structure, strict=True)):
        rows += [(term.limit - v if at_least else v - term.limit) / _scale(term, term.limit) for v in found]
        owner += [i] * len(found)
    if objective == "clearance":
        rows += [z[4] - v for found, (_, _, at_least) in zip(values, structure, strict=True) if at_least for v in found]
        goal = _SHORTER_M * length - z[4]
    else:
        goal = length if objective == "shortest" else LateralJerk(limit=0.0).rows(path)[0]
    p = ca.vertcat(*symbols)
    numbers = ca.Function("numbers", [z, p], [ca.vertcat(length, goal), *(ca.vertcat(*found) for found in values)])
    return _Posed(SmallSolver(z, p, goal, ca.vertcat(*rows)), numbers, tuple(owner))


def _figures(term: DesignTerm) -> dict[str, float]:
    """A term's numbers by name, in the order of its fields; no limit is a limit that never binds."""
    return {f.name: min(float(getattr(term, f.name)), _FREE) for f in fields(term) if f.type == "float"}


def _scale(term: DesignTerm, limit: Any) -> Any:
    """Brings a row to order one: metres stand, everything else is a share of its limit."""
    return 1.0 if term.unit == "m" else limit


def _box(problem: SigmoidProblem) -> tuple[Array, Array]:
    (a_low, a_high), (b_low, b_high) = problem.bounds["a_per_m"], problem.bounds["b"]
    (y_low, y_high), (v_low, v_high) = problem.bounds["y_max_m"], problem.bounds["speed_mps"]
    low = [math.log(-a_high), math.log(max(b_low, B_LEAST)), y_low, v_low, -50.0]
    high = [math.log(-a_low), math.log(b_high), y_high, v_high, 50.0]
    return np.array(low), np.array(high)


def _start(problem: SigmoidProblem, gentler: float) -> Array:
    """a*(v) of the closed form at b = 50, for the middle of the speeds and the centre of the lane."""
    low, high = _box(problem)
    speed = 0.5 * (low[3] + high[3])
    y_max = problem.length.lane_centre_m - problem.towards_m
    limit = min((t.limit for t in problem.terms if isinstance(t, LateralAcceleration)), default=4.0)
    sharpness = math.sqrt(6.0 * math.sqrt(3.0) * limit / (1.04 * problem.length.lane_centre_m)) / speed
    return np.array([math.log(0.9 * gentler * sharpness), math.log(50.0), y_max, speed, 0.0])


def _at_bounds(multipliers: Array, low: Array, high: Array) -> tuple[str, ...]:
    """Names of the unknowns that a bound holds; those that a bound fixes are not told."""
    held = []
    for name, value, least, most in zip(BOUNDED, multipliers, low, high, strict=False):
        if abs(value) > 1e-4 and most - least > 1e-9:
            wall = "lower" if (value < 0.0) != (name == "a_per_m") else "upper"
            held.append(f"{name} at its {wall} bound")
    return tuple(held)
