"""Child processes: every task has its answer, whatever it does to its process."""

from __future__ import annotations

import importlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from mcdas_opt.errors import ParameterError
from mcdas_opt.evaluation.running.executor import ProcessPool
from mcdas_opt.evaluation.running.messages import Ended, Task, report
from mcdas_opt.evaluation.running.worker import Worker


def alive(pid: int) -> bool:
    try:
        stat = Path(f"/proc/{pid}/stat").read_text()
    except OSError:
        return False
    return stat.rpartition(")")[2].split()[0] != "Z"


def test_each_task_is_answered_once_and_by_its_own_answer() -> None:
    pool = ProcessPool(2)
    try:
        answers = dict(pool.run([Task(divmod, (k, 3)) for k in range(17)]))
    finally:
        pool.close()
    assert {k: answer.value for k, answer in answers.items()} == {k: divmod(k, 3) for k in range(17)}


def test_what_raises_hangs_or_dies_is_told_and_the_next_task_is_done() -> None:
    worker = Worker()
    try:
        assert worker.do(Task(divmod, (1, 0))).reason.startswith("ZeroDivisionError")
        late = worker.do(Task(time.sleep, (1000.0,), 0.3))
        assert (late.ended, late.reason) == (Ended.TOO_LONG, "stopped after 0.3 s")
        assert worker.do(Task(os._exit, (7,))).reason == "its process ended with code 7"
        assert worker.do(Task(divmod, (7, 2))).value == (3, 1)
    finally:
        worker.close()


def test_a_task_reports_and_goes_on_with_what_is_said_to_it() -> None:
    worker, heard = Worker(), list[int]()

    def doubled(value: int) -> int:
        heard.append(value)
        return 2 * value

    try:
        assert worker.do(Task(report, (3,)), doubled).value == 6
        assert worker.do(Task(report, (4,))).value is None, "nobody listens"
        assert worker.do(Task(divmod, (7, 2))).value == (3, 1)
    finally:
        worker.close()
    assert heard == [3]
    assert report(5) is None, "no parent"


def test_what_is_printed_does_not_get_between_the_answers(capfd: pytest.CaptureFixture[str]) -> None:
    worker = Worker()
    try:
        assert worker.do(Task(os.write, (1, b"loud\n"))).value == 5
        assert worker.do(Task(print, ("louder",))).ended is Ended.RETURNED
        assert worker.do(Task(divmod, (7, 2))).value == (3, 1)
    finally:
        worker.close()
    assert "loud" in capfd.readouterr().err


def test_children_compute_in_one_thread_and_wait_for_nothing() -> None:
    worker = Worker()
    try:
        assert worker.do(Task(os.getenv, ("OPENBLAS_NUM_THREADS",))).value == "1"
        before = worker.do(Task(time.process_time, ())).value
        time.sleep(0.6)
        assert worker.do(Task(time.process_time, ())).value - before < 0.1
    finally:
        worker.close()


def test_a_pool_that_is_left_early_stops_its_children() -> None:
    pool = ProcessPool(2)
    answers = pool.run([Task(os.getpid, ()), Task(os.getpid, ()), *[Task(time.sleep, (1000.0,))] * 4])
    pids = {next(answers)[1].value, next(answers)[1].value}
    answers.close()
    pool.close()
    assert not any(alive(pid) for pid in pids)


def test_a_pool_that_was_left_early_works_again_and_a_closed_one_says_so() -> None:
    pool = ProcessPool(1)
    answers = pool.run([Task(os.getpid, ()), *[Task(time.sleep, (1000.0,))] * 3])
    next(answers)
    answers.close()
    assert [answer.value for _, answer in pool.run([Task(divmod, (7, 2))])] == [(3, 1)]
    pool.close()
    assert [answer.ended for _, answer in pool.run([Task(divmod, (7, 2))])] == [Ended.DIED]


def test_children_import_from_where_their_parent_does(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "somewhere_else.py").write_text("def answer():\n    return 42\n", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    worker = Worker()
    try:
        assert worker.do(Task(importlib.import_module("somewhere_else").answer, ())).value == 42
    finally:
        worker.close()


def test_children_do_not_outlive_a_killed_parent() -> None:
    """Also one in the middle of a task that would never end."""
    program = (
        "import os, time\n"
        "from mcdas_opt.evaluation.running.worker import Worker\n"
        "from mcdas_opt.evaluation.running.messages import Task\n"
        "worker = Worker()\n"
        "print(worker.do(Task(os.getpid, ())).value, flush=True)\n"
        "worker.do(Task(time.sleep, (1000.0,)))\n"
    )
    parent = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert parent.stdout is not None
    child = int(parent.stdout.readline())
    assert alive(child)
    parent.send_signal(signal.SIGKILL)
    parent.wait()
    parent.stdout.close()
    for _ in range(200):
        if not alive(child):
            break
        time.sleep(0.05)
    assert not alive(child)


def test_a_pool_needs_somebody() -> None:
    with pytest.raises(ParameterError):
        ProcessPool(0)


def test_a_pool_of_more_than_any_machine_runs_is_refused() -> None:
    with pytest.raises(ParameterError, match="workers = 1000000000"):
        ProcessPool(10**9)
