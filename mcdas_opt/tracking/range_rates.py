"""Whether a radar's ranges change as its range rates say."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from mcdas_opt.domain.measurement import RadarDetection

WRONG_MPS = 1.5  # off by more than their sd, on the mean of all returns that are followed; a recorded radar was at most 0.3
_WINDOW_S = 2.0
_LEAST_S = 1.0  # of following, of all returns together
_LONGEST_S = 1.0  # between two scans that are compared
_NOISE = 4.0  # sds of a range: so far off is no news
_STEP, _STEP_MPS = 4.0, 10.0  # sds, and more with time: farther off in one scan, it may be another reflection
_NEAR_M, _ASIDE = 10.0, 0.15  # nearer, or at a larger sine of the bearing, a body is seen from its side, and its reflection moves along it
_UNKNOWN_MPS = 30.0  # sd of a range rate that is not believed
_DISBELIEVED_S = 60.0  # then they are tried again: tracks go on meanwhile


@dataclass(slots=True)
class RangeRates:
    """Those of one radar. Where they are not believed, who is there is tracked by places alone, if these are right.

    From scan to scan, a return's range should change by its range rate, times the time between. How far it does not is summed over all
    returns that are followed, ahead and behind, and over the last seconds: noise is lost in the sum, a rate that is always too high is not.
    All of it is as the radar says it; the host's place and speed play no part.
    """

    _t_s: float = field(default=-math.inf, init=False)
    _last: dict[object, RadarDetection] = field(default_factory=dict, init=False)  # the return of each track
    _steps: deque[tuple[float, float, float]] = field(default_factory=deque, init=False)  # time, seconds of following, metres off
    _disbelieved_s: float = field(default=-math.inf, init=False)

    def take(self, followers: Mapping[RadarDetection, object], t_s: float, yaw_rad: float) -> float:
        """By how much the rates of a scan's returns, each with its track, are too high [m/s]; 0 where they are right, or too little was
        seen. `yaw_rad` is the mounting's."""
        elapsed_s, last = t_s - self._t_s, self._last
        along = {track: point for point, track in followers.items() if _is_end_on(point, yaw_rad)}
        self._t_s, self._last = t_s, along
        while self._steps and not 0.0 <= t_s - self._steps[0][0] <= _WINDOW_S:
            self._steps.popleft()
        again = [(last[track], point) for track, point in along.items() if track in last]
        if not again or not 0.0 < elapsed_s <= _LONGEST_S:
            return 0.0
        sd_m = max(point.range_sd_m for _, point in again)
        most_m = _STEP * sd_m + _STEP_MPS * elapsed_s
        steps_m = [min(max(_off_m(before, after, elapsed_s), -most_m), most_m) for before, after in again]
        self._steps.append((t_s, elapsed_s * len(again), sum(steps_m)))
        _, seconds, metres = zip(*self._steps, strict=True)
        followed_s, off_m = sum(seconds), sum(metres)
        wrong_mps = WRONG_MPS + max(point.range_rate_sd_mps for _, point in again)
        is_wrong = followed_s >= _LEAST_S and abs(off_m) > wrong_mps * followed_s + _NOISE * sd_m
        return off_m / followed_s if is_wrong else 0.0

    def disbelieve(self, t_s: float) -> None:
        """For a while from `t_s` on."""
        self._disbelieved_s = t_s

    def are_believed(self, t_s: float) -> bool:
        return not 0.0 <= t_s - self._disbelieved_s <= _DISBELIEVED_S

    def as_believed(self, points: Sequence[RadarDetection], t_s: float) -> Sequence[RadarDetection]:
        """The returns of that time, each with the uncertainty of its rate."""
        return points if self.are_believed(t_s) else [replace(point, range_rate_sd_mps=_UNKNOWN_MPS) for point in points]


def _is_end_on(point: RadarDetection, yaw_rad: float) -> bool:
    return point.range_m >= _NEAR_M and abs(math.sin(yaw_rad + point.azimuth_rad)) <= _ASIDE


def _off_m(before: RadarDetection, after: RadarDetection, elapsed_s: float) -> float:
    """How much farther the range rates say that the return went than its ranges do."""
    said_mps = 0.5 * (before.range_rate_mps + after.range_rate_mps)
    return said_mps * elapsed_s - (after.range_m - before.range_m)
