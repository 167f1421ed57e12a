"""The host's motion along its lane: a recording's speed over time integrated, and the same while it is driven."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array, vector
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.interop.recordings.csv_table import CsvTable

SLOPE_S = 0.5  # the acceleration is the slope of the speed over this much of the past
NOISE_MPS = 0.3  # wheels that stand may be measured to turn back so fast
HELD_S = 1.0  # a speed says nothing of what is farther away in time


def forward(file: str | Path, line: int, key: str, speed_mps: float) -> float:
    """The speed, or 0 where it is the noise of a car that stands. Raises `InputError` for one that reverses."""
    if speed_mps < -NOISE_MPS:
        rule = "reverses, and reversing is not driven: leave this part out (or turn the sign, if forward is meant)"
        raise InputError(file, f"line {line}: {key}", speed_mps, rule)
    return max(speed_mps, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class HostMotion:
    """Speeds (n,) [m/s], none below 0, at increasing times (n,) [s]; `source` is where they come from, for messages.

    The host keeps to the middle of the road's lane (d = 0, heading 0), its wheels along the road's curvature: a recording of one
    speed says nothing of anything else.
    """

    t_s: Array
    speed_mps: Array
    source: str = "host speed"

    def __post_init__(self) -> None:
        require_types(self)
        t_s = vector("t_s", self.t_s, "s")
        speed = vector("speed_mps", self.speed_mps, "m/s", length=t_s.size)
        if np.any(speed < 0.0):
            raise ParameterError("speed_mps", float(speed.min()), "must be at least 0", "m/s")
        if t_s.size < 2 or np.any(np.diff(t_s) <= 0.0):
            raise ParameterError("t_s", t_s.tolist(), "must be at least two times that increase", "s")

    @classmethod
    def read(cls, path: str | Path) -> HostMotion:
        """From a CSV with `t_s` (or `time_s`) and `speed_mps`; other columns are ignored.

        Raises `InputError` with the line of a cell that is no finite number, a time that does not increase, or a speed beyond 100 m/s or
        in reverse; what is less than NOISE_MPS below 0 is 0.
        """
        table = CsvTable(path)
        columns = [table.column("t_s", "time_s"), table.column("speed_mps")]
        rows = table.sound_rows(columns)
        for before, row in zip([None, *rows], rows, strict=False):
            time, speed = row.values
            key = f"line {row.line}: "
            if not (math.isfinite(time) and math.isfinite(speed)):
                raise InputError(path, key + "t_s, speed_mps", None, "must be finite numbers")
            if before is not None and time <= before.values[0]:
                raise InputError(path, key + "t_s", time, "must increase")
            if abs(speed) > 100.0:
                raise InputError(path, key + "speed_mps", speed, "exceeds 100 m/s (speeds are m/s, not km/h)")
        if len(rows) < 2:
            raise InputError(path, "", None, "needs at least two rows")
        values = np.array([(row.values[0], forward(path, row.line, "speed_mps", row.values[1])) for row in rows])
        return cls(t_s=values[:, 0], speed_mps=values[:, 1], source=str(path))

    def known(self, t_s: Array) -> NDArray[np.bool_]:
        """Whether a speed is said within `HELD_S` of these times, or between its ends within half of the step that is usual: who writes
        a speed every 10 s means what lies between."""
        after = np.clip(np.searchsorted(self.t_s, t_s), 1, self.t_s.size - 1)
        nearest = np.minimum(np.abs(self.t_s[after] - t_s), np.abs(self.t_s[after - 1] - t_s))
        usual = 0.5 * float(np.median(np.diff(self.t_s)))
        reach = np.where((t_s >= self.t_s[0]) & (t_s <= self.t_s[-1]), max(HELD_S, usual), HELD_S)
        return np.asarray(nearest <= reach + 1e-9, dtype=np.bool_)

    def require(self, t_s: Array) -> None:
        """Raises `InputError` unless the speed is known at all these times, which increase; names the first hole."""
        unknown = t_s[~self.known(t_s)]
        if unknown.size == 0:
            return
        first, last = float(self.t_s[0]), float(self.t_s[-1])
        if first < unknown[0] < last:
            k = int(np.searchsorted(self.t_s, unknown[0]))
            rule = (
                f"says nothing between {self.t_s[k - 1]:.10g} s and {self.t_s[k]:.10g} s, where the log has scans: such a hole is "
                "not filled"
            )
        else:
            rule = f"covers {first:.10g} s to {last:.10g} s, the log needs {t_s[0]:.10g} s to {t_s[-1]:.10g} s"
        raise InputError(self.source, "t_s", None, rule)

    def state(self, t_s: float, start_s: float, road: Road, vehicle: Vehicle) -> HostState:
        """The host at `t_s`, its s counted from `start_s` on. The acceleration looks at the past only."""
        speed = float(np.interp(t_s, self.t_s, self.speed_mps))
        s = self._distance(t_s) - self._distance(start_s)
        past = float(np.interp(t_s - SLOPE_S, self.t_s, self.speed_mps))
        return _in_lane(s, speed, (speed - past) / SLOPE_S, road, vehicle)

    def _distance(self, t_s: float) -> float:
        """Integral of the piecewise linear speed from the first sample to t [m]; before and after the samples the speed is held."""
        t, v = self.t_s, self.speed_mps
        whole = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t))])
        k = min(max(int(np.searchsorted(t, t_s, side="right")) - 1, 0), t.size - 1)
        return float(whole[k] + 0.5 * (v[k] + np.interp(t_s, t, v)) * (t_s - t[k]))


class LiveHost:
    """Keeps to the middle of its lane, as `HostMotion` does; remembers no more than the last moments."""

    def __init__(self, road: Road, vehicle: Vehicle) -> None:
        self._road, self._vehicle = road, vehicle
        self._recent: deque[tuple[float, float]] = deque()
        self._s_m = 0.0  # at the latest speed

    @property
    def heard_s(self) -> float | None:
        """When a speed was last heard."""
        return self._recent[-1][0] if self._recent else None

    def note(self, t_s: float, speed_mps: float) -> None:
        """A speed, noise about standstill as 0; one that is no newer than the latest is left out."""
        speed_mps = 0.0 if -NOISE_MPS <= speed_mps < 0.0 else speed_mps
        if self._recent:
            last_s, last = self._recent[-1]
            if t_s <= last_s:
                return
            self._s_m += 0.5 * (last + speed_mps) * (t_s - last_s)
        self._recent.append((t_s, speed_mps))
        while len(self._recent) > 2 and self._recent[1][0] <= t_s - SLOPE_S:
            self._recent.popleft()

    def state(self, t_s: float) -> HostState:
        """At `t_s`, at or after the latest speed, which is held. The acceleration is the slope over the last half second."""
        last_s, speed = self._recent[-1]
        first_s, first = self._recent[0]
        s = self._s_m + speed * (t_s - last_s)
        return _in_lane(s, speed, (speed - first) / max(last_s - first_s, SLOPE_S), self._road, self._vehicle)


def _in_lane(s_m: float, speed_mps: float, slope_mps2: float, road: Road, vehicle: Vehicle) -> HostState:
    """In the middle of the lane, the wheels along it; the acceleration within the vehicle's limits."""
    acceleration = min(max(slope_mps2, vehicle.acceleration_min_mps2), vehicle.acceleration_max_mps2)
    steering = math.atan(vehicle.wheelbase_m * float(road.curvature_at(s_m)))
    return HostState(s_m=s_m, speed_mps=speed_mps, acceleration_mps2=acceleration, steering_rad=steering)
