"""Who made the front distance too small: a deficit that others made is owed for a while, one that the host made is not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mcdas_opt.domain.safe_end import SafeEndSettings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.manoeuvres.safe_end import IN_THE_WAY_M, Braking
from mcdas_opt.situation.roles import gap_m


@dataclass(frozen=True, slots=True, kw_only=True)
class FrontDeficit:
    """Of one car ahead: the margin over the distance that can be held [m], and how much of what is short (at most 0) others made."""

    id: str
    margin_m: float
    owed_m: float
    speed_mps: float
    is_in_the_way: bool


def front_deficits(
    situation: Situation, vehicle: Vehicle, settings: SafeEndSettings, before: Sequence[FrontDeficit] = (), elapsed_s: float = 0.0
) -> tuple[FrontDeficit, ...]:
    """Of everybody ahead, given what was `before`, so long ago.

    Whoever comes into the host's way owes all that is short. Of who was there already counts how its speed changed; what was owed is paid
    back in `payback_s`, at most as fast as braking by `payback_mps2` does. What else is short is the host's own making.
    """
    host, braking = situation.host, Braking.of(vehicle, situation.road, settings)
    known = {one.id: one for one in before if one.is_in_the_way}
    fastest = 2.0 * settings.payback_mps2 * max(host.speed_mps, 0.0) / braking.twice_own  # [m/s] that the braking distance falls by
    found = []
    for track in situation.tracks:
        if track.s_m <= host.s_m:
            continue
        speed = max(track.speed_s_mps, 0.0)
        held = max(braking.needed(host.speed_mps, speed), 0.0)
        margin = gap_m(track, host, vehicle) - held
        owed, was = min(margin, 0.0), known.get(track.id)
        in_the_way = abs(track.d_m - host.d_m) < 0.5 * (track.across_m + vehicle.width_m) + IN_THE_WAY_M
        if was is not None and in_the_way:
            paid = min(-was.owed_m / settings.payback_s, fastest) * elapsed_s
            by_it = max(braking.needed(host.speed_mps, was.speed_mps), 0.0) - held
            owed = max(owed, min(max(was.margin_m, 0.0) + was.owed_m + paid + by_it, 0.0))
        found.append(FrontDeficit(id=track.id, margin_m=margin, owed_m=owed, speed_mps=speed, is_in_the_way=in_the_way))
    return tuple(found)
