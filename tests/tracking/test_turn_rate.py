"""How fast others turn: told from noise, carried in the track, and used where somebody may go straight on at a turn."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.domain.document import to_document
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.lane import Lane
from mcdas_opt.domain.measurement import BodyDetection, Scan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.domain.variant import Variant
from mcdas_opt.domain.vocabulary import BodyKind, Sector, Status
from mcdas_opt.errors import ParameterError
from mcdas_opt.planning.stateless import plan
from mcdas_opt.tracking.prediction import RATE_SIGMAS, TURNS_IN_S, predict, turns_with
from mcdas_opt.tracking.tracker import Tracker
from mcdas_opt.tracking.turn_rate import TurnRateFilter

STRAIGHT = Road(lanes_left=1, lanes_right=1)
CORNER = Road(lanes_left=1, curvature=((0.0, 0.0), (20.0, 0.0), (25.0, 0.12), (38.0, 0.12), (43.0, 0.0)))
TIMES = np.linspace(0.0, 4.0, 81)


def turning(heading: float, speed: float, rate: float, **more: object) -> Track:
    """One whose turn rate is known to 0.08 rad/s."""
    moving = {"speed_s_mps": speed * math.cos(heading), "speed_d_mps": speed * math.sin(heading), "heading_rad": heading}
    one = Track(id="1", s_m=30.0, d_m=6.0, speed_s_mps=0.0, turn_rate_radps=rate, turn_rate_sd_radps=0.08)
    return replace(one, **moving | more)


@given(st.floats(-1.5, 1.5), st.floats(-math.pi, math.pi))
def test_a_steady_turn_is_known_within_a_second(rate: float, heading: float) -> None:
    turn = TurnRateFilter()
    assert turn.at(0.0) == (0.0, None)
    for k in range(21):
        turn.take(0.05 * k, math.remainder(heading + rate * 0.05 * k, 2.0 * math.pi))
    found, sd = turn.at(1.0)
    assert found == pytest.approx(rate, abs=0.02)
    assert sd is not None
    assert 0.0 < sd < 0.3


@pytest.mark.parametrize("noise_rad", [0.0, 0.01, 0.03, 0.1])
def test_noise_is_not_taken_for_turning(noise_rad: float) -> None:
    """Also where headings are ten times noisier than told: at most one in a hundred."""
    random, seen = np.random.default_rng(7), 0
    for _ in range(20):
        turn = TurnRateFilter()
        for k in range(100):
            turn.take(0.05 * k, noise_rad * float(random.standard_normal()))
            rate, sd = turn.at(0.05 * k)
            assert sd is not None
            seen += k > 20 and abs(rate) > RATE_SIGMAS * sd
    assert seen <= 0.01 * 20 * 80


def test_a_track_of_an_ideal_sensor_says_how_fast_it_turns_in_the_plane() -> None:
    """Along a bend at the road's own heading: speed times curvature."""
    bend, tracker = Road(curvature=((0.0, 0.05), (200.0, 0.05))), Tracker()
    host = HostState(speed_mps=8.0)
    for k in range(31):
        body = BodyDetection(
            name="a", s_m=20.0 + 0.4 * k, d_m=0.0, speed_s_mps=8.0, speed_d_mps=0.0, length_m=4.5, width_m=1.8, heading_rad=0.0
        )
        tracker.update([Scan(sensor="ideal", sector=Sector.FRONT, t_s=0.05 * k, bodies=(body,), period_s=0.05)], host, bend, 0.05 * k)
    (one,) = tracker.tracks(1.5)
    assert one.turn_rate_radps == pytest.approx(0.4, abs=0.02)
    assert one.turn_rate_sd_radps is not None


@given(st.floats(-math.pi, math.pi), st.floats(0.0, 15.0), st.floats(-0.19, 0.19), st.sampled_from([STRAIGHT, CORNER]))
def test_what_does_not_stand_out_changes_nothing(heading: float, speed: float, rate: float, road: Road) -> None:
    one, without = turning(heading, speed, rate), turning(heading, speed, 0.0, turn_rate_sd_radps=None)
    bodies, known = predict([one], road=road).bodies, predict([without], road=road).bodies
    assert [body.id for body in bodies] == [body.id for body in known]
    for body, same in zip(bodies, known, strict=True):
        assert to_document(body.at(TIMES)) == to_document(same.at(TIMES))


def names(one: Track, road: Road) -> list[str]:
    return [body.id for body in predict([one], road=road).bodies]


def test_who_turns_about_as_the_road_does_keeps_to_it_and_any_other_may_go_straight_on() -> None:
    """Towards us at 7 m/s through a bend of 8 m: he has to turn by 0.84 rad/s to his right."""
    oncoming = turning(math.pi, 7.0, 0.0, s_m=35.0, d_m=3.0)
    kept, both = ["1"], [Variant.STRAIGHT_ON.of("1"), "1"]
    asked = -7.0 * 0.12
    for share, expected in ((1.0, kept), (0.6, kept), (1.9, kept), (0.3, both), (2.5, both), (-1.0, both), (0.0, both)):
        assert names(replace(oncoming, turn_rate_radps=share * asked), CORNER) == expected
    assert names(replace(oncoming, turn_rate_radps=asked, turn_rate_sd_radps=None), CORNER) == both
    assert names(replace(oncoming, s_m=60.0, turn_rate_radps=asked), CORNER) == both  # before the bend


def test_who_ends_his_turn_into_our_road_keeps_to_it() -> None:
    """Out of the corner, where for the next half second the road asks less and less: he turns as it asks of him now."""
    oncoming = turning(math.pi, 8.0, -8.0 * 0.09, s_m=21.5, d_m=3.0)
    assert names(oncoming, CORNER) == ["1"]


@given(st.floats(0.01, 0.3), st.sampled_from([-1.0, 1.0]), st.floats(2.0, 15.0), st.floats(0.3, 1.5), st.booleans())
def test_who_turns_back_into_the_roads_direction_settles_as_he_turns(
    angle: float, side: float, speed: float, rate: float, oncoming: bool
) -> None:
    """No sooner than at the rate that is seen, and never later, nor elsewhere, than somebody of whom no turn rate is known."""
    back = turning(side * angle + math.pi * oncoming, speed, -side * rate)
    (body,) = (one for one in predict([back], road=STRAIGHT).bodies if one.id == "1")
    (same,) = (one for one in predict([replace(back, turn_rate_sd_radps=None)], road=STRAIGHT).bodies if one.id == "1")
    moved, usual = np.abs(body.at(TIMES).d_m - 6.0), np.abs(same.at(TIMES).d_m - 6.0)
    assert np.all(moved <= usual + 1e-9)
    assert moved[-1] >= min(0.5 * abs(back.speed_d_mps) * angle / rate, float(usual[-1])) - 1e-9
    away = replace(back, turn_rate_radps=-back.turn_rate_radps)
    (body,) = (one for one in predict([away], road=STRAIGHT).bodies if one.id == "1")
    assert to_document(body.at(TIMES)) == to_document(same.at(TIMES))


@given(st.floats(0.4, 2.7), st.floats(1.0, 15.0), st.floats(-3.0, 3.0), st.sampled_from([STRAIGHT, CORNER]))
def test_who_goes_across_the_road_goes_straight_on_unless_his_turn_clearly_ends_at_once(
    heading: float, speed: float, rate: float, road: Road
) -> None:
    one, on_foot = turning(heading, speed, rate), turning(heading, speed, rate, kind=BodyKind.PEDESTRIAN)
    bodies = [predict([each], road=road).bodies for each in (one, replace(one, turn_rate_radps=0.0), on_foot)]
    turns, straight, walks = (body.at(TIMES) for (body,) in bodies)
    to_go = heading if rate < 0.0 else math.pi - heading
    if abs(rate) > RATE_SIGMAS * 0.08 and to_go <= abs(rate) * TURNS_IN_S:
        assert to_document(turns) != to_document(straight)
        if road is STRAIGHT:
            assert np.ptp(turns.d_m[17:]) < 1e-6  # from 0.85 s on
    else:
        assert to_document(turns) == to_document(straight)
    assert to_document(walks) == to_document(straight)


def test_a_host_that_waits_needs_nothing_of_who_turns_into_the_lane_beside_it() -> None:
    """Out of a side street, as tightly as a corner asks, in front of a host that stands at the junction."""
    road = Road(lane_width_m=3.2, lanes_left=1, lanes=(Lane(lane=1, oncoming=True),))
    for left in (0.75, 0.6, 0.45, 0.36):  # of his turn
        one = turning(left - math.pi, 5.4, -1.2, s_m=5.0 + 4.5 * math.sin(left), d_m=3.2 + 4.5 * (1.0 - math.cos(left)))
        known, unknown = (
            plan(Situation(host=HostState(), coverage=Coverage(), road=road, desired_speed_mps=10.0, stop_line_s_m=3.5, tracks=(each,)))
            for each in (one, replace(one, turn_rate_sd_radps=None))
        )
        assert known.status is Status.PLANNED
        assert unknown.status is Status.UNAVOIDABLE


@given(st.floats(3.0, 12.0), st.floats(0.3, 2.5))
def test_the_mirrored_turn_counts_as_much(speed: float, share: float) -> None:
    mirrored = Road(lanes_left=1, lanes_right=1, curvature=tuple((s, -kappa) for s, kappa in CORNER.curvature))
    one = turning(math.pi, speed, -share * speed * 0.12, s_m=35.0, d_m=3.0)
    other = replace(one, d_m=-one.d_m, speed_d_mps=-one.speed_d_mps, turn_rate_radps=-one.turn_rate_radps)
    assert turns_with(one, CORNER) == turns_with(other, mirrored)


def test_a_turn_rate_is_a_number_of_a_car() -> None:
    for wrong in (math.nan, 1e9):
        with pytest.raises(ParameterError, match="turn_rate_radps"):
            Track(id="1", s_m=0.0, d_m=0.0, speed_s_mps=0.0, turn_rate_radps=wrong)
    with pytest.raises(ParameterError, match="turn_rate_sd_radps"):
        Track(id="1", s_m=0.0, d_m=0.0, speed_s_mps=0.0, turn_rate_sd_radps=-1.0)
