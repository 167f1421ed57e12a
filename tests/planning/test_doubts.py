"""Whatever is wrong with the tracks, every cycle has a plan of its own that is clear of all that may be there."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from benchmarks.random_traffic import episode
from mcdas_opt.domain.doubt import DoubtKind
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vocabulary import Status
from mcdas_opt.planning.planner import Planner
from mcdas_opt.simulation.judging import verify
from mcdas_opt.tracking.prediction import predict_for
from mcdas_opt.verification.judge import judge

PLANNER = Planner()
NOISE = np.diag([0.2, 0.3, 0.1, 0.1]) ** 2
FAULTS = ("duplicate", "near duplicate", "ghost", "split", "merge", "swap", "inside", "jump", "speed", "vanish")


def car(name: str, s: float, speed: float, d: float = 0.0, length: float = 4.5) -> Track:
    return Track(id=name, s_m=s, d_m=d, speed_s_mps=speed, covariance=NOISE, length_m=length)


def traffic(*, front_m: float = 45.0, closing_mps: float = 3.0, time_s: float = 0.0) -> Situation:
    cars = (
        car("front", front_m, 20.0 - closing_mps),
        car("rear", -35.0, 21.0),
        car("left", 8.0, 21.0, 3.7),
        car("right", -20.0, 19.0, -3.7),
    )
    return Situation(
        time_s=time_s, host=HostState(speed_mps=20.0), tracks=cars, road=Road(lanes_left=1, lanes_right=1), coverage=Coverage()
    )


def planted(situation: Situation, fault: str, who: int, off_m: float, aside_m: float, faster_mps: float) -> Situation:
    """The situation as a sensor that is wrong tells of it."""
    tracks = list(situation.tracks)
    one = tracks[who % len(tracks)]
    if fault == "duplicate":
        tracks.append(replace(one, id="again"))
    elif fault in ("near duplicate", "ghost"):
        share = 0.3 if fault == "near duplicate" else 3.0
        tracks.append(
            replace(
                one, id="ghost", s_m=one.s_m + share * off_m, d_m=one.d_m + 0.3 * aside_m, speed_s_mps=one.speed_s_mps + share * faster_mps
            )
        )
    elif fault == "split":
        tracks += [replace(one, id=f"part{k}", s_m=one.s_m + 3.0 * k, speed_s_mps=one.speed_s_mps + 0.1 * k) for k in range(1, 4)]
    elif fault == "merge":
        tracks = [track for track in tracks if track is not tracks[(who + 1) % len(tracks)]]
    elif fault == "swap":
        other = tracks[(who + 1) % len(tracks)]
        tracks = [replace(track, id=other.id if track is one else one.id if track is other else track.id) for track in tracks]
    elif fault == "inside":
        host = situation.host
        tracks.append(car("inside", host.s_m + off_m, max(host.speed_mps + 3.0 * faster_mps, 0.0), host.d_m + 0.5 * aside_m))
    elif fault == "jump":
        tracks[tracks.index(one)] = replace(one, s_m=one.s_m + 5.0 * off_m, d_m=one.d_m + aside_m)
    elif fault == "speed":
        tracks[tracks.index(one)] = replace(one, speed_s_mps=one.speed_s_mps + 100.0 * faster_mps)
    else:
        tracks.remove(one)
    return replace(situation, tracks=tuple(tracks))


def later(situation: Situation, plan: Plan) -> Situation:
    """0.1 s on: the host along its plan, the others at constant speed."""
    drive, t = plan.trajectory, 0.1
    now = HostState.from_vector(np.array([np.interp(t, drive.t_s, column) for column in drive.table[1:7]]))
    tracks = tuple(replace(track, s_m=track.s_m + t * track.speed_s_mps) for track in situation.tracks)
    return replace(situation, time_s=situation.time_s + t, host=replace(now, speed_mps=max(now.speed_mps, 0.0)), tracks=tracks)


def is_of_this_cycle(plan: Plan, situation: Situation) -> bool:
    """Made for this situation, from where the host is; judged."""
    start = plan.trajectory.table[1:5, 0]
    host = situation.host
    here = np.allclose(start, (host.s_m, host.d_m, host.heading_rad, host.speed_mps), atol=1e-6)
    return here and plan.time_s == situation.time_s and (plan.verdict.passed or plan.status is Status.UNAVOIDABLE)


PLANTED = st.tuples(st.sampled_from(FAULTS), st.integers(0, 3), st.floats(-4.0, 4.0), st.floats(-2.0, 2.0), st.floats(-1.0, 1.0))


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(faults=st.lists(PLANTED, min_size=1, max_size=4), front_m=st.floats(15.0, 60.0), closing_mps=st.floats(-2.0, 8.0))
@example(faults=[("inside", 0, 0.0, 0.0, 0.0)] * 1, front_m=40.0, closing_mps=2.0)
@example(faults=[("duplicate", 0, 0.0, 0.0, 0.0)] * 3, front_m=15.0, closing_mps=7.0)
def test_planted_faults_never_stop_the_planning(faults: list[tuple[Any, ...]], front_m: float, closing_mps: float) -> None:
    """Cycle after cycle another fault, and then none: no exception, and a plan of this cycle that is not the remainder of the last one."""
    PLANNER.reset()
    truth = traffic(front_m=front_m, closing_mps=closing_mps)
    for fault in [*faults, None]:
        told = truth if fault is None else planted(truth, *fault)
        plan = PLANNER.plan(told)
        assert is_of_this_cycle(plan, told)
        assert plan.believed is not None
        relied_on = None if plan.safe_end is None else plan.safe_end.relies_on
        if plan.verdict.passed:
            assert verify(plan.trajectory, plan.believed, relies_on=relied_on).passed
        if plan.verdict.passed and all(doubt.kind is not DoubtKind.TOO_FAST for doubt in plan.doubts):  # that one moves as before
            assert verify(plan.trajectory, told, relies_on=relied_on).passed
        truth = later(truth, plan)


@pytest.mark.parametrize("family", ["sandwich", "moving", "queue", "quiet", "curved"])
def test_a_duplicate_of_a_track_changes_no_decision(family: str) -> None:
    """Not a bit of the plan; it is told, and that is all."""
    for number in range(0, 12, 2):
        first = episode(family, number).first
        for track in first.tracks[:2]:
            plans = []
            for tracks in (first.tracks, (*first.tracks, replace(track, id="~again"))):
                PLANNER.reset()
                plans.append(PLANNER.plan(replace(first, tracks=tracks)))
            one, two = plans
            assert one.trajectory.table.tobytes() == two.trajectory.table.tobytes()
            assert (one.status, one.chosen, one.escapes, one.candidates) == (two.status, two.chosen, two.escapes, two.candidates)
            assert any({track.id, "~again"} <= set(doubt.tracks) for doubt in two.doubts)


def test_swapped_ids_change_no_decision() -> None:
    """In the middle of a drive; the plans before and after are those of a drive in which ids stay."""
    drives = []
    for swapped in (False, True):
        PLANNER.reset()
        truth, chosen = traffic(front_m=30.0, closing_mps=6.0), []
        for k in range(6):
            told = planted(truth, "swap", 0, 0.0, 0.0, 0.0) if swapped and k >= 3 else truth
            plan = PLANNER.plan(told)
            chosen.append((plan.status, plan.mode, plan.side))
            truth = later(truth, plan)
        drives.append(chosen)
    assert drives[0] == drives[1]


def test_a_split_lorry_is_kept_clear_of_from_end_to_end() -> None:
    """Four reflections of 16 m: what passes is clear of all four."""
    situation = traffic()
    lorry = tuple(replace(car(f"part{k}", 30.0 + 4.0 * k, 12.0)) for k in range(4))
    told = replace(situation, tracks=(*lorry, *situation.tracks[1:]))
    PLANNER.reset()
    plan = PLANNER.plan(told)
    assert plan.status is Status.PLANNED
    assert [doubt.tracks for doubt in plan.doubts] == []  # touching within what their places are known to
    whole = replace(situation, tracks=(car("lorry", 36.0, 12.0, length=16.5), *situation.tracks[1:]))
    assert judge(plan.trajectory, told.host, PLANNER.vehicle, told.road, predict_for(whole)).passed


def test_a_host_state_that_cannot_be_is_answered_by_a_stop() -> None:
    """At first by the remainder of the last plan; when it lasts, by a judged stop in the lane, until the host is known again."""
    PLANNER.reset()
    alone, answers = traffic(front_m=60.0, closing_mps=0.0), []
    truth = replace(alone, tracks=tuple(track for track in alone.tracks if track.id != "rear"))  # who would not let it stop
    for k in range(12):
        broken = replace(truth, host=replace(truth.host, heading_rad=90.0, steering_rad=3.0)) if 2 <= k < 9 else truth
        plan = PLANNER.plan(broken)
        answers.append(plan.reason.partition(" instead of")[0])
        assert plan.verdict.passed
        if 2 <= k < 9:
            assert "the host's state cannot be" in plan.reason
        truth = later(truth, plan)
    assert answers[2:5] == ["the remainder of the previous plan"] * 3
    assert all(answer.startswith("brake ") and answer.endswith("in the lane") for answer in answers[5:9])
    assert plan.status is Status.PLANNED


@pytest.mark.parametrize("doubtful", [True, False])
def test_who_is_beyond_reach_changes_not_a_bit(doubtful: bool) -> None:
    """Two tracks in one place, or two sound ones, where no drive can come to: only the doubt is told of."""
    for number in range(0, 10, 2):
        first = episode("wide", number).first
        away = 4000.0 + first.host.s_m
        pair = (car("far1", away, 20.0, 3.7), car("far2", away + (0.5 if doubtful else 60.0), 20.0, 3.9))
        plans = []
        for tracks in (first.tracks, (*first.tracks, *pair)):
            PLANNER.reset()
            plans.append(PLANNER.plan(replace(first, tracks=tracks)))
        one, two = plans
        assert one.trajectory.table.tobytes() == two.trajectory.table.tobytes()
        assert (one.status, one.chosen, one.escapes, one.candidates) == (two.status, two.chosen, two.escapes, two.candidates)
        assert [doubt.tracks for doubt in two.doubts[len(one.doubts) :]] == ([("far1", "far2")] if doubtful else [])
