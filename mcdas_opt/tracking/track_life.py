"""One track from its first detection to its end: tentative, confirmed by M of N, coasting, gone."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

import numpy as np

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import BodyDetection, Scan
from mcdas_opt.domain.motion import TargetMotion
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.track import ALIGNED_RAD, Track
from mcdas_opt.domain.vocabulary import BodyKind
from mcdas_opt.tracking.acceleration import AccelerationFilter
from mcdas_opt.tracking.filtering import Filtering, TargetFilter, TargetFix
from mcdas_opt.tracking.screening import SAME_TIME_S, Source, source_of
from mcdas_opt.tracking.turn_rate import TurnRateFilter

GATE = 16.27  # of the squared Mahalanobis distance of (s, d, range rate): lets 99.9 % of true detections in (chi-square, 3)
INITIAL_SPEED_SD_MPS = 15.0  # of a new radar track along the road, around the host's speed
INITIAL_LATERAL_SPEED_SD_MPS = 3.0  # and across it, around 0
CONFIRM_HITS, CONFIRM_WINDOW = 3, 4  # a track is confirmed by so many hits in so many scans of the sensors that have seen it
COAST_S = 1.0  # a track dies without a hit for this long
BLIND_S = 5.0  # or this long, while it is too near to its sensor to be seen and does not stand
COASTING_PERIODS = 1.5  # without a hit for so many scan periods a track counts as coasting
LONGEST_VEHICLE_M = 18.75  # an articulated lorry, as European directive 96/53/EC allows it
ALIKE_MPS = 1.0  # reflections of one body differ less in range rate
REFLECTION_GAP_M = 5.0  # reflections of one vehicle are no farther apart along it
LONGER_M = 1.0  # than assumed, at least: less is noise
SHOWN, SHOWN_OF = 3, 10  # a length counts that so many of so many scans have shown
MOST_SOURCES = 64  # sensors that a track was seen by, the latest
_STANDING_MPS = 0.5
_COURSE_MPS, _COURSE_SIGMAS = 2.0, 2.5  # who clearly moves so fast, and not along the road, is headed where it goes
_ANYWHERE_M = 100.0  # sd of the position before the first detection: as good as unknown


class TrackLife:
    """A filter with its history. Built by `begin`; mutated by `hit`, `hide` and `miss` only."""

    def __init__(self, filter_: TargetFilter, size: tuple[float, float]) -> None:
        self._filter = filter_
        self._along, self._across = AccelerationFilter(), AccelerationFilter()
        self._turning = TurnRateFilter()
        self._hits: deque[bool] = deque(maxlen=CONFIRM_WINDOW)
        self._sources: deque[Source] = deque(maxlen=MOST_SOURCES)
        self._born_s = filter_.time_s
        self._arrival_s = -np.inf
        self._hidden_s = self._stood_s = -np.inf
        self._period_s = 0.0
        self.size = size
        self._shown_m: deque[float] = deque(maxlen=SHOWN_OF)
        self._beyond = 1.0  # +1: the far end is ahead of the near one
        self.length_m = size[0]  # learnt where its reflections show it, else as assumed
        self.name: str | None = None
        self._heading_rad: float | None = None  # what an ideal sensor says
        self._kind: BodyKind | None = None
        self.number = 0  # given when the update that began it ends
        self.confirmed = False
        self.others: set[TrackLife] = set()  # no other track of the same car, as long as there is one

    @classmethod
    def begin(
        cls,
        fix: TargetFix,
        scan: Scan,
        host: HostState,
        now: float,
        size: tuple[float, float],
        motion: TargetMotion,
        filtering: Filtering,
    ) -> TrackLife:
        """A new track: an ordinary update of a belief that knows no place and expects about the host's speed along the road."""
        s, d = fix.place
        state = np.array([s, host.speed_mps * np.cos(host.heading_rad), d, 0.0])
        sds = [_ANYWHERE_M, INITIAL_SPEED_SD_MPS, _ANYWHERE_M, INITIAL_LATERAL_SPEED_SD_MPS]
        life = cls(filtering.begin(state, np.diag(np.square(sds)), scan.t_s, motion), size)
        life.hit(fix, scan, now)
        return life

    @property
    def heard_s(self) -> float:
        """When the last hit arrived."""
        return self._arrival_s

    def costs(self, time_s: float, fixes: Sequence[TargetFix | None]) -> list[float]:
        """The cost of each fix of that time; infinite where it does not fit, or there is none."""
        return self._filter.costs(time_s, fixes, GATE)

    def goes_on_unseen(self, now: float) -> bool:
        """Whether it is a confirmed track of a radar that no scan has shown of late, though it is not too near to be seen."""
        return self.confirmed and self.name is None and self._is_quiet(now) and now - self._hidden_s > COAST_S

    def hit(self, fix: TargetFix, scan: Scan, now: float) -> None:
        self._filter.take(scan.t_s, fix)
        along, across = self._filter.speeds()
        self._along.take(self._filter.time_s, *along)
        if self.name is not None:  # of who crosses, a radar's first speeds are too far off
            self._across.take(self._filter.time_s, *across)
        if source_of(scan) not in self._sources:
            self._sources.append(source_of(scan))
        self._arrival_s, self._period_s = now, scan.period_s
        self._hits.append(True)
        self.confirmed = self.confirmed or sum(self._hits) >= CONFIRM_HITS

    def may_hide_from(self, scan: Scan, now: float) -> bool:
        """Whether that sensor has seen it before, and no sensor sees it now."""
        return self.confirmed and source_of(scan) in self._sources and self._is_quiet(now)

    def hide(self, fix: TargetFix, scan: Scan, now: float) -> None:
        """The scan could not show it, being too near; `fix` is all that follows. A standing car may stay so for ever."""
        self._filter.take(scan.t_s, fix)
        self._hidden_s = now
        if abs(self._filter.at(scan.t_s)[0][1]) < _STANDING_MPS:
            self._stood_s = now

    def _is_quiet(self, now: float) -> bool:
        return bool(now - self._arrival_s > COASTING_PERIODS * self._period_s + 1e-9)

    def goes_on(self, place: tuple[float, float], host_s_m: float, time_s: float) -> bool:
        """Whether a point that reads as a body at `place` may be a farther reflection of this one: along it, beyond its near end."""
        s, d = self.place(time_s)
        if self.name is not None or abs(place[1] - d) > 0.5 * self.size[1]:
            return False
        farther = (place[0] - s) * (1.0 if s > host_s_m else -1.0)
        known = max(self.length_m, self._shown_m[-1] if self._shown_m else 0.0)
        return self.size[0] <= farther <= min(known + REFLECTION_GAP_M, LONGEST_VEHICLE_M)

    def show(self, place: tuple[float, float], host_s_m: float, time_s: float, *, again: bool) -> None:
        """A scan has shown such a reflection (`again`: and a nearer one before). The length is what several scans have shown."""
        s, _ = self.place(time_s)
        if abs(place[0] - s) < self.size[0] + LONGER_M:
            return
        self._beyond = 1.0 if s > host_s_m else -1.0
        if again and self._shown_m:
            self._shown_m.pop()
        self._shown_m.append(abs(place[0] - s))
        if len(self._shown_m) >= SHOWN:
            self.length_m = max(self.length_m, sorted(self._shown_m)[-SHOWN])

    def know(self, body: BodyDetection, road_heading_rad: float, time_s: float) -> None:
        """An ideal sensor has told name and size: the track is confirmed. `road_heading_rad` is the road's in the plane, there."""
        self.name, self.size, self.confirmed = body.name, (body.length_m, body.width_m), True
        self.length_m = body.length_m
        self._kind = body.kind
        self._heading_rad = None if body.heading_rad is None else math.remainder(body.heading_rad, 2.0 * math.pi)
        if body.heading_rad is not None:
            self._turning.take(time_s, road_heading_rad + body.heading_rad)

    def miss(self, scan: Scan) -> None:
        """A scan that does not show this target counts against it if its sensor has seen it before."""
        if source_of(scan) in self._sources:
            self._hits.append(False)

    def is_over(self, now: float) -> bool:
        """Whether the track ends: no detection for too long, or tentative and too many misses to be confirmed."""
        hidden = now - self._hidden_s <= COAST_S + SAME_TIME_S
        longest = BLIND_S if hidden else COAST_S
        if now - max(self._arrival_s, self._stood_s if hidden else -math.inf) > longest + SAME_TIME_S:
            return True
        if self.confirmed:
            return False
        misses = len(self._hits) - sum(self._hits)
        return misses > CONFIRM_WINDOW - CONFIRM_HITS

    def place(self, time_s: float) -> tuple[float, float]:
        """(s, d) at `time_s`."""
        return self._filter.place_at(time_s)

    def spread(self, time_s: float) -> Array:
        """(2, 2) covariance of the position (s, d) at `time_s`."""
        return np.asarray(self._filter.at(time_s)[1][::2, ::2])

    def vagueness(self) -> float:
        """Variance of the position, summed [m^2]."""
        P: Array = self._filter.covariance
        return float(P[0, 0] + P[2, 2])

    def track(self, now: float) -> Track:
        state, P = self._filter.at(now)
        s, vs, d, vd = state.tolist()
        s += 0.5 * self._beyond * (self.length_m - self.size[0])  # the near end is where it is seen
        along, along_sd = self._along.at(now)
        across, across_sd = self._across.at(now)
        turn_rate, its_turn_sd = self._turning.at(now)
        return Track(
            id=str(self.number),
            s_m=s,
            d_m=d,
            speed_s_mps=vs,
            speed_d_mps=vd,
            covariance=P,
            length_m=self.length_m,
            width_m=self.size[1],
            age_s=max(now - self._born_s, 0.0),
            coasting=self._is_quiet(now),
            acceleration_s_mps2=along,
            acceleration_s_sd_mps2=along_sd,
            acceleration_d_mps2=across,
            acceleration_d_sd_mps2=across_sd,
            heading_rad=self._heading_rad if self.name is not None else course(vs, vd, P),
            kind=self._kind,
            turn_rate_radps=turn_rate,
            turn_rate_sd_radps=its_turn_sd,
        )


def course(along_mps: float, across_mps: float, covariance: Array) -> float | None:
    """Heading relative to the road [rad] of a body that clearly moves towards the host or across its road; None of any other, whose
    heading its speeds do not tell from the road's."""
    spread_s, spread_d = (_COURSE_SIGMAS * math.sqrt(max(float(covariance[k, k]), 0.0)) for k in (1, 3))
    crosses = abs(across_mps) - spread_d > max(_COURSE_MPS, math.tan(ALIGNED_RAD) * (abs(along_mps) + spread_s))
    return math.atan2(across_mps, along_mps) if crosses or along_mps + spread_s < -_COURSE_MPS else None
