"""What holds for every plan of every planner."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.random_traffic import ask, episodes
from mcdas_opt.baselines.corrected import CorrectedMethod
from mcdas_opt.domain.grid import TimeGrid
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan, Refusal
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import SelectorSettings, Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.verdict import Verdict, Violation, ViolationKind
from mcdas_opt.domain.vocabulary import Mode, Request, Side, Status
from mcdas_opt.errors import InputError, ParameterError, PlannerFaultWarning
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.deadline import Deadline, Stage
from mcdas_opt.planning.fallback.ladder import NothingPasses
from mcdas_opt.planning.mpc import MpcMethod
from mcdas_opt.planning.planner import Planner
from mcdas_opt.tracking.prediction import predict_for
from mcdas_opt.verification.judge import judge
from tests.planning.situations import car, mirrored, random_sandwich, sandwich

METHODS = ("mpc", "closed-form", "closed-form-corrected")
MIRROR_OF = {Side.LEFT: Side.RIGHT, Side.RIGHT: Side.LEFT, Side.NONE: Side.NONE}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("seed", range(8))
def test_mirrored_situation_has_mirrored_plan(method: str, seed: int) -> None:
    situation = random_sandwich(seed)
    plan, image = Planner(method=method).plan(situation), Planner(method=method).plan(mirrored(situation))
    assert (image.mode, image.side, image.status) == (plan.mode, MIRROR_OF[plan.side], plan.status)
    a, b = plan.trajectory, image.trajectory
    for name, sign in (("s_m", 1), ("d_m", -1), ("heading_rad", -1), ("speed_mps", 1), ("steering_rate_radps", -1), ("jerk_mps3", 1)):
        assert np.abs(getattr(a, name) - sign * getattr(b, name)).max() < 1e-6, name


@pytest.mark.parametrize("side", [Side.LEFT, Side.RIGHT])
def test_symmetric_scene_has_mirrored_candidates_and_the_tie_break_decides(side: Side) -> None:
    settings = Settings(selector=SelectorSettings(tie_break=side))
    plan = Planner(settings=settings).plan(sandwich())
    cost = {c.name: c.cost for c in plan.candidates}
    assert cost["left"] == pytest.approx(cost["right"], abs=1e-6)
    assert (plan.mode, plan.side) == (Mode.EVADE, side)


@pytest.mark.parametrize("seed", range(20, 50))
def test_no_plan_leaves_unverified(seed: int) -> None:
    situation = random_sandwich(seed)
    planner = Planner()
    plan = planner.plan(situation)
    verdict = judge(
        plan.trajectory,
        situation.host,
        planner.vehicle,
        situation.road,
        predict_for(situation, planner.settings.prediction),
    )
    assert verdict == plan.verdict
    assert plan.verdict.passed == (plan.status is not Status.UNAVOIDABLE)
    assert plan.reason
    for candidate in plan.candidates:
        assert candidate.passed != bool(candidate.refusal), candidate


def test_paper_sandwich_literal_fails_and_mpc_passes() -> None:
    literal = Planner(method="closed-form").plan(sandwich())
    assert not literal.verdict.passed
    assert literal.literal_mode is None  # d_f = d_r = 25 m: no row of Table 1
    worst = {v.name: v.value for v in literal.verdict.violations}
    assert worst["acceleration"] == pytest.approx(1.13 * GRAVITY_MPS2, rel=0.01)
    assert worst["friction circle"] > 1.48 * GRAVITY_MPS2
    plan = Planner().plan(sandwich())
    assert plan.verdict.passed
    assert plan.status is Status.PLANNED


@pytest.mark.parametrize("offset_m", [-2.0, -1.0, 0.0, 1.0, 2.0])
def test_offset_bends_the_reference_but_the_plan_ends_in_the_lane(offset_m: float) -> None:
    plan = Planner().plan(sandwich(offset_m))
    assert plan.verdict.passed
    assert plan.side is not Side.NONE
    assert abs(plan.trajectory.d_m[-1]) == pytest.approx(3.7, abs=1.0)


def test_same_input_same_bytes() -> None:
    documents = []
    for _ in range(2):
        planner = Planner()
        plans = [planner.plan(replace(sandwich(0.3), time_s=round(0.1 * k, 1))).to_dict() for k in range(3)]
        for document in plans:
            document.pop("timing_ms")
        documents.append(json.dumps(plans))
    assert documents[0] == documents[1]


@pytest.mark.parametrize("sector", ["left", "right"])
def test_a_side_that_nobody_watches_is_no_way_out(sector: str) -> None:
    situation = replace(sandwich(), coverage=Coverage(**{sector: False}))
    plan = Planner().plan(situation)
    blind = next(c for c in plan.candidates if c.name == sector)
    assert not blind.passed
    assert "watches" in blind.refusal
    assert plan.side.value != sector


def test_blind_everywhere_holds_the_lane_and_slows_down() -> None:
    nobody = Coverage(front=False, rear=False, left=False, right=False)
    plan = Planner().plan(Situation(host=HostState(speed_mps=15.0), coverage=nobody, desired_speed_mps=25.0))
    assert plan.mode is Mode.BRAKE
    assert np.abs(plan.trajectory.d_m).max() < 0.05
    assert plan.trajectory.speed_mps.max() < 15.1
    assert plan.trajectory.speed_mps[-1] < 0.1


def test_boxed_in_on_all_sides_is_labelled() -> None:
    neighbours = [("front", 6.0, 0.0, 5.0), ("rear", -5.5, 0.0, 30.0), ("left", 0.0, 3.7, 20.0), ("right", 0.0, -3.7, 20.0)]
    tracks = tuple(car(name, s, d, v) for name, s, d, v in neighbours)
    plan = Planner().plan(
        Situation(host=HostState(speed_mps=20.0), tracks=tracks, road=Road(lanes_left=1, lanes_right=1), coverage=Coverage())
    )
    assert plan.status is Status.UNAVOIDABLE
    assert not plan.verdict.passed
    assert "least severe" in plan.reason


def test_benign_following_is_not_disturbed() -> None:
    tracks = (car("front", 50.0, 0.0, 25.0), car("rear", -45.0, 0.0, 25.0), car("left", 5.0, 3.7, 27.0))
    plan = Planner().plan(Situation(host=HostState(speed_mps=25.0), tracks=tracks, road=Road(lanes_left=1), coverage=Coverage()))
    assert plan.mode in (Mode.HOLD, Mode.CRUISE)
    assert not plan.warning
    assert np.abs(plan.trajectory.acceleration_mps2).max() < 0.5


class _Refusing:
    """A method that never has an answer."""

    has_ladder = True

    def plan(self, situation: Situation, previous: Plan | None) -> Plan | Refusal:
        return Refusal(reason="it never does")


@pytest.mark.parametrize("seed", range(6))
def test_a_refusal_is_answered_by_the_ladder(seed: int) -> None:
    plan = Planner(method=_Refusing()).plan(random_sandwich(seed))
    assert plan.status in (Status.FALLBACK, Status.UNAVOIDABLE)
    assert plan.verdict.passed == (plan.status is Status.FALLBACK)
    assert "it never does" in plan.reason


def test_asked_to_park_it_stands_until_parking_takes_over() -> None:
    plan = Planner().plan(Situation(host=HostState(), request=Request.PARK, coverage=Coverage()))
    assert (plan.mode, plan.status) == (Mode.PARK, Status.PLANNED)
    assert plan.trajectory.speed_mps.max() < 0.1


def test_asked_to_park_it_still_escapes_from_behind() -> None:
    tracks = (car("rear", -60.0, 0.0, 15.0),)
    plan = Planner().plan(Situation(host=HostState(), tracks=tracks, request=Request.PARK, road=Road(lanes_left=1), coverage=Coverage()))
    assert plan.verdict.passed


@pytest.mark.parametrize("seed", range(4))
def test_nobody_is_steered_into_a_lane_that_nobody_watches(seed: int) -> None:
    rng = np.random.default_rng(seed)
    tracks = (car("front", 30.0, rng.uniform(-0.5, 0.5), 8.0), car("rear", -20.0, 0.0, 25.0))
    road, unseen = Road(lanes_left=1, lanes_right=1), Coverage(left=False, right=False)
    plan = Planner().plan(Situation(host=HostState(speed_mps=20.0), tracks=tracks, road=road, coverage=unseen))
    assert np.abs(plan.trajectory.d_m).max() + 0.9 < 0.5 * road.lane_width_m + 0.35


def test_before_the_end_of_the_road_the_least_severe_brakes() -> None:
    plan = Planner().plan(Situation(host=HostState(speed_mps=15.0), road=Road(road_end_s_m=15.0), coverage=Coverage()))
    assert (plan.status, plan.mode) == (Status.UNAVOIDABLE, Mode.BRAKE)
    assert plan.trajectory.acceleration_mps2.min() < -6.0


def test_a_plan_names_the_candidate_that_it_is() -> None:
    plan = Planner().plan(sandwich(0.3))
    assert any(c.name == plan.chosen and c.passed for c in plan.candidates)


def test_equal_situations_are_equal() -> None:
    situation = random_sandwich(5)
    assert Situation.from_json(situation.to_json()) == situation


def test_unknown_names_are_refused() -> None:
    with pytest.raises(ParameterError, match="closed-form"):
        Planner(method="closed-from")
    with pytest.raises(InputError, match="sedan"):
        Planner(vehicle="seden")
    with pytest.raises(ParameterError, match="deadline_s"):
        Planner(deadline_s=0.0)
    with pytest.raises(ParameterError, match=r"deadline_s = 50 s: must be at most 10: seconds, not milliseconds\?"):
        Planner(deadline_s=50)


def test_a_deadline_gone_by_leaves_the_answer_to_the_ladder() -> None:
    plan = Planner(deadline_s=1e-9).plan(sandwich())
    assert plan.status is Status.FALLBACK
    assert plan.verdict.passed
    assert any("deadline" in c.refusal for c in plan.candidates)


@pytest.mark.parametrize("over", [tuple(Stage)[k:] for k in range(len(Stage) + 1)])
def test_whenever_the_deadline_comes_the_answer_is_judged(over: tuple[Stage, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    """With a last stage only the simple drives are left, and the least severe of them."""
    monkeypatch.setattr(Deadline, "is_over_for", lambda deadline, stage: stage in over)
    planner = Planner(deadline_s=10.0)
    for family in ("sandwich", "dense", "slippery", "contradictory"):
        for one in episodes(family, 5):
            planner.reset()
            for _, plan in ask(one, planner):
                assert np.isfinite(plan.trajectory.table).all()
                assert plan.verdict.passed or plan.status is Status.UNAVOIDABLE
                assert (plan.escapes is None) is (Stage.TIME_TO_REACT in over) or "contradicts" in plan.reason


def test_a_deadline_that_does_not_come_changes_nothing() -> None:
    with_one, without = Planner(deadline_s=10.0), Planner()
    for one in episodes("sandwich", 6):
        for planner in (with_one, without):
            planner.reset()
        for (_, plan), (_, other) in zip(ask(one, with_one), ask(one, without), strict=True):
            assert plan.trajectory.table.tobytes() == other.trajectory.table.tobytes()


class Broken:
    has_ladder, vehicle = True, Vehicle()

    def plan(self, situation: Situation, previous: Plan | None) -> Plan:
        raise ZeroDivisionError("of a planner")


def test_what_a_method_raises_is_answered_by_the_ladder_and_told() -> None:
    with pytest.warns(PlannerFaultWarning, match="Broken failed: ZeroDivisionError: of a planner"):
        plan = Planner(method=Broken()).plan(sandwich())
    assert (plan.status, plan.verdict.passed) == (Status.FALLBACK, True)
    assert "Broken failed: ZeroDivisionError: of a planner" in plan.reason


def test_what_a_method_raises_of_our_errors_is_answered_by_the_ladder_too() -> None:
    """As a record refuses a number that it computed."""

    class Refused(Broken):
        def plan(self, situation: Situation, previous: Plan | None) -> Plan:
            raise ParameterError("speed_mps", -1.0, "must be positive")

    with pytest.warns(PlannerFaultWarning, match="Refused failed: ParameterError: speed_mps"):
        plan = Planner(method=Refused()).plan(sandwich())
    assert (plan.status, plan.verdict.passed) == (Status.FALLBACK, True)


class Believed:
    """The corrected closed form's plan with columns changed, and a verdict that says nothing of it."""

    def __init__(self, *, has_ladder: bool, **changes: float) -> None:
        self.has_ladder, self.changes = has_ladder, changes
        self.of, self.vehicle = CorrectedMethod(Vehicle()), Vehicle()

    def plan(self, situation: Situation, previous: Plan | None) -> Plan | Refusal:
        plan = self.of.plan(situation, previous)
        assert isinstance(plan, Plan)
        drive = plan.trajectory
        changed = replace(drive, **{name: getattr(drive, name) + more for name, more in self.changes.items()})
        return replace(plan, trajectory=changed, verdict=Verdict())


@pytest.mark.parametrize("at_m", [0.0, 5e6])
def test_a_method_with_a_ladder_is_judged_whatever_it_says_of_itself(at_m: float) -> None:
    situation = sandwich()
    there = replace(situation, host=replace(situation.host, s_m=at_m), tracks=tuple(replace(t, s_m=t.s_m + at_m) for t in situation.tracks))
    assert Planner(method=Believed(has_ladder=True)).plan(there).status is Status.PLANNED
    plan = Planner(method=Believed(has_ladder=True, d_m=1.0)).plan(there)
    assert (plan.status, plan.verdict.passed) == (Status.FALLBACK, True)
    assert "start position" in plan.reason


@pytest.mark.parametrize("has_ladder", [True, False])
def test_a_trajectory_that_is_not_finite_is_no_plan(has_ladder: bool) -> None:
    plan = Planner(method=Believed(has_ladder=has_ladder, d_m=np.nan, jerk_mps3=np.inf)).plan(sandwich())
    assert (plan.status, plan.verdict.passed) == (Status.FALLBACK, True)
    assert "Believed gave a trajectory that is not finite: d_m, jerk_mps3" in plan.reason


@pytest.mark.parametrize("kmh", [20, 40, 60, 80, 100, 130])
def test_the_corrected_path_is_driven_within_its_bound(kmh: int) -> None:
    v = kmh / 3.6
    tracks = (car("front", 20.0 + 1.2 * v, 0.0, 0.6 * v), car("rear", -8.0 - 0.6 * v, 0.0, 1.4 * v))
    situation = Situation(host=HostState(speed_mps=v), tracks=tracks, road=Road(lanes_left=1, lanes_right=1), coverage=Coverage())
    planner = Planner(method="closed-form-corrected")
    plan = planner.plan(situation)
    assert plan.mode is Mode.EVADE
    t = plan.trajectory
    lateral = np.abs(t.speed_mps**2 * np.tan(t.steering_rad) / planner.vehicle.wheelbase_m)
    assert lateral.max() <= planner.settings.sigmoid.lateral_acceleration_mps2 * 1.001


def test_situation_survives_json() -> None:
    situation = random_sandwich(3)
    again = Situation.from_json(situation.to_json())
    assert again.to_json() == situation.to_json()
    a, b = Planner().plan(situation).to_dict(), Planner().plan(again).to_dict()
    a.pop("timing_ms"), b.pop("timing_ms")
    assert a == b


class Fine:
    """A plan of its own once, sampled every 2 ms, then refusals."""

    has_ladder = True

    def __init__(self) -> None:
        self.vehicle, self.asked = Vehicle(), 0

    def plan(self, situation: Situation, previous: Plan | None) -> Plan | Refusal:
        self.asked += 1
        if self.asked > 1:
            return Refusal(reason="no more")
        t = np.linspace(0.0, 4.0, 2001)
        states = np.zeros((t.size, 6))
        states[:, 0], states[:, 3] = situation.host.s_m + situation.host.speed_mps * t, situation.host.speed_mps
        drive = Trajectory.from_states(t, states, np.zeros((t.size - 1, 2)))
        return Plan(planner="fine", mode=Mode.HOLD, side=Side.NONE, prediction="", verdict=Verdict(), trajectory=drive)


def test_a_plan_sampled_more_finely_than_a_grid_may_be_is_no_fault_later() -> None:
    planner, alone = Planner(method=Fine()), Situation(host=HostState(speed_mps=20.0), coverage=Coverage())
    assert planner.plan(alone).status is Status.PLANNED
    then = planner.plan(replace(alone, time_s=0.1, host=replace(alone.host, s_m=2.0)))
    assert (then.status, then.verdict.passed) == (Status.FALLBACK, True)


class FailsTheJudge(MpcMethod):
    """Answers as ours does, with a verdict that fails."""

    def answer(self, cycle: Cycle) -> Plan | NothingPasses:
        answer = super().answer(cycle)
        assert isinstance(answer, Plan)
        return replace(
            answer, verdict=Verdict(violations=(Violation(kind=ViolationKind.SAMPLING, t_s=0.0, value=1.0, limit=0.1, unit="s"),))
        )


def test_what_fails_the_judge_keeps_its_candidates_and_iterations() -> None:
    plan = Planner(method=FailsTheJudge(Vehicle(), Settings())).plan(sandwich())
    usual = Planner().plan(sandwich())
    assert plan.status is Status.FALLBACK
    assert plan.iterations == usual.iterations > 0
    assert {row.name for row in usual.candidates} <= {row.name for row in plan.candidates}


def test_a_planner_has_the_settings_of_its_method() -> None:
    fast = Settings(speed_limit_excess=0.2)
    assert Planner(method=MpcMethod(Vehicle(), fast)).settings == fast
    assert Planner(method=MpcMethod(Vehicle(), fast), settings=fast).settings == fast
    with pytest.raises(ParameterError, match="those of the method"):
        Planner(method=MpcMethod(Vehicle(), fast), settings=Settings())


def test_a_method_of_a_shorter_horizon_plans() -> None:
    short = Settings(grid=TimeGrid(steps_s=np.full(30, 0.1)))
    assert Planner(method=MpcMethod(Vehicle(), short)).plan(sandwich()).status is Status.PLANNED
