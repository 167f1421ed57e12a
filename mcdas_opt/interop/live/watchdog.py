"""Calls back when a planning step is not done in time, so that something is published every cycle."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable


class Watchdog:
    """`arm(at_s, bark)`, then the work, then `disarm()`. When the clock passes `at_s` before that, the watchdog's thread calls
    `bark()` once. Real time: not for a loop on a clock of its own."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._at_s: float | None = None
        self._bark: Callable[[], None] = _silence
        self._ended = False
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()

    def arm(self, at_s: float, bark: Callable[[], None]) -> None:
        with self._changed:
            self._at_s, self._bark = at_s, bark
            self._changed.notify()

    def disarm(self) -> None:
        """After this returns, `bark` is not called."""
        with self._changed:
            self._at_s = None

    def close(self) -> None:
        with self._changed:
            self._ended = True
            self._changed.notify()
        self._thread.join()

    def _watch(self) -> None:
        with self._changed:
            while not self._ended:
                left = None if self._at_s is None else self._at_s - time.monotonic()
                if left is not None and left <= 0.0:
                    self._at_s = None
                    self._bark()
                    continue
                self._changed.wait(left)


def _silence() -> None:
    """The callback before the first `arm`."""
