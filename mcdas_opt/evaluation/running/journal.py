"""A file of records that is only ever appended to, and of which a kill at any moment costs at most the last line."""

from __future__ import annotations

import errno
import json
import os
import time
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mcdas_opt.errors import InputError, McdasError

_SYNC_S = 1.0


class StoppedError(McdasError):
    """A run that had to stop by a fault of ours; what was written is kept."""


class Journal:
    """One JSON record a line, each behind its checksum. Opening it cuts off a line that a kill has torn; `records` holds the rest.

    Raises `InputError` where an earlier line is damaged, another process has it open, or the disk takes no more: then the file ends
    with the last whole record.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            self._file = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        except OSError as error:
            raise InputError(path, "", None, f"cannot be written: {error.strerror}") from None
        if not _held(self._file):
            os.close(self._file)
            raise InputError(path, "", None, "is being written by another run")
        self.records: list[dict[str, Any]] = []
        self._end = 0
        for record, size in _whole_lines(path):
            self.records.append(record)
            self._end += size
        os.ftruncate(self._file, self._end)
        self._synced = time.monotonic()

    def append(self, record: dict[str, Any]) -> None:
        """Adds one record, whole or not at all."""
        line = _line(record)
        try:
            done = 0
            while done < len(line):
                done += os.pwrite(self._file, line[done:], self._end + done)
            if time.monotonic() - self._synced > _SYNC_S:
                os.fsync(self._file)
                self._synced = time.monotonic()
        except OSError as error:
            os.ftruncate(self._file, self._end)
            rule = f"cannot be written: {error.strerror}; {len(self.records)} records are kept, the same command with --resume goes on"
            raise InputError(self.path, "", None, rule) from None
        self._end += len(line)
        self.records.append(record)

    def close(self) -> None:
        os.close(self._file)

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _held(file: int) -> bool:
    """Whether the file is now this process's alone, until it is closed. Where the system knows no such thing: taken for granted."""
    try:
        import fcntl
    except ImportError:
        return True
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        return error.errno not in (errno.EAGAIN, errno.EACCES)
    return True


def _line(record: dict[str, Any]) -> bytes:
    text = json.dumps(record, allow_nan=False, separators=(",", ":")).encode()
    return b"%08x %s\n" % (zlib.crc32(text), text)


def _whole_lines(path: Path) -> Iterator[tuple[dict[str, Any], int]]:
    """(record, bytes) of each whole line; stops before a torn last one."""
    lines = path.read_bytes().splitlines(keepends=True)
    for number, line in enumerate(lines, start=1):
        checksum, _, text = line.rstrip(b"\n").partition(b" ")
        if not line.endswith(b"\n") or checksum != b"%08x" % zlib.crc32(text):
            if number == len(lines):
                return
            raise InputError(path, f"line {number}", None, "is damaged")
        yield json.loads(text), len(line)


def write_whole(path: Path, data: str | bytes) -> None:
    """Replaces a file in one step: readers see the old or the new one. Raises `InputError` where the disk takes no more."""
    beside = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with beside.open("wb") as file:
            file.write(data.encode() if isinstance(data, str) else data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(beside, path)
    except OSError as error:
        beside.unlink(missing_ok=True)
        raise InputError(path, "", None, f"cannot be written: {error.strerror}") from None
