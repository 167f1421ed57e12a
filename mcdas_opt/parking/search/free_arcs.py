"""How far an arc is free, by conservative advancement: along it as far as the clearance makes safe, again and again."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.rules import Array
from mcdas_opt.parking.path import along_arc, top_curvature
from mcdas_opt.parking.world import World

REACH_M = 3.0  # how far arcs are followed
MARGIN_M = 1e-3  # more clearance than asked
LOOKAHEAD = 14  # advancement steps along one arc
STEERING_SHARES = (1.0, 0.5, 0.0, -0.5, -1.0)  # of the largest curvature
_PROBE_STEP_M = 0.01


def advance(
    world: World, asked_m: float, pose: Array, kappa: Array, direction: Array, room: Array, *, step_m: float, steps: int
) -> tuple[Array, Array]:
    """(free, blocked), (n,) each [m]: how far every arc keeps the asked clearance, and where it was first seen not to (infinite: nowhere).

    Arcs begin at `pose` (n, 3), which has the clearance `room` (n,), with curvature `kappa` and `direction` (+1 or -1). A step is at
    least `step_m`: contact lies between the two lengths.
    """
    stretch = 1.0 + np.abs(kappa) * world.body.reach  # how far a body point moves per metre, at most
    free, blocked = np.zeros(len(pose)), np.full(len(pose), np.inf)
    active = np.arange(len(pose))
    slack = room - asked_m
    for _ in range(steps):
        ahead = np.minimum(free[active] + np.maximum(slack / stretch[active], step_m), REACH_M)
        slack = world.clearance(along_arc(pose[active], kappa[active], direction[active] * ahead)) - asked_m
        sound = slack >= 0.0
        free[active[sound]] = ahead[sound]
        blocked[active[~sound]] = ahead[~sound]
        unfinished = sound & (ahead < REACH_M - 1e-9)
        active, slack = active[unfinished], slack[unfinished]
        if active.size == 0:
            break
    return free, blocked


def arcs_both_ways(shares: tuple[float, ...], top: float) -> tuple[Array, Array]:
    """(curvature, direction) of an arc for every share of the largest curvature, forward and then in reverse."""
    return np.tile(np.array(shares) * top, 2), np.repeat([1.0, -1.0], len(shares))


def total_free_length(case: ParkingCase, world: World, pose: Array) -> float:
    """How far [m], all added, the arcs lead from a pose before they come too near to something."""
    kappa, direction = arcs_both_ways(STEERING_SHARES, top_curvature(case.vehicle))
    room = np.full(kappa.size, float(world.clearance(pose[None])[0]))
    poses = np.tile(pose, (kappa.size, 1))
    asked = case.limits.clearance_m + MARGIN_M
    free, _ = advance(world, asked, poses, kappa, direction, room, step_m=_PROBE_STEP_M, steps=LOOKAHEAD)
    return float(free.sum())
