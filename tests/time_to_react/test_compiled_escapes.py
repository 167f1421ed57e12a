"""The escape map in C against what numpy says."""

from __future__ import annotations

import ctypes
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.escape_case import CompiledCase
from benchmarks.escape_truth import situation_of
from mcdas_opt.domain.lane import Lane
from mcdas_opt.domain.prediction import CruisingBody, KnownBody, PredictedBody, Prediction
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.manoeuvres.clearance import Margins
from mcdas_opt.native import library as native
from mcdas_opt.native.form import SWITCH
from mcdas_opt.time_to_react.compiled_map import answered
from mcdas_opt.time_to_react.escapes import escapes_under
from mcdas_opt.time_to_react.guess import Case
from mcdas_opt.time_to_react.library import KINDS, EscapeSettings
from mcdas_opt.time_to_react.predicted_traffic import LATTICE_S, PredictedTraffic
from mcdas_opt.time_to_react.search import Found, found
from mcdas_opt.tracking.prediction import predict

pytestmark = pytest.mark.filterwarnings("ignore::mcdas_opt.native.form.InterpretedFormWarning")

CAR = Vehicle()
CLOSE = 1e-9


@pytest.fixture(scope="module")
def library() -> ctypes.CDLL:
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv(SWITCH, raising=False)
        built = native.library()
    if built is None:
        pytest.skip("there is no native library")
    return built


def varied(index: int) -> Situation:
    """Situations of every kind: also roads that end, bends that change, hosts that brake to rest and that are at top speed."""
    situation = situation_of(31, index)
    road, host = situation.road, situation.host
    if index % 4 == 1:
        road = replace(road, curvature=((-20.0, 0.0), (15.0, 0.003), (60.0, 0.001), (120.0, -0.002)))
    if index % 5 == 2:
        road = Road(lanes_left=1, lanes_right=1, friction=road.friction, road_end_s_m=90.0)
    if index % 6 == 3:
        narrow = Lane(lane=0, width_m=((30.0, 3.7), (90.0, 0.0)), merges=Side.LEFT if index % 12 == 3 else Side.NONE)
        road = replace(road, lanes_left=1, lanes_right=1, lanes=(narrow, Lane(lane=1, closed_m=((60.0, 90.0),))))
    if index % 3 == 0:
        host = replace(host, speed_mps=(1.5, CAR.speed_max_mps)[index % 2], acceleration_mps2=(-1.0, 1.0)[index % 2])
    return replace(situation, road=road, host=host)


def with_changing(bodies: tuple[PredictedBody, ...], index: int) -> tuple[PredictedBody, ...]:
    """Besides them those that brake to a standstill, that accelerate for a while, that change lanes or settle otherwise, that respond; or
    none."""
    more: tuple[dict[str, float], ...] = ()
    if index % 2:
        more = {"acceleration_mps2": -4.0}, {"acceleration_mps2": 2.0, "changing_s": 1.5}
    if index % 3:
        more += {"speed_d_mps": 0.8, "lateral_swell": 6.0, "lateral_fade_s": 0.7}, {"lateral_fade_s": 1.7}
    if index % 4:
        more += {"response_s": 0.3, "braking_mps2": 4.0}, {"acceleration_mps2": 1.0, "changing_s": 1.5, "response_s": 1.0}
    own = tuple(body for body in bodies if isinstance(body, CruisingBody))
    stops = {body.id: max(body.speed_s_mps, 0.0) / 4.0 for body in own}
    return bodies + tuple(replace(body, **{"changing_s": stops[body.id], **change}) for change in more for body in own)


def asked(index: int) -> tuple[Situation, Vehicle, Prediction, EscapeSettings]:
    situation = varied(index)
    prediction = predict(situation.tracks)
    if index % 7 > 3:
        prediction = Prediction(name=prediction.name, bodies=with_changing(prediction.bodies, index))
    return situation, CAR, prediction, EscapeSettings()


@settings(max_examples=25, deadline=None)
@given(index=st.integers(0, 10_000))
def test_members_are_sound_as_numpy_says(index: int, library: ctypes.CDLL) -> None:
    plain, fast = Case(*asked(index)), CompiledCase(library, *asked(index))
    random = np.random.default_rng(index)
    members = random.integers(0, plain.members.kind.size, 40)
    starts = random.integers(0, int(plain.end_of_constant_input()[0] / LATTICE_S) + 1, 40)
    (good, demand), (sound, in_c) = plain.sound(members, starts), fast.sound(members, starts)
    assert np.array_equal(good, sound)
    assert np.all(np.abs(demand - in_c) <= CLOSE * (1.0 + demand))


@settings(max_examples=25, deadline=None)
@given(index=st.integers(0, 10_000))
def test_the_predicted_traffic_is_what_is_made_of_each_body_alone(index: int) -> None:
    bodies = with_changing(predict(varied(index).tracks).bodies, index)
    grown = Margins(along_m=0.3, across_m=0.1)
    together = PredictedTraffic.of(bodies, 14.0, grown)
    alone = [PredictedTraffic.of([KnownBody(id=b.id, length_m=b.length_m, width_m=b.width_m, motion=b.at)], 14.0, grown) for b in bodies]
    for field in fields(PredictedTraffic):
        for row, single in zip(getattr(together, field.name), alone, strict=True):
            assert np.abs(row - getattr(single, field.name)[0]).max() <= CLOSE


@settings(max_examples=10, deadline=None)
@given(index=st.integers(0, 10_000))
def test_the_map_asks_no_less_than_who_asks_everything(index: int, library: ctypes.CDLL) -> None:
    """In C members are driven where the search comes by; in numpy all of them, from every anchor."""
    plain, fast = found(Case(*asked(index))), answered(library, *asked(index))
    assert (plain.end_s, plain.ender, plain.start, plain.closer) == (fast.end_s, fast.ender, fast.start, fast.closer)
    for one, other in zip(plain.now, fast.now, strict=True):
        assert one == pytest.approx(other, abs=CLOSE)


@pytest.mark.parametrize(
    ("seed", "index", "point_m"),
    [*((32, index, 0.0) for index in range(8)), *((32, index, 3.5) for index in range(4)), (2077, 279, 0.0), (2077, 738, 0.0)],
)
def test_the_map_is_the_same_without_a_compiler(
    seed: int, index: int, point_m: float, library: ctypes.CDLL, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also of a dynamic vehicle whose zero-sideslip point lies ahead of its middle."""
    situation, car = situation_of(seed, index), replace(CAR, zero_sideslip_point_m=point_m)
    fast = escapes_under(predict(situation.tracks), situation, car)
    monkeypatch.setenv(SWITCH, "0")
    assert native.library() is None
    plain = escapes_under(predict(situation.tracks), situation, car)
    for kind in KINDS:
        one, other = getattr(plain, kind), getattr(fast, kind)
        assert replace(one, demand_mps2=None) == replace(other, demand_mps2=None)
        assert one.demand_mps2 == pytest.approx(other.demand_mps2, abs=CLOSE)


@settings(max_examples=10, deadline=None)
@given(index=st.integers(0, 10_000))
def test_bodies_of_any_kind_and_any_margins_are_answered(index: int, library: ctypes.CDLL) -> None:
    """What has no closed form, and who is grown by the prediction's margins, comes as tables."""
    situation, car, prediction, chosen = asked(index)
    scripted = tuple(KnownBody(id=b.id, length_m=b.length_m, width_m=b.width_m, motion=b.at) for b in prediction.bodies)
    alike = answered(library, situation, car, Prediction(name="script", bodies=scripted), chosen)
    own = answered(library, situation, car, prediction, chosen)
    assert (alike.end_s, alike.start, alike.closer) == (own.end_s, own.start, own.closer)
    grown = replace(chosen, margins=Margins(along_m=0.2, share_of_prediction=0.5))
    wide = tuple(replace(b, covariance=np.eye(4)) for b in prediction.bodies if isinstance(b, CruisingBody))
    uncertain = Prediction(name="wide", bodies=wide)
    plain, fast = found(Case(situation, car, uncertain, grown)), answered(library, situation, car, uncertain, grown)
    assert (plain.end_s, plain.start, plain.closer) == (fast.end_s, fast.start, fast.closer)


def test_maps_do_not_depend_on_those_before_nor_on_other_threads(library: ctypes.CDLL) -> None:
    """The numbers that a call works with are the thread's own, and are used again."""
    cases = [asked(index) for index in range(24)]

    def maps(order: list[int]) -> dict[int, Found]:
        return {index: answered(library, *cases[index]) for index in order}

    alone, forwards = maps(list(range(24))), list(range(24))
    with ThreadPoolExecutor(3) as pool:
        for told in pool.map(maps, [forwards[::-1], forwards[::2], forwards[1::2] + forwards]):
            assert all(alone[index] == answer for index, answer in told.items())
