"""Tracks that cannot all be true: what is doubted of them, and what is planned around instead.

A doubt stops nothing. Whoever may be there is planned around: both of two in one place; who jumped, where it is said to be now and, for a
while, where it was going; who is said to be within the host, beside it. The optimiser, the judge and the times to react see the same.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.doubt import Doubt, DoubtKind, SupposedTrack
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.situation import MOST_TRACKS, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.geometry.rectangle import separation_of_poses
from mcdas_opt.geometry.window import frame_near
from mcdas_opt.situation.assess import CLOCK_DIGITS
from mcdas_opt.situation.host_faults import HARDEST_MPS2, JUMP_MPS

_SIGMAS = 3.0
_OVERLAP_M = 0.5  # bodies that overlap by more, beyond their uncertainty, cannot both be there
_JUMP_M = 3.0  # farther from where it was going, within a cycle, no car gets
_AGAINST_MPS, _AGAINST_SIGMAS = 2.0, 2.0  # who differ in speed by both move against one another
_FASTEST_MPS = 100.0
_MEMORY_S = 1.0  # an older situation says nothing of this one
_SUPPOSED_S = 0.5  # a body whose track has jumped away is planned around for so long
_BESIDE_M = 0.1  # from the host's body to one that was said to be within it
_SURE = 0.99  # of a limit: below it rounding explains nothing
_ROUNDING_M = 1e-6  # what a shift of the origin may change: nobody is ahead by less
_LEAST_SD_M = 0.1  # of an estimate, where one direction is weighed against another
_SUPPOSED = "before its jump"


@dataclass(frozen=True, slots=True, kw_only=True)
class Believed:
    """The situation to plan in, what is doubted of the one that was given, and who is supposed in the cycles to come."""

    situation: Situation
    doubts: tuple[Doubt, ...] = ()
    supposed: tuple[SupposedTrack, ...] = ()


def believed(
    situation: Situation, before: Sequence[Track], elapsed_s: float, supposed: Sequence[SupposedTrack], vehicle: Vehicle
) -> Believed:
    """What to believe of a situation's tracks, given those `before`, so long ago, and who was supposed then; places of all are counted from
    one origin. Of what is not doubted everything stays as it is.

    - Faster than any car: it moves as before, or as the fastest car does.
    - Jumped, in place or speed, since `before` (at most a second ago): it is where it is said to be, and may for a while still be where
      it was going, unless another track is there now: then the two have swapped ids. The nearest, where a situation holds no more.
    - Within the host: it is beside the host, in the direction in which its place is least wrong.
    - In one place: they are all there. Of those that are equal in everything but their names one stays.
    """
    last = {track.id: track for track in before} if 0.0 < elapsed_s <= _MEMORY_S else {}
    doubts: list[Doubt] = []
    tracks = [_drivable(track, last.get(track.id), doubts) for track in situation.tracks]
    still = _supposed(tracks, last, supposed, elapsed_s, situation.road, doubts)
    tracks = _without_duplicates(tracks, last, doubts)
    doubts += _in_one_place(tracks, last)
    tracks = [_beside(track, last.get(track.id), elapsed_s, situation.host, vehicle, doubts) for track in tracks]
    taken = {track.id for track in tracks}
    still = [one for one in still if one.track.id not in taken and _depth_in_host(one.track, situation.host, vehicle) is None]
    if len(tracks) + len(still) > MOST_TRACKS:
        still = sorted(still, key=lambda one: abs(one.track.s_m - situation.host.s_m))[: MOST_TRACKS - len(tracks)]
    tracks += [one.track for one in still]
    same = len(tracks) == len(situation.tracks) and all(map(operator.is_, tracks, situation.tracks))
    return Believed(situation=situation if same else replace(situation, tracks=tuple(tracks)), doubts=tuple(doubts), supposed=tuple(still))


def planned_around(situation: Situation, vehicle: Vehicle) -> Situation:
    """The situation with the tracks that somebody who remembers nothing plans around: what plans are judged in."""
    return believed(situation, (), 0.0, (), vehicle).situation


def _drivable(track: Track, last: Track | None, doubts: list[Doubt]) -> Track:
    """The track at a speed that a car can have."""
    fastest = max(abs(track.speed_s_mps), abs(track.speed_d_mps))
    if fastest <= _FASTEST_MPS:
        return track
    doubts.append(Doubt(kind=DoubtKind.TOO_FAST, tracks=(track.id,), value=fastest, unit="m/s"))
    if last is not None and max(abs(last.speed_s_mps), abs(last.speed_d_mps)) <= _FASTEST_MPS:
        return replace(track, speed_s_mps=last.speed_s_mps, speed_d_mps=last.speed_d_mps)
    along, across = (min(max(speed, -_FASTEST_MPS), _FASTEST_MPS) for speed in (track.speed_s_mps, track.speed_d_mps))
    return replace(track, speed_s_mps=along, speed_d_mps=across)


def _supposed(
    tracks: Sequence[Track],
    last: dict[str, Track],
    supposed: Sequence[SupposedTrack],
    elapsed_s: float,
    road: Road,
    doubts: list[Doubt],
) -> list[SupposedTrack]:
    """Who may still be where it was going, though no track is there now."""
    found, changed = [], _changed(tracks, last, elapsed_s)
    if not supposed and not changed:
        return []
    now = _rows(tracks)
    for one in supposed:
        left_s, expected = round(one.left_s - elapsed_s, CLOCK_DIGITS), one.track.later(elapsed_s)
        if 0.0 < elapsed_s <= _MEMORY_S and left_s > 0.0 and _who_is(expected, now, elapsed_s) is None:
            found.append(SupposedTrack(track=expected, left_s=left_s))
    swapped: set[frozenset[str]] = set()
    for track, then in changed:
        doubt = _jump(track, then, elapsed_s)
        if doubt is None or _goes_on_in_the_plane(track, then, elapsed_s, road):
            continue
        expected = then.later(elapsed_s)
        at = _who_is(expected, now, elapsed_s)
        if at is None:
            doubts.append(doubt)
            found.append(SupposedTrack(track=replace(expected, id=f"{track.id} {_SUPPOSED}"), left_s=_SUPPOSED_S))
            continue
        other = tracks[at]
        if {track.id, other.id} not in swapped:
            swapped.add(frozenset((track.id, other.id)))
            apart = math.hypot(track.s_m - other.s_m, track.d_m - other.d_m)
            doubts.append(Doubt(kind=DoubtKind.IDS_SWAPPED, tracks=(track.id, other.id), value=apart, unit="m"))
    return list({one.track.id: one for one in found}.values())


def _changed(tracks: Sequence[Track], last: dict[str, Track], elapsed_s: float) -> list[tuple[Track, Track]]:
    """Tracks as they are and as they were, where place or speed has changed by what may be more than a car's can: all that `_jump` finds
    something of are among them."""
    most_m, most_mps, half_s = _SURE * _JUMP_M, _SURE * (JUMP_MPS + HARDEST_MPS2 * elapsed_s), 0.5 * elapsed_s
    return [
        (now, then)
        for now, then in ((track, last[track.id]) for track in tracks if track.id in last)
        if abs(now.s_m - then.s_m - half_s * (now.speed_s_mps + then.speed_s_mps)) > most_m
        or abs(now.d_m - then.d_m - half_s * (now.speed_d_mps + then.speed_d_mps)) > most_m
        or abs(now.speed_s_mps - then.speed_s_mps) > most_mps
    ]


def _rows(tracks: Sequence[Track]) -> Array:
    """(6, n): s, d and speed along the road of each, and their variances."""
    return (
        np.array([(t.s_m, t.d_m, t.speed_s_mps, t.covariance[0, 0], t.covariance[2, 2], t.covariance[1, 1]) for t in tracks])
        .reshape(-1, 6)
        .T
    )


def _who_is(expected: Track, rows: Array, elapsed_s: float) -> int | None:
    """The first of the tracks that is where a body was expected, as fast as that: `_place_error` and `_speed_error` of all at once."""
    there = np.ones(rows.shape[1], dtype=bool)
    of = (expected.s_m, expected.d_m, expected.speed_s_mps)
    allowed = (_JUMP_M, _JUMP_M, JUMP_MPS + HARDEST_MPS2 * elapsed_s)
    for row, variances, value, most, k in zip(rows[:3], rows[3:], of, allowed, (0, 2, 1), strict=True):
        spread = _SIGMAS * np.sqrt(np.maximum(variances + expected.covariance[k, k], 0.0))
        there &= ~(np.abs(row - value) > most + spread)
    return int(there.argmax()) if there.any() else None


def _jump(track: Track, last: Track, elapsed_s: float) -> Doubt | None:
    along, across = (0.5 * (last.speed_s_mps + track.speed_s_mps), 0.5 * (last.speed_d_mps + track.speed_d_mps))
    off = _place_error(track, replace(last, speed_s_mps=along, speed_d_mps=across).later(elapsed_s))
    if off is not None:
        return Doubt(kind=DoubtKind.JUMPED, tracks=(track.id,), value=off, unit="m")
    faster = _speed_error(track, last, elapsed_s)
    return None if faster is None else Doubt(kind=DoubtKind.SPEED_JUMPED, tracks=(track.id,), value=faster, unit="m/s")


def _goes_on_in_the_plane(track: Track, last: Track, elapsed_s: float, road: Road) -> bool:
    """Whether its place and speed along a bent road have jumped alone, as those of a body far beside a bend do, and it has moved on in the
    plane as a car can."""
    if road.is_straight:
        return False
    frame = frame_near(road, last.s_m)
    x, y, yaw = frame.to_plane(np.array([last.s_m, track.s_m]), np.array([last.d_m, track.d_m]), np.zeros(2))
    stretch = 1.0 - np.array([last.d_m, track.d_m]) * road.curvature_at([last.s_m, track.s_m])
    along, across = stretch * np.array([last.speed_s_mps, track.speed_s_mps]), np.array([last.speed_d_mps, track.speed_d_mps])
    vx, vy = along * np.cos(yaw) - across * np.sin(yaw), along * np.sin(yaw) + across * np.cos(yaw)
    off = math.hypot(x[1] - x[0] - 0.5 * elapsed_s * (vx[0] + vx[1]), y[1] - y[0] - 0.5 * elapsed_s * (vy[0] + vy[1]))
    return off <= _JUMP_M and math.hypot(vx[1] - vx[0], vy[1] - vy[0]) <= JUMP_MPS + HARDEST_MPS2 * elapsed_s


def _place_error(track: Track, expected: Track) -> float | None:
    """How far it is from where it was expected [m], where that is farther than a car gets."""
    spreads = (_SIGMAS * math.sqrt(max(float(track.covariance[k, k] + expected.covariance[k, k]), 0.0)) for k in (0, 2))
    along, across = abs(track.s_m - expected.s_m), abs(track.d_m - expected.d_m)
    is_off = any(off > _JUMP_M + spread for off, spread in zip((along, across), spreads, strict=True))
    return math.hypot(along, across) if is_off else None


def _speed_error(track: Track, expected: Track, elapsed_s: float) -> float | None:
    """By how much its speed has changed [m/s], where that is more than a car's can."""
    faster = abs(track.speed_s_mps - expected.speed_s_mps)
    spread = _SIGMAS * math.sqrt(max(float(track.covariance[1, 1] + expected.covariance[1, 1]), 0.0))
    return faster if faster > JUMP_MPS + HARDEST_MPS2 * elapsed_s + spread else None


def _in_one_place(tracks: Sequence[Track], last: dict[str, Track]) -> list[Doubt]:
    """Groups of tracks whose bodies overlap by more than they can be mistaken. Two that were there before and clearly differ in speed are
    no doubt: one car has run into the other."""
    if not _some_overlap(tracks):
        return []
    places = np.array([(t.s_m, t.d_m, t.length_m, t.width_m) for t in tracks])
    reach = 0.5 * (places[:, None, 2:] + places[None, :, 2:]) - np.abs(places[:, None, :2] - places[None, :, :2])
    variances = np.array([(t.covariance[0, 0], t.covariance[2, 2]) for t in tracks])
    deep = np.asarray(reach - _SIGMAS * np.sqrt(np.maximum(variances[:, None] + variances[None], 0.0))).min(axis=-1)
    meet = (deep >= _OVERLAP_M) & ~_run_together(tracks, last)
    np.fill_diagonal(meet, False)
    depth = np.where(meet, reach.min(axis=-1), 0.0)
    return [
        Doubt(kind=DoubtKind.ONE_PLACE, tracks=tuple(tracks[k].id for k in group), value=float(depth[group].max()), unit="m")
        for group in _groups(meet)
    ]


def _groups(meet: NDArray[np.bool_]) -> Iterator[NDArray[np.intp]]:
    """Indices of those (n, n) that meet one another, each group of them in order; who meets nobody is in none."""
    left = meet.any(axis=0)
    while left.any():
        group = np.zeros_like(left)
        new = np.arange(left.size) == left.argmax()
        while new.any():
            group |= new
            new = meet[new].any(axis=0) & ~group
        left &= ~group
        yield np.flatnonzero(group)


def _run_together(tracks: Sequence[Track], last: dict[str, Track]) -> NDArray[np.bool_]:
    """(n, n): whether two that were there before clearly differ in speed."""
    speeds = np.array([track.speed_s_mps for track in tracks])
    variances = np.array([track.covariance[1, 1] for track in tracks])
    known = np.array([track.id in last for track in tracks])
    spreads = np.sqrt(np.maximum(variances[:, None] + variances, 0.0))
    differ = np.abs(speeds[:, None] - speeds) > np.maximum(_AGAINST_SIGMAS * spreads, _AGAINST_MPS)
    return np.asarray(differ & known & known[:, None])


def _some_overlap(tracks: Sequence[Track]) -> bool:
    """Whether the bodies of two of them overlap by more than they may, however uncertain they are."""
    longest_m = max((track.length_m for track in tracks), default=0.0)
    from_behind = sorted(tracks, key=attrgetter("s_m"))
    for i, one in enumerate(from_behind, start=1):
        for other in from_behind[i:]:
            if other.s_m - one.s_m > longest_m:
                break
            along = 0.5 * (one.length_m + other.length_m) - abs(one.s_m - other.s_m)
            across = 0.5 * (one.width_m + other.width_m) - abs(one.d_m - other.d_m)
            if along >= _OVERLAP_M and across >= _OVERLAP_M:
                return True
    return False


def _without_duplicates(tracks: Sequence[Track], last: dict[str, Track], doubts: list[Doubt]) -> list[Track]:
    """Of tracks that are equal in all that plans depend on one stays: the one that was known before, else the first."""
    kept: dict[object, int] = {}
    found: list[Track] = []
    for track in tracks:
        at = kept.setdefault((_what_plans_depend_on(track), track.covariance.tobytes()), len(found))
        if at == len(found):
            found.append(track)
            continue
        doubts.append(Doubt(kind=DoubtKind.DUPLICATE, tracks=(found[at].id, track.id), value=0.0, unit="m"))
        if track.id in last and found[at].id not in last:
            found[at] = track
    return found


def _beside(track: Track, was: Track | None, elapsed_s: float, host: HostState, vehicle: Vehicle, doubts: list[Doubt]) -> Track:
    """The track, or, where its body overlaps the host's, the same beside the host: moved along or across the road, whichever its estimate
    is less sure of. One that is deeper in the host than it can be mistaken, and still closes in, would have hit: it closes in no more. But
    not one in line with the host that has come nearer as it says it does: it is where it came from, and closes in, being shorter than was
    thought.
    """
    depth = _depth_in_host(track, host, vehicle)
    if depth is None:
        return track
    doubts.append(Doubt(kind=DoubtKind.WITHIN_HOST, tracks=(track.id,), value=min(depth), unit="m"))
    along, across = (math.sqrt(max(float(track.covariance[k, k]), 0.0)) for k in (0, 2))
    is_in_line = depth[1] - _SIGMAS * across >= _OVERLAP_M
    is_deep = is_in_line and depth[0] - _SIGMAS * along >= _OVERLAP_M
    ahead, aside = track.s_m - host.s_m, track.d_m - host.d_m
    if is_in_line and was is not None and _has_come_nearer(track, was, elapsed_s, host):
        return track.moved_to(track.s_m + math.copysign(depth[0] + _BESIDE_M, ahead), track.d_m)
    if aside != 0.0 and depth[1] / max(across, _LEAST_SD_M) <= depth[0] / max(along, _LEAST_SD_M):
        out, sideways = math.copysign(1.0, aside), track.speed_d_mps
        still = 0.0 if is_deep and sideways * out < 0.0 else sideways
        return replace(track, d_m=track.d_m + out * (depth[1] + _BESIDE_M), speed_d_mps=still)
    out, speed = 1.0 if ahead > _ROUNDING_M else -1.0, track.speed_s_mps
    alike = host.speed_mps if is_deep and (speed - host.speed_mps) * out < 0.0 else speed
    return replace(track, s_m=track.s_m + out * (depth[0] + _BESIDE_M), speed_s_mps=alike)


def _has_come_nearer(track: Track, was: Track, elapsed_s: float, host: HostState) -> bool:
    """Whether it came nearer along the road since then, by about as much as the two speeds say: it has not jumped there."""
    ahead = track.s_m - host.s_m
    closing_m = math.copysign(1.0, ahead) * (host.speed_mps - track.speed_s_mps) * elapsed_s
    nearer_m = abs(was.s_m - (host.s_m - host.speed_mps * elapsed_s)) - abs(ahead)
    return closing_m > _ROUNDING_M and abs(nearer_m - closing_m) <= 0.5 * closing_m


def _depth_in_host(track: Track, host: HostState, vehicle: Vehicle) -> tuple[float, float] | None:
    """How deep its body overlaps the host's along and across the road [m]; None where it does not."""
    if track.lies_aslant and _apart(track, host, vehicle):
        return None
    ahead, aside, longest = abs(track.s_m - host.s_m), abs(track.d_m - host.d_m), track.length_m + vehicle.length_m
    if ahead > longest or aside > longest:
        return None
    c, s = abs(math.cos(host.heading_rad)), abs(math.sin(host.heading_rad))
    along = 0.5 * (track.along_m + vehicle.length_m * c + vehicle.width_m * s) - ahead
    across = 0.5 * (track.across_m + vehicle.length_m * s + vehicle.width_m * c) - aside
    return (along, across) if along > 0.0 and across > 0.0 else None


def _apart(track: Track, host: HostState, vehicle: Vehicle) -> bool:
    """Whether the bodies are apart as they are turned, on the straight line that the road is between the two."""
    assert track.heading_rad is not None
    x, y, halves = np.array([track.s_m - host.s_m]), track.d_m - host.d_m, (0.5 * vehicle.length_m, 0.5 * vehicle.width_m)
    its_halves = (0.5 * track.length_m, 0.5 * track.width_m)
    return float(separation_of_poses(x, y, host.heading_rad, track.heading_rad, halves, its_halves)[0]) > 0.0


_NAMES = ("id", "age_s", "coasting", "covariance")  # of a track: no plan depends on the first three
_what_plans_depend_on = attrgetter(*(each.name for each in fields(Track) if each.name not in _NAMES))
