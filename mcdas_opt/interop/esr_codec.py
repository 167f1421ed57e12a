"""The CAN messages of a Delphi ESR, both ways, by a DBC.

The radar's azimuth is clockwise positive, ISO 8855's is not: the sign turns here and nowhere else.
"""

from __future__ import annotations

import io
import math
from dataclasses import dataclass, field
from enum import IntEnum
from pathlib import Path
from typing import Any

from mcdas_opt.catalogue.data_files import models_folder, read_bytes
from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.errors import InputError, ParameterError, of_extra

FIRST_TRACK, TRACKS, STATUS_1, STATUS_2 = 0x500, 64, 0x4E0, 0x4E1
_STATUS, _RANGE, ANGLE = "CAN_TX_TRACK_STATUS", "CAN_TX_TRACK_RANGE", "CAN_TX_TRACK_ANGLE"
RANGE_RATE, _WIDTH = "CAN_TX_TRACK_RANGE_RATE", "CAN_TX_TRACK_WIDTH"
_SIGNALS = (_STATUS, _RANGE, ANGLE, RANGE_RATE, _WIDTH)
_SPEED, _INDEX = "CAN_TX_VEHICLE_SPEED_CALC", "CAN_TX_SCAN_INDEX"
LARGEST_DBC = 20_000_000  # bytes
_ERRORS = ("CAN_TX_INTERNAL_ERROR", "CAN_TX_RANGE_PERF_ERROR", "CAN_TX_OVERHEAT_ERROR")


class TargetStatus(IntEnum):
    """What the radar says a slot holds."""

    NO_TARGET = 0
    NEW = 1
    NEW_UPDATED = 2
    UPDATED = 3
    COASTED = 4
    MERGED = 5
    INVALID_COASTED = 6
    NEW_COASTED = 7

    @property
    def measured(self) -> bool:
        """Seen in this very cycle. A coasted target is the radar's own prediction: it holds no news for another filter."""
        return self in (TargetStatus.NEW, TargetStatus.NEW_UPDATED, TargetStatus.UPDATED, TargetStatus.MERGED)


@dataclass(frozen=True, slots=True, kw_only=True)
class EsrTarget:
    """One slot (0-based). Azimuth is ISO 8855 (counter-clockwise positive, from the radar's axis); what a slot without a target
    says (200 m, 81.91 m/s) looks valid, so that only `status` tells."""

    slot: int
    status: TargetStatus
    range_m: float = 200.0
    azimuth_rad: float = 0.0
    range_rate_mps: float = 81.91
    width_m: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class EsrMotion:
    """The host's speed as the radar was told it, and its scan counter."""

    speed_mps: float
    scan_index: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class EsrHealth:
    """`working` false: the radar reports an internal, range performance or overheat error and vouches for nothing."""

    working: bool


class WrongLengthError(ValueError):
    """A frame shorter or longer than its message; `short` says which."""

    def __init__(self, short: bool) -> None:
        self.short = short
        super().__init__("the frame is not as long as its message")


@dataclass(slots=True, kw_only=True)
class EsrCodec:
    """Frames to ESR messages and back. `dbc` is a path; default the shipped minimal one.

    Raises `InputError` where the DBC cannot be parsed or lacks a track message or one of its signals, `MissingExtraError` without
    cantools. The two status messages may be missing: then the radar's own speed and health are unknown.
    """

    dbc: str | Path | None = None
    _messages: dict[int, Any] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        require_types(self)
        path = models_folder() / "can" / "esr_minimal.dbc" if self.dbc is None else Path(self.dbc)
        messages = {message.frame_id: message for message in _load(path)}
        missing = [k for k in range(TRACKS) if FIRST_TRACK + k not in messages]
        if missing:
            names = [f"ESR_Track{k + 1:02d} (0x{FIRST_TRACK + k:X})" for k in missing]
            listed = ", ".join(names[:3]) + (f" ... {names[-1]}" if len(names) > 3 else "")
            raise InputError(path, "", None, f"lacks {len(names)} of the {TRACKS} ESR track messages: {listed}")
        for k in range(TRACKS):
            message = messages[FIRST_TRACK + k]
            absent = [name for name in _SIGNALS if name not in message.signal_tree]
            if absent:
                raise InputError(path, f"{message.name} (0x{message.frame_id:X})", None, f"lacks the signal {absent[0]}")
            self._messages[message.frame_id] = message
        for identifier, needed in ((STATUS_1, {_SPEED}), (STATUS_2, set(_ERRORS))):
            if identifier in messages and needed <= set(messages[identifier].signal_tree):
                self._messages[identifier] = messages[identifier]

    def decode(self, identifier: int, data: bytes) -> EsrTarget | EsrMotion | EsrHealth | None:
        """The message of a frame; None when it is not one of the radar's that we read. Raises `WrongLengthError`."""
        message = self._messages.get(identifier)
        if message is None:
            return None
        if len(data) != message.length:
            raise WrongLengthError(short=len(data) < message.length)
        values = message.decode(data, decode_choices=False)
        if identifier == STATUS_1:
            return EsrMotion(speed_mps=float(values[_SPEED]), scan_index=int(values.get(_INDEX, 0)))
        if identifier == STATUS_2:
            return EsrHealth(working=not any(values[name] for name in _ERRORS))
        return EsrTarget(
            slot=identifier - FIRST_TRACK,
            status=TargetStatus(int(values[_STATUS])),
            range_m=float(values[_RANGE]),
            azimuth_rad=-math.radians(float(values[ANGLE])),
            range_rate_mps=float(values[RANGE_RATE]),
            width_m=float(values[_WIDTH]),
        )

    def encode(self, item: EsrTarget | EsrMotion | EsrHealth) -> tuple[int, bytes]:
        """Identifier and data of a message, values rounded to the signals' steps.

        Raises `ParameterError` for a value outside its signal's range, or for a message that the DBC does not have.
        """
        if isinstance(item, EsrTarget):
            if not 0 <= item.slot < TRACKS:
                raise ParameterError("slot", item.slot, f"must lie in [0, {TRACKS - 1}]")
            values = {_STATUS: int(item.status), _RANGE: item.range_m, ANGLE: -math.degrees(item.azimuth_rad)}
            return self._encode(FIRST_TRACK + item.slot, {**values, RANGE_RATE: item.range_rate_mps, _WIDTH: item.width_m})
        if isinstance(item, EsrMotion):
            return self._encode(STATUS_1, {_SPEED: item.speed_mps, _INDEX: item.scan_index})
        return self._encode(STATUS_2, {_ERRORS[0]: 0 if item.working else 1})

    def _encode(self, identifier: int, values: dict[str, float]) -> tuple[int, bytes]:
        message = self._messages.get(identifier)
        if message is None:
            raise ParameterError("identifier", f"0x{identifier:X}", "is no message of this DBC")
        raw = {}
        for signal in message.signals:
            value = values.get(signal.name, signal.offset)
            if not math.isfinite(value):
                raise ParameterError(signal.name, value, "must be finite", signal.unit or "")
            raw[signal.name] = round((value - signal.offset) / signal.scale)
            low = -(1 << (signal.length - 1)) if signal.is_signed else 0
            high = low + (1 << signal.length) - 1
            if not low <= raw[signal.name] <= high:
                limits = [low * signal.scale + signal.offset, high * signal.scale + signal.offset]
                raise ParameterError(signal.name, value, f"must lie in [{limits[0]:g}, {limits[1]:g}]", signal.unit or "")
        return identifier, bytes(message.encode(raw, scaling=False))


def _load(path: Path) -> Any:
    with of_extra("cantools", "can"):
        import cantools
    content = io.BytesIO(read_bytes(path, LARGEST_DBC))
    try:
        text = io.TextIOWrapper(content, encoding="cp1252").read()  # as cantools decodes it
        return cantools.database.load_string(text, database_format="dbc").messages
    except (cantools.Error, UnicodeDecodeError, ValueError) as error:
        raise InputError(path, "", None, f"is no DBC: {str(error).splitlines()[0]}") from None
