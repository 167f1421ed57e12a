"""The parking program: derivatives by block are the derivatives, both forms of the checks mean the same, Ctrl-C gets through."""

import os
import signal

import casadi as ca
import numpy as np
import pytest

from mcdas_opt.errors import ParameterError
from mcdas_opt.parking.cost import COSTS, costs_named
from mcdas_opt.parking.program.block_derivatives import Copies, nlp_of
from mcdas_opt.parking.program.equations import COMMON, EXTRA, STATE, check, check_rows, check_unknowns, interval
from mcdas_opt.parking.program.nlp import solve_parking
from mcdas_opt.parking.program.records import FORMS, Checks, ParkingPhysics, ParkingProgram
from mcdas_opt.parking.program.stages import Stages
from mcdas_opt.solvers.held_interrupts import held_interrupts

PHYSICS = ParkingPhysics(2.7, -0.9, 3.6, 0.9, 1.5, 0.5, 0.05)
BOX = np.array([[6.0, -1.0], [8.0, -1.0], [8.0, 0.2], [6.0, 0.2]])


def chain(form: str, intervals: int):
    """Intervals, and one check of each kind."""
    steps = STATE * (intervals + 1) + np.zeros(intervals, dtype=np.int64)
    k = np.arange(intervals)
    driven = np.column_stack([STATE * k[:, None] + np.arange(2 * STATE), steps])
    first = int(steps.max()) + 1
    own = first + np.arange(2 * EXTRA[form]).reshape(2, -1)
    copies = [
        Copies(interval(), driven),
        Copies(check(form, False), np.append(STATE + np.arange(3), own[0])[None]),
        Copies(check(form, True), np.append(driven[1], own[1])[None]),
    ]
    return nlp_of(copies, first + own.size, COMMON)


@pytest.mark.parametrize("form", FORMS)
def test_derivatives_by_block_are_those_of_the_whole(form):
    problem, derivatives = chain(form, 3)
    x, p, f, g = (problem[key] for key in "xpfg")
    rng = np.random.default_rng(3)
    at = rng.uniform(0.1, 0.9, x.numel()), rng.uniform(0.1, 1.0, p.numel())
    multipliers = rng.normal(size=g.numel())
    value, jacobian = derivatives["jac_g"](*at)
    cost, gradient = derivatives["grad_f"](*at)
    whole = ca.Function("whole", [x, p], [g, ca.jacobian(g, x), f, ca.gradient(f, x), ca.hessian(2.0 * f + ca.dot(multipliers, g), x)[0]])(
        *at
    )
    for ours, theirs in zip((value, jacobian, cost, gradient), whole[:4], strict=True):
        assert np.asarray(ca.densify(ours)) == pytest.approx(np.asarray(ca.densify(theirs)), abs=1e-10)
    bent = np.asarray(ca.densify(derivatives["hess_lag"](*at, 2.0, multipliers)))
    assert bent == pytest.approx(np.triu(np.asarray(ca.densify(whole[4]))), abs=1e-9)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("gap", [0.2, -0.1])
def test_a_check_is_met_just_when_the_clearance_is(form, gap):
    """A car straight behind a box: the certificate of its separating line holds where the gap is at least the clearance."""
    x = float(BOX[:, 0].min()) - PHYSICS.front_m - PHYSICS.clearance_m - gap
    checks = Checks(
        intervals=np.zeros(1, dtype=np.int64),
        fractions=np.zeros(1),
        vertices=BOX[None],
        angles=np.array([np.pi]),
        offsets=np.array([-6.0]),
    )
    own, low, high, numbers = check_unknowns(form, checks, np.zeros(1), clearance_cost=False)
    assert np.all(low <= own + 1e-12)
    assert np.all(own <= high + 1e-12)
    common = np.append([*PHYSICS], np.zeros(COMMON - len(PHYSICS)))
    rows, _ = check(form, False).value(np.concatenate([[x, -0.4, 0.0], own[0]]), numbers[0], common)
    least, most = check_rows(form)
    value = np.asarray(rows).ravel()
    held = bool(np.all(value >= least - 1e-9) and np.all(value <= most + 1e-9))
    assert held == (gap > 0.0)


def straight() -> ParkingProgram:
    """Two metres ahead from rest to rest, no obstacle nearer than the box."""
    n = 12
    nodes = np.zeros((n + 1, STATE))
    nodes[:, 0] = np.linspace(0.0, 2.0, n + 1)
    low, high = nodes - [5.0, 1.0, 1.0, 0.0, 0.5], nodes + [5.0, 1.0, 1.0, 2.0, 0.5]
    low[[0, -1]] = high[[0, -1]] = nodes[[0, -1]]
    checks = Checks(
        intervals=np.array([n - 1]),
        fractions=np.array([0.0]),
        vertices=BOX[None],
        angles=np.array([np.pi]),
        offsets=np.array([-6.0]),
    )
    return ParkingProgram(
        nodes=nodes,
        nodes_low=low,
        nodes_high=high,
        segments=np.zeros(n, dtype=np.int64),
        steps=np.array([0.3]),
        steps_low=np.array([0.01]),
        steps_high=np.array([1.0]),
        checks=checks,
    )


def test_both_forms_give_the_shortest_time_there_is():
    for form in FORMS:
        found = solve_parking(straight(), PHYSICS, COSTS["time"], form=form)
        assert found.violation < 1e-6
        assert found.duration_s == pytest.approx(2.0 * np.sqrt(2.0 / PHYSICS.acceleration_mps2), rel=2e-3)


def test_stage_by_stage_is_the_same_program():
    by_stages = Stages(straight(), PHYSICS, COSTS["time"], 100).solve()
    whole = solve_parking(straight(), PHYSICS, COSTS["time"])
    assert by_stages.violation < 1e-6
    assert by_stages.duration_s == pytest.approx(whole.duration_s, rel=1e-4)
    assert by_stages.nodes[0] == pytest.approx(whole.nodes[0], abs=1e-6)
    assert by_stages.nodes[-1] == pytest.approx(whole.nodes[-1], abs=1e-6)


def test_costs_have_names():
    assert costs_named("clearance").clearance > 0.0
    with pytest.raises(ParameterError, match="did you mean 'clearance'"):
        costs_named("clearence")


def test_an_interrupt_during_a_solve_is_raised_after_it():
    finished = []

    def interrupted() -> None:
        with held_interrupts():
            os.kill(os.getpid(), signal.SIGINT)
            finished.append(solve_parking(straight(), PHYSICS, COSTS["time"]))

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert len(finished) == 1
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
