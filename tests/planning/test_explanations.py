"""Whole drives: what a plan says of itself is what its numbers say."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from itertools import pairwise, product

import numpy as np
import pytest

from mcdas_opt import Planner, replay, simulate
from mcdas_opt.catalogue.data_files import shipped
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.lane import Lane
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.safe_end import EndKind
from mcdas_opt.domain.settings import SelectorSettings, Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.verdict import Verdict, Violation, ViolationKind
from mcdas_opt.domain.vocabulary import Alert, Mode, Side, Status
from mcdas_opt.evaluation.suites import expand
from mcdas_opt.planning.candidate import Checked, strongest_mps2
from mcdas_opt.planning.candidates import driven_closed_form
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.memory import Memory, ReportedMode
from mcdas_opt.planning.proposals.keep_lane import keep_lane
from mcdas_opt.planning.reporting.reason import threat
from mcdas_opt.planning.reporting.reported_mode import still_agrees
from mcdas_opt.plotting.words import passed
from mcdas_opt.situation.assess import assess
from mcdas_opt.tracking.prediction import predict_for
from tests.planning.situations import car

COMFORTABLE_MPS2 = 3.0  # of every shipped road's grip it is the lesser
FOLLOWED = re.compile(r"; (\S+) costs (\d+\.\d\d)")


class _Noting(Planner):
    """Keeps what every cycle left."""

    def __init__(self) -> None:
        super().__init__()
        self.left: list[tuple[Plan, Memory]] = []

    def plan(self, situation):
        plan = super().plan(situation)
        self.left.append((plan, self.memory))
        return plan


@cache
def _drives() -> tuple[list[tuple[Plan, Memory]], ...]:
    scenes = [*shipped("scenes", ".toml"), *(case.scene for case in expand("mid-vehicle", 6, seed=515).cases)]
    return tuple(_cycles(scene) for scene in scenes)


def _cycles(scene) -> list[tuple[Plan, Memory]]:
    planner = _Noting()
    simulate(scene, planner)
    return planner.left


def _plans() -> list[Plan]:
    return [plan for drive in _drives() for plan, _ in drive]


def test_the_chosen_candidates_own_cost_is_told_and_called_the_least_only_where_it_is() -> None:
    least_of = 0
    for plan in _plans():
        if plan.status is not Status.PLANNED:
            continue
        name, cost = FOLLOWED.search(plan.reason).groups()
        rows = {row.name: row for row in plan.candidates if row.cost is not None}
        assert name == plan.chosen
        costs = [row.cost for row in rows.values() if row.passed]
        if found := re.search(r"the least of (\d+) that pass, next (\S+) with (\d+\.\d\d)", plan.reason):
            count, other, its = found.groups()
            assert (int(count), f"{rows[other].cost:.2f}") == (len(costs), its)
            assert float(cost) <= min(costs) + 0.005
            least_of += 1
        for other, its in re.findall(r", (\S+) with (\d+\.\d\d) comes to no safe end", plan.reason):
            assert (rows[other].end, f"{rows[other].cost:.2f}") == (EndKind.OPEN, its)
        for other, its in re.findall(r", (\S+) with (\d+\.\d\d) is not better by enough", plan.reason):
            assert rows[other].passed
            assert float(its) < float(cost) + 0.005
        for other, its in re.findall(r", (\S+) with (\d+\.\d\d) fails", plan.reason):
            assert not rows[other].passed
            assert float(its) < float(cost) + 0.005
    assert least_of > 20


def test_threats_are_told_where_there_are_some_and_only_there() -> None:
    seen = set()
    for drive in _drives():
        for plan, memory in drive:
            if plan.status is Status.PLANNED:
                threatened, alerted = memory.assessment.threatened, plan.alert is not Alert.NONE
                answers = re.match(r"\S+ (crosses and is let through|.* ahead, asks for [\d.]+ m/s\^2);|track ", plan.reason) is not None
                assert plan.reason.startswith("nothing threatens;") == (not threatened and not alerted and not answers)
                assert plan.reason.startswith("with its inputs held it meets ") == (not threatened and alerted and not answers)
                seen.add((threatened, alerted))
    assert seen >= {(False, False), (True, True)}


def test_no_alert_while_the_plan_itself_is_clearly_comfortable() -> None:
    """0.7 of what is comfortable: an alert that was given does not flicker."""
    seen = 0
    for plan in _plans():
        x, road = plan.trajectory, plan.situation.road
        asked = np.hypot(x.acceleration_mps2, x.speed_mps**2 * np.tan(x.steering_rad) / plan.vehicle.wheelbase_m).max()
        comfortable = min(COMFORTABLE_MPS2, 0.7 * road.friction * GRAVITY_MPS2)
        if plan.status is Status.PLANNED and plan.safe_end.safe and asked <= 0.7 * comfortable and plan.mode is not Mode.EVADE:
            assert plan.alert is Alert.NONE
            seen += 1
    assert seen > 500


def test_who_steers_out_or_brakes_hard_warns_whatever_threatens() -> None:
    """A front car's braking, or somebody ahead of it, may ask for that while nothing threatens at the speeds of now."""
    seen = set()
    for drive in _drives():
        for plan, memory in drive:
            x, road, limits = plan.trajectory, plan.situation.road, Settings().comfort.limits(plan.situation.host.speed_mps)
            asked = np.hypot(x.acceleration_mps2, x.speed_mps**2 * np.tan(x.steering_rad) / plan.vehicle.wheelbase_m).max()
            comfortable = min(COMFORTABLE_MPS2, 0.7 * road.friction * GRAVITY_MPS2)
            hard = strongest_mps2(x) < -limits.braking_mps2
            if hard or (plan.mode is Mode.EVADE and asked > comfortable):
                assert plan.alert is not Alert.NONE
                assert not plan.reason.startswith("nothing threatens")
                seen.add((hard, memory.assessment.threatened))
    assert seen >= {(True, False), (False, False), (False, True)}


def test_only_an_evasion_that_was_begun_goes_on() -> None:
    said = 0
    for drive in _drives():
        for (_, before), (plan, _) in pairwise(drive):
            if "; goes on as begun" in plan.reason:
                assert (plan.mode, plan.side) == (Mode.EVADE, before.active.side)
                said += 1
    assert said > 10


def test_who_would_collide_is_told_of_that_though_it_leaves_its_lane() -> None:
    cycle = Cycle.of(Situation(host=HostState(speed_mps=10.0), coverage=Coverage()), Vehicle())
    driven = driven_closed_form.drive(keep_lane(cycle, Mode.CRUISE), cycle)
    collides = Verdict(violations=(Violation(kind=ViolationKind.COLLISION, body="1", t_s=1.0, value=-0.5, limit=0.0, unit="m"),))
    assert "collision with 1" in Checked(driven=driven, verdict=collides, departure=Side.LEFT).refusal
    assert Checked(driven=driven, verdict=Verdict(), departure=Side.LEFT).refusal == "leaves its lane to the left"
    assert Checked(driven=driven, verdict=Verdict()).refusal == ""


def test_what_ends_is_told_by_its_name() -> None:
    road = Road(lanes=(Lane(lane=0, width_m=((60.0, 3.7), (90.0, 0.0)), merges=Side.LEFT),), lanes_left=1)
    host = HostState(speed_mps=25.0)
    lane_ends = assess(Situation(host=host, road=road, coverage=Coverage()), Vehicle(), SelectorSettings())
    road_ends = assess(Situation(host=host, road=Road(road_end_s_m=60.0), coverage=Coverage()), Vehicle(), SelectorSettings())
    assert threat(lane_ends).startswith("the end of the lane, ")
    assert threat(road_ends).startswith("the end of the road, ")


def test_one_warning() -> None:
    plans = _plans()
    assert all(plan.warning == (plan.alert is not Alert.NONE) for plan in plans)
    assert {plan.warning for plan in plans} == {False, True}


def test_who_begins_to_steer_out_of_a_threat_warns() -> None:
    begun = 0
    for drive in _drives():
        for plan, memory in drive:
            if plan.side is not Side.NONE and memory.assessment.threatened:
                assert plan.warning
                begun += 1
    assert begun > 10


def test_the_mode_is_what_the_plan_does() -> None:
    for plan in _plans():
        changes_lanes = plan.mode is Mode.CRUISE and plan.side is not Side.NONE  # as nothing forces it to
        assert not changes_lanes or plan.indicator is plan.side
        assert (plan.mode is Mode.EVADE or changes_lanes) == (plan.side is not Side.NONE)
        strongest = strongest_mps2(plan.trajectory)
        assert not (plan.mode is Mode.BRAKE and strongest >= 0.3)
        assert not (plan.mode is Mode.ACCELERATE and strongest <= -0.3)
        assert not (plan.mode in (Mode.HOLD, Mode.CRUISE) and abs(strongest) > 2.5 + 1e-9)  # begins beyond 2, with a band of 0.5


def test_the_mode_changes_within_a_second_only_for_something_new_or_to_the_opposite() -> None:
    changes = 0
    for drive in _drives():
        for (_, before), (plan, after) in pairwise(drive):
            then, now = before.reported, after.reported
            assert isinstance(then, ReportedMode)
            if then.mode is now.mode:
                continue
            changes += 1
            within_a_second = then.age_s + 0.1 < 1.0 - 1e-6
            assert (f"; {now.mode.value} " in plan.reason and f" s after {then.mode.value} began: " in plan.reason) == within_a_second
            if then.age_s + 0.1 < 1.0 - 1e-6 and not now.is_news_after(then):
                assert not still_agrees(then.mode, plan)
    assert changes > 10


def test_the_shipped_recording_can_be_followed() -> None:
    """Seen by two noisy radars, by a host that does not do as planned: the mode changes within a second only where what is known has
    changed, besides what is measured: who threatens, who is there, or who is taken to brake, accelerate or change lanes."""
    plans = [cycle.plan for cycle in replay("front_and_rear").cycles]
    changed = [(before, after) for before, after in pairwise(plans) if (before.mode, before.side) != (after.mode, after.side)]
    assert 1 <= len(changed) <= 4
    assert {plan.status for plan in plans} == {Status.PLANNED}
    for (_, first), (before, after) in pairwise(changed):
        if after.time_s - first.time_s < 1.0 - 1e-6:
            assert _known(before) != _known(after)
            assert re.search(rf" s after {before.mode.value} began: .*foreseen", after.reason)


def _known(plan: Plan) -> frozenset[str]:
    braking = {f"{track.id} braking" for track in plan.situation.tracks if track.braking_seen_mps2}
    return frozenset(body.id for body in predict_for(plan.situation).bodies) | braking


@pytest.mark.parametrize("method", ["closed-form", "aeb"])
def test_what_nobody_looked_at_is_said(method: str) -> None:
    run = simulate("sandwich-60-40", method)
    for cycle in run.cycles:
        assert cycle.plan.safe_end is None
        assert all("not looked at" in passed(row) for row in cycle.plan.candidates if row.passed)


def test_the_driver_is_warned_of_every_plan_that_is_a_fallback() -> None:
    """Between a lorry and a van that closes in, on a road for two ways: everything in the lane passes, and ends not safely."""
    seen = set()
    for gap_m, behind_m, faster_mps in product((24.5, 20.0, 30.0), (24.7, 18.0), (5.6, 3.0, 8.0)):
        lorry = replace(car("lorry", gap_m + 2.25 + 2.3, 0.0, 16.7), length_m=4.6)
        van = car("van", -behind_m - 4.6, 0.0, 22.2 + faster_mps)
        road = Road(lanes_left=1, lane_width_m=3.5, friction=0.8, lanes=(Lane(lane=1, oncoming=True),))
        plan = Planner().plan(
            Situation(host=HostState(speed_mps=22.2), tracks=(lorry, van), road=road, desired_speed_mps=22.2, coverage=Coverage())
        )
        assert (plan.alert is Alert.NONE) is not plan.warning
        if plan.status is not Status.PLANNED:
            seen.add(plan.safe_end is not None and plan.safe_end.safe)
            assert plan.alert is not Alert.NONE, plan.reason
    assert False in seen


@pytest.mark.parametrize(("speed_mps", "front", "warns"), [(33.0, False, True), (33.0, True, False), (0.0, False, False)])
def test_a_host_that_drives_where_nobody_watches_ahead_warns_of_that(speed_mps: float, front: bool, warns: bool) -> None:
    seen = Coverage(front=front, rear=False, left=False, right=False)
    plan = Planner().plan(Situation(host=HostState(speed_mps=speed_mps), coverage=seen, road=Road(lanes_left=1)))
    assert (plan.alert is Alert.WARN) is warns
    assert plan.reason.startswith("nobody watches ahead: slows down") is warns
