"""What the planner chooses: never worse than the closed form, and where nothing passes with counted work."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from shapely import affinity, geometry

from benchmarks.one_shot import Tally, examine, random_situation
from mcdas_opt import verify
from mcdas_opt.baselines.corrected import CorrectedMethod
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.cost_weights import CostWeights
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import KnownBody, PredictedBody, Prediction
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2
from mcdas_opt.domain.vocabulary import Side, Status
from mcdas_opt.evaluation.suites import expand
from mcdas_opt.planning.candidates import continuation, evaluator
from mcdas_opt.planning.candidates.collision_check import verdicts
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.deadline import Stage
from mcdas_opt.planning.fallback.severity import severities, severity
from mcdas_opt.planning.lane_problem import lane_mpc_solver
from mcdas_opt.planning.mpc import MpcMethod
from mcdas_opt.planning.planner import Planner
from mcdas_opt.planning.rungs.simple_drives import simple_policies
from mcdas_opt.planning.solver_settings import SolverSettings
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.record import Outcome
from mcdas_opt.solvers.interior_point import InteriorPointEngine
from mcdas_opt.solvers.osqp_engine import OsqpEngine
from mcdas_opt.solvers.outcome import Ending
from mcdas_opt.tracking.prediction import predict
from mcdas_opt.verification.judge import judge
from tests.planning.situations import sandwich, under

FAMILY = range(7_100_000_000, 7_100_000_060)


@pytest.fixture(scope="module")
def planner() -> Planner:
    return Planner()


def quiet(situation: Situation) -> Situation:
    """Whoever is ahead or behind in the lane goes as fast as the host."""
    speed = situation.host.speed_mps
    return replace(situation, tracks=tuple(replace(t, speed_s_mps=speed) if abs(t.d_m) < 1.8 else t for t in situation.tracks))


def half_out(situation: Situation) -> Situation:
    """The host astride the edge of its lane, on the side where somebody stands beside it if there is one."""
    return replace(situation, host=replace(situation.host, d_m=float(np.sign(situation.host.d_m)) * 0.7))


def queued(situation: Situation) -> Situation:
    """Everybody slow and near, the host among them."""
    slow = 6.0 / max(situation.host.speed_mps, 6.0)
    tracks = tuple(replace(t, s_m=np.sign(t.s_m) * (4.7 + slow * abs(t.s_m)), speed_s_mps=slow * t.speed_s_mps) for t in situation.tracks)
    return replace(situation, host=replace(situation.host, speed_mps=slow * situation.host.speed_mps), tracks=tracks)


@pytest.mark.parametrize(
    ("changed", "seeds", "least"),
    [(None, range(60), 15), (quiet, range(60, 100), 12), (half_out, range(100, 130), 5), (queued, range(130, 160), 3)],
    ids=["as drawn", "quiet", "half out of the lane", "queued"],
)
def test_no_plan_is_worse_than_the_closed_forms(
    planner: Planner, changed: Callable[[Situation], Situation] | None, seeds: range, least: int
) -> None:
    corrected, tally = CorrectedMethod(planner.vehicle, planner.settings), Tally()
    for seed in (FAMILY.start + number for number in seeds):
        situation = random_situation(seed)
        examine(seed, planner, corrected, tally, situation if changed is None else changed(situation))
    assert tally.counts["situations"] == len(seeds)
    assert tally.counts["both pass"] >= least
    worse = {kind: seeds for kind, seeds in tally.seeds.items() if kind.startswith(("worse", "NaN", "unverified", "exception"))}
    assert not worse


@pytest.mark.parametrize("mirrored", [1.0, -1.0])
def test_a_closed_form_that_swings_out_of_its_lane_is_compared_at_the_price_of_leaving_it(planner: Planner, mirrored: float) -> None:
    corrected, tally, swung = CorrectedMethod(planner.vehicle, planner.settings), Tally(), 0
    for askew_m, friction in ((0.6, 0.2), (0.7, 0.35), (0.85, 0.2), (0.85, 0.35)):
        situation = Situation(
            host=HostState(d_m=-mirrored * askew_m, heading_rad=-0.02 * mirrored),
            tracks=(Track(id="rear", s_m=-54.5, d_m=0.0, speed_s_mps=16.1),),
            road=Road(lanes_left=2, lanes_right=2, friction=friction),
            desired_speed_mps=5.0,
            coverage=Coverage(),
        )
        examine(0, planner, corrected, tally, situation)
        plan = planner.previous
        assert plan is not None
        swung += plan.chosen == "accelerate-driven" and plan.side is (Side.LEFT if mirrored > 0.0 else Side.RIGHT)
    assert tally.counts["both pass"] == 4
    assert swung >= 2
    assert not tally.seeds


def test_the_pre_check_convicts_nobody_whom_the_judge_would_pass(planner: Planner) -> None:
    seen = exact = 0
    for seed in FAMILY:
        situation = random_situation(seed)
        prediction = predict(situation.tracks, planner.settings.prediction)
        cycle = replace(Cycle.of(situation, planner.vehicle, planner.settings), prediction=prediction)
        drives = [driven.trajectory for driven in simple_policies(cycle)]
        for drive, quick in zip(drives, verdicts(drives, cycle), strict=True):
            judged = judge(drive, situation.host, planner.vehicle, situation.road, prediction)
            assert quick.passed == judged.passed
            if quick == judged:
                exact += 1
            else:
                seen += 1
                assert {violation.name for violation in quick.violations} <= {violation.name for violation in judged.violations}
        assert severities(drives, cycle) == [severity(drive, cycle) for drive in drives]
    assert seen > 20
    assert exact > 20


def test_a_plan_that_leaves_has_the_judges_own_verdict(planner: Planner) -> None:
    unavoidable = 0
    for seed in FAMILY:
        situation = random_situation(seed)
        planner.reset()
        plan = planner.plan(situation)
        prediction = predict(situation.tracks, planner.settings.prediction)
        relies_on = None if plan.safe_end is None else plan.safe_end.relies_on
        if relies_on is not None:
            assert verify(plan.trajectory, situation, relies_on=relies_on).passed
            continue
        assert plan.verdict == judge(plan.trajectory, situation.host, planner.vehicle, situation.road, prediction)
        unavoidable += plan.status is Status.UNAVOIDABLE
    assert unavoidable >= 3


def test_the_backup_engine_is_asked_exactly_where_the_first_has_no_answer(planner: Planner, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[str, bool]] = []
    ask = lane_mpc_solver.ask

    def silent_now_and_then(engine: Any, *rest: Any) -> Any:
        outcome = ask(engine, *rest)
        backup = isinstance(engine, OsqpEngine)
        if not backup and len(asked) % 3 == 0:
            outcome = replace(outcome, ending=Ending.FAILED)
        asked.append(("backup" if backup else "first", outcome.usable))
        return outcome

    monkeypatch.setattr(lane_mpc_solver, "ask", silent_now_and_then)
    backups = 0
    for seed in FAMILY[:20]:
        asked.clear()
        planner.reset()
        planner.plan(random_situation(seed))
        for (_, usable_before), (name, _) in pairwise(asked):
            assert (name == "backup") == (not usable_before)
            backups += name == "backup"
    assert backups > 10


def test_newton_steps_are_counted_over_all_ways(planner: Planner, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each solve gets what is left of the cycle's, and little where nothing is left."""
    few = SolverSettings(newton_steps_cycle=40, newton_steps_late=6)
    method, ask = MpcMethod(planner.vehicle, planner.settings, few), lane_mpc_solver.ask
    taken: dict[Any, int] = {}
    late = 0

    def counting(engine: Any, x0: Any, p: Any, steps: Any, guess: Any, cap: int) -> Any:
        nonlocal late
        outcome = ask(engine, x0, p, steps, guess, cap)
        if isinstance(engine, InteriorPointEngine):
            left = few.newton_steps_cycle - taken.get(engine, 0)
            assert cap == min(few.newton_steps, max(left, few.newton_steps_late))
            late += left < few.newton_steps_late
            taken[engine] = taken.get(engine, 0) + outcome.inner_iterations
        return outcome

    monkeypatch.setattr(lane_mpc_solver, "ask", counting)
    for seed in FAMILY[:20]:
        taken.clear()
        method.plan(random_situation(seed), None)
    assert late > 20


def queue(seed: int) -> Situation:
    """One lane at walking or cycling speed: a slower car just ahead, a faster one just behind."""
    r = np.random.default_rng(seed)
    v = r.uniform(2.0, 8.0)
    front = Track(id="front", s_m=4.5 + r.uniform(1.0, 0.6 * v), d_m=r.normal(0.0, 0.2), speed_s_mps=max(v - r.uniform(1.0, 6.0), 0.0))
    rear = Track(id="rear", s_m=-4.5 - r.uniform(0.5, 6.0), d_m=r.normal(0.0, 0.2), speed_s_mps=v + r.uniform(0.0, 3.0))
    return Situation(host=HostState(speed_mps=v), tracks=(front, rear), road=Road(), coverage=Coverage())


def test_who_was_relied_on_before_has_responded(planner: Planner) -> None:
    """Asked again, somebody relied on is relied on still; and, having had the time to respond, also from nearer than without memory."""

    def relied(situation: Situation) -> bool:
        return "unless rear brakes" in planner.plan(situation).reason

    first = nearer_remembered = nearer_anew = 0
    for seed in range(180):
        situation = queue(seed)
        planner.reset()
        if not relied(situation):
            continue
        first += 1
        front, rear = situation.tracks
        assert relied(replace(situation, time_s=0.3))
        nearer = replace(situation, time_s=0.6, tracks=(front, replace(rear, s_m=min(rear.s_m + 0.5, -4.6))))
        remembered = relied(nearer)
        planner.reset()
        anew = relied(nearer)
        assert remembered or not anew
        nearer_remembered, nearer_anew = nearer_remembered + remembered, nearer_anew + anew
    assert first >= 15
    assert nearer_remembered > nearer_anew


@pytest.mark.parametrize("side", [-1.0, 1.0], ids=("right", "left"))
def test_a_corner_over_the_edge_has_left_the_road_and_farther_is_worse(planner: Planner, side: float) -> None:
    """The rectangle's corners are shapely's; half the width alone would let a turned car's corner hang over the edge."""
    road, car, heading = Road(lanes_left=1, lanes_right=1), planner.vehicle, 0.2
    half_length, half_width = 0.5 * car.length_m, 0.5 * car.width_m
    box = affinity.rotate(geometry.box(-half_length, -half_width, half_length, half_width), heading, use_radians=True)
    to_edge = road.left_edge_m - box.bounds[3]
    found = []
    for beyond in (-0.05, 0.05, 0.5):
        states = np.array([[0.0, side * (to_edge + beyond), side * heading, 10.0, 0.0, 0.0]] * 2)
        drive = Trajectory.from_states(np.array([0.0, 0.1]), states, np.zeros((1, 2)))
        found.append(severity(drive, under(predict(()), car, road))[0])
    inside, over, far = found
    assert inside == 0.0
    assert 1e2 < over < far


@pytest.mark.parametrize("gap_m", [-0.2, 0.2, 0.6])
@pytest.mark.parametrize("slower_mps", [2.2, 2.8, 3.2])
@pytest.mark.parametrize("sideways_mps", [-0.54, -0.8])
def test_who_drives_past_a_car_that_comes_over_does_not_brake_beside_it(
    planner: Planner, gap_m: float, slower_mps: float, sideways_mps: float
) -> None:
    """It may come as fast as anybody, and then nothing passes; but only braking is hit if it comes more slowly, too."""
    covariance = np.diag([0.01, 0.05, 0.003, 0.026])
    beside = Track(id="1", s_m=gap_m, d_m=3.45, speed_s_mps=slower_mps, speed_d_mps=sideways_mps, covariance=covariance)
    behind = Track(id="2", s_m=-13.2, d_m=0.0, speed_s_mps=9.0, covariance=covariance)
    situation = Situation(
        host=HostState(speed_mps=5.56), tracks=(beside, behind), road=Road(lanes_left=1, lanes_right=1), coverage=Coverage()
    )
    planner.reset()
    drive = planner.plan(situation).trajectory
    assert float(drive.speed_mps[drive.t_s <= 1.0].min()) > 5.0
    assert float(np.interp(2.0, drive.t_s, drive.s_m)) > gap_m + 2.0 * slower_mps + 3.0


def test_a_lane_change_that_may_be_slower_is_no_more_severe_than_the_fastest(planner: Planner) -> None:
    """To a host that keeps its lane. One that steers into the lane that he leaves meets him there if he is slow: as he keeps his lane and
    as he is changing it, both at once, of which the worse counts."""
    graded = 0
    for seed in FAMILY:
        situation = random_situation(seed)
        sides = [(track, float(np.sign(track.d_m)) * (abs(track.d_m) > 3.0)) for track in situation.tracks]
        coming = [replace(track, d_m=track.d_m - 0.5 * side, speed_d_mps=-0.9 * side) for track, side in sides]
        prediction = predict(coming, planner.settings.prediction, situation.road)
        certain = Prediction(name="", bodies=tuple(_certain(body) for body in prediction.bodies))
        cycle = Cycle.of(situation, planner.vehicle, planner.settings)
        for driven in simple_policies(cycle):
            of_each = (severity(driven.trajectory, replace(cycle, prediction=of)) for of in (prediction, certain))
            (some, when), (most, first) = of_each
            assert when == first
            assert some <= most + 1e-9 or driven.proposed.side is not Side.NONE
            if first == float("-inf") or most >= 1e3:
                assert some == pytest.approx(most, rel=1e-12)
            graded += some < most - 1e-9
    assert graded > 10


def _certain(body: PredictedBody) -> PredictedBody:
    """The same motion, which nobody foretold."""
    return KnownBody(id=body.id, length_m=body.length_m, width_m=body.width_m, motion=body.at)


def test_what_the_regulations_driver_avoids_is_avoided() -> None:
    """UN R157's competent driver, which can only brake, against cut-ins, cut-outs and a braking lead, evenly spread over the suite."""
    families: set[str] = set()
    avoided = 0
    for case in expand("un-r157", None, seed=11).cases[::20]:
        if simulate(case.scene, "un-r157").outcome is Outcome.SAFE:
            run = simulate(case.scene, "mpc")
            assert (run.outcome, run.unverified_plans) == (Outcome.SAFE, 0), case.scene.name
            families.add(case.family)
            avoided += 1
    assert avoided >= 8
    assert len(families) >= 2


def test_a_manoeuvre_under_way_is_compared_again_only_when_its_price_has_risen() -> None:
    """The same plans from fewer candidates than where all of them are compared in every cycle."""
    method = MpcMethod(load_vehicle("sedan"), weights=CostWeights(replanning_ratio=0.0))
    alone, comparing = Planner(), Planner(method=method)
    situation, spared = sandwich(0.4), 0
    for k in range(6):
        situation = replace(situation, time_s=round(0.1 * k, 1))
        plan, other = alone.plan(situation), comparing.plan(situation)
        assert np.array_equal(plan.trajectory.d_m, other.trajectory.d_m)
        assert plan.verdict.passed
        spared += len(other.candidates) - len(plan.candidates)
        names = ("s_m", "d_m", "heading_rad", "speed_mps", "acceleration_mps2", "steering_rad")
        host = replace(situation.host, **{name: float(getattr(plan.trajectory, name)[1]) for name in names})
        moved = [replace(track, s_m=track.s_m + 0.1 * track.speed_s_mps) for track in situation.tracks]
        situation = replace(situation, host=host, tracks=tuple(moved))
    assert plan.side is not Side.NONE
    assert spared > 0


def test_a_manoeuvre_whose_price_rises_is_compared_again() -> None:
    """Somebody appears where the manoeuvre ends: the other candidates are asked too."""
    planner, situation = Planner(), sandwich(0.4)
    plan = planner.plan(situation)
    assert plan.side is not Side.NONE
    across = 3.7 if plan.side is Side.LEFT else -3.7
    slow = replace(situation.tracks[0], id="slow", s_m=situation.host.s_m + 22.0, d_m=across, speed_s_mps=0.5 * situation.host.speed_mps)
    again = planner.plan(replace(situation, time_s=0.1, tracks=(*situation.tracks, slow)))
    assert len(again.candidates) > 1


def test_no_plan_that_passes_goes_on_past_the_end_of_the_road(planner: Planner) -> None:
    """However it is continued beyond its horizon: the host's front, too, stays on the road."""
    passed = continued = 0
    for seed in FAMILY:
        situation = random_situation(seed)
        speed = situation.host.speed_mps
        end_m = 5.0 + speed**2 / (0.8 * situation.road.friction * GRAVITY_MPS2) + 2.0 * speed
        situation = replace(situation, road=replace(situation.road, road_end_s_m=end_m))
        planner.reset()
        plan = planner.plan(situation)
        if plan.verdict.passed:
            passed += 1
            continued += plan.trajectory.t_s[-1] > planner.settings.grid.times_s[-1] + 0.05
            assert float(plan.trajectory.s_m.max()) + 0.5 * planner.vehicle.length_m <= end_m + 0.05
    assert passed >= 20
    assert continued >= 5


def test_after_the_deadline_a_comparison_continues_only_the_cheapest(monkeypatch: pytest.MonkeyPatch) -> None:
    planner, continued = Planner(deadline_s=10.0), []

    def late(candidate: Any, cycle: Cycle) -> Any:
        continued.append(candidate)
        monkeypatch.setattr(Cycle, "is_late_for", lambda cycle, stage: stage in (Stage.SEARCH, Stage.SAFE_END))
        return continuation.ended(candidate, cycle)

    monkeypatch.setattr(evaluator, "ended", late)
    for seed in (7104000061, 7104000112, 7104000139):  # four, five and five pass, but none comes to a safe end
        planner.reset()
        plan = planner.plan(random_situation(seed))
        assert (plan.status, plan.verdict.passed) == (Status.FALLBACK, True)
        assert 1 <= len(continued) <= 2  # the cheapest of either round
        continued.clear()
        monkeypatch.undo()
        monkeypatch.setattr(evaluator, "ended", late)


def test_the_most_promising_ways_will_do_wherever_all_of_them_do(planner: Planner) -> None:
    """At a threat few are solved first: as many situations pass, mostly by the same candidate, in fewer Newton steps; others are named."""
    method = MpcMethod(planner.vehicle, solver=SolverSettings(first_candidates=99))
    every, same, spared, few, most = Planner(method=method), 0, 0, 0, 0
    for seed in FAMILY:
        situation = random_situation(seed)
        planner.reset()
        every.reset()
        plan, other = planner.plan(situation), every.plan(situation)
        assert (plan.status, plan.safe_end is not None and plan.safe_end.safe) == (
            other.status,
            other.safe_end is not None and other.safe_end.safe,
        )
        assert {c.name for c in plan.candidates} == {c.name for c in other.candidates} or plan.status is not Status.PLANNED
        same += plan.chosen == other.chosen
        spared += sum(c.refusal.startswith("not solved: others rank higher") for c in plan.candidates)
        few, most = few + plan.iterations, most + other.iterations
    assert same >= 0.85 * len(FAMILY)
    assert spared > 20
    assert few < 0.9 * most
