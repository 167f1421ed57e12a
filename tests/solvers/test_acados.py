"""The race's acados engine: the same problem as everybody's, where acados is installed; one line where it is not."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.acados_engine import AcadosEngine
from benchmarks.lane_situations import evasion, lane_problem, posed
from mcdas_opt.solvers.interior_point import InteriorPointEngine
from mcdas_opt.solvers.outcome import Ending

PROBLEM, NODES = lane_problem(2), 20


@pytest.fixture(scope="module", params=[False, True], ids=["Gauss-Newton", "curved"])
def engine(request):
    try:
        return AcadosEngine(PROBLEM, NODES, curved=request.param)
    except ImportError as error:  # one that is there and cannot generate or compile is a failure
        pytest.skip(str(error))


def family(seed, count):
    rng = np.random.default_rng(seed)
    return [posed(*evasion(rng, 2), PROBLEM, NODES) for _ in range(count)]


def test_it_solves_the_same_problem(engine):
    ours = InteriorPointEngine(PROBLEM, NODES, compiled=False)
    for q in family(3, 8):
        engine.reset()
        theirs, mine = (e.solve(q.x0, q.p, q.steps, q.guess, 60) for e in (engine, ours))
        assert theirs.ending is Ending.CONVERGED
        assert theirs.objective == pytest.approx(mine.objective, rel=1e-3)
    assert len(engine.seconds) == 8


def test_a_reset_forgets_everything(engine):
    first, second = family(4, 2)
    answers = []
    for before in ((), (second,), (second, second)):
        for q in before:
            engine.solve(q.x0, q.p, q.steps, q.guess)
        engine.reset()
        answers.append(engine.solve(first.x0, first.p, first.steps, first.guess).u.tobytes())
    assert len(set(answers)) == 1


def test_absence_is_an_import_error(tmp_path, monkeypatch):
    monkeypatch.setenv("ACADOS_SOURCE_DIR", str(tmp_path / "install"))
    with pytest.raises(ImportError, match="no acados_template beside"):
        AcadosEngine(PROBLEM, NODES)
    monkeypatch.delenv("ACADOS_SOURCE_DIR")
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(ImportError, match="acados is not installed"):
        AcadosEngine(PROBLEM, NODES)


def test_a_missing_renderer_is_named_and_nothing_is_asked(tmp_path, monkeypatch):
    (tmp_path / "acados_template").mkdir()
    monkeypatch.setenv("ACADOS_SOURCE_DIR", str(tmp_path / "install"))
    with pytest.raises(RuntimeError, match="t_renderer"):
        AcadosEngine(PROBLEM, NODES)
