"""Safe ends against what they say: two cars driven through, the front braking fully, the follower not at all."""

from __future__ import annotations

import math
from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import BodyMotion, CruisingBody, FreeBody, Prediction
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.safe_end import EndKind, SafeEndSettings
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2
from mcdas_opt.errors import ParameterError
from mcdas_opt.manoeuvres.safe_end import LastEnd, demand_on_follower, distance_to_hold, ends, last_end
from mcdas_opt.native.form import SWITCH

SEDAN = load_vehicle("sedan")
SPEEDS = st.floats(0.5, 40.0)


def travelled(t: Array, speed: float, braking: float, after: float) -> Array:
    """How far a car gets that brakes evenly to rest, begun `after`."""
    braked = np.clip(t - after, 0.0, speed / braking)
    return speed * np.minimum(t, after) + speed * braked - 0.5 * braking * braked**2


@given(host=SPEEDS, front=SPEEDS, friction=st.floats(0.2, 1.0))
def test_distance_to_hold_is_the_least_that_survives_a_front_car_that_brakes_fully(host: float, front: float, friction: float) -> None:
    cfg, road = SafeEndSettings(), Road(friction=friction)
    grip = friction * GRAVITY_MPS2
    t = np.linspace(0.0, 60.0, 6001)
    ahead = travelled(t, front, min(cfg.front_braking_mps2, grip), 0.0)
    own = travelled(t, host, cfg.braking_share * min(8.0, grip), cfg.response_s)
    needed = float(distance_to_hold(host, front, SEDAN, road, cfg))
    assert float((needed + ahead - own).min()) > -1e-6
    if needed > 0.0:
        assert float((needed - 0.01 + ahead - own).min()) < 0.0


@given(host=SPEEDS, front=SPEEDS, friction=st.floats(0.2, 1.0), share=st.floats(-1.0, 0.5))
def test_distance_to_hold_survives_every_constant_acceleration_of_the_front_car(
    host: float, front: float, friction: float, share: float
) -> None:
    """Hypotheses of the safe end: constant velocity (share 0), constant acceleration (any), and full braking (share -1)."""
    cfg, road = SafeEndSettings(), Road(friction=friction)
    grip = friction * GRAVITY_MPS2
    t = np.linspace(0.0, 60.0, 6001)
    a = share * min(cfg.front_braking_mps2, grip)
    ahead = travelled(t, front, -a, 0.0) if a < -1e-3 else front * t + 0.5 * max(a, 0.0) * t**2
    own = travelled(t, host, cfg.braking_share * min(8.0, grip), cfg.response_s)
    assert float((float(distance_to_hold(host, front, SEDAN, road, cfg)) + ahead - own).min()) > -1e-6


@given(gap=st.floats(0.5, 80.0), closing=st.floats(0.1, 15.0))
def test_follower_that_brakes_as_demanded_just_stops_short(gap: float, closing: float) -> None:
    demand = float(demand_on_follower(gap, closing, 1.0))
    if not math.isfinite(demand):
        assert gap <= closing + 1e-9
        return
    t = np.linspace(0.0, 1.0 + 1.5 * closing / demand, 4001)
    left = gap - travelled(t, closing, demand, 1.0)
    assert abs(float(left.min())) < 1e-3 + 1e-3 * gap


def cruising(name: str, s: float, v: float, d: float = 0.0) -> CruisingBody:
    return CruisingBody(id=name, length_m=4.5, width_m=1.8, s_m=s, d_m=d, speed_s_mps=v, speed_d_mps=0.0, covariance=np.zeros((4, 4)))


def steady(v: float, seconds: float = 4.0) -> Trajectory:
    t = np.round(np.arange(round(seconds / 0.1) + 1) * 0.1, 9)
    zero = np.zeros_like(t)
    return Trajectory.from_states(t, np.column_stack([v * t, zero, zero, np.full_like(t, v), zero, zero]), np.zeros((t.size, 2)))


def end_of(drive: Trajectory, *bodies: CruisingBody, road: Road | None = None) -> tuple[EndKind, float | None, float | None]:
    start = HostState.from_vector(drive.states[0])
    end = last_end(drive, start, SEDAN, road or Road(), Prediction(name="test", bodies=bodies)).end
    return end.kind, end.front_margin_m, end.follower_demand_mps2


def test_kinds_of_ends() -> None:
    assert end_of(steady(20.0)) == (EndKind.CLEAR, None, None)
    assert end_of(steady(20.0), cruising("beside", 0.0, 20.0, d=3.7)) == (EndKind.CLEAR, None, None)
    kind, margin, demand = end_of(steady(20.0), cruising("front", 40.0, 20.0), cruising("rear", -40.0, 20.0))
    assert kind is EndKind.HELD
    assert margin == pytest.approx(35.5 - float(distance_to_hold(20.0, 20.0, SEDAN, Road())))
    assert demand == 0.0
    assert end_of(steady(0.0), cruising("front", 5.0, 0.0))[0] is EndKind.STOPPED
    # closing at 5 m/s on a car that was far at first: too near at the end
    assert end_of(steady(20.0), cruising("front", 28.0, 15.0))[0] is EndKind.OPEN
    assert end_of(steady(20.0), cruising("rear", -40.0, 28.0))[0] is EndKind.OPEN


@given(
    speed=st.floats(0.0, 30.0),
    others=st.lists(st.tuples(st.floats(-60.0, 160.0), st.floats(-3.0, 35.0), st.floats(-4.0, 4.0)), max_size=4),
    road=st.sampled_from([Road(), Road(road_end_s_m=60.0), Road(road_end_s_m=150.0), Road(curvature=((0.0, 0.0), (80.0, 0.01)))]),
    crosses=st.booleans(),
    owed=st.sampled_from([None, {}, {"0": -3.0, "2": 0.0}]),
)
def test_both_forms_weigh_every_end_to_the_bit_and_the_last_alone_as_among_all(
    speed: float, others: list[tuple[float, float, float]], road: Road, crosses: bool, owed: dict[str, float] | None
) -> None:
    drive, start = steady(speed), HostState(s_m=-1.0, speed_mps=speed)
    bodies: list[CruisingBody | FreeBody] = [cruising(str(k), s, v, d) for k, (s, v, d) in enumerate(others)]
    if crosses:
        bodies.append(FreeBody(id="crossing", length_m=4.5, width_m=1.8, motion=_crossing, heading_rad=1.2, covariance=np.zeros((4, 4))))

    def weighed() -> tuple[list[bytes], LastEnd]:
        asked = start, SEDAN, road, Prediction(name="test", bodies=tuple(bodies)), None, owed
        found, last = ends(drive, 3, *asked), last_end(drive, *asked)
        assert (last.end, last.front_fails) == (found.at(-1, 4.0), bool(found.front_fails[-1])) or crosses  # turned otherwise by then
        return [np.asarray(getattr(found, field.name)).tobytes() for field in fields(found)], last

    compiled = weighed()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(SWITCH, "0")
        assert weighed() == compiled


def _crossing(t: Array) -> BodyMotion:
    turning = 1.2 - 0.2 * t
    return BodyMotion(s_m=30.0 + 2.0 * t, d_m=-8.0 + 4.0 * t, heading_rad=turning, speed_s_mps=2.0 + 0.0 * t, speed_d_mps=4.0 + 0.0 * t)


@pytest.mark.parametrize("gap_m", [1.0, 2.0, 4.0])
def test_who_was_closer_before_is_no_worse_off(gap_m: float) -> None:
    assert end_of(steady(30.0), cruising("front", 4.5 + gap_m, 30.0))[0] is EndKind.HELD
    assert end_of(steady(30.0), cruising("front", 4.5 + gap_m, 29.9))[0] is EndKind.OPEN


def test_end_of_the_road_is_a_car_that_stands() -> None:
    stopping = 20.0 * 0.2 + 20.0**2 / (2 * 0.97 * 8.0)
    last = 80.0 + 0.5 * SEDAN.length_m
    assert end_of(steady(20.0), road=Road(road_end_s_m=last + stopping + 0.1))[0] is EndKind.HELD
    assert end_of(steady(20.0), road=Road(road_end_s_m=last + stopping - 0.1))[0] is EndKind.OPEN


def test_settings_name_what_is_wrong() -> None:
    with pytest.raises(ParameterError, match="response_s"):
        SafeEndSettings(response_s=0.0)
    with pytest.raises(ParameterError, match="braking_share"):
        SafeEndSettings(braking_share=1.5)
