"""IPOPT as the oracle: its status is read before its point."""

from __future__ import annotations

import numpy as np
import pytest

from mcdas_opt.solvers.interior_point import InteriorPointEngine
from mcdas_opt.solvers.ipopt_engine import IpoptEngine
from mcdas_opt.solvers.linearisation import Linearisation
from mcdas_opt.solvers.outcome import Ending
from tests.solvers.small_problems import double_integrator, idle_guess, one_step, parameters

NODES = 20
STEPS = np.full(NODES, 0.1)


def solve(engine, small, x0=(0.0, 0.0), target=4.0, **more):
    n = engine.nodes
    start = np.asarray(x0, dtype=float)
    return engine.solve(start, parameters(small, n, target), STEPS[:n], idle_guess(small, n, start), **more)


@pytest.fixture(scope="module")
def small():
    return double_integrator(x_bound=(-5.0, 3.9), u_bound=(-3.0, 3.0))


@pytest.fixture(scope="module")
def engine(small):
    return IpoptEngine(small, NODES)


def test_a_bounded_step_is_the_clipped_one():
    bounded = one_step(4.0, (-1.0, 2.0))
    ipopt = IpoptEngine(bounded, 1)
    for target, u in ((10.0, 2.0), (1.0, 0.8), (-10.0, -1.0)):
        outcome = solve(ipopt, bounded, (0.0,), target)
        assert outcome.ending is Ending.CONVERGED
        assert outcome.u[0, 0] == pytest.approx(u, abs=1e-6)


def test_it_agrees_with_the_interior_point_and_counts_its_cost_alike(engine, small):
    theirs = solve(engine, small)
    ours = solve(InteriorPointEngine(small, NODES, compiled=False), small)
    assert theirs.ending is Ending.CONVERGED
    assert ours.objective == pytest.approx(theirs.objective, rel=1e-3)
    np.testing.assert_allclose(ours.x, theirs.x, atol=5e-3)
    own, p = Linearisation(small, NODES), parameters(small, NODES, 4.0)
    assert theirs.objective == pytest.approx(own.objective(theirs.x, theirs.u, own.slacks(theirs.x, theirs.u, p), p), rel=1e-12)


def test_infeasible_is_told_although_there_is_a_point():
    tight = double_integrator(x_bound=(-1.0, 1.0), u_bound=(-3.0, 3.0))
    outcome = solve(IpoptEngine(tight, NODES), tight, (0.0, 5.0), 0.0)
    assert outcome.ending in (Ending.INFEASIBLE, Ending.FAILED)
    assert np.all(np.isfinite(outcome.x))  # the trap
    assert not outcome.usable


def test_the_iteration_limit_is_told(engine, small):
    outcome = solve(engine, small, iterations=2)
    assert outcome.ending is Ending.LIMIT
    assert outcome.iterations <= 2


def test_what_is_not_finite_never_leaves(engine, small):
    outcome = solve(engine, small, target=np.nan)
    assert not outcome.usable
    assert solve(engine, small).ending is Ending.CONVERGED
