"""Frames as they arrive: python-can's buses behind reader threads, each frame stamped by the loop's own clock."""

from __future__ import annotations

import contextlib
import queue
import threading
import time
from collections.abc import Mapping
from typing import Any, NamedTuple, Protocol

from mcdas_opt.errors import InputError, of_extra

_POLL_S = 0.1  # how long a reader waits before it looks whether it is to end
_OLDEST_S = 1.0  # an older stamp is not of the clock that it should be of


class Arrival(NamedTuple):
    """A data frame; `t_s` on the loop's clock. `fault`: what came instead of one (the bus's own error, a remote frame), in words."""

    t_s: float
    channel: str
    identifier: int
    data: bytes
    fault: str = ""


class Inbox(Protocol):
    """Where the loop takes frames from."""

    @property
    def channels(self) -> tuple[str, ...]: ...

    def wait(self, until_s: float) -> list[Arrival]:
        """Everything that arrives until the clock shows `until_s`, in order of arrival; at least what is there already."""
        ...


class BusInbox:
    """Reads python-can buses, one thread a bus. A frame's time is the bus's own stamp, brought to the loop's clock by its age; where the
    stamp is no recent time of day, when the frame was read."""

    def __init__(self, buses: Mapping[str, Any]) -> None:
        """`buses`: name to an open `can.BusABC`; closed by `close`."""
        self.channels = tuple(buses)
        self._buses = dict(buses)
        self._arrived: queue.SimpleQueue[Arrival] = queue.SimpleQueue()
        self._ended = threading.Event()
        self._threads = [threading.Thread(target=self._read, args=entry, daemon=True) for entry in self._buses.items()]
        for thread in self._threads:
            thread.start()

    def wait(self, until_s: float) -> list[Arrival]:
        found: list[Arrival] = []
        with contextlib.suppress(queue.Empty):
            while True:
                left = until_s - time.monotonic()
                found.append(self._arrived.get(timeout=left) if left > 0.0 else self._arrived.get_nowait())
        return sorted(found, key=lambda arrival: arrival.t_s)

    def close(self) -> None:
        """Ends the readers, then closes the buses."""
        self._ended.set()
        for thread in self._threads:
            thread.join()
        for bus in self._buses.values():
            bus.shutdown()

    def __enter__(self) -> BusInbox:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _read(self, channel: str, bus: Any) -> None:
        from can import CanError

        while not self._ended.is_set():
            try:
                message = bus.recv(_POLL_S)
            except (CanError, OSError) as error:
                self._arrived.put(Arrival(time.monotonic(), channel, 0, b"", f"the bus failed: {error}"))
                self._ended.wait(_POLL_S)
                continue
            if message is None:
                continue
            fault = "error frame" if message.is_error_frame else "remote frame" if message.is_remote_frame else ""
            data = b"" if message.data is None else bytes(message.data)
            age = time.time() - float(message.timestamp)
            t_s = time.monotonic() - (age if 0.0 <= age <= _OLDEST_S else 0.0)
            self._arrived.put(Arrival(t_s, channel, int(message.arbitration_id), data, fault))


def open_bus(channel: str, interface: str) -> Any:
    """A python-can bus. Raises `InputError` that names the channel and the interface; `MissingExtraError` without python-can."""
    with of_extra("python-can", "can"):
        import can
    if interface not in can.VALID_INTERFACES:
        raise InputError("--interface", "", interface, "is no interface of python-can; known: " + ", ".join(sorted(can.VALID_INTERFACES)))
    try:
        return can.Bus(channel=channel, interface=interface)
    except (can.CanError, OSError, ImportError, ValueError) as error:
        raise InputError(channel, "", None, f"cannot be opened as {interface}: {error}") from None
