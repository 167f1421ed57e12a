"""The journal: whatever a kill or a full disk leaves, every whole record is there and nothing else."""

from __future__ import annotations

import errno
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mcdas_opt.errors import InputError
from mcdas_opt.evaluation.running.journal import Journal, write_whole
from tests.evaluation.full_disk import fill_up

RECORDS = [{"index": k, "text": "x" * (300 * k), "value": 0.1 * k} for k in range(6)]
EVERY_ONE = [HealthCheck.function_scoped_fixture]


def written(path: Path) -> None:
    with Journal(path) as journal:
        for record in RECORDS:
            journal.append(record)


def read(path: Path) -> list[dict[str, Any]]:
    with Journal(path) as journal:
        return journal.records


@pytest.fixture(scope="module")
def killed(tmp_path_factory: pytest.TempPathFactory) -> tuple[bytes, bytes, list[int]]:
    """What a kill leaves: the file, the log beside it, and the log's length at first and after each record."""
    path = tmp_path_factory.mktemp("killed") / "journal"
    program = (
        "import json, os, sys\n"
        "from pathlib import Path\n"
        "from mcdas_opt.evaluation.running.journal import Journal\n"
        "path = Path(sys.argv[1])\n"
        "journal = Journal(path)\n"
        "sizes = [os.path.getsize(f'{path}-wal')]\n"
        "for record in json.loads(sys.argv[2]):\n"
        "    journal.append(record)\n"
        "    sizes.append(os.path.getsize(f'{path}-wal'))\n"
        "print(json.dumps(sizes), flush=True)\n"
        "os.kill(os.getpid(), 9)\n"
    )
    done = subprocess.run([sys.executable, "-c", program, str(path), json.dumps(RECORDS)], capture_output=True, text=True)
    return path.read_bytes(), path.with_name("journal-wal").read_bytes(), json.loads(done.stdout)


@given(cut=st.integers(0, 200_000))
@settings(max_examples=60, deadline=None, suppress_health_check=EVERY_ONE)
def test_torn_anywhere_the_whole_records_before_are_there_and_appending_goes_on(
    tmp_path: Path, killed: tuple[bytes, bytes, list[int]], cut: int
) -> None:
    path, (file, log, sizes) = tmp_path / "journal", killed
    cut = sizes[0] + cut % (len(log) - sizes[0] + 1)
    path.write_bytes(file)
    path.with_name("journal-wal").write_bytes(log[:cut])
    kept = sum(size <= cut for size in sizes[1:])
    with Journal(path) as journal:
        assert journal.records == RECORDS[:kept]
        for record in RECORDS[kept:]:
            journal.append(record)
    assert read(path) == RECORDS


@given(place=st.integers(0, 1_000_000), bit=st.integers(0, 7))
@settings(max_examples=150, deadline=None, suppress_health_check=EVERY_ONE)
def test_a_damaged_file_is_told_and_left_alone_or_does_not_matter(tmp_path: Path, place: int, bit: int) -> None:
    path = tmp_path / "journal"
    path.unlink(missing_ok=True)
    written(path)
    whole = bytearray(path.read_bytes())
    whole[place % len(whole)] ^= 1 << bit
    path.write_bytes(whole)
    try:
        found = read(path)
    except InputError:
        assert path.read_bytes() == bytes(whole)
    else:
        assert found == RECORDS


def test_a_damaged_record_is_told(tmp_path: Path) -> None:
    path = tmp_path / "journal"
    written(path)
    whole = path.read_bytes()
    path.write_bytes(whole.replace(b"xxxx", b"xxxy", 1))
    with pytest.raises(InputError, match=r"record \d.*damaged"):
        Journal(path)


def test_a_journal_of_an_older_version_is_refused_with_what_to_do(tmp_path: Path) -> None:
    path = tmp_path / "rows.journal"
    old = b'0f1a2b3c {"index":0}\n' * 40
    path.write_bytes(old)
    with pytest.raises(InputError, match="finish the run with the version that began it, or name another --out"):
        Journal(path)
    assert path.read_bytes() == old


@pytest.mark.parametrize("pages", [2, 3, 4])
def test_a_full_disk_keeps_whole_records(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, pages: int) -> None:
    path = tmp_path / "journal"
    fill_up(monkeypatch, pages)
    done, reason = 0, ""
    with Journal(path) as journal:
        for record in [*RECORDS, *RECORDS]:
            try:
                journal.append(record)
            except InputError as error:
                reason = str(error)
                break
            done += 1
    assert 0 < done < 2 * len(RECORDS)
    assert "disk is full" in reason
    assert f"{done} records are kept" in reason
    monkeypatch.undo()
    assert read(path) == [*RECORDS, *RECORDS][:done]


def test_not_a_number_is_never_written(tmp_path: Path) -> None:
    with Journal(tmp_path / "journal") as journal, pytest.raises(ValueError, match="JSON"):
        journal.append({"value": float("nan")})
    assert read(tmp_path / "journal") == []


def test_a_file_is_replaced_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "table"
    write_whole(path, "old")

    def full(file: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(InputError, match="No space left"):
        write_whole(path, "new and longer")
    assert path.read_text() == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["table"]


def test_a_folder_that_is_not_there_is_bad_input(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be written"):
        Journal(tmp_path / "nowhere" / "journal")


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="operating system: /proc")
def test_what_cannot_be_opened_holds_no_descriptor(tmp_path: Path) -> None:
    damaged = tmp_path / "damaged"
    damaged.write_bytes(b"SQLite format 3\0" + bytes(4000))
    written(tmp_path / "journal")
    before = len(os.listdir("/proc/self/fd"))
    kept = []
    for path in [damaged, tmp_path, tmp_path / "nowhere" / "journal"] * 5:
        with pytest.raises(InputError) as refused:
            Journal(path)
        kept.append(refused.value)  # with its traceback
    read(tmp_path / "journal")
    assert len(os.listdir("/proc/self/fd")) == before


def numbers() -> list[Any]:
    return [0, 0.1, -1e-300, 1e300, True, None, "é\n"]


def test_records_come_back_to_the_last_bit(tmp_path: Path) -> None:
    path = tmp_path / "journal"
    with Journal(path) as journal:
        journal.append({"values": numbers()})
    with Journal(path) as journal:
        assert journal.records == [{"values": numbers()}]


def test_two_runs_never_write_one_file(tmp_path: Path) -> None:
    path = tmp_path / "rows.journal"
    opening = f"from pathlib import Path; from mcdas_opt.evaluation.running.journal import Journal; Journal(Path({str(path)!r}))"
    with Journal(path) as first:
        first.append({"index": 0})
        other = subprocess.run([sys.executable, "-c", opening], capture_output=True, text=True)
        assert other.stderr.strip().endswith("is being written by another run")
        first.append({"index": 1})
    with Journal(path) as again:
        assert [record["index"] for record in again.records] == [0, 1]
