"""The escape map: closed forms, symmetry, and brute force."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest

import mcdas_opt
from benchmarks.escape_truth import Truth, situation_of
from mcdas_opt.domain.escapes import Closer, Escapes
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import ParameterError
from mcdas_opt.manoeuvres.clearance import Margins
from mcdas_opt.manoeuvres.family import Demand
from mcdas_opt.time_to_react.escapes import escapes_under
from mcdas_opt.time_to_react.library import KINDS, EscapeSettings
from mcdas_opt.time_to_react.predicted_traffic import LATTICE_S, PredictedTraffic
from mcdas_opt.tracking.prediction import predict
from tests.planning.situations import mirrored, random_sandwich

SEDAN = Vehicle()
LENGTH = SEDAN.length_m


def of(situation: Situation) -> Escapes:
    return escapes_under(predict(situation.tracks), situation, SEDAN)


def chased(closing_kmh: float, gap_m: float, speed: float = 20.0, **road: float) -> Situation:
    rear = Track(id="rear", s_m=-gap_m - LENGTH, d_m=0.0, speed_s_mps=speed + closing_kmh / 3.6)
    return Situation(host=HostState(speed_mps=speed), tracks=(rear,), road=Road(lanes_left=1, lanes_right=1, **road), coverage=Coverage())


@pytest.mark.parametrize(("closing_kmh", "needed_m"), [(20.0, 5.1), (40.0, 20.6), (60.0, 46.3)])
def test_accelerating_away_needs_what_the_closed_form_says(closing_kmh: float, needed_m: float) -> None:
    """v_rel^2 / (2 a): 5.1, 20.6, 46 m at 3 m/s^2; a little more for the jerk and the grid of starts."""
    closing = closing_kmh / 3.6
    answer = of(chased(closing_kmh, needed_m + 2.5 * closing)).accelerate
    assert answer.open
    assert answer.last_moment_s is not None
    left = needed_m + (2.5 - answer.last_moment_s) * closing
    assert 0.99 * needed_m <= left <= 1.08 * needed_m + 0.25 * closing
    assert answer.closed_by is Closer.REAR


@pytest.mark.parametrize(("closing_kmh", "needed_m"), [(20.0, 4.7), (40.0, 9.4), (60.0, 14.0)])
def test_steering_out_needs_what_the_closed_form_says(closing_kmh: float, needed_m: float) -> None:
    """2.1 m sideways at 0.6 g: 0.84 s. No car gets there sooner; the family gets there not much later."""
    closing = closing_kmh / 3.6
    for side in ("left", "right"):
        answer = getattr(of(chased(closing_kmh, needed_m + 2.0 * closing, friction=0.6)), side)
        assert answer.open
        # accelerating meanwhile (the circle's other half) may win a little: at 20 km/h up to an eighth of what is needed
        left = needed_m + (2.0 - answer.last_moment_s) * closing
        assert 0.85 * needed_m <= left <= needed_m + 0.4 * closing


@pytest.mark.parametrize("speed", [10.0, 20.0, 30.0])
@pytest.mark.parametrize("friction", [0.9, 0.4])
def test_braking_for_a_wall_needs_the_stopping_distance(speed: float, friction: float) -> None:
    most = min(8.0, friction * 9.80665)
    stop = speed**2 / (2.0 * most)
    wall = Track(id="wall", s_m=stop + 2.0 * speed + LENGTH, d_m=0.0, speed_s_mps=0.0)
    answer = of(Situation(host=HostState(speed_mps=speed), tracks=(wall,), road=Road(friction=friction), coverage=Coverage())).brake
    assert answer.last_moment_s is not None
    left = stop + (2.0 - answer.last_moment_s) * speed
    assert stop <= left <= 1.06 * stop + 0.4 * speed
    assert answer.closed_by is Closer.FRONT


def test_nobody_around_closes_nothing_but_where_there_is_no_road() -> None:
    answer = of(Situation(host=HostState(speed_mps=20.0), road=Road(lanes_left=1), coverage=Coverage()))
    for kind in ("brake", "accelerate", "left"):
        candidate = getattr(answer, kind)
        assert (candidate.open, candidate.last_moment_s, candidate.closed_by) == (True, 10.0, None)
        assert candidate.demand_mps2 is not None
        assert 0.0 < candidate.demand_mps2 < 3.0
    assert (answer.right.open, answer.right.last_moment_s, answer.right.closed_by) == (False, None, Closer.EDGE)


def beside(first_m: float, last_m: float, speed: float) -> tuple[Track, ...]:
    """Cars bumper to bumper in the lane to the left."""
    return tuple(Track(id=f"beside {s}", s_m=float(s), d_m=3.7, speed_s_mps=speed) for s in range(int(first_m), int(last_m) + 1, 6))


def test_a_row_of_cars_beside_closes_its_side() -> None:
    answer = of(
        Situation(host=HostState(speed_mps=20.0), tracks=beside(-48, 18, 20.0), road=Road(lanes_left=1, lanes_right=1), coverage=Coverage())
    )
    assert not answer.left.open
    assert answer.left.closed_by is Closer.SIDE
    assert answer.right.open


def test_past_a_single_car_beside_a_lane_change_with_another_speed_is_open() -> None:
    answer = of(Situation(host=HostState(speed_mps=20.0), tracks=beside(0, 0, 20.0), road=Road(lanes_left=1), coverage=Coverage())).left
    assert answer.open
    assert answer.demand_mps2 is not None
    assert answer.demand_mps2 > 2.0


def test_a_side_that_nobody_watches_is_closed() -> None:
    situation = Situation(host=HostState(speed_mps=20.0), road=Road(lanes_left=1, lanes_right=1), coverage=Coverage(left=False))
    assert of(situation).left.closed_by is Closer.SIDE
    assert of(situation).right.open


def test_a_start_that_waits_may_open_what_is_closed_now() -> None:
    """Faster cars beside now are ahead and gone later: closed now, so without a demand, but still open."""
    left = of(Situation(host=HostState(speed_mps=20.0), tracks=beside(-60, 18, 28.0), road=Road(lanes_left=1), coverage=Coverage())).left
    assert left.open
    assert left.demand_mps2 is None
    assert left.last_moment_s == 10.0


@pytest.mark.parametrize("seed", range(6))
def test_the_mirrored_situation_has_the_mirrored_map(seed: int) -> None:
    situation = random_sandwich(seed)
    here, there = of(situation), of(mirrored(situation))
    for kind, other in (("brake", "brake"), ("accelerate", "accelerate"), ("left", "right"), ("right", "left")):
        one, two = getattr(here, kind), getattr(there, other)
        assert (one.open, one.last_moment_s, one.closed_by) == (two.open, two.last_moment_s, two.closed_by)


@pytest.mark.parametrize("index", [1, 7, 12, 18])
def test_a_last_moment_is_never_late_and_hardly_early(index: int) -> None:
    """The truth is the last start for which a library some ten times finer, driven and judged, holds a sound drive."""
    situation = situation_of(11, index)
    answer, truth = of(situation), Truth(situation, SEDAN)
    for kind in KINDS:
        candidate = getattr(answer, kind)
        assert candidate.open == (candidate.last_moment_s is not None)
        last = truth.last(kind)
        if last is None:
            assert not candidate.open
        else:
            assert (candidate.last_moment_s or 0.0) <= last + 1e-9
            assert last - (candidate.last_moment_s or 0.0) <= 0.2


@pytest.mark.parametrize(
    ("seed", "indices"), [(2077, (279, 567, 738)), (7601, (261, 1182, 1547, 1568, 1712, 2260, 2585, 2629)), (7603, range(200))]
)
def test_whatever_is_comfortable_is_an_escape(seed: int, indices: Iterable[int]) -> None:
    """No last comfortable moment is later than the last of any demand: of the first eleven, gentle starts were once the only late ones."""
    for index in indices:
        for candidate in of(situation_of(seed, index)).candidates:
            easy, last = candidate.last_comfortable_s, candidate.last_moment_s or 0.0
            assert easy is None or (candidate.open and easy <= last)


@pytest.mark.parametrize("sideways", [0.0, 0.4, -1.5])
def test_a_body_at_an_angle_counts_as_a_box_that_holds_it_and_straightens_up_with_it(sideways: float) -> None:
    body = predict((Track(id="a", s_m=20.0, d_m=0.0, speed_s_mps=10.0, speed_d_mps=sideways),)).bodies[0]
    traffic = PredictedTraffic.of([body], 4.0, Margins())
    turned = np.abs(body.at(LATTICE_S * np.arange(traffic.s_m.shape[1])).heading_rad)
    holds_long = 0.5 * (body.length_m * np.cos(turned) + body.width_m * np.sin(turned))
    holds_wide = 0.5 * (body.width_m * np.cos(turned) + body.length_m * np.sin(turned))
    assert np.all(traffic.half_length_m[0] >= holds_long - 1e-12)
    assert np.all(traffic.half_width_m[0] >= holds_wide - 1e-12)
    assert traffic.half_width_m[0, -1] <= 0.5 * body.width_m + 0.025 * abs(sideways)


def test_less_grip_closes_sooner() -> None:
    before = 11.0
    for friction in (0.9, 0.6, 0.3):
        moment = of(chased(40.0, 45.0, friction=friction)).left.last_moment_s
        assert moment is not None
        assert moment < before
        before = moment


def test_the_public_name_predicts_by_itself() -> None:
    situation = chased(40.0, 45.0)
    assert mcdas_opt.escapes(situation) == of(situation)


def test_the_map_is_a_document() -> None:
    document = of(replace(chased(20.0, 20.0), time_s=3.0)).to_dict()
    assert set(document) == set(KINDS)
    assert set(document["left"]) == {"open", "last_moment_s", "closed_by", "demand_mps2", "last_comfortable_s"}


@pytest.mark.parametrize(
    ("record", "name", "value"),
    [
        *((EscapeSettings, "comfort_mps2", value) for value in (0.0, -1.0, float("nan"))),
        *((EscapeSettings, "comfort_share", value) for value in (0.0, 1.5)),
        (EscapeSettings, "clear_m", float("inf")),
        *((Margins, name, -0.1) for name in ("along_m", "across_m", "share_of_prediction")),
        *((Demand, name, value) for name in ("friction", "steering") for value in (0.0, float("nan"))),
    ],
)
def test_settings_cannot_be_born_wrong(record: type, name: str, value: float) -> None:
    with pytest.raises(ParameterError, match=name):
        record(**{name: value})


@pytest.mark.parametrize(
    ("radius_m", "speed_mps", "ahead_m"), [(12.0, 12.0, 20.0), (12.0, 16.0, 35.0), (30.0, 22.0, 35.0), (80.0, 30.0, 60.0)]
)
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_who_comes_too_fast_to_a_bend_can_brake_until_about_the_last_moment(
    radius_m: float, speed_mps: float, ahead_m: float, side: float
) -> None:
    """It was closed by friction as soon as a car that keeps its speed could not hold the bend."""
    ramp_m, grip = 8.0, Road().grip_mps2
    curvature = ((0.0, 0.0), (ahead_m, 0.0), (ahead_m + ramp_m, side / radius_m), (ahead_m + 80.0, side / radius_m))
    road = Road(curvature=curvature, shoulder_left_m=1.0, shoulder_right_m=1.0)
    found = of(Situation(host=HostState(speed_mps=speed_mps), road=road, coverage=Coverage())).brake
    assert found.open
    assert found.last_moment_s is not None
    slowing_m = (speed_mps**2 - grip * radius_m) / (2.0 * -SEDAN.acceleration_min_mps2)  # to what the tyres hold in the bend
    latest_s = (ahead_m + ramp_m - slowing_m) / speed_mps
    assert latest_s - 1.5 < found.last_moment_s < latest_s
