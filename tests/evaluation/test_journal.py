"""The journal: whatever a kill or a full disk leaves, every whole record is there and nothing else."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mcdas_opt.errors import InputError
from mcdas_opt.evaluation.running.journal import Journal, write_whole

RECORDS = [{"index": k, "text": "x" * (3 * k), "value": 0.1 * k} for k in range(6)]


def written(path: Path) -> bytes:
    with Journal(path) as journal:
        for record in RECORDS:
            journal.append(record)
    return path.read_bytes()


@given(cut=st.integers(0, 10_000))
@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_cut_anywhere_the_whole_records_before_are_there_and_appending_goes_on(tmp_path: Path, cut: int) -> None:
    path = tmp_path / "journal"
    path.unlink(missing_ok=True)
    whole = written(path)
    cut %= len(whole) + 1
    path.write_bytes(whole[:cut])
    kept = whole[:cut].count(b"\n")
    with Journal(path) as journal:
        assert journal.records == RECORDS[:kept]
        for record in RECORDS[kept:]:
            journal.append(record)
    assert path.read_bytes() == whole


def test_a_damaged_line_in_the_middle_is_told_and_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "journal"
    whole = bytearray(written(path))
    whole[30] ^= 1
    path.write_bytes(whole)
    with pytest.raises(InputError, match=r"line \d.*damaged"):
        Journal(path)
    assert path.read_bytes() == bytes(whole)


@given(room=st.integers(0, 400))
@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_full_disk_keeps_whole_records(tmp_path: Path, room: int) -> None:
    """The device takes `room` more bytes, writing as much of a line as fits."""
    path = tmp_path / "journal"
    path.unlink(missing_ok=True)
    left, true_write = [room], os.pwrite

    def short_write(file: int, data: bytes, at: int) -> int:
        if left[0] == 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        done = true_write(file, data[: left[0]], at)
        left[0] -= done
        return done

    with pytest.MonkeyPatch.context() as patch, Journal(path) as journal:
        patch.setattr(os, "pwrite", short_write)
        done, reason = 0, ""
        for record in RECORDS:
            try:
                journal.append(record)
            except InputError as error:
                reason = str(error)
                break
            done += 1
    if done < len(RECORDS):
        assert "No space left" in reason
        assert f"{done} records are kept" in reason
    with Journal(path) as journal:
        assert journal.records == RECORDS[:done]


def test_not_a_number_is_never_written(tmp_path: Path) -> None:
    with Journal(tmp_path / "journal") as journal, pytest.raises(ValueError, match="JSON"):
        journal.append({"value": float("nan")})
    assert (tmp_path / "journal").read_bytes() == b""


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


def numbers() -> list[Any]:
    return [0, 0.1, -1e-300, 1e300, True, None, "é\n"]


def test_records_come_back_to_the_last_bit(tmp_path: Path) -> None:
    path = tmp_path / "journal"
    with Journal(path) as journal:
        journal.append({"values": numbers()})
    with Journal(path) as journal:
        assert journal.records == [{"values": numbers()}]


def test_two_runs_never_write_one_file(tmp_path: Path) -> None:
    pytest.importorskip("fcntl", reason="operating system: locks as POSIX has them")
    path = tmp_path / "rows.journal"
    with Journal(path) as first:
        first.append({"index": 0})
        with pytest.raises(InputError, match="another run"):
            Journal(path)
        first.append({"index": 1})
    with Journal(path) as again:
        assert [record["index"] for record in again.records] == [0, 1]
