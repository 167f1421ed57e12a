"""The baselines in their textbook form: what their sources say of them holds, and their verdicts are the judge's."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from mcdas_opt.actuation.adaptive_cruise import AdaptiveCruise
from mcdas_opt.baselines.acc import AccMethod
from mcdas_opt.baselines.aeb import AebMethod, needed_gap_m
from mcdas_opt.baselines.competent_driver import BRAKING_MPS2, JERK_MPS3, CompetentDriverMethod
from mcdas_opt.baselines.idm_mobil import IDM, IdmMobilMethod
from mcdas_opt.baselines.lane import neighbours_in
from mcdas_opt.catalogue.scenes import scene_from_document
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan, Refusal
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Mode, Request, Side
from mcdas_opt.dynamics.car_following import Leader, iso_15622_limits
from mcdas_opt.planning.method import build_method, known_methods
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.record import Outcome
from mcdas_opt.tracking.prediction import predict_for
from mcdas_opt.verification.judge import judge

CAR = Vehicle()
BASELINES = ("aeb", "un-r157", "idm-mobil", "acc")


def situation(*tracks: Track, speed: float = 20.0, time_s: float = 0.0, wanted: float | None = None, **road: object) -> Situation:
    return Situation(
        host=HostState(speed_mps=speed), tracks=tracks, road=Road(**road), time_s=time_s, desired_speed_mps=wanted, coverage=Coverage()
    )


@pytest.mark.parametrize("name", BASELINES)
@pytest.mark.parametrize(
    "other",
    [
        Track(id="parked", s_m=30.0, d_m=15.0, speed_s_mps=0.0),
        Track(id="parked", s_m=30.0, d_m=-4.0, speed_s_mps=0.0),
        Track(id="oncoming", s_m=30.0, d_m=5.0, speed_s_mps=-12.0, heading_rad=math.pi),
        Track(id="on foot", s_m=30.0, d_m=3.0, speed_s_mps=0.0, length_m=0.5, width_m=0.5),
    ],
    ids=["far beside", "near beside", "oncoming", "on foot"],
)
def test_nobody_beside_the_road_is_braked_for(name: str, other: Track) -> None:
    alone, beside = (
        planned(build_method(name, CAR, Settings()), situation(*them, speed=12.0, lanes_left=0, lanes_right=0)) for them in ((), (other,))
    )
    np.testing.assert_array_equal(beside.trajectory.states, alone.trajectory.states)


@pytest.mark.parametrize("name", BASELINES)
@pytest.mark.parametrize(
    "other",
    [
        Track(id="half in", s_m=30.0, d_m=2.2, speed_s_mps=0.0),
        Track(id="oncoming", s_m=30.0, d_m=1.0, speed_s_mps=-12.0, heading_rad=math.pi),
        Track(id="crossing", s_m=30.0, d_m=8.0, speed_s_mps=0.0, speed_d_mps=-3.0, heading_rad=-0.5 * math.pi),
    ],
    ids=["half in", "oncoming", "crossing"],
)
def test_who_reaches_into_the_lane_from_beside_the_road_is_braked_for(name: str, other: Track) -> None:
    plan = planned(build_method(name, CAR, Settings()), situation(other, speed=18.0, lanes_left=0, lanes_right=0))
    assert plan.trajectory.acceleration_mps2.min() < -1.0


def test_who_will_be_in_the_lane_on_his_way_across_is_in_it_and_who_has_crossed_it_is_not() -> None:
    def at(d_m: float) -> Situation:
        on_foot = Track(
            id="on foot", s_m=30.0, d_m=d_m, speed_s_mps=0.0, speed_d_mps=1.4, heading_rad=0.5 * math.pi, length_m=0.4, width_m=0.6
        )
        return situation(on_foot, lanes_left=0, lanes_right=0)

    found = [neighbours_in(0, at(d), CAR).ahead is not None for d in (-15.0, -6.0, -2.0, 0.0, 4.0)]
    assert found == [False, True, True, True, False]


def ahead(gap_m: float, speed_mps: float, d_m: float = 0.0, name: str = "front") -> Track:
    return Track(id=name, s_m=gap_m + CAR.length_m, d_m=d_m, speed_s_mps=speed_mps)


def planned(method: AebMethod | CompetentDriverMethod | IdmMobilMethod, at: Situation, previous: Plan | None = None) -> Plan:
    plan = method.plan(at, previous)
    assert isinstance(plan, Plan)
    return plan


@pytest.mark.parametrize("name", BASELINES)
def test_registered_judged_as_they_are_and_not_for_parking(name: str) -> None:
    assert name in known_methods()
    method = build_method(name, CAR, Settings())
    crowded = situation(ahead(9.0, 5.0), Track(id="rear", s_m=-12.0, d_m=0.0, speed_s_mps=27.0), lanes_left=1)
    plan = method.plan(crowded, None)
    assert isinstance(plan, Plan)
    assert plan.planner == name
    assert plan.verdict == judge(plan.trajectory, crowded.host, CAR, crowded.road, predict_for(crowded))
    assert not plan.verdict.passed  # 15 m/s too fast 9 m behind: nobody repairs it
    parking = Situation(host=HostState(), request=Request.PARK, coverage=Coverage())
    assert isinstance(method.plan(parking, None), Refusal)


@pytest.mark.parametrize(("speed", "friction"), [(8.0, 0.9), (25.0, 0.9), (18.0, 0.5), (10.0, 0.25)])
def test_aeb_stops_for_a_standing_car_when_physics_allows(speed: float, friction: float) -> None:
    """From where it cannot yet see that it must, to standstill: no touch, and not far from the car."""
    strength = min(8.0, friction * 9.80665)
    gap = needed_gap_m(speed, Leader(gap_m=0.0, speed_mps=0.0), 0.0, strength, 40.0) + 5.0
    document = {
        "duration_s": gap / speed + speed / strength + 2.0,
        "road": {"friction": friction},
        "host": {"speed_mps": speed},
        "neighbour": [{"s_m": gap + CAR.length_m, "speed_mps": 0.0}],
    }
    run = simulate(scene_from_document(document, Path("standing.toml")), planner="aeb")
    assert run.outcome is Outcome.SAFE
    assert run.trajectory.speed_mps[-1] < 0.1
    assert run.min_clearance_m is not None
    assert 0.2 < run.min_clearance_m < 3.5 + 0.05 * speed
    assert [mode for _, mode in run.modes][:2] == ["hold", "brake"]


@given(speed=st.floats(5.0, 35.0), closing=st.floats(0.5, 30.0), share=st.floats(0.05, 3.0))
@example(speed=7.0, closing=7.0, share=1.0 - 1e-9)
@example(speed=7.0, closing=7.0, share=1.0 + 1e-9)
@settings(max_examples=30)
def test_aeb_brakes_exactly_from_the_last_moment_on(speed: float, closing: float, share: float) -> None:
    assume(abs(share - 1.0) >= 1e-9)  # the gap is a difference of two places, which round
    method = AebMethod(CAR)
    other = max(speed - closing, 0.0)
    needed = needed_gap_m(speed, Leader(gap_m=0.0, speed_mps=other), 0.0, 8.0, 40.0)
    plan = planned(method, situation(ahead(share * needed, other), speed=speed))
    assert (plan.mode is Mode.BRAKE) == (share <= 1.0)
    assert planned(method, situation(ahead(share * needed, speed + 0.1), speed=speed)).mode is Mode.HOLD


@pytest.mark.parametrize("braking", [2.5, 5.0, 7.0])
def test_aeb_sees_that_the_car_ahead_goes_on_braking(braking: float) -> None:
    front = {"s_m": 50.0 + CAR.length_m, "speed_mps": 25.0, "motion": [{"start_s": 0.5, "acceleration_mps2": -braking}]}
    document = {"duration_s": 11.0, "host": {"speed_mps": 25.0}, "neighbour": [front]}
    run = simulate(scene_from_document(document, Path("braking.toml")), planner="aeb")
    assert run.outcome is Outcome.SAFE
    assert run.trajectory.speed_mps[-1] < 1.0


def test_aeb_once_braking_brakes_until_the_closing_has_ended() -> None:
    method = AebMethod(CAR)
    first = planned(method, situation(ahead(12.0, 5.0)))
    assert first.mode is Mode.BRAKE
    room = situation(ahead(12.0, 5.0), speed=7.0, time_s=1.0)
    assert planned(method, room, first).mode is Mode.BRAKE
    assert planned(method, room).mode is Mode.HOLD


@given(speed=st.floats(3.0, 30.0), headroom=st.floats(1.1, 2.0))
@settings(max_examples=30)
def test_idm_keeps_its_equilibrium_gap(speed: float, headroom: float) -> None:
    """s_e(v) = (s_0 + v T) / sqrt(1 - (v / v_0)^4) behind a leader of the same speed (Treiber et al. 2000, eq 5)."""
    idm, desired = IDM, headroom * speed
    gap = (idm.jam_distance_m + speed * idm.headway_s) / math.sqrt(1.0 - (speed / desired) ** 4)
    plan = planned(IdmMobilMethod(CAR), situation(ahead(gap, speed), speed=speed, wanted=desired, speed_limit_mps=60.0))
    assert np.abs(plan.trajectory.acceleration_mps2).max() < 1e-6
    nearer = planned(IdmMobilMethod(CAR), situation(ahead(0.9 * gap, speed), speed=speed, wanted=desired, speed_limit_mps=60.0))
    assert nearer.trajectory.acceleration_mps2[10] < -0.01


@given(gap=st.floats(0.5, 120.0), closing=st.floats(0.0, 15.0), left=st.booleans())
@example(gap=1.0, closing=8.0, left=True)
@example(gap=100.0, closing=0.0, left=False)
@settings(max_examples=40)
def test_mobil_never_changes_when_the_new_follower_would_brake_harder_than_is_safe(gap: float, closing: float, left: bool) -> None:
    side, sign = (Side.LEFT, 1.0) if left else (Side.RIGHT, -1.0)
    behind = Track(id="next", s_m=-gap - CAR.length_m, d_m=sign * 3.7, speed_s_mps=20.0 + closing)
    at = situation(ahead(25.0, 12.0), behind, lanes_left=int(left), lanes_right=int(not left))
    method = IdmMobilMethod(CAR)
    trade = method.exchange(at, side)
    assert trade is not None
    plan = planned(method, at)
    safe = trade.new_after >= -4.0
    assert (plan.side is side) == (safe and trade.gain_mps2 > 0.0)
    if gap < 3.0 and closing > 2.0:
        assert plan.side is Side.NONE


def test_mobil_asks_for_a_lane_that_is_there_watched_and_free_beside() -> None:
    slow = ahead(25.0, 12.0)
    method = IdmMobilMethod(CAR)
    assert planned(method, situation(slow, lanes_left=1)).side is Side.LEFT
    assert planned(method, situation(slow)).side is Side.NONE
    beside = Track(id="beside", s_m=2.0, d_m=3.7, speed_s_mps=20.0)
    assert planned(method, situation(slow, beside, lanes_left=1)).side is Side.NONE
    blind = Situation(host=HostState(speed_mps=20.0), tracks=(slow,), road=Road(lanes_left=1), coverage=Coverage(left=False))
    assert planned(method, blind).side is Side.NONE
    begun = planned(method, situation(slow, lanes_left=1))
    later = Situation(
        host=HostState(s_m=10.0, d_m=0.6, speed_mps=20.0), tracks=(slow,), road=Road(lanes_left=1), time_s=0.5, coverage=Coverage()
    )
    assert planned(method, later, begun).memory is begun.memory


def test_the_competent_driver_reacts_as_published() -> None:
    """Throttle released at once, the brake after 0.75 s, 0.774 g 0.6 s later; the clock runs on from cycle to cycle."""
    assert abs(BRAKING_MPS2 / JERK_MPS3 - 0.6) < 0.001
    method = CompetentDriverMethod(CAR)
    near = situation(ahead(25.0, 0.0))  # 1.25 s
    plan = planned(method, near)
    t, a = plan.trajectory.t_s, plan.trajectory.acceleration_mps2
    assert np.allclose(a[(t > 0.1) & (t <= 0.75)], -0.4)
    assert np.interp(1.05, t, a) == pytest.approx(-12.65 * 0.3, abs=0.7)
    assert np.interp(1.45, t, a) == pytest.approx(-BRAKING_MPS2, abs=0.02)
    later = planned(method, situation(ahead(12.0, 0.0), time_s=0.7), plan)
    assert later.memory == plan.memory
    assert np.interp(0.35, later.trajectory.t_s, later.trajectory.acceleration_mps2) == pytest.approx(-12.65 * 0.3, abs=0.7)
    assert planned(method, situation(ahead(12.0, 0.0), time_s=0.7)).trajectory.acceleration_mps2[6] == pytest.approx(-0.4)


def test_the_competent_driver_perceives_critical_closing_and_whoever_leaves_the_wandering_zone() -> None:
    method = CompetentDriverMethod(CAR)
    for gap, mode in ((41.0, Mode.HOLD), (39.0, Mode.BRAKE)):  # 20 m/s closing: 2 s are 40 m
        assert planned(method, situation(ahead(gap, 0.0))).mode is mode
    assert planned(method, situation(ahead(10.0, 20.5))).mode is Mode.HOLD
    for out_of_lane_m, mode in ((0.3, Mode.HOLD), (0.45, Mode.BRAKE), (-0.45, Mode.HOLD)):
        coming = ahead(15.0, 5.0, d_m=3.7 - out_of_lane_m, name="next")
        assert planned(method, situation(coming, lanes_left=1)).mode is mode
        mirrored = ahead(15.0, 5.0, d_m=out_of_lane_m - 3.7, name="next")
        assert planned(method, situation(mirrored, lanes_right=1)).mode is mode


@pytest.mark.parametrize("time_gap", [0.8, 1.2, 2.0])
def test_acc_gains_are_those_of_the_riccati_equation_and_damp_both_errors(time_gap: float) -> None:
    cruise = AdaptiveCruise(time_gap_s=time_gap)
    on_gap, on_closing = cruise.gains
    a, b = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[-time_gap], [-1.0]])
    closed = a + b @ np.array([[on_gap, on_closing]])
    assert np.linalg.eigvals(closed).real.max() < -0.1
    from scipy.linalg import solve_continuous_are

    p = solve_continuous_are(a, b, np.diag([1.0 / 25.0, 1.0 / 2.25]), np.eye(1))
    assert (-on_gap, -on_closing) == pytest.approx(tuple((b.T @ p)[0]))
    steady = Leader(gap_m=cruise.standstill_m + 20.0 * time_gap, speed_mps=20.0)
    assert cruise.wanted_mps2(20.0, 30.0, steady) == pytest.approx(0.0)


@given(
    speed=st.floats(0.0, 45.0),
    wanted=st.floats(0.0, 45.0),
    gap=st.floats(-5.0, 200.0),
    front=st.floats(0.0, 45.0),
    acceleration=st.floats(-3.0, 2.0),
)
def test_acc_asks_for_no_more_than_iso_15622_allows(speed: float, wanted: float, gap: float, front: float, acceleration: float) -> None:
    asked = AdaptiveCruise().wanted_mps2(speed, wanted, Leader(gap_m=gap, speed_mps=front))
    most, least, _ = iso_15622_limits(speed)
    assert -least <= asked <= most


@pytest.mark.parametrize(("speed", "wanted"), [(5.0, 10.0), (20.0, 25.0), (33.0, 36.0)])
def test_acc_settles_at_its_time_gap_and_its_limit(speed: float, wanted: float) -> None:
    document = {
        "duration_s": 40.0,
        "road": {"speed_limit_mps": 40.0},
        "host": {"speed_mps": speed, "desired_speed_mps": wanted},
        "neighbour": [{"name": "front", "s_m": 2.5 * speed + 4.5, "speed_mps": speed}],
    }
    run = simulate(scene_from_document(document, Path("acc.toml")), "acc")
    gap = float(run.neighbours[0].s_m[-1] - run.trajectory.s_m[-1]) - 4.5
    assert gap == pytest.approx(2.0 + 1.2 * speed, rel=0.03)
    assert float(run.trajectory.speed_mps[-1]) == pytest.approx(speed, abs=0.1)
    assert run.trajectory.acceleration_mps2.max() < iso_15622_limits(speed)[0] + 0.05
    alone = situation(speed=30.0, wanted=40.0, speed_limit_mps=32.0)
    assert isinstance(plan := AccMethod(CAR).plan(alone, None), Plan)
    assert plan.trajectory.speed_mps.max() < 32.05


@pytest.mark.parametrize("name", BASELINES)
def test_the_first_plan_loads_nothing(name: str) -> None:
    code = f"""
import sys
import mcdas_opt as mo

front = mo.Track(id="front", s_m=29.5, d_m=0.0, speed_s_mps=11.1)
seen = mo.Situation(host=mo.HostState(speed_mps=11.1), tracks=(front,), coverage=mo.Coverage(), road=mo.Road())
planner = mo.Planner(vehicle="sedan", method={name!r})
before = set(sys.modules)
planner.plan(seen)
print(sorted(set(sys.modules) - before))
"""
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "[]"
