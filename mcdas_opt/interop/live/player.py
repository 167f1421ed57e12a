"""A recorded CAN log played onto buses at its own pace: a bench without a car."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping, Sequence
from typing import Any

from mcdas_opt.interop.recordings.can_frames import Frame


class LogPlayer:
    """Sends frames in a thread of its own, each at its own time after `start`; those of a channel without a bus are left out."""

    def __init__(self, frames: Sequence[Frame], buses: Mapping[str, Any]) -> None:
        """`buses`: the log's channel to an open `can.BusABC`; the player closes them at its end."""
        self._frames = [frame for frame in frames if frame.channel in buses]
        self._buses = dict(buses)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._play, daemon=True)

    def start(self) -> None:
        self._thread.start()

    def close(self) -> None:
        self._ended.set()
        self._thread.join()
        for bus in self._buses.values():
            bus.shutdown()

    def _play(self) -> None:
        from can import Message

        began = time.monotonic()
        for frame in self._frames:
            left = frame.t_s - self._frames[0].t_s - (time.monotonic() - began)
            if left > 0.0 and self._ended.wait(left):
                return
            message = Message(arbitration_id=frame.identifier, data=frame.data, is_extended_id=frame.identifier > 0x7FF)
            self._buses[frame.channel].send(message)
