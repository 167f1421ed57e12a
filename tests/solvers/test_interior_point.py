"""The interior point on problems whose answer is known, and on what can go wrong."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.solvers import interior_point
from mcdas_opt.solvers.linearisation import Linearisation
from mcdas_opt.solvers.outcome import Ending
from mcdas_opt.solvers.stage_problem import StageGuess, StageProblem
from tests.solvers.small_problems import chain, double_integrator, idle_guess, one_step, parameters, wall

STEPS = np.full(20, 0.1)


def reference(small, nodes):
    """The reference: interpreted. `test_compiled_kernel` compares the compiled one with it."""
    return interior_point.InteriorPointEngine(small, nodes, compiled=False)


def solve(engine, small, x0, target, **more):
    n = engine.nodes
    x0 = np.atleast_1d(np.asarray(x0, dtype=float))
    return engine.solve(x0, parameters(small, n, target), STEPS[:n], more.pop("guess", idle_guess(small, n, x0)), **more)


BOUNDED = one_step(4.0, (-1.0, 2.0))
BOUNDED_ENGINE = reference(BOUNDED, 1)
WALL = wall(0.5, at=1.0)
WALL_ENGINE = reference(WALL, 1)
PLACES = st.floats(-10.0, 10.0)


@settings(deadline=None, max_examples=40)
@given(PLACES, PLACES)
def test_a_bounded_step_is_the_clipped_one(x0, target):
    outcome = solve(BOUNDED_ENGINE, BOUNDED, x0, target)
    assert outcome.ending is Ending.CONVERGED
    assert outcome.u[0, 0] == pytest.approx(np.clip(0.8 * (target - x0), -1.0, 2.0), abs=2e-3)
    assert -1.0 <= outcome.u[0, 0] <= 2.0


@settings(deadline=None, max_examples=40)
@given(PLACES, PLACES)
def test_a_soft_wall_is_passed_only_when_it_pays(x0, target):
    outcome = solve(WALL_ENGINE, WALL, x0, target)
    free = x0 + 0.5 * (target - x0)
    at_price = x0 + 0.5 * (target - x0 - 0.5)  # where the price is paid
    expected = free if free <= 1.0 else max(at_price, 1.0)
    assert outcome.ending is Ending.CONVERGED
    assert outcome.x[1, 0] == pytest.approx(expected, abs=2e-3)
    assert outcome.s[1, 0] == pytest.approx(max(outcome.x[1, 0] - 1.0, 0.0), abs=1e-12)  # the least, not the barrier's


@pytest.mark.parametrize(("nx", "nu"), [(1, 1), (2, 1), (3, 2), (5, 3), (2, 4)])
def test_a_linear_quadratic_problem_is_solved_in_one_step_as_by_dense_algebra(nx, nu):
    rng = np.random.default_rng(nx + 10 * nu)
    linear, m = chain(rng, nx, nu)
    nodes, x0 = 6, rng.standard_normal(nx)
    outcome = solve(reference(linear, nodes), linear, x0, 0.7)
    # all states are linear in the inputs: x_k = A^k x0 + sum A^(k-1-j) B u_j, so the whole is one least-squares problem
    power = [np.linalg.matrix_power(m["a"], k) for k in range(nodes + 1)]
    blocks, right = [np.eye(nodes * nu)], [np.zeros(nodes * nu)]
    for k in range(nodes + 1):
        weight = m["q"] if k < nodes else m["w"]
        effect = [power[k - 1 - j] @ m["b"] if j < k else np.zeros((nx, nu)) for j in range(nodes)]
        blocks.append(weight @ np.hstack(effect))
        right.append(weight @ (0.7 - power[k] @ x0))
    u = np.linalg.lstsq(np.vstack(blocks), np.concatenate(right), rcond=None)[0]
    assert outcome.ending is Ending.CONVERGED
    assert outcome.iterations <= 2  # the step, and one that finds nothing left to do
    np.testing.assert_allclose(outcome.u.ravel(), u, atol=1e-9)


def test_the_objective_is_the_problem_s_own():
    small = double_integrator(u_bound=(-3.0, 3.0))
    outcome = solve(reference(small, 20), small, [0.0, 0.0], 4.0)
    own = Linearisation(small, 20)
    p = parameters(small, 20, 4.0)
    assert outcome.objective == pytest.approx(own.objective(outcome.x, outcome.u, own.slacks(outcome.x, outcome.u, p), p), rel=1e-12)


def test_bounds_hold_where_the_problem_says_they_do():
    """x bounds from node 1 on: a start outside of them is brought back, and is no contradiction."""
    small = double_integrator(x_bound=(-1.0, 1.0), u_bound=(-30.0, 30.0))
    outcome = solve(reference(small, 20), small, [1.02, -0.5], 5.0)
    assert outcome.ending is Ending.CONVERGED
    assert np.abs(outcome.x[1:]).max() <= 1.0 + 1e-6
    assert outcome.x[-1, 0] == pytest.approx(1.0, abs=1e-3)


def test_a_contradiction_is_told_and_gives_no_point():
    small = double_integrator(x_bound=(-1.0, 1.0), u_bound=(-3.0, 3.0))
    outcome = solve(reference(small, 20), small, [0.0, 5.0], 0.0)  # speed 5 cannot be brought under 1 in one step
    assert outcome.ending is Ending.INFEASIBLE
    assert not outcome.usable
    assert "contradict" in outcome.message


@pytest.mark.parametrize("where", ["x0", "p", "steps", "x", "u", "multipliers"])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_not_finite_is_told_and_does_not_stay(where, bad):
    small = double_integrator(u_bound=(-3.0, 3.0))
    engine = reference(small, 20)
    good = solve(engine, small, [0.0, 0.0], 4.0)
    again = StageGuess(x=good.x.copy(), u=good.u.copy(), s=good.s.copy(), multipliers=good.multipliers.copy())
    data = {"x0": np.zeros(2), "p": parameters(small, 20, 4.0), "steps": STEPS.copy()}
    spoilt = data[where] if where in data else getattr(again, where)
    spoilt.flat[-1] = bad
    outcome = engine.solve(data["x0"], data["p"], data["steps"], again)
    assert outcome.ending is Ending.NOT_FINITE
    assert not outcome.usable
    after = solve(engine, small, [0.0, 0.0], 4.0)
    assert after.ending is Ending.CONVERGED
    assert np.array_equal(after.u, good.u)


def test_an_overflow_inside_is_told():
    small = double_integrator(u_bound=(-3.0, 3.0))
    outcome = solve(reference(small, 20), small, [1e200, 1e200], 0.0)
    assert outcome.ending is Ending.NOT_FINITE
    assert not outcome.usable


def test_the_iteration_limit_ends_it_with_a_finite_point():
    small = double_integrator(u_bound=(-3.0, 3.0))
    engine = reference(small, 20)
    outcome = solve(engine, small, [0.0, 0.0], 4.0, iterations=2)
    assert outcome.ending is Ending.LIMIT
    assert outcome.usable
    assert outcome.iterations == 2
    assert "last step" in outcome.message
    assert engine.solve(np.zeros(2), parameters(small, 20, 4.0), STEPS, idle_guess(small, 20), 0).ending is Ending.LIMIT


def test_a_solve_leaves_nothing_behind():
    """Same input, same bytes, whatever was solved in between."""
    small = double_integrator(u_bound=(-3.0, 3.0))
    engine = reference(small, 20)
    first = solve(engine, small, [0.3, 0.0], 4.0)
    solve(engine, small, [-2.0, 1.0], -4.0, guess=engine.shifted(first))
    again = solve(engine, small, [0.3, 0.0], 4.0)
    assert np.array_equal(first.x, again.x)
    assert np.array_equal(first.multipliers, again.multipliers)


def test_a_twin_shares_what_is_built_and_no_numbers():
    small = double_integrator(u_bound=(-3.0, 3.0))
    engine = reference(small, 20)
    twin = engine.twin()
    ours, theirs = solve(engine, small, [0.3, 0.0], 4.0), solve(twin, small, [-2.0, 1.0], -4.0)
    for one in (engine, twin):  # whoever of them solved what before
        assert np.array_equal(solve(one, small, [-2.0, 1.0], -4.0).x, theirs.x)
        assert np.array_equal(solve(one, small, [0.3, 0.0], 4.0).multipliers, ours.multipliers)


def test_a_solution_that_is_handed_back_stays_where_it_is():
    small = double_integrator(x_bound=(-5.0, 3.9), u_bound=(-3.0, 3.0))
    engine = reference(small, 20)
    first = solve(engine, small, [0.0, 0.0], 4.0)
    held = StageGuess(x=first.x, u=first.u, s=first.s, multipliers=first.multipliers)
    again = solve(engine, small, [0.0, 0.0], 4.0, guess=held)
    assert again.iterations <= 2
    np.testing.assert_allclose(again.u, first.u, atol=2e-3)


def test_the_receding_horizon_needs_few_iterations_and_gets_there():
    small = double_integrator(x_bound=(-5.0, 5.0), u_bound=(-3.0, 3.0))
    engine = reference(small, 20)
    x, last, counts = np.array([-4.0, 0.0]), None, []
    for _ in range(60):
        last = solve(engine, small, x, 3.0, guess=idle_guess(small, 20, x) if last is None else engine.shifted(last))
        assert last.ending is Ending.CONVERGED
        counts.append(last.iterations)
        x = last.x[1]
    assert np.abs(x - [3.0, 0.0]).max() < 0.02
    assert max(counts[1:]) < counts[0]
    assert np.median(counts[1:]) <= 2


def test_the_answer_does_not_depend_on_units():
    """Position in millimetres, speed in mm/s, acceleration in mm/s^2: the same numbers come out, scaled."""
    from dataclasses import replace

    import casadi as ca

    small = double_integrator(u_bound=(-3.0, 3.0))
    x, u, p, h = ca.SX.sym("x", 2), ca.SX.sym("u", 1), ca.SX.sym("p", 1), ca.SX.sym("h")
    k = 1000.0
    fine: StageProblem = replace(
        small,
        dynamics=ca.Function("dynamics", [x, u, p, h], [k * small.dynamics(x / k, u / k, p, h)]),
        residual=ca.Function("residual", [x, u, p], [small.residual(x / k, u / k, p)]),
        terminal_residual=ca.Function("terminal_residual", [x, p], [small.terminal_residual(x / k, p)]),
        inequality=ca.Function("inequality", [x, u, p], [ca.SX(0, 1)]),
        u_lower=k * small.u_lower,
        u_upper=k * small.u_upper,
        x_scale=k * small.x_scale,
        u_scale=k * small.u_scale,
    )
    coarse = solve(reference(small, 20), small, [0.0, 0.0], 4.0)
    finer = solve(reference(fine, 20), fine, [0.0, 0.0], 4.0)
    np.testing.assert_allclose(finer.u / k, coarse.u, atol=2e-3)
    assert finer.objective == pytest.approx(coarse.objective, rel=1e-4)
