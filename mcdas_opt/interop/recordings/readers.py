"""Which reader opens which recording: by the format's name, or by what the file is called."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

from mcdas_opt.domain.registry import Registry
from mcdas_opt.errors import InputError, ParameterError, nearest
from mcdas_opt.interop.recordings.recording import FOLDER, Recording

ESR_CANDUMP, RADAR_CSV = "esr-candump", "radar-csv"
READERS = Registry(
    group="mcdas_opt.recordings",
    what="format",
    own={
        ESR_CANDUMP: "mcdas_opt.interop.recordings.candump:CandumpRecording",
        RADAR_CSV: "mcdas_opt.interop.recordings.csv_table:CsvTable",
        "mdf4": "mcdas_opt.interop.recordings.mdf4:Mdf4Recording",
        "mcap": "mcdas_opt.interop.recordings.mcap:McapRecording",
        "rosbag2": "mcdas_opt.interop.recordings.rosbag2:Rosbag2Recording",
    },
)


class Reader(Protocol):
    """What an entry point names: a class with the endings of its files' names, built as `Reader(path)`."""

    @property
    def suffixes(self) -> tuple[str, ...]: ...

    def __call__(self, path: str | Path) -> Recording: ...


def format_of(path: Path) -> str:
    """The format whose files end so. Raises `InputError` that lists the formats."""
    ending = FOLDER if path.is_dir() else path.suffix.lower()
    for name in (*READERS.own, *READERS.known()):
        reader: Reader = READERS.load(name)
        if ending in reader.suffixes:
            return name
    raise InputError(path, "", None, f"is of no known format by its name; say --format, one of {', '.join(READERS.known())}")


def open_recording(path: Path, format: str) -> Recording:
    """The recording, opened. Raises `InputError` for an unknown format or a file that is not of it, `MissingExtraError`."""
    try:
        reader: Reader = READERS.load(format)
    except ParameterError:
        raise InputError("--format", "", format, f"is not a known format; {nearest(format, READERS.known())}") from None
    return reader(path)
