"""A file of records that is only ever appended to, and of which a kill at any moment costs no whole record."""

from __future__ import annotations

import json
import os
import sqlite3
import time
import zlib
from pathlib import Path
from typing import Any

from mcdas_opt.errors import InputError, McdasError

_SYNC_S = 1.0
_TABLE = "create table if not exists records (number integer primary key, checksum integer not null, record text not null)"
_REFUSED = {
    sqlite3.SQLITE_BUSY: "is being written by another run",
    sqlite3.SQLITE_NOTADB: "is no journal of this version (SQLite): finish the run with the version that began it, or name another --out",
}


class StoppedError(McdasError):
    """A run that had to stop by a fault of ours; what was written is kept."""


class Journal:
    """A table of JSON records (SQLite), each committed by itself, behind its checksum; `records` holds them all.

    Raises `InputError` where the file is damaged or no journal, another process has it open, or the disk takes no more: then the file
    ends with the last whole record.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            self._base = sqlite3.connect(path, timeout=0.0, isolation_level=None)
        except sqlite3.Error as error:
            raise InputError(path, "", None, f"cannot be written: {error}") from None
        try:
            self.records = self._opened()
        except BaseException:
            self._base.close()
            raise
        self._synced = time.monotonic()

    def append(self, record: dict[str, Any]) -> None:
        """Adds one record, whole or not at all."""
        text = json.dumps(record, allow_nan=False, separators=(",", ":"))
        try:
            self._base.execute("insert into records values (?, ?, ?)", (len(self.records), zlib.crc32(text.encode()), text))
            self.records.append(record)
            if time.monotonic() - self._synced > _SYNC_S:
                self._base.execute("pragma wal_checkpoint")
                self._synced = time.monotonic()
        except sqlite3.Error as error:
            rule = f"cannot be written: {error}; {len(self.records)} records are kept, the same command with --resume goes on"
            raise InputError(self.path, "", None, rule) from None

    def close(self) -> None:
        self._base.close()

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _opened(self) -> list[dict[str, Any]]:
        """Holds the file until it is closed, and reads what is there; a damaged file is left as it is."""
        try:
            self._base.text_factory = bytes  # damaged text is for the checksum to find
            self._base.execute("pragma locking_mode = exclusive")
            self._base.execute("pragma journal_mode = wal")
            self._base.execute("pragma synchronous = normal")  # a kill loses nothing; `append` waits for the disk once in a while
            self._base.execute("begin exclusive")
            self._base.execute(_TABLE)
            whole = self._base.execute("pragma quick_check").fetchall() == [(b"ok",)]
            rows = self._base.execute("select number, checksum, record from records order by number").fetchall()
            for place, (number, checksum, text) in enumerate(rows):
                if number != place or not isinstance(text, bytes) or zlib.crc32(text) != checksum:
                    raise InputError(self.path, f"record {place}", None, "is damaged")
            if not whole:
                raise InputError(self.path, "", None, "is damaged")
            self._base.execute("commit")
        except UnicodeDecodeError:  # SQLite quotes a damaged schema
            raise InputError(self.path, "", None, "is damaged") from None
        except sqlite3.Error as error:
            rule = _REFUSED.get(error.sqlite_errorcode & 0xFF, f"is damaged or cannot be written: {error}")
            raise InputError(self.path, "", None, rule) from None
        return [json.loads(text) for _, _, text in rows]


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
