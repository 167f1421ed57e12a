"""What a plan keeps beyond its verdict: a safe end, the remainder of the previous plan, and the least severe where nothing passes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.safe_end import EndKind
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vocabulary import Side, Status
from mcdas_opt.manoeuvres.safe_end import ends
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.fallback.severity import severity
from mcdas_opt.planning.lane_problem.transcribed_problem import TranscribedProblem
from mcdas_opt.planning.memory import PreviousPlan
from mcdas_opt.planning.planner import Planner
from mcdas_opt.planning.proposals.expected_followers import open_sides
from mcdas_opt.planning.rungs.remainder import remainder
from mcdas_opt.planning.rungs.simple_drives import simple_policies
from mcdas_opt.solvers.outcome import Outcome
from mcdas_opt.solvers.stage_problem import StageGuess
from mcdas_opt.tracking.prediction import predict_for
from tests.planning.situations import car, random_sandwich, sandwich

SEEDS = range(60, 100)


def later(situation: Situation, plan: Plan, seconds: float) -> Situation:
    """The situation when everybody has done as predicted and the host as planned."""
    k = int(np.argmin(np.abs(plan.trajectory.t_s - seconds)))
    tracks = tuple(replace(t, s_m=t.s_m + t.speed_s_mps * seconds) for t in situation.tracks)
    return replace(situation, time_s=situation.time_s + seconds, host=HostState.from_vector(plan.trajectory.states[k]), tracks=tracks)


@pytest.fixture(scope="module")
def planner() -> Planner:
    return Planner()


def test_the_seeds_hold_every_ending(planner: Planner) -> None:
    """What is said below of plans that pass, that end safely and that do not is not said of nobody."""
    found: Counter[str] = Counter()
    for seed in SEEDS:
        planner.reset()
        plan = planner.plan(random_sandwich(seed))
        found[plan.status.value] += 1
        found["safe end"] += plan.safe_end is not None and plan.safe_end.safe
        found["open end"] += plan.safe_end is not None and not plan.safe_end.safe
    assert min(found[kind] for kind in ("planned", "unavoidable", "safe end")) >= 5, found
    assert found["open end"] >= 1


@pytest.mark.parametrize("seed", SEEDS)
def test_planned_comes_to_a_safe_end_and_what_does_not_says_so(planner: Planner, seed: int) -> None:
    situation = random_sandwich(seed)
    planner.reset()
    plan = planner.plan(situation)
    if plan.status is Status.UNAVOIDABLE:
        assert plan.safe_end is None
        return
    assert plan.safe_end is not None
    assert plan.safe_end.t_s == plan.trajectory.t_s[-1]
    prediction = predict_for(situation, planner.settings.prediction)
    again = ends(plan.trajectory, -1, situation.host, planner.vehicle, situation.road, prediction)
    if plan.safe_end.relies_on is None:
        assert bool(again.safe[0]) == plan.safe_end.safe
    else:  # the front is as safe as ever, and who is relied on follows at his distance, or leaves the host no lane beside
        assert not again.front_fails[0]
        assert again.follower_fails[0]
        followers = [track for track in situation.tracks if track.id in plan.safe_end.relies_on.split(" and ")]
        gaps_m = [situation.host.s_m - one.s_m - 0.5 * (one.length_m + planner.vehicle.length_m) for one in followers]
        assert min(gaps_m) > 0.0
        if any(gap_m < 2.0 + 0.65 * 1.2 * one.speed_s_mps for gap_m, one in zip(gaps_m, followers, strict=True)):
            assert not open_sides(Cycle.of(situation, planner.vehicle, planner.settings))
        assert plan.side is Side.NONE
    if plan.status is Status.PLANNED:
        assert plan.safe_end.safe
    if not plan.safe_end.safe:
        assert "no safe end" in plan.reason or "instead of" in plan.reason


def test_rest_of_a_plan_is_the_plan_where_everybody_does_as_foreseen(planner: Planner) -> None:
    planner.reset()
    situation = sandwich()
    plan = planner.plan(situation)
    previous = PreviousPlan.of(plan)
    assert previous is not None
    for seconds in (0.1, 0.5, 1.0):
        rest = remainder(replace(previous, age_s=seconds), later(situation, plan, seconds), planner.vehicle)
        assert rest is not None
        n = min(len(rest), len(plan.trajectory) - round(seconds / 0.1))
        assert np.abs(rest.states[1:n] - plan.trajectory.states[round(seconds / 0.1) + 1 :][: n - 1]).max() < 1e-9
    assert remainder(replace(previous, age_s=60.0), situation, planner.vehicle) is None
    assert remainder(None, situation, planner.vehicle) is None
    assert PreviousPlan.of(replace(plan, status=Status.UNAVOIDABLE)) is None


@pytest.mark.parametrize("early_s", [-5e-7, 3e-9, 5e-7, 2e-6, 1e-4, 3e-4, 9e-4, 1.5e-3])
def test_rest_of_a_plan_begins_however_shortly_before_a_sample_the_cycle_comes(planner: Planner, early_s: float) -> None:
    """A clock that jitters: a first step of 0.3 ms was none that a grid may have, and raised out of `step`."""
    planner.reset()
    situation = sandwich()
    previous = PreviousPlan.of(plan := planner.plan(situation))
    assert previous is not None
    for _ in range(3):  # the rest of a rest too
        rest = remainder(replace(previous, age_s=0.3 - early_s), later(situation, plan, 0.3), planner.vehicle)
        assert rest is not None
        assert np.diff(rest.t_s).min() > 1e-3
        previous = replace(previous, trajectory=rest)


class _Forced:
    """An engine that answers as it is told."""

    kind = "forced"

    def __init__(self, answer: Callable[[StageGuess], Outcome]) -> None:
        self.answer = answer

    def solve(self, x0: Any, p: Any, steps_s: Any, guess: StageGuess, iterations: int | None = None) -> Outcome:
        return self.answer(guess)

    def shifted(self, outcome: Outcome) -> StageGuess:
        return StageGuess(x=outcome.x, u=outcome.u, s=outcome.s)

    def twin(self) -> _Forced:
        return self

    def reset(self) -> None: ...


def _raising(guess: StageGuess) -> Outcome:
    raise RuntimeError("the engine is on fire")


def test_rest_of_the_last_plan_answers_when_the_engines_fall_silent(monkeypatch: pytest.MonkeyPatch) -> None:
    planner = Planner()
    situation = sandwich()
    first = planner.plan(situation)
    assert (first.status, first.side is not Side.NONE) == (Status.PLANNED, True)
    silent = property(lambda posed: _Forced(_raising))
    monkeypatch.setattr(TranscribedProblem, "interior_point", silent)
    monkeypatch.setattr(TranscribedProblem, "osqp", silent)
    for _ in range(10):
        plan = planner.plan(situation := later(situation, planner.previous or first, 0.1))
        assert plan.status is Status.FALLBACK
        assert "the remainder of the previous plan" in plan.reason
        assert plan.safe_end is not None
        assert plan.safe_end.safe
        assert plan.side is first.side


@pytest.mark.parametrize("seed", SEEDS)
def test_unavoidable_is_no_more_severe_than_what_anybody_would_try(planner: Planner, seed: int) -> None:
    situation = random_sandwich(seed)
    planner.reset()
    plan = planner.plan(situation)
    if plan.status is not Status.UNAVOIDABLE:
        assert plan.verdict.passed
        return
    cycle = Cycle.of(situation, planner.vehicle, planner.settings)
    simple = [severity(driven.trajectory, cycle)[0] for driven in simple_policies(cycle)]
    assert severity(plan.trajectory, cycle)[0] <= min(simple) + 0.5 + 1e-9


def test_doubtful_tracks_are_named_and_the_planning_goes_on(planner: Planner) -> None:
    twice = sandwich()
    front, rear = twice.tracks
    ghost = replace(twice, tracks=(*twice.tracks, car("ghost", front.s_m + 0.2, 0.1, 10.0)))
    planner.reset()
    plan = planner.plan(ghost)
    assert plan.status is Status.PLANNED
    assert [(doubt["kind"], doubt["tracks"]) for doubt in plan.to_dict()["doubts"]] == [("in one place", ["front", "ghost"])]
    jumped = replace(ghost, time_s=0.1, tracks=(replace(front, s_m=front.s_m + 12.0), rear))
    plan = planner.plan(jumped)
    assert plan.status is Status.PLANNED
    assert "track front jumped by" in plan.doubts[0].words
    assert [one.track.id for one in planner.memory.observed.supposed] == ["front before its jump"]
    inside = replace(twice, tracks=(car("inside", 0.5, 0.2, 12.0), rear))
    planner.reset()
    plan = planner.plan(inside)
    assert plan.status is Status.PLANNED
    assert "track inside is where the host is" in plan.doubts[0].words
    planner.reset()
    plan = planner.plan(replace(twice, tracks=(replace(front, speed_s_mps=900.0), rear)))
    assert plan.verdict.passed
    assert "track front moves at 900 m/s, faster than any car" in plan.doubts[0].words


def test_end_kinds_are_reported_in_the_document(planner: Planner) -> None:
    planner.reset()
    document = planner.plan(sandwich()).to_dict()
    assert document["safe_end"]["kind"] in {kind.value for kind in EndKind}
    assert document["safe_end"]["t_s"] == document["trajectory"]["t_s"][-1]
