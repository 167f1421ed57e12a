"""Two cycles that nobody asked for, before the first one that somebody does."""

from __future__ import annotations

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.method import CycleMethod
from mcdas_opt.planning.time_to_react import with_time_to_react

_FAST_MPS, _SLOW_MPS = 20.0, 12.0


def rehearse(method: CycleMethod, settings: Settings) -> None:
    """Two cycles that nobody asked for, one in which nothing threatens and one between two cars. What runs for the first time takes two to
    four times as long: memory is touched, texts are linked, small tables made."""
    own = min(_FAST_MPS, 0.5 * method.vehicle.speed_max_mps)
    front = Track(id="front", s_m=30.0, d_m=0.0, speed_s_mps=own * _SLOW_MPS / _FAST_MPS)
    rear = Track(id="rear", s_m=-20.0, d_m=0.0, speed_s_mps=own)
    for tracks in ((), (front, rear)):
        situation = Situation(host=HostState(speed_mps=own), tracks=tracks, coverage=Coverage())
        cycle = Cycle.of(situation, method.vehicle, settings)
        answer = method.answer(cycle)
        if isinstance(answer, Plan):
            with_time_to_react(answer, cycle)
