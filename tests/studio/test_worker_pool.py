"""Workers: what they are given comes back, what breaks is told, and none outlives its server."""

from __future__ import annotations

import asyncio
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from mcdas_opt.domain.settings import Settings
from mcdas_opt.errors import InputError, McdasError
from mcdas_opt.studio.folder import Folder
from mcdas_opt.studio.sandwich_tab import SandwichTab
from mcdas_opt.studio.worker_pool import AwaitedWorker, FaultError, LostWorkerError, StoppedError, WorkerPool, _read


def refuse() -> None:
    raise InputError("a.toml", "key", 3, "is odd")


def break_down() -> None:
    raise ZeroDivisionError("of a planner")


def die() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def test_work_comes_back_and_trouble_is_told(caplog: pytest.LogCaptureFixture) -> None:
    async def run() -> None:
        worker = AwaitedWorker()
        try:
            assert await worker.do(max, 2, 5) == 5
            first = await worker.do(os.getpid)
            assert first != os.getpid()
            with pytest.raises(McdasError, match=r"a\.toml: key = 3: is odd"):
                await worker.do(refuse)
            with pytest.raises(FaultError, match="ZeroDivisionError: of a planner"):
                await worker.do(break_down)
            assert await worker.do(os.getpid) == first, "trouble does not end it"
            with pytest.raises(LostWorkerError):
                await worker.do(die)
            assert await worker.do(os.getpid) != first, "another takes its place"
        finally:
            worker.close()
        with pytest.raises((LostWorkerError, RuntimeError)):
            await worker.do(os.getpid)

    asyncio.run(run())
    assert "break_down" in caplog.text


@pytest.mark.skipif(sys.platform == "win32", reason="operating system: niceness is POSIX's")
def test_drives_give_way_to_what_is_answered_at_once(tmp_path: Path) -> None:
    folder, own = Folder(root=tmp_path), os.getpriority(os.PRIO_PROCESS, 0)

    async def run() -> tuple[int, int]:
        worker = AwaitedWorker()
        try:
            answering = await worker.do(os.getpriority, os.PRIO_PROCESS, 0)
            for _ in range(2):
                await worker.do(_read, folder, "shipped", "sandwich-60-40", None)
            return answering, await worker.do(os.getpriority, os.PRIO_PROCESS, 0)
        finally:
            worker.close()

    assert asyncio.run(run()) == (own, min(own + 15, 19))
    assert os.getpriority(os.PRIO_PROCESS, 0) == own


def test_a_planner_that_cannot_leaves_the_others_their_word(tmp_path: Path) -> None:
    async def run() -> list[dict[str, Any]]:
        workers = WorkerPool(("closed-form", "nobody"))
        try:
            question = SandwichTab(Folder(root=tmp_path)).question()
            return [part async for part in workers.answer(question, workers.planners) if part["part"] != "waiting"]
        finally:
            workers.close()

    parts = asyncio.run(run())
    assert sorted(part["part"] for part in parts) == ["escapes", "plan", "problem"]
    assert any("nobody" in part.get("text", "") for part in parts)


def test_what_was_answered_before_waits_for_no_worker(tmp_path: Path) -> None:
    """What every page shows first was planned for each of them, behind whatever others had asked."""

    async def run() -> None:
        workers, folder = WorkerPool(("closed-form", "mpc")), Folder(root=tmp_path)
        try:
            question = SandwichTab(folder).question()
            first = [part async for part in workers.answer(question, workers.planners) if part["part"] != "waiting"]
            busy = [asyncio.create_task(worker.do(time.sleep, 1.0)) for worker in workers._workers]
            again = [part async for part in workers.answer(SandwichTab(folder).question(), workers.planners, "another page")]
            assert not any(one.done() for one in busy)
            assert sorted(map(str, again)) == sorted(map(str, first))
            other = SandwichTab(folder)
            other.act({"do": "edit", "changes": {"host_speed_mps": 17.0}})
            new = [part async for part in workers.answer(other.question(), workers.planners) if part["part"] != "waiting"]
            assert sorted(map(str, new)) != sorted(map(str, first)), "another question has its own answer"
            await asyncio.gather(*busy)
        finally:
            workers.close()

    asyncio.run(run())


def test_a_drive_tells_how_far_it_is_and_ends_when_nobody_wants_it(tmp_path: Path) -> None:
    scene = SandwichTab(Folder(root=tmp_path)).at.scene

    async def run() -> None:
        workers, heard = WorkerPool(("mpc",)), list[tuple[int, int]]()
        try:
            await workers.drive(scene, "closed-form", Settings(), lambda done, of: True)

            def no(done: int, of: int) -> bool:
                heard.append((done, of))
                return False

            with pytest.raises(StoppedError):
                await workers.drive(scene, "mpc", Settings(), no)
            (done, of), *more = heard
            assert not more
            assert 0 < done < of
            drive = await workers.drive(scene, "closed-form", Settings(), lambda done, of: True)
            assert drive["outcome"]
            with pytest.raises(McdasError, match="nobody"):
                await workers.drive(scene, "nobody", Settings(), lambda done, of: True)
        finally:
            workers.close()

    asyncio.run(run())


SERVER = """
import asyncio, os, sys
from mcdas_opt.studio.worker_pool import AwaitedWorker
worker = AwaitedWorker()
print(asyncio.run(worker.do(os.getpid)), flush=True)
sys.stdin.read()
"""


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_no_worker_outlives_its_server(how: signal.Signals, tmp_path: Path) -> None:
    script = tmp_path / "server.py"
    script.write_text(f"if __name__ == '__main__':\n{''.join(f'    {line}' + chr(10) for line in SERVER.strip().splitlines())}")
    server = subprocess.Popen(
        [sys.executable, str(script)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    )
    with server:
        assert server.stdout is not None
        child = int(server.stdout.readline())
        assert Path(f"/proc/{child}").exists() or sys.platform != "linux"
        server.send_signal(how)
        server.wait(timeout=60)
        for _ in range(600):
            try:
                os.kill(child, 0)
            except ProcessLookupError:
                return
            time.sleep(0.1)
    pytest.fail("the worker is still there")
