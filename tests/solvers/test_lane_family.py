"""Every engine on the same random lane problems, as the planner poses them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.lane_situations import NoisyLoop, evasion, lane_problem, posed
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.solvers.interior_point import InteriorPointEngine
from mcdas_opt.solvers.ipopt_engine import IpoptEngine
from mcdas_opt.solvers.linearisation import Linearisation
from mcdas_opt.solvers.osqp_engine import OsqpEngine
from mcdas_opt.solvers.outcome import Ending
from mcdas_opt.solvers.stage_problem import StageGuess

PROBLEM = lane_problem(3)
NODES = 40


@pytest.fixture(scope="module")
def engine():
    return InteriorPointEngine(PROBLEM, NODES, compiled=False)


@pytest.fixture(scope="module")
def oracle():
    return IpoptEngine(PROBLEM, NODES)


def family(seed, count, **more):
    rng = np.random.default_rng(seed)
    return [posed(*evasion(rng, 3, **more), PROBLEM) for _ in range(count)]


def test_plausible_cold_starts_converge(engine):
    outcomes = [engine.solve(q.x0, q.p, q.steps, q.guess) for q in family(11, 100)]
    assert [o.ending for o in outcomes] == [Ending.CONVERGED] * 100
    assert max(o.iterations for o in outcomes) <= 20
    assert np.median([o.iterations for o in outcomes]) <= 9


def test_the_answer_is_a_minimum_by_ipopt_s_account(engine, oracle):
    """From our answer IPOPT finds nothing cheaper nearby; nor does it from the cold guess (where it may end on the wrong side)."""
    compared = cold = 0
    for q in family(12, 12):
        ours = engine.solve(q.x0, q.p, q.steps, q.guess)
        near = oracle.solve(q.x0, q.p, q.steps, StageGuess(x=ours.x, u=ours.u, s=ours.s))
        far = oracle.solve(q.x0, q.p, q.steps, q.guess)
        assert ours.ending is Ending.CONVERGED
        if far.ending is Ending.CONVERGED:
            cold += 1
            assert ours.objective <= far.objective * 1.001
        if near.ending is Ending.CONVERGED:  # now and then IPOPT itself runs into its limit
            compared += 1
            assert ours.objective == pytest.approx(near.objective, rel=1e-3)
            np.testing.assert_allclose(ours.u[0] / PROBLEM.u_upper, near.u[0] / PROBLEM.u_upper, atol=5e-3)
    assert compared >= 9
    assert cold >= 9


def test_osqp_s_iteration_comes_to_the_same_answer(engine):
    other = OsqpEngine(PROBLEM, NODES)
    compared = 0
    for q in family(13, 8):
        ours = engine.solve(q.x0, q.p, q.steps, q.guess)
        other.reset()
        theirs = other.solve(q.x0, q.p, q.steps, q.guess, 20)
        if theirs.ending is Ending.CONVERGED:
            compared += 1
            assert ours.objective <= theirs.objective * 1.001
            if theirs.objective < 1.1 * ours.objective:  # the same side
                np.testing.assert_allclose(theirs.x[:, 1], ours.x[:, 1], atol=0.1)
    assert compared >= 4


def mirrored(q):
    """The same situation in a mirror: left is right."""
    names = list(PROBLEM.parameters)
    p = q.p.copy()
    for i, name in enumerate(names):
        odd = name in ("kappa", "kappa_slope", "kappa_nose", "kappa_tail", "ref_start_d", "ref_amplitude", "ref_bend") or (
            name.startswith("body") and name.endswith("_d")
        )
        if odd:
            p[:, i] = -p[:, i]
    left, right = names.index("left_edge"), names.index("right_edge")
    p[:, [left, right]] = -p[:, [right, left]]
    sign_x, sign_u = np.array([1.0, -1.0, -1.0, 1.0, 1.0, -1.0]), np.array([1.0, -1.0])
    guess = StageGuess(x=q.guess.x * sign_x, u=q.guess.u * sign_u, s=q.guess.s)
    return replace(q, x0=q.x0 * sign_x, p=p, guess=guess), sign_x, sign_u


def test_the_mirrored_problem_has_the_mirrored_answer(engine):
    for q in family(14, 20):
        other, sign_x, sign_u = mirrored(q)
        one = engine.solve(q.x0, q.p, q.steps, q.guess)
        two = engine.solve(other.x0, other.p, other.steps, other.guess)
        assert one.iterations == two.iterations
        np.testing.assert_allclose(two.x * sign_x, one.x, atol=1e-8)
        np.testing.assert_allclose(two.u * sign_u, one.u, atol=1e-8)


@pytest.mark.parametrize(("urgency", "most"), [(1.0, 15), (2.0, 40)])
def test_noisy_closed_loops_stay_converged_in_few_iterations(engine, urgency, most):
    """Where half of the evasions end in a scrape, too."""
    warm_counts = []
    for seed in (101, 102):
        loop, last = NoisyLoop(seed, neighbours=3, steps=100, urgency=urgency), None
        for situation, proposed, event in loop.run():
            warm = last is not None and not event
            q = posed(situation, proposed, PROBLEM, guess=engine.shifted(last) if warm else None)
            last = engine.solve(q.x0, q.p, q.steps, q.guess)
            assert last.ending is Ending.CONVERGED
            if warm:
                warm_counts.append(last.iterations)
            loop.drive(last.u[0])
    assert np.median(warm_counts) <= 3
    assert max(warm_counts) <= most


def test_stopping_behind_a_standing_car_stays_converged(engine):
    """Down to standstill in noise, where steering does nothing and the speed's bound is active at every node."""
    for seed in range(3):
        loop, last = NoisyLoop(seed, neighbours=1, steps=100), None
        car = replace(loop.situation.tracks[0], s_m=45.0, d_m=0.0, speed_s_mps=0.0)
        road = replace(loop.situation.road, friction=0.9, curvature=((0.0, 0.0),))
        loop.situation = replace(loop.situation, host=HostState(speed_mps=13.0), tracks=(car,), road=road)
        keep = replace(loop.proposed, path=replace(loop.proposed.path, amplitude_m=0.0, start_d_m=0.0), speed_mps=0.0, manoeuvre=None)
        for _ in range(80):
            q = posed(loop.situation, keep, PROBLEM, guess=None if last is None else engine.shifted(last))
            last = engine.solve(q.x0, q.p, q.steps, q.guess)
            assert last.ending is Ending.CONVERGED
            loop.drive(last.u[0])
        assert loop.situation.host.speed_mps < 1.0
        assert loop.situation.host.s_m < 45.0 - 4.5


def test_a_crash_that_cannot_be_avoided_still_has_a_plan(engine):
    """The rows are soft: the slack says how deep, and the plan uses what brakes there are."""
    rng = np.random.default_rng(5)
    situation, proposed = evasion(rng, 1, side=Side.LEFT)
    front = replace(situation.tracks[0], s_m=9.0, d_m=0.0, speed_s_mps=0.0)
    boxed = replace(
        situation, tracks=(front,), road=replace(situation.road, lanes_left=0, lanes_right=0, friction=0.9, curvature=((0.0, 0.0),))
    )
    keep = replace(proposed, path=replace(proposed.path, amplitude_m=0.0, start_d_m=0.0), speed_mps=0.0, manoeuvre=None)
    q = posed(boxed, keep, PROBLEM)
    outcome = engine.solve(q.x0, q.p, q.steps, q.guess)
    collision = PROBLEM.slacks.index("collision")
    assert outcome.usable
    assert outcome.s[:, collision].max() > 0.3
    assert outcome.x[5, PROBLEM.states.index("a")] < -4.0


def test_braking_that_a_standstill_is_too_near_for_is_called_infeasible(engine):
    """v >= 0 at the next node and a = -6 at 0.3 m/s contradict each other: told within few iterations, not guessed at."""
    situation, proposed = evasion(np.random.default_rng(6), 0)
    host = HostState(speed_mps=0.3, acceleration_mps2=-6.0)
    q = posed(replace(situation, host=host), proposed, PROBLEM)
    outcome = engine.solve(q.x0, q.p, q.steps, q.guess)
    assert outcome.ending is Ending.INFEASIBLE
    assert outcome.iterations <= 20


def test_work_grows_linearly_with_neighbours():
    """One more body adds the same number of operations to a stage, whichever it is."""
    from mcdas_opt.solvers.stage_functions import stage_functions

    work = []
    for slots in (1, 2, 3, 4, 5):
        _, f = stage_functions(lane_problem(slots))
        work.append(sum(function.n_instructions() for function in f))
    growth = np.diff(work)
    assert growth.max() <= 1.1 * growth.min()


def test_iterations_do_not_grow_with_the_horizon():
    rng = np.random.default_rng(15)
    cases = [evasion(rng, 3) for _ in range(6)]
    counts = {}
    for nodes in (20, 80):
        engine = InteriorPointEngine(PROBLEM, nodes, compiled=False)
        outcomes = [engine.solve(q.x0, q.p, q.steps, q.guess) for q in (posed(*case, PROBLEM, nodes) for case in cases)]
        assert all(o.ending is Ending.CONVERGED for o in outcomes)
        counts[nodes] = np.mean([o.iterations for o in outcomes])
    assert counts[80] <= 1.5 * counts[20]


def test_the_objective_is_linearisation_s(engine):
    own = Linearisation(PROBLEM, NODES)
    for q in family(16, 3):
        o = engine.solve(q.x0, q.p, q.steps, q.guess)
        least = own.slacks(o.x, o.u, q.p)
        np.testing.assert_allclose(o.s, least, atol=1e-10)
        assert o.objective == pytest.approx(own.objective(o.x, o.u, least, q.p), rel=1e-10)
