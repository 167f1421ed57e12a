"""Workers on other computers: whom one waits for, how long, and what becomes of a trial whose worker was taken for dead."""

from __future__ import annotations

import logging
import os
import platform
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest

from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.tuning import workers
from mcdas_opt.tuning.search_space import SPACE
from mcdas_opt.tuning.storage import open_study
from mcdas_opt.tuning.study import run_study
from mcdas_opt.tuning.traffic import OBJECTIVES, DriveFigures
from tests.tuning.invented import Drives, spec

optuna = pytest.importorskip("optuna")
pytest.importorskip("cmaes")
ELSEWHERE = "yesterdays-container:1:123"


def opened(storage: Path, method: str = "tpe") -> Any:
    wanted = spec(method)
    return open_study(storage, wanted.name, wanted.fingerprint, len(OBJECTIVES))


def begun_elsewhere(study: Any) -> Any:
    trial = study.ask({part.name: optuna.distributions.FloatDistribution(part.low, part.high, log=part.log) for part in SPACE})
    trial.set_user_attr("worker", ELSEWHERE)
    return trial


def numbers(study: Any, state: Any) -> list[int]:
    return [trial.number for trial in study.get_trials(deepcopy=False, states=(state,))]


@pytest.mark.parametrize("method", ["tpe", "cma-es"])
def test_a_worker_that_is_gone_from_another_computer_is_waited_for_no_longer_than_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, method: str
) -> None:
    class Meanwhile(Drives):
        """The last that is heard of the other worker is during our last drive."""

        def __call__(self, scenes: Sequence[Scene], values: Mapping[str, float]) -> Iterator[DriveFigures]:
            if left.number in numbers(study, optuna.trial.TrialState.RUNNING):
                left.set_user_attr("seen_s", time.time())
            yield from super().__call__(scenes, values)

    monkeypatch.setattr(workers, "SILENT_S", 4.0)
    monkeypatch.setattr(workers, "_PATIENT_S", 0.1)
    caplog.set_level(logging.INFO, "mcdas_opt")
    study = opened(tmp_path / "study.db", method)
    left = begun_elsewhere(study)
    assert len(run_study(spec(method), tmp_path / "study.db", 3, Meanwhile())) == 3
    assert numbers(study, optuna.trial.TrialState.FAIL) == [left.number]
    told = [record.getMessage() for record in caplog.records]
    assert told[0].startswith(f"waiting for trial {left.number}, in hand of process 1 on yesterdays-container; it counts as failed")
    assert told[1].startswith(f"trial {left.number} counts as failed: nothing was heard of process 1 on yesterdays-container")
    assert len(told) == 2


def test_a_worker_elsewhere_that_shows_life_keeps_its_trial(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workers, "SILENT_S", 1.0)
    monkeypatch.setattr(workers, "BEAT_S", 0.05)
    study, others = opened(tmp_path / "study.db"), workers.Others()
    trial = begun_elsewhere(study)

    def left() -> bool:
        return others.left(study.trials[trial.number])

    with workers.heard_of(trial):
        until = time.monotonic() + 1.6
        while time.monotonic() < until:
            assert not left()
            time.sleep(0.1)
    time.sleep(1.3)
    assert left()


@pytest.mark.parametrize(("ahead_s", "is_left"), [(-1e5, True), (-10.0, False), (1e5, False)])
def test_a_clock_of_another_computer_that_is_ahead_only_makes_us_look(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ahead_s: float, is_left: bool
) -> None:
    study, others = opened(tmp_path / "study.db"), workers.Others()
    trial = begun_elsewhere(study)
    trial.set_user_attr("seen_s", time.time() + ahead_s)
    assert others.left(study.trials[0]) is is_left
    later = time.monotonic() + workers.SILENT_S + 1.0
    monkeypatch.setattr(time, "monotonic", lambda: later)
    assert others.left(study.trials[0])


def test_who_was_taken_for_dead_goes_on_with_another_trial(tmp_path: Path) -> None:
    class TakenOver(Drives):
        """While the first trial is driven, others give it up."""

        def __call__(self, scenes: Sequence[Scene], values: Mapping[str, float]) -> Iterator[DriveFigures]:
            if self.count == 0:
                study.tell(0, state=optuna.trial.TrialState.FAIL)
            yield from super().__call__(scenes, values)

    study = opened(tmp_path / "study.db")
    trials = run_study(spec("tpe"), tmp_path / "study.db", 3, TakenOver())
    assert [trial.number for trial in trials] == [1, 2, 3]
    assert numbers(study, optuna.trial.TrialState.FAIL) == [0]


def test_a_worker_of_this_computer_is_gone_when_its_process_is(tmp_path: Path) -> None:
    study, others = opened(tmp_path / "study.db"), workers.Others()
    trial = begun_elsewhere(study)
    workers.sign(trial)
    assert not others.left(study.trials[0])
    trial.set_user_attr("worker", f"{platform.node()}:{os.getpid()}:1")  # its number, but another start
    assert others.left(study.trials[0])
