"""Returns that come again and again, and of which no track comes: the radar, its clock or the host's motion is not what it says."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from mcdas_opt.domain.measurement import RadarDetection
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.tracking.placed import Place, PlacedBodies
from mcdas_opt.tracking.track_life import ALIKE_MPS, TrackLife

SCANS = 8  # in which one return has come; a car that is tracked is confirmed by the third
_NEAR_M, _CLOSING_MPS = 5.0, 50.0  # a return is found again within so much of its range, and more with the time between
_ASIDE_M, _CROSSING_MPS = 3.0, 10.0  # and across its line of sight
_RATE_MPS, _RATE_MPS2 = 3.0, 15.0  # and of its range rate: clutter says another one each time
_LONGEST_S = 1.0
_FORGOTTEN = 0.1  # of a scan that has counted, with each that shows its confirmed track
_OFF_ROAD_M = 1.0  # beyond the edge: rails, posts and trees stand there
_BESIDE = 2.0  # of touching: so near a body its own farther reflections are


@dataclass(slots=True)
class UnfollowedReturns:
    """Remembers, of one radar, the returns of its last two scans that belong to no confirmed track, or to a young one, and in how many
    scans each has come without one.

    They are compared as the radar says them: neither the host's place nor its speed, which may be what is wrong, plays a part.
    """

    _seen: Array = field(default_factory=lambda: np.empty((0, 5)), init=False)  # range, azimuth, range rate, scans, scans ago
    _tracks: list[object] = field(default_factory=list, init=False)  # the tentative track that each belongs to
    _t_s: float = field(default=0.0, init=False)

    def take(
        self,
        returns: Sequence[tuple[RadarDetection, object]],
        t_s: float,
        hit: Set[object] = frozenset(),
        confirmed: Mapping[RadarDetection, object] = MappingProxyType({}),
    ) -> int:
        """In how many scans the most persistent of these returns has come, each with its tentative track; 0: there are none.

        `hit` are all tracks that this scan has shown. Whose track is among them has gone on there: another return where it was before, as
        of the next post of a guard rail, does not go on from it. `confirmed` are the returns that belong to confirmed tracks: what was
        counted of one is forgotten little by little, so that it counts where the track is soon lost, and begun anew.
        """
        elapsed_s = min(max(t_s - self._t_s, 0.0), _LONGEST_S)
        self._t_s = t_s
        if not returns and not self._tracks:
            return 0
        scans = dict(zip(self._tracks, self._seen[:, 3].tolist(), strict=True))
        lost = [k for k, track in enumerate(self._tracks) if track not in hit and self._seen[k, 4] <= 2.0]
        old, tracks = self._seen[lost], [self._tracks[k] for k in lost]
        old[:, 4] += 1.0
        new = np.array([(p.range_m, p.azimuth_rad, p.range_rate_mps, scans.get(track, 0.0) + 1.0, 1.0) for p, track in returns])
        new = new.reshape(-1, 5)
        apart = np.abs(new[:, None, :3] - old[None, :, :3])
        again = (
            (apart[..., 0] <= _NEAR_M + _CLOSING_MPS * elapsed_s)
            & (apart[..., 1] * new[:, :1] <= _ASIDE_M + _CROSSING_MPS * elapsed_s)
            & (apart[..., 2] <= _RATE_MPS + _RATE_MPS2 * elapsed_s)
        )
        new[:, 3] = np.maximum(new[:, 3], 1.0 + np.where(again, old[None, :, 3], 0.0).max(axis=1, initial=0.0))
        left = ~again.any(axis=0)
        young = [(p, track) for p, track in confirmed.items() if scans.get(track, 0.0) > _FORGOTTEN]
        kept = np.array([(p.range_m, p.azimuth_rad, p.range_rate_mps, scans[track] - _FORGOTTEN, 1.0) for p, track in young])
        self._seen = np.concatenate([new, kept.reshape(-1, 5), old[left]])
        self._tracks = [track for _, track in (*returns, *young)]
        self._tracks += [track for track, is_left in zip(tracks, left, strict=True) if is_left]
        return int(new[:, 3].max(initial=0.0))


def unexplained(
    followers: Mapping[RadarDetection, TrackLife], lives: Sequence[TrackLife], road: Road, t_s: float, now: float
) -> list[tuple[RadarDetection, TrackLife]]:
    """Of a scan's returns, each with its track (`followers`), those whose tracks are tentative still, but for what stands beside the road,
    and farther reflections of a body that is seen: beside it, or as its echo on a longer way."""
    tentative = [(point, life) for point, life in followers.items() if not life.confirmed]
    if not tentative:
        return []
    bodies, staying = PlacedBodies[TrackLife](_BESIDE), set(lives)
    for life in lives:
        if life.confirmed and not life.goes_on_unseen(now):
            bodies.add(life, life.place(t_s), life.size)
    seen = [point for point, life in followers.items() if life.confirmed]
    return [
        (point, life)
        for point, life in tentative
        if life in staying
        and _is_on(road, life.place(t_s))
        and next(bodies.meeting(life.place(t_s), life.size), None) is None
        and not any(_is_echo(point, other) for other in seen)
    ]


def _is_echo(point: RadarDetection, of: RadarDetection) -> bool:
    return point.range_m > of.range_m and abs(point.range_rate_mps - of.range_rate_mps) < ALIKE_MPS


def _is_on(road: Road, place: Place) -> bool:
    return float(road.right_edge_at(place[0])) - _OFF_ROAD_M <= place[1] <= float(road.left_edge_at(place[0])) + _OFF_ROAD_M
