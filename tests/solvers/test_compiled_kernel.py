"""The compiled kernel: the same numbers as the interpreted one, whatever becomes of compiler and cache."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys

import casadi as ca
import numpy as np
import pytest

from benchmarks.lane_situations import evasion, lane_problem, posed
from mcdas_opt.native import compile_cache
from mcdas_opt.solvers import c_text
from mcdas_opt.solvers.interior_point import RULE, SWITCH, InteriorPointEngine
from mcdas_opt.solvers.interpreted_kernel import side_by_side
from mcdas_opt.solvers.kernel_source import PORTABLE
from mcdas_opt.solvers.newton_loop import looped
from mcdas_opt.solvers.outcome import Ending
from tests.solvers.small_problems import chain, double_integrator, idle_guess, one_step, parameters, problem, wall

pytestmark = pytest.mark.filterwarnings("ignore::mcdas_opt.native.form.InterpretedFormWarning")

needs_compiler = pytest.mark.skipif(
    sys.platform == "win32" or not any(shutil.which(name) for name in ("cc", "gcc", "clang")), reason="there is no C compiler"
)


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """An empty cache folder, and compiling allowed."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.delenv(SWITCH, raising=False)
    return tmp_path / "mcdas-opt"


SMALL = double_integrator(x_bound=(-5.0, 3.9), u_bound=(-3.0, 3.0))


def both(small, nodes):
    compiled = InteriorPointEngine(small, nodes, compiled=True, announce=lambda line: None)
    assert compiled.kind == "compiled"
    return compiled, InteriorPointEngine(small, nodes, compiled=False)


def answer(engine, small=SMALL, target=4.0):
    n = engine.nodes
    x0 = np.zeros(small.nx)
    return engine.solve(x0, parameters(small, n, target), np.full(n, 0.1), idle_guess(small, n))


@needs_compiler
def test_its_loop_decides_as_the_written_one_to_the_bit(cache):
    lane = lane_problem(3)
    engine = InteriorPointEngine(lane, 40, compiled=True, announce=lambda line: None)
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


@needs_compiler
def test_it_equals_the_interpreted_one_on_lane_problems_cold_and_warm(cache):
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


@needs_compiler
@pytest.mark.parametrize(
    ("small", "nodes"),
    [
        (one_step(4.0, (-1.0, 2.0)), 1),
        (wall(0.5, at=0.5), 9),
        (double_integrator(), 7),
        (chain(np.random.default_rng(0), 3, 2)[0], 8),
        (chain(np.random.default_rng(1), 2, 4)[0], 5),
    ],
    ids=["bounds on u only", "soft rows only", "no inequality at all", "three states, two inputs", "more inputs than states"],
)
def test_it_equals_the_interpreted_one_for_every_kind_of_problem(cache, small, nodes):
    compiled, interpreted = both(small, nodes)
    one, two = answer(compiled, small), answer(interpreted, small)
    assert (one.ending, one.iterations) == (two.ending, two.iterations)
    np.testing.assert_allclose(one.x, two.x, atol=1e-9)
    np.testing.assert_allclose(one.u, two.u, atol=1e-9)
    assert one.objective == pytest.approx(two.objective, rel=1e-12)


@needs_compiler
def test_it_too_survives_what_is_not_finite(cache):
    compiled, _ = both(SMALL, 20)
    good = answer(compiled)
    n = compiled.nodes
    far = compiled.solve(np.full(2, 1e200), parameters(SMALL, n, 0.0), np.full(n, 0.1), idle_guess(SMALL, n, 1e200))
    assert far.ending is Ending.NOT_FINITE
    assert np.array_equal(answer(compiled).u, good.u)


@needs_compiler
def test_it_is_built_once_and_announced_once(cache):
    said = []
    for _ in range(3):
        assert InteriorPointEngine(SMALL, 20, announce=said.append).kind == "compiled"
    assert said == ["compiling the planner's kernels once (half a minute; `mcdas-opt warmup` does it ahead) ..."]
    assert len(list(cache.iterdir())) == 1  # the library, and no traces of its building


@needs_compiler
@pytest.mark.parametrize("damage", [lambda b: b[: len(b) // 2], lambda b: b[:-1] + b"?", lambda b: b"", lambda b: b"text"])
def test_a_damaged_library_is_built_again(cache, damage):
    first = answer(InteriorPointEngine(SMALL, 20, announce=lambda line: None))
    (path,) = cache.iterdir()
    whole = path.read_bytes()
    path.unlink()  # a new file: the old one is still mapped
    path.write_bytes(damage(whole))
    said = []
    engine = InteriorPointEngine(SMALL, 20, announce=said.append)
    assert engine.kind == "compiled"
    assert len(said) == 1
    assert [p.read_bytes() for p in cache.iterdir()] == [whole]
    assert np.array_equal(answer(engine).u, first.u)


@needs_compiler
def test_processes_may_build_at_once(cache):
    script = (
        "from tests.solvers.test_compiled_kernel import SMALL, answer\n"
        "from mcdas_opt.solvers.interior_point import InteriorPointEngine\n"
        "engine = InteriorPointEngine(SMALL, 20)\n"
        "print(engine.kind, engine.reason, answer(engine).objective)\n"
    )
    root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
    environment = {**os.environ, "PYTHONPATH": root}
    started = [
        subprocess.Popen(
            [sys.executable, "-c", script], cwd=root, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        for _ in range(3)
    ]
    said = [process.communicate(timeout=120)[0] for process in started]
    assert len(set(said)) == 1, said
    assert said[0].startswith("compiled ")
    assert all(p.suffix == ".so" for p in cache.iterdir())


def test_without_a_compiler_it_is_interpreted_and_says_so(cache, monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path / "nothing"))
    monkeypatch.delenv("CC", raising=False)
    engine = InteriorPointEngine(SMALL, 20, announce=pytest.fail)
    assert engine.kind == "interpreted"
    assert "no C compiler" in engine.reason
    assert answer(engine).ending is Ending.CONVERGED


@pytest.mark.skipif(sys.platform == "win32", reason="operating system: the fake compiler is a shell script")
@pytest.mark.parametrize(
    "body", ["echo broken >&2; exit 1", "exit 0", 'for a; do case "$last" in -o) echo junk > "$a";; esac; last="$a"; done']
)
def test_with_a_broken_compiler_it_is_interpreted_and_says_so(cache, monkeypatch, tmp_path, body):
    fake = tmp_path / "fakecc"
    fake.write_text(f"#!/bin/sh\n{body}\n")
    fake.chmod(0o755)
    monkeypatch.setenv("CC", str(fake))
    engine = InteriorPointEngine(SMALL, 20, announce=lambda line: None)
    assert engine.kind == "interpreted"
    assert "fakecc cannot build it" in engine.reason
    assert list(cache.iterdir()) == []
    assert answer(engine).ending is Ending.CONVERGED


def test_a_cache_that_cannot_be_written_is_no_reason_to_fail(monkeypatch, tmp_path):
    (tmp_path / "mcdas-opt").write_text("a file where the folder should be")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.delenv(SWITCH, raising=False)
    engine = InteriorPointEngine(SMALL, 20, announce=lambda line: None)
    assert engine.kind == "interpreted"
    assert engine.reason


def test_the_switch_forbids_compiling(cache, monkeypatch):
    monkeypatch.setenv(SWITCH, "0")
    engine = InteriorPointEngine(SMALL, 20, announce=pytest.fail)
    assert (engine.kind, engine.reason) == ("interpreted", "compiling is switched off")
    assert not cache.exists()


@needs_compiler
def test_the_switch_allows_the_portable_build_alone(cache, monkeypatch, tmp_path):
    told = tmp_path / "told"
    wrapped = tmp_path / "wrapped"
    wrapped.write_text(f'#!/bin/sh\necho "$@" >> {told}\nexec {compile_cache.compiler()} "$@"\n')
    wrapped.chmod(0o755)
    monkeypatch.setenv("CC", str(wrapped))
    monkeypatch.setenv(SWITCH, "portable")
    chosen = InteriorPointEngine(SMALL, 20, announce=lambda line: None)
    monkeypatch.delenv(SWITCH)
    asked = InteriorPointEngine(SMALL, 20, builds=PORTABLE, announce=lambda line: pytest.fail("it was built already"))
    assert chosen.kind == asked.kind == "compiled"
    assert "-march=native" not in told.read_text()
    assert "VECTOR_MATH" not in told.read_text()
    assert np.array_equal(answer(chosen).x, answer(asked).x)


def test_what_has_no_c_text_is_interpreted(cache):
    odd = problem(
        nx=1,
        nu=1,
        dynamics=lambda x, u, p, h: x + h * (u + 0.1 * ca.erf(x)),
        residual=lambda x, u, p: ca.vertcat(x - p[0], u),
        terminal=lambda x, p: x - p[0],
    )
    engine = InteriorPointEngine(odd, 5, announce=pytest.fail)
    assert engine.kind == "interpreted"
    assert "operation" in engine.reason
    assert answer(engine, odd, 1.0).ending is Ending.CONVERGED


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


@needs_compiler
@pytest.mark.parametrize("loop", [True, False])
def test_every_operation_means_the_same_in_c(cache, loop):
    import ctypes

    function, stages = every_operation(), 8
    head = f"#include <math.h>\n#define LD {stages}\n"
    head += "#define LESSER(a, b) ((a) < (b) ? (a) : (b))\n#define GREATER(a, b) ((a) > (b) ? (a) : (b))\n"
    call = "every(a, r);" if loop else "for (int k = 0; k < LD; k++) every(k, a, r);"
    text = f"{head}{c_text.c_function(function, loop=loop)}\nvoid run(const double *a, double *r) {{ {call} }}\n"
    library = compile_cache.load([text], ["-O1 -lm"], folder=cache, announce=lambda line: None)
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
