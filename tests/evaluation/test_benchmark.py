"""A benchmark's run: every scene and planner has its row, whoever misbehaves and whenever it is killed."""

from __future__ import annotations

import importlib.util
import json
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from mcdas_opt.catalogue.scenes import load_scene
from mcdas_opt.cli.app import app
from mcdas_opt.domain.settings import Settings
from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.evaluation import benchmark
from mcdas_opt.evaluation.benchmark import Results, run
from mcdas_opt.evaluation.comparison import benchmark as compare
from mcdas_opt.evaluation.families import shipped_suites
from mcdas_opt.evaluation.provenance import digest
from mcdas_opt.evaluation.results_folder import JOURNAL, LABELS, MANIFEST
from mcdas_opt.evaluation.running.executor import ProcessPool
from mcdas_opt.evaluation.running.journal import Journal
from mcdas_opt.evaluation.suites import Suite, expand
from mcdas_opt.evaluation.table import PARQUET, read_table, write_table
from mcdas_opt.simulation.loop import simulate
from tests.cli.command_line import run as run_here
from tests.evaluation.full_disk import fill_up

pytestmark = pytest.mark.usefixtures("users_planners")


def driven(suite: Suite, planners: tuple[str, ...], folder: Path, workers: int = 1, limit_s: float = 60.0, resume: bool = False) -> Results:
    pool = ProcessPool(workers)
    try:
        return run(suite, planners, folder, pool, limit_s=limit_s, resume=resume)
    finally:
        pool.close()


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def test_rows_and_hash_do_not_depend_on_how_many_work(short_suite: Path, tmp_path: Path) -> None:
    suite = expand(short_suite, 4, seed=3)
    one, two = (driven(suite, ("gentle", "closed-form"), tmp_path / str(n), workers=n) for n in (1, 2))
    assert one.rows == two.rows
    assert one.rows_hash == two.rows_hash
    assert [(row["index"], row["planner"]) for row in one.rows] == [(k, name) for k in range(4) for name in ("gentle", "closed-form")]
    assert all(len(cycles) == row["plans"] for row, cycles in zip(one.rows, one.cycles_ms, strict=True))
    assert not any("_ms" in key or "time_ms" in key for key in one.rows[0])
    assert {row["label"] for row in one.rows} == {"-"}


def test_who_raises_or_dies_marks_its_row_and_the_run_goes_on(short_suite: Path, tmp_path: Path) -> None:
    suite = expand(short_suite, 1, seed=3)
    results = driven(suite, ("gentle", "raises", "dies", "prints"), tmp_path / "out")
    ended = {name: {row["ended"] for row in results.rows if row["planner"] == name} for name in results.manifest["planners"]}
    assert ended == {"gentle": {"drove"}, "raises": {"raised"}, "dies": {"died"}, "prints": {"drove"}}
    by_name = {row["planner"]: row for row in results.rows}
    assert by_name["raises"]["error"] == "PlannerFaultError: planner 'raises' at t = 0.30 s: raised RuntimeError: no idea"
    assert by_name["dies"]["error"].endswith("code 7")
    assert by_name["dies"]["outcome"] == ""
    gentle, prints = ([row for row in results.rows if row["planner"] == name] for name in ("gentle", "prints"))
    assert [row | {"planner": ""} for row in gentle] == [row | {"planner": ""} for row in prints]


def test_who_hangs_is_stopped_at_the_limit(short_suite: Path, tmp_path: Path) -> None:
    results = driven(expand(short_suite, 2, seed=3), ("hangs",), tmp_path / "out", limit_s=1.0)
    assert [(row["ended"], row["error"]) for row in results.rows] == [("too long", "stopped after 1 s")] * 2


def test_labels_are_frozen_before_anybody_drives(labelled_suite: Path, tmp_path: Path) -> None:
    suite, folder = expand(labelled_suite, 3, seed=3), tmp_path / "out"
    stages: list[tuple[str, bool]] = []
    pool = ProcessPool(1)
    try:
        results = run(
            suite, ("gentle",), folder, pool, progress=lambda stage, done, of: stages.append((stage, (folder / LABELS).is_file()))
        )
    finally:
        pool.close()
    assert stages[0] == ("labels", False)
    assert all(frozen for stage, frozen in stages if stage == "drives")
    frozen = json.loads((folder / LABELS).read_text())
    assert frozen["suite_hash"] == suite.hash == results.manifest["suite_hash"]
    assert frozen["labels_hash"] == digest(frozen["labels"]) == results.manifest["labels_hash"]
    assert [label for _, label, *_ in frozen["labels"]] == [row["label"] for row in results.rows]


def test_a_folder_of_another_run_is_refused_and_left_alone(short_suite: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    suite, folder = expand(short_suite, 2, seed=3), tmp_path / "out"
    first = driven(suite, ("gentle",), folder)
    before = contents(folder)
    with pytest.raises(InputError, match="--resume"):
        driven(suite, ("gentle",), folder)
    with pytest.raises(InputError, match="suite_hash"):
        driven(Suite(name=suite.name, seed=3, cases=tuple(reversed(suite.cases))), ("gentle",), folder, resume=True)
    with pytest.raises(InputError, match="planners"):
        driven(suite, ("closed-form",), folder, resume=True)
    with monkeypatch.context() as patch:
        patch.setattr(benchmark.provenance, "versions", lambda: {"mcdas-opt": "0.0.9"})
        with pytest.raises(InputError, match="versions"):
            driven(suite, ("gentle",), folder, resume=True)
    assert contents(folder) == before
    assert driven(suite, ("gentle",), folder, resume=True).rows_hash == first.rows_hash
    foreign = tmp_path / "letters"
    foreign.mkdir()
    (foreign / "letter.txt").write_text("dear")
    with pytest.raises(InputError, match="holds no such run"):
        driven(suite, ("gentle",), foreign)
    assert contents(foreign) == {"letter.txt": b"dear"}


def test_a_class_stands_beside_the_registered_ones_by_its_place(short_suite: Path, users_planners: Path) -> None:
    theirs = import_module("their_planners")
    found = compare(short_suite, [theirs.Gentle, "gentle"], scenes=2)
    by_class, by_name = ([row for row in found.rows if row["planner"] == name] for name in ("their_planners:Gentle", "gentle"))
    assert [{**row, "planner": ""} for row in by_class] == [{**row, "planner": ""} for row in by_name]
    assert {row["ended"] for row in by_class} == {"drove"}

    class Here(theirs.Gentle):
        pass

    for wrong, says in (
        (Here, "at the top level of a module"),
        ("their_planners:Nobody", "no attribute 'Nobody'"),
        ("nowhere:Gentle", "No module named 'nowhere'"),
        (theirs.Gentle(None, None), "must be a str or a type"),
    ):
        with pytest.raises(ParameterError, match=says):
            compare(short_suite, ["mpc", wrong], scenes=1)


def test_an_unknown_planner_is_told_with_the_known_ones(short_suite: Path, tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match=r"known: .*closed-form.*gentle.*mpc"):
        driven(expand(short_suite, 1), ("mpg",), tmp_path / "out")
    with pytest.raises(ParameterError, match="twice"):
        driven(expand(short_suite, 1), ("mpc", "mpc"), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_an_unknown_plant_is_told_before_anybody_drives(short_suite: Path, tmp_path: Path) -> None:
    pool = ProcessPool(1)
    with pytest.raises(ParameterError, match="did you mean 'kinematic'"):
        run(expand(short_suite, 1), ("mpc",), tmp_path / "out", pool, plant="kinetic")
    pool.close()
    assert not (tmp_path / "out").exists()


def test_a_full_disk_stops_with_the_rows_kept_and_resuming_completes_them(
    short_suite: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    suite, folder = expand(short_suite, 6, seed=4), tmp_path / "out"
    whole = driven(suite, ("gentle",), tmp_path / "whole")
    with monkeypatch.context() as patch:
        fill_up(patch, 2)
        found = CliRunner().invoke(
            app,
            ["benchmark", str(short_suite), "--scenes", "6", "--seed", "4", "--planners", "gentle", "--out", str(folder), "--workers", "1"],
        )
    assert isinstance(found.exception, InputError)  # the program's exit code 2
    assert "disk is full" in str(found.exception)
    with Journal(folder / JOURNAL) as journal:
        kept = len(journal.records)
    assert 0 < kept < 6
    manifest = json.loads((folder / MANIFEST).read_text())
    assert driven(suite, ("gentle",), folder, resume=True, limit_s=manifest["limit_s"]).rows == whole.rows


def program(suite: Path, folder: Path, *more: str) -> list[str]:
    """A process that drives six scenes with two planners, and prints the hash of its rows."""
    return [sys.executable, "-m", "tests.evaluation.run_only", str(suite), str(folder), *more]


def whole_table(results: str) -> tuple[str, list[Any]]:
    found = json.loads(results)
    return found["rows_hash"], found["rows"]


def test_killed_at_any_point_and_resumed_the_rows_are_the_same(short_suite: Path, tmp_path: Path) -> None:
    whole = subprocess.run(program(short_suite, tmp_path / "whole"), capture_output=True, check=True, text=True).stdout
    folder = tmp_path / "killed"
    for rows in (0, 1, 7):
        with subprocess.Popen(program(short_suite, folder), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as child:
            wait_for_rows(rows, child)
            child.send_signal(signal.SIGKILL)
    with Journal(folder / JOURNAL) as journal:
        assert 7 <= len(journal.records) < 12
    last = subprocess.run(program(short_suite, folder), capture_output=True, check=True, text=True).stdout
    assert whole_table(last) == whole_table(whole)
    rows_there = whole_table(last)[1]
    assert len({(row["index"], row["planner"]) for row in rows_there}) == len(rows_there) == 12


def wait_for_rows(count: int, child: subprocess.Popen[str]) -> None:
    """Until `run_only` says that so many rows are written."""
    assert child.stderr is not None
    for line in child.stderr:
        stage, _, done = line.partition(" ")
        if stage == "drives" and int(done) >= count:
            return
    raise AssertionError(f"it ended before row {count}")


def test_json_is_the_contracts(short_suite: Path, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    command = [sys.executable, "-m", "mcdas_opt", "benchmark", str(short_suite), "--scenes", "2", "--planners", "gentle,aeb", "--json"]
    done = subprocess.run([*command, "--out", str(folder)], capture_output=True, check=True, text=True)
    document = json.loads(done.stdout, parse_constant=lambda name: pytest.fail(name))
    assert {"rows", "rows_hash", "summary", "pairs", "report", "suite_hash", "labels_hash", "seed", "versions", "commit"} <= document.keys()
    assert set(document["summary"]) == {"gentle", "aeb"}
    share = document["summary"]["gentle"]["scripted"]["collisions"]
    assert 0.0 <= share["low"] <= share["k"] / share["n"] <= share["high"] <= 1.0
    assert share["n"] == 2
    origin, rows = read_table(Path(document["rows"]))
    assert len(rows) == 4
    assert origin["rows_hash"] == document["rows_hash"]
    for file in ("rows.csv", "timings.csv", "report.html", "report.md", "summary.json"):
        text = (folder / file).read_text(encoding="utf-8")
        assert document["suite_hash"] in text, file
        assert document["versions"]["mcdas-opt"] in text, file
    assert re.search(r"drives: 4 of 4, [\d.]+/s", done.stderr)


def test_why_a_planner_failed_is_said_beside_the_table(
    short_suite: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["benchmark", str(short_suite), "--scenes", "2", "--planners", "gentle,raises", "--workers", "1", "--out"]
    code, _, err = run_here(monkeypatch, capsys, *command, str(tmp_path / "out"))
    assert code == 0
    said = [line for line in err.splitlines() if "failed" in line]
    assert len(said) == 1
    assert "raises failed in 2 of 2 drives, in the first: " in said[0]
    assert said[0].endswith("RuntimeError: no idea")


def test_the_parquet_file_holds_the_rows_with_their_types(short_suite: Path, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    results = driven(expand(short_suite, 2, seed=3), ("closed-form",), tmp_path / "run")
    origin, _ = read_table(write_table(tmp_path, results, {"seed": 3}))
    table = parquet.read_table(tmp_path / PARQUET)
    assert json.loads(table.schema.metadata[b"mcdas_opt"]) == origin
    assert table.to_pylist() == [dict(row) for row in results.rows]


def test_a_contradiction_of_the_oracle_fails_the_run(labelled_suite: Path, tmp_path: Path) -> None:
    """Labels that call everything unavoidable, and a planner that is safe somewhere."""
    suite, folder = expand(labelled_suite, 2, seed=3), tmp_path / "out"
    results = driven(suite, ("gentle",), folder, limit_s=300.0)
    assert any(row["outcome"] == "safe" for row in results.rows)
    frozen = json.loads((folder / LABELS).read_text())
    frozen["labels"] = [[index, "U", "U", "U", onset] for index, *_, onset in frozen["labels"]]
    (folder / LABELS).write_text(json.dumps(frozen))
    found = CliRunner().invoke(
        app, ["benchmark", str(labelled_suite), "--scenes", "2", "--seed", "3", "--planners", "gentle", "--out", str(folder), "--resume"]
    )
    assert found.exit_code == 1
    assert "unavoidable" in found.output
    assert (folder / "rows.csv").is_file()


@contextmanager
def cluster(folder: Path) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """A Dask scheduler and two workers of one thread each, as processes of their own."""
    file = folder / "scheduler.json"
    quiet: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    tool = [sys.executable, "-m"]
    scheduler = [
        *tool,
        "distributed.cli.dask_scheduler",
        "--host",
        "127.0.0.1",
        "--port",
        "0",
        "--no-dashboard",
        "--scheduler-file",
        str(file),
    ]
    worker = [*tool, "distributed.cli.dask_worker", "--scheduler-file", str(file), "--nthreads", "1", "--no-nanny", "--no-dashboard"]
    running = [subprocess.Popen(scheduler, **quiet)]
    try:
        for _ in range(600):
            if file.is_file() and file.read_text().strip():
                break
            time.sleep(0.05)
        running += [subprocess.Popen([*worker, "--local-directory", str(folder)], **quiet) for _ in range(2)]
        yield json.loads(file.read_text())["address"], running[1:]
    finally:
        for process in running:
            process.kill()
            process.wait()


@pytest.mark.skipif(importlib.util.find_spec("distributed") is None, reason="needs the extra dask")
def test_a_dask_cluster_gives_the_same_rows_also_when_a_worker_is_killed(short_suite: Path, tmp_path: Path) -> None:
    here = subprocess.run(program(short_suite, tmp_path / "here"), capture_output=True, check=True, text=True).stdout
    folder = tmp_path / "there"
    with cluster(tmp_path) as (address, workers):
        child = subprocess.Popen(program(short_suite, folder, address), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        wait_for_rows(2, child)
        workers[0].send_signal(signal.SIGKILL)
        out, err = child.communicate(timeout=240)
    assert child.returncode == 0, err
    assert whole_table(out) == whole_table(here)


def test_nobody_at_the_schedulers_address_is_bad_input(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed")
    from mcdas_opt.evaluation.running import dask_cluster

    monkeypatch.setattr(dask_cluster, "_CONNECT_S", 0.2)
    with pytest.raises(InputError, match="no Dask scheduler answers"):
        dask_cluster.DaskCluster("tcp://127.0.0.1:9")


def test_the_planner_of_the_documentation_drives() -> None:
    """Its block of ten lines, as printed."""
    text = (Path(__file__).resolve().parents[2] / "docs" / "extend" / "planner.md").read_text(encoding="utf-8")
    block = re.search(r"```python\n(.*?)```", text.partition("## From an acceleration law")[2], re.S)
    assert block is not None
    assert len([line for line in block[1].splitlines() if line.strip()]) <= 10
    names: dict[str, Any] = {}
    exec(compile(block[1], "planner.md", "exec"), names)
    scene = load_scene("stopped-obstacle")
    drive = simulate(scene.model_copy(update={"duration_s": 1.0}), names["Timid"](scene.vehicle, Settings()))
    assert drive.plans == 10
    assert drive.trajectory.speed_mps[-1] < scene.host.speed_mps - 1.0


def test_the_documentation_lists_what_is_shipped() -> None:
    text = (Path(__file__).resolve().parents[2] / "docs" / "benchmark.md").read_text(encoding="utf-8")
    listed = set(re.findall(r"^\| `([\w-]+)` \| [\w, ]+ \| (?:scripted|reacting|recorded)", text, re.M))
    assert listed == set(shipped_suites())
