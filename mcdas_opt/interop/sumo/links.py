"""Which lane of a route's edge leads to which of the next one. On an edge of a few metres, as maps have them between the parts of a
junction, nobody changes lanes: the lane that leads on from it is taken before."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from mcdas_opt.interop.sumo.connection import Connection, LaneDomain
from mcdas_opt.interop.sumo.polylines import length_m

_SHORT_M = 30.0


class Link(NamedTuple):
    """To a lane of the next edge, as SUMO counts them, through lanes inside the junction. Where no lane leads to one that goes on, and the
    edge is too short to change lanes on, `to` is the one that does, `beside` lanes from where they lead."""

    to: int
    via: str
    beside: int = 0


Links = Mapping[int, Sequence[Link]]  # of one edge, by lane


def may_use(lanes: LaneDomain, lane: str, vehicle_class: str) -> bool:
    allowed = lanes.getAllowed(lane)
    return (not allowed or vehicle_class in allowed) and vehicle_class not in lanes.getDisallowed(lane)


def links_along(sumo: Connection, route: Sequence[str], vehicle_class: str) -> list[Links]:
    """Of each edge, those that lead on along the route; of the last one none. Links between lanes that the vehicle may use, where there are
    any; and of a lane's to such as go on themselves."""
    found: list[Links] = [{i: [] for i in range(sumo.edge.getLaneNumber(route[-1]))}]
    on = {*found[0]}
    for name, following in zip(route[-2::-1], route[:0:-1], strict=True):
        every = {i: _links(sumo.lane, f"{name}_{i}", following) for i in range(sumo.edge.getLaneNumber(name))}
        own = {i: list(_usable(sumo.lane, f"{name}_{i}", following, ahead, vehicle_class)) for i, ahead in every.items()}
        links: Links = own if any(own.values()) else every
        ways_on = {i for i in on if may_use(sumo.lane, f"{following}_{i}", vehicle_class)}
        if any(length_m(np.asarray(sumo.lane.getShape(f"{following}_{i}"))) < _SHORT_M for i in ways_on):
            links = _to_lanes_that_go_on(links, ways_on)
        else:
            links = {i: [link for link in ahead if link.to in ways_on] or ahead for i, ahead in links.items()}
        found.append(links)
        on = {i for i, ahead in links.items() if ahead}
    return found[::-1]


def _to_lanes_that_go_on(links: Links, on: set[int]) -> Links:
    """Those that lead to one of these lanes; where none does, the one that comes nearest, led over to it."""
    direct = {i: [link for link in ahead if link.to in on] for i, ahead in links.items()}
    if any(direct.values()) or not any(links.values()):
        return direct
    led = [(i, link._replace(to=to, beside=to - link.to)) for i, ahead in links.items() for link in ahead for to in on]
    nearest, best = min(led, key=lambda one: abs(one[1].beside))
    return {i: [best] if i == nearest else [] for i in links}


def _usable(lanes: LaneDomain, lane: str, following: str, links: Iterable[Link], vehicle_class: str) -> Iterator[Link]:
    if may_use(lanes, lane, vehicle_class):
        yield from (link for link in links if may_use(lanes, f"{following}_{link.to}", vehicle_class))


def _links(lanes: LaneDomain, lane: str, following: str) -> list[Link]:
    ends = [(*str(link[0]).rpartition("_"), str(link[4])) for link in lanes.getLinks(lane)]
    return [Link(int(index), via) for edge, _, index, via in ends if edge == following]
