"""Studies: searches, files, pruning, workers that die, the front, and the guard."""

from __future__ import annotations

import contextlib
import json
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.cli.tune import print_study
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.evaluation.running.journal import StoppedError
from mcdas_opt.evaluation.running.messages import Answer, Ended, Task
from mcdas_opt.planning.adjustable import adjusted, defaults
from mcdas_opt.planning.parameter_files import planner_with
from mcdas_opt.plotting import style
from mcdas_opt.tuning import tune_in_traffic
from mcdas_opt.tuning.choice import SetResult, choose, judged, pareto
from mcdas_opt.tuning.gain import gain_of
from mcdas_opt.tuning.search_space import SPACE, Range, default_values, shares_of, values_at
from mcdas_opt.tuning.searchers import search
from mcdas_opt.tuning.study import Trial, run_study
from mcdas_opt.tuning.study_options import StudyOptions
from mcdas_opt.tuning.traffic import DriveFigures, TrafficCost, on_executor
from tests.plotting.pixels import coloured, pixels
from tests.tuning.invented import Drives, figures, scenes, spec

pytest.importorskip("optuna")
pytest.importorskip("cmaes")
METHODS = ("tpe", "nsga2", "cma-es")


@pytest.mark.parametrize("name", ["run#1.db", "50%25.db", "100%.db", "which?.db", "{x}.db", "with space.db", "ü&=.db"])
def test_a_study_lives_in_the_file_that_was_named_whatever_its_name(tmp_path: Path, name: str) -> None:
    for trials in (1, 2):
        assert len(run_study(spec("tpe", count=1), tmp_path / name, trials, Drives())) == trials
        assert {file.name.removesuffix("-wal").removesuffix("-shm") for file in tmp_path.iterdir()} == {name}


@given(share=st.floats(0.0, 1.0))
def test_ranges_invert(share: float) -> None:
    point = np.full(len(SPACE), share)
    assert shares_of(SPACE, values_at(SPACE, point)) == pytest.approx(point, abs=1e-9)


def test_every_default_lies_in_its_range() -> None:
    assert default_values(SPACE) == {part.name: defaults()[part.name] for part in SPACE}


@pytest.mark.parametrize("method", ["random", "de", "cma-es", "tpe"])
def test_searches_repeat_count_and_come_near(method: str) -> None:
    def bowl(x: Array) -> float:
        return float(np.sum((x - 0.3) ** 2))

    first, again = search(method, bowl, 3, 120, seed=5), search(method, bowl, 3, 120, seed=5)
    assert np.array_equal(first.points, again.points)
    assert len(first.scores) == 120
    assert np.all(np.diff(first.curve) <= 0.0)
    assert first.curve[-1] < 0.05
    assert bowl(first.best) == first.curve[-1]


@pytest.mark.parametrize("method", METHODS)
def test_a_study_holds_what_was_asked_for_and_goes_on_where_it_stood(tmp_path: Path, method: str) -> None:
    storage = tmp_path / "study.db"
    run_study(spec(method), storage, 3, Drives())
    drives = Drives()
    trials = run_study(spec(method), storage, 5, drives)
    assert len(trials) == 5
    assert trials[0].values == pytest.approx(default_values(SPACE))
    assert len({tuple(trial.values.values()) for trial in trials}) == 5
    assert drives.count <= 2 * 8
    idle = Drives()
    assert run_study(spec(method), storage, 5, idle) == trials
    assert idle.count == 0


def test_the_same_seed_is_the_same_study_in_one_go_or_after_a_stop(tmp_path: Path) -> None:
    whole = run_study(spec("de"), tmp_path / "whole.db", 4, Drives())
    run_study(spec("de"), tmp_path / "parts.db", 2, Drives())
    assert [t.values for t in run_study(spec("de"), tmp_path / "parts.db", 4, Drives())] == [t.values for t in whole]


def test_pruned_trials_were_worse_early(tmp_path: Path) -> None:
    drives = Drives()
    trials = run_study(spec("de"), tmp_path / "study.db", 9, drives)
    cut = [trial for trial in trials if trial.pruned]
    assert cut
    assert drives.count < 9 * 8
    assert all(trial.cost.drives in (3, 8) and trial.cost.collisions > 0.0 for trial in cut)
    assert not [trial for trial in pareto(trials) if trial in cut]


@pytest.mark.parametrize("method", ["tpe", "cma-es"])
def test_kill_minus_nine_loses_and_doubles_no_trial(tmp_path: Path, method: str) -> None:
    storage, want = tmp_path / "study.db", 6
    root = Path(__file__).resolve().parents[2]
    command = [sys.executable, "-m", "tests.tuning.invented", str(storage), method, str(want)]
    workers = [subprocess.Popen(command, cwd=root) for _ in range(2)]
    while _finished(storage) < 2:
        assert any(worker.poll() is None for worker in workers)
        time.sleep(0.02)
    workers[0].send_signal(signal.SIGKILL)
    for worker in workers:
        worker.wait(timeout=120)
    before = _rows(storage)
    trials = run_study(spec(method), storage, want, Drives())
    assert len(trials) == want
    assert len({tuple(trial.values.values()) for trial in trials}) == want
    assert {trial.number for trial in trials} >= {number for number, state in before if state in ("COMPLETE", "PRUNED")}
    assert not [state for _, state in _rows(storage) if state in ("RUNNING", "WAITING")]


def _rows(storage: Path) -> list[tuple[int, str]]:
    with contextlib.closing(sqlite3.connect(f"file:{storage}?mode=ro", uri=True, timeout=30.0)) as base:
        return base.execute("select number, state from trials").fetchall()


def _finished(storage: Path) -> int:
    try:
        return sum(state in ("COMPLETE", "PRUNED") for _, state in _rows(storage))
    except sqlite3.Error:
        return 0


def test_the_file_of_another_study_is_left_as_it_is(tmp_path: Path) -> None:
    storage, text = tmp_path / "study.db", tmp_path / "notes.txt"
    run_study(spec("random"), storage, 2, Drives())
    text.write_text("not a study", encoding="utf-8")
    empty = tmp_path / "other.db"
    with contextlib.closing(sqlite3.connect(empty)) as base:
        base.execute("create table mine (x)")
        base.commit()
    kept = {file: file.read_bytes() for file in (storage, text, empty)}
    for wrong, file, words in (
        (spec("tpe"), storage, "search = 'random': is another study's"),
        (spec("random", count=5), storage, "scenes"),
        (spec("random"), text, "is not a study's storage"),
        (spec("random"), empty, "holds no study"),
        (spec("random"), tmp_path / "no" / "where.db", "folder does not exist"),
    ):
        with pytest.raises(InputError, match=words):
            run_study(wrong, file, 3, Drives())
    assert {file: file.read_bytes() for file in kept} == kept


def test_unknown_searches_ranges_and_values_are_told() -> None:
    with pytest.raises(ParameterError, match="did you mean 'cma-es'"):
        spec("cmaes")
    with pytest.raises(ParameterError, match="wrong order"):
        Range(name="sigmoid.b", low=50.0, high=20.0)
    with pytest.raises(ParameterError, match=r"did you mean 'cost\.nearness'"):
        adjusted({"cost.nearnes": 1.0})


COSTS = st.builds(
    TrafficCost,
    collisions=st.sampled_from([0.0, 0.25, 0.5]),
    peak_lateral_mps2=st.floats(1.0, 8.0),
    peak_jerk_mps3=st.floats(0.0, 40.0),
    manoeuvre_m=st.floats(10.0, 80.0),
    unverified=st.just(0),
    drives=st.just(8),
)


@settings(max_examples=50)
@given(costs=st.lists(COSTS, min_size=1, max_size=20))
def test_nothing_is_better_in_everything_than_the_front_and_the_choice_is_on_it(costs: list[TrafficCost]) -> None:
    trials = [Trial(number=i, values={}, cost=cost, pruned=False) for i, cost in enumerate(costs)]
    front = pareto(trials)
    for trial in trials:
        dominated = [one for one in trials if all(a < b for a, b in zip(one.cost.objectives, trial.cost.objectives, strict=True))]
        assert trial not in front or not dominated
    taken = choose(trials)
    assert taken.trial in front
    assert taken.trial.cost.collisions == min(cost.collisions for cost in costs)
    assert taken.reasons


@settings(max_examples=80)
@given(train=st.tuples(COSTS, COSTS), validation=st.tuples(COSTS, COSTS), test=st.tuples(COSTS, COSTS))
def test_the_guard_refuses_whatever_loses_on_validation(
    train: tuple[TrafficCost, TrafficCost], validation: tuple[TrafficCost, TrafficCost], test: tuple[TrafficCost, TrafficCost]
) -> None:
    sets = [
        SetResult(name=name, seed=k, scenes=(), default=default, tuned=tuned)
        for k, (name, (default, tuned)) in enumerate((("train", train), ("validation", validation), ("test", test)))
    ]
    verdict = judged(sets)
    wins = train[1].score < train[0].score
    loses = validation[1].score > validation[0].score or validation[1].collisions > validation[0].collisions
    assert verdict.accepted == (wins and not loses)
    assert verdict.reason.startswith("accepted" if verdict.accepted else "refused")
    assert [one.name for one in verdict.sets] == ["train", "validation", "test"]


class Backwards:
    """An executor that answers last things first, and whose tasks may fail."""

    def __init__(self, fails: int | None = None) -> None:
        self.fails = fails

    def run(self, tasks: Sequence[Task]) -> Iterator[tuple[int, Answer]]:
        for number in reversed(range(len(tasks))):
            scene, values = tasks[number].arguments
            if number == self.fails:
                yield number, Answer(Ended.RAISED, reason="ValueError: no")
            else:
                yield number, Answer(Ended.RETURNED, value=asdict(figures(scene, values)))

    def close(self) -> None:
        pass


def test_drives_come_in_the_order_of_their_scenes_whoever_was_faster() -> None:
    values = default_values(SPACE)
    assert list(on_executor(Backwards())(scenes(5), values)) == [figures(scene, values) for scene in scenes(5)]
    with pytest.raises(StoppedError, match="invented-2: ValueError"):
        list(on_executor(Backwards(fails=2))(scenes(5), values))


@pytest.mark.parametrize("held_out", [4, 5])
def test_a_study_reports_writes_what_is_accepted_and_draws_either_way(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, held_out: int
) -> None:
    monkeypatch.setattr(tune_in_traffic, "avoidable", lambda suite, seed, count: scenes(count))
    monkeypatch.setattr(tune_in_traffic, "in_turn", Drives())
    options = StudyOptions(scenes=5, held_out=held_out, method="random", seed=4)
    out = tmp_path / "tuned.toml"
    report = tune_in_traffic.tune_in_traffic("sandwich", 9, tmp_path / "study.db", options, out=out)
    document = json.loads(json.dumps(report.to_dict(), allow_nan=False))
    contract = {"a_per_m", "b", "y_max_m", "length_m", "objective", "value", "constraints", "method", "evaluations", "path"}
    assert contract <= set(document)
    assert document["evaluations"] == 9
    assert [one["name"] for one in document["guarded"]["sets"]] == ["train", "validation", "test"]
    assert document["value"] <= document["guarded"]["sets"][0]["default"]["collisions"] * 100.0 + 10.0
    shown = pixels(out.with_suffix(".png"))
    assert coloured(shown, style.VERMILION).sum() > 3 * 30  # the chosen one in three planes
    assert coloured(shown, style.ORANGE).sum() > 3 * 30  # the defaults
    assert (coloured(shown, style.GREEN).sum() > 1000) == bool(report.importance)
    gain, test = document["gain"], document["guarded"]["sets"][2]
    assert (gain["defaults"]["n"], gain["tuned"]["n"]) == (held_out, held_out)
    assert gain["defaults"]["k"] == round(held_out * test["default"]["collisions"])
    assert gain["score_difference"] == pytest.approx(report.guarded.sets[2].tuned.score - report.guarded.sets[2].default.score)
    assert gain["verdict"] == report.gain.verdict
    assert gain["verdict"] in repr(report)
    assert out.exists() == report.accepted
    if report.accepted:
        assert gain["verdict"] in out.read_text(encoding="utf-8")
        assert planner_with(out, Vehicle(), "mpc").settings.sigmoid.b == report.values["sigmoid.b"]
    if report.importance:
        assert sum(report.importance.values()) == pytest.approx(1.0)


@pytest.mark.parametrize("trials", [1, 9])
def test_what_a_study_found_is_read_in_80_columns(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], trials: int
) -> None:
    monkeypatch.setattr(tune_in_traffic, "avoidable", lambda suite, seed, count: scenes(count))
    monkeypatch.setattr(tune_in_traffic, "in_turn", Drives())
    monkeypatch.setenv("COLUMNS", "80")
    options = StudyOptions(scenes=12, held_out=8, method="random", seed=4)
    report = tune_in_traffic.tune_in_traffic("sandwich", trials, tmp_path / "study.db", options)
    print_study(report, Path("study.db"))
    said = capsys.readouterr().out
    assert "…" not in said
    assert max(map(len, said.splitlines())) <= 80
    for words in ("verdict", "validation", "collided", "lateral", "score", *report.values):
        assert words in said
    assert ("The best trial is the defaults" in said) == (trials == 1)
    last = " ".join(said.split("Test scenes, not tuned on, that collided, with 95 % intervals:")[1].split())
    assert last.startswith(f"defaults {report.gain.defaults.k} of 8 [")
    assert last.endswith("Tuning changed nothing." if trials == 1 else f"The tuned values are {report.gain.verdict}.")
    assert said.count("defaults │") == 3
    assert said.count("tuned    │") == (0 if trials == 1 else 3)


def driven(lateral: float, collided: bool = False) -> DriveFigures:
    return DriveFigures(collided=collided, peak_lateral_mps2=lateral, peak_jerk_mps3=1.0, manoeuvre_m=0.0, unverified=0)


@pytest.mark.parametrize(
    ("lateral", "collided", "verdict"),
    [
        ([2.0] * 8, [], "no better than the defaults: the same scores"),
        ([1.9] * 8, [], "better than the defaults: score lower in 8, higher in 0 of 8 test scenes, p = 0.0078"),
        (
            [1.9] * 7 + [2.1],
            [],
            "not shown to be better than the defaults: score lower in 7, higher in 1 of 8 test scenes, p = 0.07",
        ),
        ([2.1] * 4 + [1.9] * 4, [], "no better than the defaults: score lower in 4, higher in 4"),
        ([2.1] * 8, [], "worse than the defaults: score lower in 0, higher in 8"),
        ([1.9] * 8, [3], "no better than the defaults: collides in 1 of 8 test scenes, they in 0"),
        ([1.9] * 14 + [9.0], [], "no better than the defaults: score lower in 14, higher in 1 of 15"),
        ([], [], "nothing is known of other scenes"),
    ],
)
def test_what_tuning_brings_is_said_of_the_test_scenes(lateral: list[float], collided: list[int], verdict: str) -> None:
    tuned = [driven(value, k in collided) for k, value in enumerate(lateral)]
    gain = gain_of([driven(2.0) for _ in lateral], tuned)
    assert gain.verdict.startswith(verdict)
    assert gain.helped == verdict.startswith("better")
    assert json.loads(json.dumps(gain.to_dict(), allow_nan=False))["verdict"] == gain.verdict


@given(values=st.lists(st.tuples(st.floats(0.0, 9.0), st.booleans(), st.floats(0.0, 9.0), st.booleans()), min_size=1, max_size=30))
def test_who_helps_is_no_worse_in_any_sum_and_hurts_the_other_way_round(values: list[tuple[float, bool, float, bool]]) -> None:
    old, new = [driven(a, hit) for a, hit, _, _ in values], [driven(b, hit) for _, _, b, hit in values]
    there, back = gain_of(old, new), gain_of(new, old)
    assert (there.better, there.worse, there.score_difference) == (back.worse, back.better, pytest.approx(-back.score_difference))
    assert not (there.helped and back.helped)
    if there.helped:
        assert there.tuned.k <= there.defaults.k
        assert there.p < 0.05
