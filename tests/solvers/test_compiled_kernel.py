"""The compiled kernel: the same numbers as the interpreted one, for every vehicle, number of neighbours and horizon."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import sys
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from benchmarks.lane_situations import evasion, lane_problem, posed
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.native.form import SWITCH, InterpretedFormWarning, warn_interpreted
from mcdas_opt.native.library import NoLibraryError, library, load
from mcdas_opt.ocp.lane_mpc import LaneProblem, SlackPenalty, default_weights
from mcdas_opt.solvers import c_text
from mcdas_opt.solvers.barrier_stage import BarrierStage
from mcdas_opt.solvers.interior_point import RULE, InteriorPointEngine, _compiled_maker
from mcdas_opt.solvers.interpreted_kernel import side_by_side
from mcdas_opt.solvers.newton_loop import looped
from mcdas_opt.solvers.outcome import Ending
from tests.solvers.small_problems import double_integrator, idle_guess, parameters

needs_library = pytest.mark.skipif(library() is None, reason="there is no native library")
SMALL = double_integrator(x_bound=(-5.0, 3.9), u_bound=(-3.0, 3.0))


SEDAN = Vehicle()
VAN = replace(SEDAN, wheelbase_m=3.6, front_overhang_m=1.0, rear_overhang_m=1.1, width_m=2.0, steering_max_rad=0.6)


def both(problem, nodes):
    compiled = InteriorPointEngine(problem, nodes, compiled=True)
    assert compiled.kind == "compiled"
    return compiled, InteriorPointEngine(problem, nodes, compiled=False)


@needs_library
def test_its_loop_decides_as_the_written_one_to_the_bit():
    lane = lane_problem(3)
    engine = InteriorPointEngine(lane, 40, compiled=True)
    other, rng = engine.twin(), np.random.default_rng(22)
    for urgency in (1.0, 1.0, 2.0, 2.0, 2.0, 2.0):
        q = posed(*evasion(rng, 3, urgency=urgency), lane)
        for most in (60, 3):
            ends = []
            for one, loop in ((engine, engine._kernel.loop), (other, lambda **how: looped(other._kernel, **how))):
                one._load(q.x0, q.p, q.steps, q.guess)
                one._kernel.cold(10.0, 0.1)
                ends.append(repr(loop(warm=False, iterations=most, rule=RULE)))
            assert ends[0] == ends[1]
            for mine, its in zip(vars(engine._kernel.iterate).values(), vars(other._kernel.iterate).values(), strict=True):
                np.testing.assert_array_equal(mine, its)


@needs_library
def test_it_equals_the_interpreted_one_on_lane_problems_cold_and_warm():
    lane = lane_problem(3)
    compiled, interpreted = both(lane, 40)
    rng = np.random.default_rng(21)
    for _ in range(10):
        q = posed(*evasion(rng, 3), lane)
        one, two = (engine.solve(q.x0, q.p, q.steps, q.guess) for engine in (compiled, interpreted))
        assert (one.ending, one.iterations) == (two.ending, two.iterations)
        x0 = one.x[1] + 0.01
        again = [engine.solve(x0, q.p, q.steps, engine.shifted(o)) for engine, o in ((compiled, one), (interpreted, two))]
        for a, b in ((one, two), again):
            assert a.iterations == b.iterations
            np.testing.assert_allclose(a.x, b.x, atol=1e-6)
            np.testing.assert_allclose(a.u, b.u, atol=1e-6)
            np.testing.assert_allclose(a.s, b.s, atol=1e-6)
            np.testing.assert_allclose(a.multipliers, b.multipliers, rtol=1e-6, atol=1e-6)
            assert a.objective == pytest.approx(b.objective, rel=1e-9)


@needs_library
@pytest.mark.parametrize(
    ("vehicle", "neighbours", "nodes"),
    [(SEDAN, 1, 40), (SEDAN, 0, 15), (VAN, 12, 40), (load_vehicle("lincoln_mkz"), 7, 23), (load_vehicle("bmw_320i"), 5, 60), (SEDAN, 3, 1)],
)
def test_one_library_serves_every_vehicle_number_of_neighbours_and_horizon(vehicle, neighbours, nodes):
    problem = lane_problem(neighbours, vehicle)
    compiled, interpreted = both(problem, nodes)
    rng = np.random.default_rng(8)
    for _ in range(3):
        q = posed(*evasion(rng, neighbours), problem, nodes)
        one, two = (engine.solve(q.x0, q.p, q.steps, q.guess) for engine in (compiled, interpreted))
        assert (one.ending, one.iterations) == (two.ending, two.iterations)
        np.testing.assert_allclose(one.x, two.x, atol=1e-6)
        np.testing.assert_allclose(one.u, two.u, atol=1e-6)


@needs_library
@pytest.mark.parametrize(
    "options", [{"free_weights": True}, {"sloping_edges": True}, {"slips": True}, {"free_weights": True, "slips": True}]
)
def test_parameters_that_a_problem_may_have_are_found_among_its_own(options):
    """And those that it has not are fixed: the solver checks on its own that both pose the same."""
    problem = LaneProblem(vehicle=Vehicle(), neighbours=2, **options).stage_problem()
    compiled, interpreted = both(problem, 20)
    plain = lane_problem(2)
    q = posed(*evasion(np.random.default_rng(4), 2), plain, 20)
    more = {
        **dict.fromkeys(problem.parameters, 0.0),
        **default_weights(),
        "centre": Vehicle().centre_m,
        "steering_rate_share": 0.5,
        "driving_pull": 1.5,
        "braking_unloads": 0.05,
    }
    more["weight_path_deviation"] *= 1.5
    p = np.column_stack([q.p[:, plain.parameters.index(n)] if n in plain.parameters else np.full(21, more[n]) for n in problem.parameters])
    one, two = (engine.solve(q.x0, p, q.steps, q.guess) for engine in (compiled, interpreted))
    assert (one.ending, one.iterations) == (two.ending, two.iterations)
    np.testing.assert_allclose(one.x, two.x, atol=1e-6)


@needs_library
def test_it_too_survives_what_is_not_finite():
    problem = lane_problem(2)
    engine = InteriorPointEngine(problem, 20, compiled=True)
    q = posed(*evasion(np.random.default_rng(2), 2), problem, 20)
    good = engine.solve(q.x0, q.p, q.steps, q.guess)
    for x0, p in ((np.full(6, 1e200), q.p), (q.x0, np.where(np.arange(q.p.shape[1]) == q.p.shape[1] - 1, np.nan, q.p))):
        assert engine.solve(x0, p, q.steps, q.guess).ending is Ending.NOT_FINITE
    assert np.array_equal(engine.solve(q.x0, q.p, q.steps, q.guess).u, good.u)


def test_a_problem_of_no_family_is_interpreted():
    engine = InteriorPointEngine(SMALL, 20)
    assert engine.kind == "interpreted"
    n = engine.nodes
    assert engine.solve(np.zeros(2), parameters(SMALL, n, 4.0), np.full(n, 0.1), idle_guess(SMALL, n)).ending is Ending.CONVERGED
    dearer = {**LaneProblem(vehicle=Vehicle(), neighbours=1).penalties, "road": SlackPenalty(linear=1.0, quadratic=1.0, scale=0.03)}
    assert InteriorPointEngine(LaneProblem(vehicle=Vehicle(), neighbours=1, penalties=dearer).stage_problem(), 5).kind == "interpreted"


@needs_library
def test_stage_functions_of_another_problem_are_found_out(monkeypatch):
    monkeypatch.delenv(SWITCH, raising=False)
    warn_interpreted.cache_clear()
    problem = lane_problem(1)
    dearer = replace(problem, slack_linear=2.0 * problem.slack_linear)
    with pytest.warns(InterpretedFormWarning, match="of another lane problem"):
        assert InteriorPointEngine(dearer, 20).kind == "interpreted"
    wider = LaneProblem(vehicle=replace(Vehicle(), width_m=2.0), neighbours=1).stage_problem()
    warn_interpreted.cache_clear()
    with pytest.warns(InterpretedFormWarning, match="of another lane problem"):
        assert InteriorPointEngine(replace(wider, member=problem.member), 20).kind == "interpreted"


ROWS = range(lane_problem(1).ng)
PER_SLACK = ("slack_linear", "slack_quadratic", "s_scale")


def without(problem, row, hidden):
    """`problem` with one row less, or with one that is active nowhere (its value far below its slack)."""
    arguments = [ca.SX.sym(name, size) for name, size in (("x", 6), ("u", 2), ("p", len(problem.parameters)))]
    rows = ca.vertsplit(problem.inequality(*arguments))
    kept = [row_of if i != row else row_of - 1e3 for i, row_of in enumerate(rows) if hidden or i != row]
    changed = replace(problem, inequality=ca.Function("inequality", arguments, [ca.vertcat(*kept)]))
    if hidden:
        return changed
    less = {name: tuple(v for i, v in enumerate(getattr(problem, name)) if i != row) for name in ("rows", "slack_of")}
    return replace(changed, **less)


@needs_library
@pytest.mark.parametrize("hidden", [True, False], ids=["changed", "removed"])
@pytest.mark.parametrize("row", ROWS)
def test_every_row_is_compared_active_or_not(row, hidden):
    changed = without(lane_problem(1), row, hidden)
    warn_interpreted.cache_clear()
    with pytest.warns(InterpretedFormWarning, match="of another lane problem"):
        assert InteriorPointEngine(changed, 5).kind == "interpreted"


@needs_library
def test_every_cost_state_price_and_size_is_compared():
    problem = lane_problem(1)
    x, u, p, h = (ca.SX.sym(name, size) for name, size in (("x", 6), ("u", 2), ("p", len(problem.parameters)), ("h", 1)))
    residual, step, member = problem.residual(x, u, p), problem.dynamics(x, u, p, h), problem.member

    def scaled(vector, i):
        return ca.vertcat(*(each * (1.0001 if k == i else 1.0) for k, each in enumerate(ca.vertsplit(vector))))

    changes = [{"residual": ca.Function("r", [x, u, p], [scaled(residual, i)])} for i in range(residual.numel())]
    changes += [{"dynamics": ca.Function("f", [x, u, p, h], [scaled(step, i)])} for i in range(6)]
    changes += [{name: getattr(problem, name) * (1.0 + 1e-3 * (np.arange(5) == i))} for name in PER_SLACK[:2] for i in range(5)]
    changes += [{"slacks": (*problem.slacks, "new"), **{n: np.append(getattr(problem, n), 1.0) for n in PER_SLACK}}]
    changes += [{"member": replace(member, columns=member.columns[1:])}, {"member": replace(member, numbers=member.numbers[1:])}]
    for change in changes:
        with pytest.raises(NoLibraryError, match="of another lane problem"):
            _compiled_maker(BarrierStage(replace(problem, **change)), change.get("member", member), 40, load())
    assert _compiled_maker(BarrierStage(problem), member, 40, load())().kind == "compiled"


def test_the_switch_forbids_the_compiled_form(monkeypatch):
    monkeypatch.setenv(SWITCH, "0")
    engine = InteriorPointEngine(lane_problem(1), 20)
    assert (engine.kind, engine.reason) == ("interpreted", "the compiled form is switched off")


@needs_library
def test_the_switch_allows_the_portable_form_alone(monkeypatch):
    problem = lane_problem(2)
    q = posed(*evasion(np.random.default_rng(2), 2), problem)
    asked = InteriorPointEngine(problem, 40, portable=True)
    monkeypatch.setenv(SWITCH, "portable")
    chosen = InteriorPointEngine(problem, 40)
    assert chosen.kind == asked.kind == "compiled"
    one, other = (engine.solve(q.x0, q.p, q.steps, q.guess) for engine in (asked, chosen))
    assert np.array_equal(one.x, other.x)


def every_operation():
    """Values of each operation that there is C text for, at (a, b)."""
    a, b = ca.SX.sym("a"), ca.SX.sym("b")
    inside = ca.tanh(a)
    results = [a + b, a - b, a * b, a / (b**2 + 1), ca.fmin(a, b), ca.fmax(a, b), a < b, a <= b, ca.eq(a, b), ca.ne(a, b)]
    results += [ca.logic_and(a > 0, b > 0), ca.logic_or(a > 0, b > 0), ca.if_else(a > b, a, 2 * b), (a**2 + 1) ** b, (a**2 + 1) ** 1.7]
    results += [
        ca.atan2(a, b),
        ca.hypot(a, b),
        ca.fmod(a, 3.0),
        -a,
        a**2,
        2 * a,
        1 / (a**2 + 1),
        ca.logic_not(a > 0),
        ca.sign(a),
        ca.fabs(a),
    ]
    results += [ca.sqrt(a**2), ca.exp(a), ca.log(a**2 + 1), ca.sin(a), ca.cos(a), ca.tan(a), ca.asin(inside), ca.acos(inside), ca.atan(a)]
    results += [ca.sinh(a), ca.cosh(a), ca.tanh(a), ca.floor(a), ca.ceil(a), a + 1e-300, a * -2.5]
    return ca.Function("every", [ca.vertcat(a, b)], [ca.vertcat(*results)])


@pytest.mark.skipif(sys.platform == "win32" or shutil.which("cc") is None, reason="there is no C compiler")
@pytest.mark.parametrize("loop", [True, False])
def test_every_operation_means_the_same_in_c(tmp_path, loop):
    function, stages = every_operation(), 8
    head = f"#include <math.h>\n#define LANES {stages}\n"
    head += "#define LESSER(a, b) ((a) < (b) ? (a) : (b))\n#define GREATER(a, b) ((a) > (b) ? (a) : (b))\n"
    call = "every(a, r);" if loop else "for (int k = 0; k < LANES; k++) every(a + k, r + k);"
    text = f"{head}{c_text.c_function(function, loop=loop)}\nvoid run(const double *a, double *r) {{ {call} }}\n"
    source, target = tmp_path / "every.c", tmp_path / "every.so"
    source.write_text(text)
    subprocess.run(["cc", "-std=c99", "-O1", "-fPIC", "-shared", "-o", str(target), str(source), "-lm"], check=True)
    library = ctypes.CDLL(str(target))
    places = np.random.default_rng(3).uniform(-2.0, 2.0, (2, stages))
    places[:, -1] = [1.0, 1.0]
    results = np.zeros((function.size1_out(0), stages))
    library.run(places.ctypes.data_as(ctypes.c_void_p), results.ctypes.data_as(ctypes.c_void_p))
    for k in range(stages):
        np.testing.assert_allclose(results[:, k], np.asarray(function(places[:, k])).ravel(), rtol=1e-13, atol=1e-13)


def test_every_operation_means_the_same_for_stages_side_by_side():
    """To the bit; also for a result that is a constant, one that is only handed through, and none at all."""
    a, h = ca.SX.sym("a", 2), ca.SX.sym("h")
    function = ca.Function("f", [a, h, ca.SX.sym("unread", 3)], [every_operation()(a), ca.vertcat(2.5, h, 0.0), ca.SX(0, 1)])
    rng = np.random.default_rng(3)
    for stages in (1, 2, 7):
        inputs = [rng.uniform(-2.0, 2.0, (2, stages)), 0.3, np.zeros((3, stages))]
        one, other = function.map(stages).call(inputs), side_by_side(function, stages).call(inputs)
        for mapped, side in zip(one, other, strict=True):
            np.testing.assert_array_equal(np.asarray(mapped), np.asarray(side))


def test_the_text_of_a_constant_that_c_cannot_write_is_refused():
    a = ca.SX.sym("a")
    with pytest.raises(c_text.UnsupportedOperationError, match="inf"):
        c_text.c_function(ca.Function("f", [a], [a + ca.inf]), loop=False)
