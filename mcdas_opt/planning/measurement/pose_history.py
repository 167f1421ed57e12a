"""Where the host was when a scan was taken: radar data arrive with an age, and a car knows where it has been."""

from __future__ import annotations

from collections import deque

import numpy as np

from mcdas_opt.domain.host import HostState

_KEPT = 64  # states; at a cycle of 0.1 s more than any latency that is planned for
_AT_ONCE_S = 1e-9
_FARTHEST_BACK_S = 10.0  # what is older is no scan that anybody believes
_GAP_MAX_S = 1.0  # the clock has jumped


class PoseHistory:
    """The host's latest states; asked for one between two of them it interpolates, for one before them it drives backwards."""

    def __init__(self) -> None:
        self._states: deque[tuple[float, HostState]] = deque(maxlen=_KEPT)

    def note(self, time_s: float, host: HostState) -> None:
        """A state newer than all before; one at the time of the last replaces it. Time that runs back or jumps ahead starts the history
        anew."""
        if self._states:
            later_s = time_s - self._states[-1][0]
            if later_s == 0.0:
                self._states.pop()
            elif not 0.0 < later_s <= _GAP_MAX_S:
                self._states.clear()
        self._states.append((time_s, host))

    def at(self, time_s: float) -> HostState:
        """The state at `time_s`, at or before the last noted one (later: the last one)."""
        last_s, last = self._states[-1]
        if time_s >= last_s - _AT_ONCE_S:
            return last
        after_s, after = last_s, last
        for before_s, before in reversed(self._states):
            if before_s <= time_s:
                share = (time_s - before_s) / (after_s - before_s) if after_s > before_s else 0.0
                x0, x1 = before.to_vector(), after.to_vector()
                return HostState.from_vector(x0 + share * (x1 - x0))
            after_s, after = before_s, before
        age, first = min(after_s - time_s, _FARTHEST_BACK_S), after
        x = first.to_vector().copy()
        v = first.speed_mps
        x[0] -= v * np.cos(first.heading_rad) * age
        x[1] -= v * np.sin(first.heading_rad) * age
        return HostState.from_vector(x)
