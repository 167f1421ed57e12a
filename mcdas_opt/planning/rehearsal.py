"""Cycles that nobody asked for, before the first one that somebody does."""

from __future__ import annotations

import gc

import numpy as np

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.method import CycleMethod
from mcdas_opt.planning.reporting.time_to_react import with_time_to_react

_FAST_MPS, _SLOW_MPS = 20.0, 12.0
_KNOWN = np.diag([0.1, 0.1, 0.1, 0.1]) ** 2
_STRAIGHT = Road()
_WIDE = Road(lanes_left=1, lanes_right=1)
_BEND = Road(lanes_left=1, curvature=((0.0, 0.0), (20.0, 0.01), (60.0, 0.01), (80.0, 0.0)))


def rehearse(method: CycleMethod, settings: Settings) -> None:
    """Cycles that nobody asked for: one in which nothing threatens, one between two cars with a lane to either side, and one in a bend that
    somebody crosses. What runs for the first time takes two to four times as long: memory is touched, texts are linked, small tables
    made. Then Python's collector looks through all that was loaded so far; else it does within one of the first cycles, for 30 ms."""
    own = min(_FAST_MPS, 0.5 * method.vehicle.speed_max_mps)
    front = Track(id="front", s_m=30.0, d_m=0.0, speed_s_mps=own * _SLOW_MPS / _FAST_MPS, covariance=_KNOWN)
    rear = Track(id="rear", s_m=-20.0, d_m=0.0, speed_s_mps=own, covariance=_KNOWN)
    crossing = Track(id="crossing", s_m=60.0, d_m=-12.0, speed_s_mps=0.0, speed_d_mps=3.0, heading_rad=0.5 * np.pi, covariance=_KNOWN)
    for road, tracks in ((_STRAIGHT, ()), (_WIDE, (front, rear)), (_BEND, (crossing,))):
        situation = Situation(host=HostState(speed_mps=own), tracks=tracks, coverage=Coverage(), road=road)
        cycle = Cycle.of(situation, method.vehicle, settings)
        answer = method.answer(cycle)
        if isinstance(answer, Plan):
            with_time_to_react(answer, cycle)
    gc.collect()
