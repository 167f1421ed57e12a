"""The time-to-react assessment of plans, and the alert over a scene."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import Settings, WarningSettings
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Alert
from mcdas_opt.planning.planner import Planner
from mcdas_opt.time_to_react.alert import alert
from mcdas_opt.time_to_react.escapes import escapes
from mcdas_opt.time_to_react.library import KINDS
from mcdas_opt.time_to_react.sweep import swept
from tests.planning.situations import car, sandwich

OFF = Settings(warning=WarningSettings(escapes=False))


@pytest.mark.parametrize("method", ["mpc", "closed-form-corrected"])
def test_a_plan_carries_the_map_unless_that_is_turned_off(method: str) -> None:
    situation = sandwich()
    plan = Planner(method=method).plan(situation)
    assert plan.escapes == escapes(situation)
    document = json.loads(json.dumps(plan.to_dict(), allow_nan=False))
    assert set(document["escapes"]) == set(KINDS)
    assert document["alert"] in {"none", "warn", "act"}
    bare = Planner(method=method, settings=OFF).plan(situation)
    assert bare.escapes is None
    assert "escapes" not in bare.to_dict()
    assert np.array_equal(bare.trajectory.states, plan.trajectory.states)


def approach(time_s: float) -> Situation:
    """A wall ahead, nobody brakes, no lane beside."""
    wall = car("wall", 80.0 - 20.0 * time_s, 0.0, 0.0)
    return Situation(time_s=time_s, host=HostState(speed_mps=20.0), tracks=(wall,), road=Road(), coverage=Coverage())


def test_a_wall_is_warned_of_first_and_acted_on_before_it_is_too_late() -> None:
    """Comfortable braking (3 m/s^2) from 20 m/s takes 67 m and more, full braking 25 m."""
    settings, told, first = WarningSettings(), Alert.NONE, {}
    for step in range(40):
        found = escapes(approach(0.1 * step))
        told = alert(found, settings, told)
        first.setdefault(told, (0.1 * step, found))
    warned, acted = first[Alert.WARN], first[Alert.ACT]
    assert warned[0] < acted[0]
    assert 80.0 - 4.5 - 20.0 * warned[0] <= 20.0**2 / (2.0 * 2.9) + 20.0 * 0.3
    assert acted[1].brake.open
    assert 20.0**2 / 16.0 <= 80.0 - 4.5 - 20.0 * acted[0] <= 20.0**2 / 16.0 + 20.0 * 0.6


def test_a_gentler_idea_of_comfort_warns_earlier() -> None:
    def warned_at(comfort: float) -> float:
        from mcdas_opt.time_to_react.library import EscapeSettings

        chosen = EscapeSettings(comfort_mps2=comfort)
        for step in range(40):
            if alert(escapes(approach(0.1 * step), settings=chosen), WarningSettings()) is not Alert.NONE:
                return 0.1 * step
        return 4.0

    times = [warned_at(comfort) for comfort in (2.0, 3.0, 4.5)]
    assert times == sorted(times)
    assert times[0] < times[-1]


def test_the_sweep_is_the_map_at_each_of_its_points() -> None:

    situation = sandwich()
    sweep = swept(situation, Vehicle(), front_gap_m=np.array([10.0, 30.0]), closing_mps=np.array([2.0, 8.0]))
    front, rear = situation.tracks
    for c, closing in enumerate(sweep.closing_mps):
        for g, gap in enumerate(sweep.front_gap_m):
            moved = replace(front, s_m=float(gap) + 4.5), replace(rear, speed_s_mps=situation.host.speed_mps + float(closing))
            there = escapes(replace(situation, tracks=moved))
            for k, candidate in enumerate(there.candidates):
                assert (candidate.last_moment_s is None) == bool(np.isnan(sweep.last_moment_s[k, c, g]))
                assert candidate.last_moment_s is None or candidate.last_moment_s == sweep.last_moment_s[k, c, g]


def test_who_is_put_ahead_and_behind_has_an_id_of_his_own() -> None:
    sweeps = []
    for ids in (("a", "b", "c"), ("front", "rear", "front braking")):
        beside = tuple(car(name, s_m, 3.7, 20.0) for name, s_m in zip(ids, (30.0, -30.0, 60.0), strict=True))
        situation = Situation(host=HostState(speed_mps=20.0), tracks=beside, road=Road(lanes_left=1), coverage=Coverage())
        sweeps.append(swept(situation, Vehicle(), front_gap_m=np.array([10.0, 30.0]), closing_mps=np.array([2.0, 8.0])))
    assert np.array_equal(sweeps[0].last_moment_s, sweeps[1].last_moment_s, equal_nan=True)
