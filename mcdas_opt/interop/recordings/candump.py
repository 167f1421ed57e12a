"""CAN logs as text: the format of `candump -L` (can-utils), `(seconds) bus ID#DATA` a line.

python-can parses the lines; which lines it is given is decided here, because its reader stops at the first bad one and takes
half a byte for a whole one.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Iterable
from pathlib import Path

from mcdas_opt.catalogue.data_files import read_bytes
from mcdas_opt.errors import InputError, of_extra
from mcdas_opt.interop.recordings.recording import CanLog, Frame, Table, Tally, no_such_channel

_SOUND = re.compile(
    r"\(\d{1,12}(\.\d{1,9})?\)\s+\S+\s+([0-9A-Fa-f]{3}|[0-9A-Fa-f]{8})#(([0-9A-Fa-f]{2}){0,8}|R\d?|#\d([0-9A-Fa-f]{2}){0,64})(\s+[RT])?"
)
_BEGUN = re.compile(r"\([\d.]*(\)(\s+(\S+(\s+[0-9A-Fa-f]{0,8}(#(([0-9A-Fa-f]{0,15}|#(\d[0-9A-Fa-f]{0,127})?)(\s+[RT]?)?)?)?)?)?)?)?")
ISOLATED_S = 60.0  # a stamp this far from both its neighbours is no stamp of this recording


def read_candump(path: str | Path) -> CanLog:
    """Every sound data frame of a log. Bad lines are left out and counted by kind.

    Raises `InputError` where the file cannot be read or holds no line of the format, `MissingExtraError` without python-can.
    """
    text = read_bytes(Path(path)).decode("utf-8", errors="replace")
    bad, numbers, sound = Tally(), [], []
    for number, line in enumerate(text.split("\n"), start=1):
        entry = line.strip()
        if not entry:
            continue
        if _SOUND.fullmatch(entry):
            numbers.append(number)
            sound.append(entry)
        else:
            bad.add("cut short" if _BEGUN.fullmatch(entry) else "not a candump line", number)
    if not sound:
        shown = text[:40].split("\n")[0]
        raise InputError(path, "line 1", shown, "is no candump log: wants lines '(seconds) bus ID#DATA', as `candump -L` writes them")
    frames = _parse(sound, numbers)
    kept = [frame for k, frame in enumerate(frames) if not _isolated(frames, k)]
    for frame in set(frames) - set(kept):
        bad.add("stamp far from its neighbours", frame.line)
    return CanLog(frames=tuple(kept), bad=bad, other=len(sound) - len(frames))


class CandumpRecording:
    """A log of CAN frames as text; raises as `read_candump`."""

    suffixes = (".log", ".candump")

    def __init__(self, path: str | Path) -> None:
        self.path = path
        self._log = read_candump(path)

    @property
    def channels(self) -> tuple[str, ...]:
        """The buses."""
        return tuple(sorted({frame.channel for frame in self._log.frames}))

    def can_log(self) -> CanLog:
        return self._log

    def table(self, *names: str) -> Table:
        """There is none in a log of frames."""
        raise no_such_channel(self.path, names, self.channels)


def write_candump(frames: Iterable[Frame]) -> str:
    """The text of a log, one line a frame, in the order given."""
    return "".join(frame.to_line() + "\n" for frame in frames)


def _parse(lines: list[str], numbers: list[int]) -> list[Frame]:
    with of_extra("python-can", "can"):
        from can import CanutilsLogReader
    frames = []
    for message, number in zip(CanutilsLogReader(io.StringIO("\n".join(lines))), numbers, strict=True):
        if message.is_error_frame or message.is_remote_frame or message.is_fd:
            continue
        stamp, data = float(message.timestamp), bytes(message.data)
        channel = f"can{message.channel}" if isinstance(message.channel, int) else str(message.channel)
        frames.append(Frame(t_s=stamp, channel=channel, identifier=int(message.arbitration_id), data=data, line=number))
    return frames


def _isolated(frames: list[Frame], k: int) -> bool:
    if len(frames) < 3:
        return False
    before = abs(frames[k].t_s - frames[k - 1].t_s) if k > 0 else math.inf
    after = abs(frames[k + 1].t_s - frames[k].t_s) if k + 1 < len(frames) else math.inf
    return min(before, after) > ISOLATED_S
