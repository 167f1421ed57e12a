"""Who keeps his distance behind the host is expected to brake behind it: ordinary braking stays ordinary with somebody behind."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan, Refusal
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import Settings, WarningSettings
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vocabulary import Status
from mcdas_opt.dynamics.car_following import IdmSettings, Leader, idm_acceleration
from mcdas_opt.evaluation.suites import expand
from mcdas_opt.planning.planner import Planner
from mcdas_opt.simulation.judging import verify
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.record import Outcome
from mcdas_opt.situation.attentive_followers import attentive_followers
from mcdas_opt.tracking.follower_prediction import with_attentive_followers
from mcdas_opt.tracking.prediction import predict

CYCLE_S = 0.1
CAR = load_vehicle("sedan")
KNOWN = np.diag([0.04, 0.04, 0.04, 0.01])
SETTINGS = Settings(warning=WarningSettings(escapes=False))


def follower(gap_m: float, speed_mps: float, braking_mps2: float = 0.0) -> Track:
    rate = {"acceleration_s_mps2": -braking_mps2, "acceleration_s_sd_mps2": 0.2}
    return Track(
        id="behind", d_m=0.0, s_m=-gap_m - 0.5 * (4.5 + CAR.length_m), speed_s_mps=speed_mps, covariance=KNOWN, length_m=4.5, **rate
    )


def attends(gap_m: float, closing_mps: float, *, host_mps: float = 20.0, before: bool = False, braking_mps2: float = 0.0) -> bool:
    tracks = (follower(gap_m, host_mps + closing_mps, braking_mps2),)
    situation = Situation(host=HostState(speed_mps=host_mps), tracks=tracks, road=Road(), coverage=Coverage())
    return bool(attentive_followers(situation, CAR, SETTINGS, frozenset({"behind"}) if before else frozenset()))


@given(
    gap_m=st.floats(1.0, 80.0), closing_mps=st.floats(-5.0, 15.0), host_mps=st.floats(0.0, 30.0), seen_mps2=st.sampled_from([0.0, 2.5, 5.0])
)
def test_who_is_attentive_stays_behind_a_host_that_drives_on(gap_m: float, closing_mps: float, host_mps: float, seen_mps2: float) -> None:
    """Predicted so, he brakes by no more than what may be asked of him, or what he is seen to brake with, and from now on."""
    assume(host_mps + closing_mps >= 0.0)
    assume(max(closing_mps, 0.0) ** 2 <= 2.0 * max(4.0, seen_mps2) * (gap_m - 0.5))
    track = follower(gap_m, host_mps + closing_mps, seen_mps2)
    situation = Situation(host=HostState(speed_mps=host_mps), tracks=(track,), road=Road(), coverage=Coverage())
    told = with_attentive_followers(predict(situation.tracks), situation, frozenset({"behind"}), SETTINGS.safe_end)
    (body,) = (one for one in told.bodies if one.id == "behind")
    t = np.linspace(0.0, 20.0, 2001)
    motion = body.at(t)
    nearest = (host_mps * t - motion.s_m - 0.5 * (4.5 + CAR.length_m)).min()
    assert nearest >= min(gap_m, 0.5) - 0.26  # a length of the host's that the prediction is not told
    assert np.diff(motion.speed_s_mps).min() >= -0.01 * max(4.0, seen_mps2) - 1e-9
    assert motion.speed_s_mps.min() >= -1e-9


@given(gap_m=st.floats(0.1, 80.0), closing_mps=st.floats(-5.0, 15.0))
def test_who_is_attentive(gap_m: float, closing_mps: float) -> None:
    """At first who keeps his distance, less of it if he hardly closes in; then who needs no harder braking than may be asked of him, and
    brakes where he would be there soon, or needs more than 3 m/s^2."""
    keeps_it = gap_m >= 2.0 + (0.65 if closing_mps <= 1.0 else 1.0) * 1.2 * (20.0 + closing_mps)
    assert attends(gap_m, closing_mps) == (keeps_it and closing_mps <= 3.0)
    stays_behind = max(closing_mps, 0.0) ** 2 <= 2.0 * 4.0 * gap_m
    is_late = closing_mps > 1.0 and gap_m <= min(max(closing_mps / 6.0, 2.0), 3.0) * closing_mps
    assert attends(gap_m, closing_mps, before=True) == (stays_behind and not is_late)
    assert attends(gap_m, closing_mps, before=True, braking_mps2=0.1) == stays_behind
    assert attends(gap_m, closing_mps, before=True, braking_mps2=8.0) == (max(closing_mps, 0.0) ** 2 <= 2.0 * 8.0 * gap_m)


def drive(
    speed_mps: float, gap_m: float, behind_m: float, braking_mps2: float, planner: Planner | None = None
) -> tuple[list[float], list[Status], float, float]:
    """One lane, 12 s: the leader brakes to a stop after 1 s; who follows does as the IDM. What the host brakes by,
    the plans' statuses, and the least gaps ahead and behind."""
    planner, host, t = planner or Planner(settings=SETTINGS), HostState(speed_mps=speed_mps), 0.0
    lengths = 0.5 * (4.5 + CAR.length_m)
    front, front_mps, rear, rear_mps = gap_m + lengths, speed_mps, -behind_m - lengths, speed_mps
    idm = IdmSettings(headway_s=1.2, acceleration_mps2=1.5, deceleration_mps2=2.0)
    braking, statuses, ahead, behind = [], [], gap_m, behind_m
    rear_a = 0.0
    for _ in range(120):
        front_a = -braking_mps2 if t >= 1.0 and front_mps > 0.0 else 0.0
        rates = {"acceleration_s_sd_mps2": 0.2, "covariance": KNOWN, "length_m": 4.5}
        tracks = (
            Track(id="front", d_m=0.0, s_m=front, speed_s_mps=front_mps, acceleration_s_mps2=front_a, **rates),
            Track(id="behind", d_m=0.0, s_m=rear, speed_s_mps=rear_mps, acceleration_s_mps2=rear_a, **rates),
        )
        situation = Situation(time_s=round(t, 9), host=host, tracks=tracks, road=Road(), desired_speed_mps=speed_mps, coverage=Coverage())
        plan = planner.plan(situation)
        if plan.status is not Status.UNAVOIDABLE:  # who is relied on within the horizon, too, is named
            assert plan.safe_end is not None
            assert verify(plan.trajectory, situation, vehicle=CAR, relies_on=plan.safe_end.relies_on).passed
            assert any(part.startswith(" behind keeps") for part in plan.reason.split(";")) >= (plan.safe_end.relies_on is not None)
        host, t = HostState.from_vector(plan.trajectory.states[1]), t + CYCLE_S
        leader = Leader(gap_m=max(host.s_m - rear - lengths, 0.1), speed_mps=host.speed_mps)
        rear_a = idm_acceleration(rear_mps, speed_mps, leader, idm)
        front, front_mps = front + front_mps * CYCLE_S, max(front_mps + front_a * CYCLE_S, 0.0)
        rear, rear_mps = rear + rear_mps * CYCLE_S, max(rear_mps + rear_a * CYCLE_S, 0.0)
        braking.append(-host.acceleration_mps2)
        statuses.append(plan.status)
        ahead, behind = min(ahead, front - host.s_m - lengths), min(behind, host.s_m - rear - lengths)
    return braking, statuses, ahead, behind


@pytest.mark.parametrize(
    ("speed_mps", "gap_m", "behind_m", "braking_mps2"), [(10.0, 16.0, 16.0, 2.5), (8.0, 13.0, 14.0, 2.0), (20.0, 28.0, 26.0, 2.5)]
)
def test_stop_and_go_with_somebody_behind_is_driven_as_without(
    speed_mps: float, gap_m: float, behind_m: float, braking_mps2: float
) -> None:
    braking, statuses, ahead, behind = drive(speed_mps, gap_m, behind_m, braking_mps2)
    assert set(statuses) == {Status.PLANNED}
    assert max(braking) <= braking_mps2 + 1.5
    assert min(ahead, behind) > 1.0


class PlansNothing:
    """A method that leaves every answer to the fallback."""

    name = "nothing"

    def plan(self, situation: Situation, previous: Plan | None) -> Refusal:
        return Refusal(reason="none", candidates=(), iterations=0)


def test_a_fallback_names_the_follower_that_it_relies_on() -> None:
    _, statuses, _, _ = drive(10.0, 16.0, 16.0, 2.5, Planner(method=PlansNothing(), settings=SETTINGS))
    assert statuses.count(Status.FALLBACK) > 30


@pytest.mark.parametrize("behind_m", [30.0, 36.0, 55.0])
def test_a_host_stops_behind_who_brakes_hard_though_somebody_follows(behind_m: float) -> None:
    braking, _, ahead, behind = drive(25.0, 36.0, behind_m, 7.5)
    assert max(braking) > 7.0
    assert ahead > 1.0
    assert behind > 0.5


@pytest.mark.parametrize("index", [3, 21, 32, 37, 60, 120])
def test_nobody_is_hit_for_fear_of_somebody_behind(index: int) -> None:
    """Drives of the suite that hit a leader who braked gently, or stood, to be spared by a follower who would have braked."""
    case = expand("followed", None, 3101).cases[index]
    drive = simulate(case.scene, Planner(settings=SETTINGS))
    assert drive.outcome is Outcome.SAFE
    assert drive.fallbacks <= 0.05 * len(drive.cycles)
