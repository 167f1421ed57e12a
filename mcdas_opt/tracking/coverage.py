"""Which sectors a working sensor covers."""

from __future__ import annotations

from dataclasses import dataclass, field

from mcdas_opt.domain.measurement import Scan
from mcdas_opt.domain.track import Coverage
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.tracking.screening import Source, source_of

COVERAGE_PERIODS = 3.0  # without a scan for so many periods a sector counts as blind


@dataclass(slots=True)
class _Watch:
    sector: Sector
    period_s: float
    arrival_s: float


@dataclass(slots=True)
class SectorWatch:
    """Remembers when each working sensor was last heard of. Several sensors may cover one sector; one is enough."""

    _heard: dict[Source, _Watch] = field(default_factory=dict)

    def heard(self, scan: Scan, now: float) -> None:
        """A sound scan has arrived at `now` (whatever its age): its sector is covered."""
        self._heard[source_of(scan)] = _Watch(scan.sector, scan.period_s, now)

    def lost(self, scan: Scan) -> None:
        """The sensor says that it does not work, or sends nothing sound."""
        self._heard.pop(source_of(scan), None)

    def coverage(self, now: float) -> Coverage:
        """A sector is covered when one of its sensors was heard of within so many of its periods."""
        seen = {w.sector for w in self._heard.values() if now - w.arrival_s <= COVERAGE_PERIODS * w.period_s + 1e-9}
        return Coverage(**{sector.value: sector in seen for sector in Sector})
