"""Which sectors a working sensor covers."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from mcdas_opt.domain.measurement import Scan
from mcdas_opt.domain.track import Coverage
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.tracking.screening import FUTURE_TOLERANCE_S, SAME_TIME_S, Source, source_of
from mcdas_opt.tracking.track_life import COAST_S, CONFIRM_HITS, MOST_SOURCES

COVERAGE_PERIODS = 3.0  # without a scan for so many periods, or for as long as tracks live, a sector counts as blind


@dataclass(frozen=True, slots=True)
class _Watch:
    """A sensor that was last heard of at `arrival_s`; it still has to be heard `awaited` times before somebody there can be known."""

    sector: Sector
    period_s: float
    arrival_s: float
    awaited: int = 0
    is_working: bool = True

    @property
    def longest_s(self) -> float:
        """For so long without a scan the sector counts as covered."""
        return min(COVERAGE_PERIODS * self.period_s, COAST_S)


@dataclass(slots=True)
class SectorWatch:
    """Remembers when each working sensor was last heard of. Several sensors may cover one sector; one is enough.

    Who was tracked is forgotten when a sensor is silent for longer than tracks live, or the clock jumps (`is_anew`). Until it has been
    heard so often that a track can be confirmed again, nobody there is known, and a sector where nobody is known is not covered.
    """

    is_anew: bool = False
    _heard: dict[Source, _Watch] = field(default_factory=dict)

    def heard(self, scan: Scan, now: float) -> None:
        """A sound scan has arrived at `now` (whatever its age)."""
        if len(self._heard) > MOST_SOURCES:  # those that are silent are forgotten
            self._heard = {source: watch for source, watch in self._heard.items() if now - watch.arrival_s <= COAST_S}
            self.is_anew = True
        was = self._heard.get(source_of(scan))
        begins = self.is_anew if was is None else now - was.arrival_s > COAST_S + SAME_TIME_S
        awaited = CONFIRM_HITS if begins else 0 if was is None else was.awaited
        self._heard[source_of(scan)] = _Watch(scan.sector, scan.period_s, now, max(awaited - 1, 0))

    def lost(self, scan: Scan) -> None:
        """The sensor says that it does not work, or sends what nobody can be tracked by."""
        named = (scan.sensor, scan.sector)  # one that does not work may not say where it sits
        for source, was in self._heard.items():
            if source == source_of(scan) or (not scan.working and source[:2] == named):
                self._heard[source] = replace(was, is_working=False)

    def coverage(self, now: float) -> Coverage:
        """A sector is covered when one of its sensors was heard of within so many of its periods, and not longer ago than tracks live."""
        seen = {
            watch.sector
            for watch in self._heard.values()
            if watch.is_working and not watch.awaited and -FUTURE_TOLERANCE_S <= now - watch.arrival_s <= watch.longest_s + SAME_TIME_S
        }
        return Coverage(**{sector.value: sector in seen for sector in Sector})
