"""Recorded radar, moment by moment: what the tracker believed, as situations that every planner can answer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Mode
from mcdas_opt.errors import InputError
from mcdas_opt.interop.replay import replay
from mcdas_opt.interop.replay_record import Cycle

NOTE = "A log says nothing of the road: one lane to either side is assumed, and sides that no radar watches count as occupied."
_LANES = Road(lanes_left=1, lanes_right=1)


@dataclass(frozen=True, slots=True, kw_only=True)
class Moments:
    """The cycles of a log, on an assumed road (`NOTE`)."""

    name: str
    cycles: tuple[Cycle, ...]
    road: Road = _LANES
    vehicle: Vehicle = field(default_factory=Vehicle)

    @property
    def times_s(self) -> list[float]:
        """Since the first cycle."""
        return [round(cycle.t_s - self.cycles[0].t_s, 3) for cycle in self.cycles]

    @property
    def first_threat(self) -> int:
        """Index of the first cycle in which something is to be done; 0 where nothing ever is."""
        quiet = (Mode.HOLD, Mode.CRUISE)
        return next((k for k, cycle in enumerate(self.cycles) if cycle.mode not in quiet), 0)

    def situation(self, moment: int) -> Situation:
        """Raises `InputError` for a moment that the log has not."""
        if not 0 <= moment < len(self.cycles):
            raise InputError(self.name, "moment", moment, f"must be in 0 .. {len(self.cycles) - 1}")
        cycle = self.cycles[moment]
        tracks = tuple(
            Track(
                id=seen.id,
                s_m=cycle.host.s_m + seen.s_m,
                d_m=cycle.host.d_m + seen.d_m,
                speed_s_mps=seen.speed_s_mps,
                speed_d_mps=seen.speed_d_mps,
                covariance=seen.covariance,
                length_m=seen.length_m,
                width_m=seen.width_m,
                coasting=seen.coasting,
            )
            for seen in cycle.tracks
        )
        covered = {sector.value for sector in cycle.covered}
        coverage = Coverage(**{name: name in covered for name in ("front", "rear", "left", "right")})
        return Situation(time_s=cycle.t_s, host=cycle.host, tracks=tracks, coverage=coverage, road=self.road)


def read(path: Path, progress: Callable[[int, int], None] | None = None) -> Moments:
    """Runs the recording through the tracker, without planning. The host's speed is sought beside it, in `<name>.host.csv`.

    Raises `InputError` for an unusable file, `MissingExtraError` for CAN logs without their packages.
    """
    beside = path.with_name(f"{path.stem}.host.csv")
    done = replay(path, host=beside if beside.is_file() else None, plan=False, progress=progress)
    return Moments(name=path.name, cycles=done.cycles)
