"""Who behind the host is expected to have braked by the end of a plan that keeps its lane; who is before is predicted to brake."""

from __future__ import annotations

from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.lanes.lane_choice import neighbours_in_open_lane


def expected_followers(cycle: Cycle) -> tuple[str, ...]:
    """While driving is ordinary: the attentive follower; and where no lane beside is open, everybody who is behind. The gap to a host that
    keeps its lane is his to keep who follows, or comes in behind, too closely (Responsibility-Sensitive Safety, Shalev-Shwartz et al.
    2017)."""
    attentive = cycle.attentive_follower
    if not cycle.is_ordinary or open_sides(cycle):
        return () if attentive is None else (attentive,)
    host_m, length_m = cycle.situation.host.s_m, cycle.vehicle.length_m
    return tuple(one.id for one in cycle.situation.tracks if host_m - one.s_m > 0.5 * (one.along_m + length_m))


def open_sides(cycle: Cycle) -> frozenset[Side]:
    """The sides whose next lane is free as manners ask: with the headway to everybody there."""
    situation = cycle.situation
    lane = situation.host_lane
    sides = (Side.LEFT, Side.RIGHT)
    return frozenset(side for side in sides if neighbours_in_open_lane(lane, side, situation, cycle.vehicle, cycle.settings) is not None)
