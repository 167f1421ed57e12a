"""CAN frames, wherever they come from."""

from __future__ import annotations

from dataclasses import dataclass, field

from mcdas_opt.interop.recordings.tally import Tally


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """One classic CAN data frame; `line` is where it stands in its file, counted from 1 (0: nowhere yet)."""

    t_s: float
    channel: str
    identifier: int
    data: bytes
    line: int = 0

    def to_line(self) -> str:
        """As candump writes it, without the line's end; times to the microsecond."""
        digits = 3 if self.identifier < 0x800 else 8
        return f"({self.t_s:.6f}) {self.channel} {self.identifier:0{digits}X}#{self.data.hex().upper()}"


@dataclass(frozen=True, slots=True, kw_only=True)
class CanLog:
    """Data frames in the order of the file, what was bad, and how many sound entries held no data frame."""

    frames: tuple[Frame, ...]
    bad: Tally = field(default_factory=Tally)
    other: int = 0
