"""How long nothing has been heard, counted in the time in which the loop listened."""

from __future__ import annotations

from collections.abc import Mapping

from mcdas_opt.errors import InputError
from mcdas_opt.interop.live.assembler import ScanAssembler


class SilentBusError(InputError):
    """No bus says anything any more, or what it says is no radar's, or nobody says the host's speed."""


class Silence:
    """Who has not been heard for more than `patience_s`.

    A cycle counts for `cycle_s` at most: a loop that was held up longer (its output was not read, its process stopped) listened to
    nobody then, and what it missed is not the bus's silence.
    """

    def __init__(self, began_s: float, patience_s: float, cycle_s: float) -> None:
        self._began_s, self._patience_s, self._cycle_s = began_s, patience_s, cycle_s
        self._last_s = began_s
        self._lasted_s: dict[str, float] = {}

    def of(self, radars: Mapping[str, ScanAssembler], speed_heard_s: float | None, now: float) -> tuple[str, ...]:
        """Channels on which no radar was heard of late, asked once a cycle; raises `SilentBusError` when that is all of them, or the
        host's speed has ended. `speed_heard_s`: when it was last known."""
        listened_s, self._last_s = min(now - self._last_s, self._cycle_s), now

        def quiet(what: str, heard_s: float | None) -> bool:
            since_s = now - (self._began_s if heard_s is None else heard_s)
            self._lasted_s[what] = min(self._lasted_s.get(what, 0.0) + listened_s, since_s)
            return self._lasted_s[what] > self._patience_s

        mute = [quiet(name, radar.heard_s) for name, radar in radars.items()]
        silent = tuple(name for name, radar in radars.items() if quiet(f"radar {name}", radar.radar_heard_s))
        speechless = quiet("speed", speed_heard_s)
        names, lasted = ", ".join(radars), f"for {self._patience_s:g} s"
        if len(silent) == len(radars):
            if all(mute):
                said = "no frame" if all(radar.heard_s is None for radar in radars.values()) else "no frame any more"
            else:
                said = "frames, but no ESR track frame (0x500 to 0x53F)"
            raise SilentBusError(names, "", None, f"is silent: {said} {lasted}")
        if speechless:
            raise SilentBusError(names, "", None, f"says no host speed (ESR_Status1, 0x4E0) {lasted}: pass --speed")
        return silent
