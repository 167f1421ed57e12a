"""The real-time iteration on OSQP: right where it converges, and never a point that OSQP should not have returned."""

from __future__ import annotations

import numpy as np
import osqp
import pytest
from scipy.sparse import csc_matrix

from mcdas_opt.solvers.interior_point import InteriorPointEngine
from mcdas_opt.solvers.osqp_engine import OsqpEngine, OsqpSettings
from mcdas_opt.solvers.outcome import Ending, Outcome
from tests.solvers.small_problems import double_integrator, idle_guess, one_step, parameters, wall

NODES = 20
STEPS = np.full(NODES, 0.1)
SMALL = double_integrator(x_bound=(-5.0, 3.9), u_bound=(-3.0, 3.0))


def solve(engine, small=SMALL, x0=(0.0, 0.0), target=4.0, iterations=10, guess=None):
    n = engine.nodes
    start = np.asarray(x0, dtype=float)
    return engine.solve(start, parameters(small, n, target), STEPS[:n], guess or idle_guess(small, n, start), iterations)


def test_osqp_itself_returns_a_point_for_an_infeasible_problem():
    """The trap: it is the status that tells, not x."""
    solver = osqp.OSQP()
    solver.setup(
        csc_matrix(np.eye(1)), np.zeros(1), csc_matrix([[1.0], [1.0]]), np.array([1.0, -2.0]), np.array([2.0, -1.0]), verbose=False
    )
    result = solver.solve(raise_error=False)
    assert result.info.status_val in (3, 4)
    assert result.x is not None


def test_osqp_itself_takes_nan_for_a_cost():
    solver = osqp.OSQP()
    solver.setup(csc_matrix(np.eye(1)), np.array([np.nan]), csc_matrix([[1.0]]), np.array([-1.0]), np.array([1.0]), verbose=False)
    result = solver.solve(raise_error=False)
    assert result.info.status_val != 1
    assert not np.all(np.isfinite(result.x))


@pytest.mark.parametrize("target", [-8.0, 0.5, 4.0])
def test_it_agrees_with_the_interior_point(target):
    ours = solve(OsqpEngine(SMALL, NODES, OsqpSettings(tolerance=1e-6, qp_iterations=10000)), target=target)
    other = solve(InteriorPointEngine(SMALL, NODES, compiled=False), target=target, iterations=60)
    assert ours.ending is Ending.CONVERGED
    np.testing.assert_allclose(ours.x, other.x, atol=5e-3)
    assert ours.objective == pytest.approx(other.objective, rel=1e-3)


def test_the_slacks_are_the_least_that_the_point_needs():
    small = wall(0.5, at=1.0)
    outcome = solve(OsqpEngine(small, 1), small, x0=(0.0,), target=8.0)
    assert outcome.s[0, 0] == 0.0
    assert outcome.s[1, 0] == pytest.approx(max(outcome.x[1, 0] - 1.0, 0.0), abs=1e-12)
    assert outcome.x[1, 0] == pytest.approx(3.75, abs=1e-2)  # the price is paid


def test_an_infeasible_problem_gives_no_point_and_leaves_no_trace():
    small = double_integrator(x_bound=(-1.0, 1.0), u_bound=(-3.0, 3.0))
    engine = OsqpEngine(small, NODES)
    good = solve(engine, small, target=0.5)
    outcome = solve(engine, small, x0=(0.0, 5.0), target=0.5)
    assert outcome.ending is Ending.INFEASIBLE
    assert not outcome.usable
    assert "infeasible" in outcome.message
    after = solve(engine, small, target=0.5)
    assert after.ending is Ending.CONVERGED
    np.testing.assert_allclose(after.u, good.u, atol=1e-2)


def test_bounds_that_contradict_each_other_are_a_failure_not_an_exception():
    small = one_step(1.0, (1.0, -1.0))
    outcome = solve(OsqpEngine(small, 1), small, x0=(0.0,))
    assert outcome.ending in (Ending.FAILED, Ending.INFEASIBLE)
    assert not outcome.usable


@pytest.mark.parametrize("where", ["x0", "p", "guess"])
def test_what_is_not_finite_never_leaves(where):
    engine = OsqpEngine(SMALL, NODES)
    good = solve(engine)
    x0, p, guess = np.zeros(2), parameters(SMALL, NODES, 4.0), idle_guess(SMALL, NODES)
    {"x0": x0, "p": p, "guess": guess.x}[where].flat[-1] = np.nan
    outcome = engine.solve(x0, p, STEPS, guess, 10)
    assert not outcome.usable
    assert outcome.ending is Ending.NOT_FINITE
    engine.reset()
    assert np.array_equal(solve(engine).u, good.u)


def test_few_inner_iterations_are_not_called_converged():
    outcome = solve(OsqpEngine(SMALL, NODES, OsqpSettings(qp_iterations=10)), iterations=2)
    assert outcome.ending is Ending.LIMIT
    assert outcome.usable
    assert outcome.iterations == 2
    assert outcome.inner_iterations <= 20
    assert outcome.message


def test_an_exception_in_osqp_is_a_value(monkeypatch):
    engine = OsqpEngine(SMALL, NODES)
    good = solve(engine)

    def broken(*_args, **_more):
        raise RuntimeError("no memory")

    monkeypatch.setattr(engine._solver, "solve", broken)
    outcome = solve(engine)
    assert outcome.ending is Ending.FAILED
    assert not outcome.usable
    assert "no memory" in outcome.message
    after = solve(engine)  # with a new workspace
    assert after.ending is Ending.CONVERGED
    np.testing.assert_allclose(after.u, good.u, atol=1e-2)


def test_the_shifted_solution_is_a_warm_start():
    engine = OsqpEngine(SMALL, NODES)
    cold = solve(engine, iterations=10)
    moved = cold.x[1]
    warm = solve(engine, x0=moved, guess=engine.shifted(cold), iterations=10)
    engine.reset()
    again = solve(engine, x0=moved, iterations=10)
    assert warm.ending is Ending.CONVERGED
    assert warm.inner_iterations <= again.inner_iterations
    assert warm.objective == pytest.approx(again.objective, rel=1e-2)


def test_an_outcome_is_usable_only_when_it_ended_well_and_is_finite():
    x, u, s = np.zeros((2, 1)), np.zeros((1, 1)), np.zeros((2, 0))
    spoilt = x.copy()
    spoilt[0, 0] = np.nan
    for ending in Ending:
        ended_well = ending in (Ending.CONVERGED, Ending.LIMIT)
        assert Outcome(ending=ending, x=x, u=u, s=s).usable is ended_well
        assert not Outcome(ending=ending, x=spoilt, u=u, s=s).usable
