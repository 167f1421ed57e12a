"""What is remembered of one sensor, and whether it can be right."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field

from mcdas_opt.domain.measurement import RadarDetection, Scan
from mcdas_opt.domain.road import Road
from mcdas_opt.tracking import notices
from mcdas_opt.tracking.range_rates import RangeRates
from mcdas_opt.tracking.track_life import TrackLife
from mcdas_opt.tracking.unfollowed import SCANS, UnfollowedReturns, unexplained


@dataclass(slots=True)
class Heard:
    """One sensor, and its last scan."""

    last: Scan
    rates: RangeRates = field(default_factory=RangeRates)
    _unfollowed: UnfollowedReturns = field(default_factory=UnfollowedReturns)

    def doubts(
        self, followers: Mapping[RadarDetection, TrackLife], lives: Sequence[TrackLife], hit: Set[TrackLife], road: Road, now: float
    ) -> dict[str, str]:
        """What speaks against its last scan, by counter, in words: a return that has come so often that it should be tracked, and is not,
        and range rates that are found to be wrong. They are not believed any more then.

        `followers` are the scan's returns, each with its track, `hit` all tracks that the scan has shown, of all there are (`lives`).
        """
        scan, t_s, found = self.last, self.last.t_s, dict[str, str]()
        confirmed = {point: life for point, life in followers.items() if life.confirmed}
        came = self._unfollowed.take(unexplained(followers, lives, road, t_s, now), t_s, hit, confirmed)
        too_high_mps = self.rates.take(confirmed, t_s, scan.mounting.yaw_rad)
        if too_high_mps != 0.0 and self.rates.are_believed(t_s):
            found["range_rates"] = notices.range_rates(scan, too_high_mps)
        if came >= SCANS:
            found["unfollowed"] = notices.unfollowed(scan, came)
        if came >= SCANS or too_high_mps != 0.0:
            self.rates.disbelieve(t_s)
        return found
