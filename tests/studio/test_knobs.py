"""Sliders: what is turned is what the scene then says, and nothing else changes."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.catalogue.data_files import models_folder, read_toml, shipped
from mcdas_opt.catalogue.scenes import Scene, load_scene, scene_from_document
from mcdas_opt.domain.settings import SigmoidSettings
from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.studio.knobs import KNOBS, SIGMOID, front_and_rear, positions, sigmoid_of, turned

BY_KEY = {knob.key: knob for knob in KNOBS}
PATH = models_folder() / "scenes" / "sandwich-60-40.toml"
DOCUMENT = read_toml(PATH)
SCENE = scene_from_document(DOCUMENT, PATH)


def turn(values: dict[str, Any]) -> Scene:
    return scene_from_document(turned(SCENE, DOCUMENT, values), PATH)


@given(st.fixed_dictionaries({}, optional={k.key: st.floats(k.low, k.high) for k in KNOBS if k.key not in SIGMOID}))
def test_the_scene_stands_where_the_sliders_were_put(values: dict[str, float]) -> None:
    if values.get("host_speed_mps", 0.0) > SCENE.vehicle.speed_max_mps:
        return
    found = positions(turn(values), SigmoidSettings())
    before = positions(SCENE, SigmoidSettings())
    aside = abs(values.get("front_offset_m", 0.0)) >= 2.3  # a car so far aside is in front no more
    for key, value in found.items():
        if aside and key.startswith("front") and value is None:
            continue
        if key in values:
            assert value == pytest.approx(values[key], abs=1e-9)
        elif not aside:
            assert value == before[key]


def test_nothing_turned_is_the_same_scene() -> None:
    assert turn({}) == SCENE


@given(st.sampled_from(SIGMOID), st.data())
def test_the_sigmoid_turns_apart_from_the_scene(key: str, data: st.DataObject) -> None:
    value = data.draw(st.floats(BY_KEY[key].low, BY_KEY[key].high))
    assert getattr(sigmoid_of(SigmoidSettings(), {key: value}), key) == value
    assert turn({key: value}) == SCENE


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, "25", None, True, [1.0], 1e9, -1e9])
@pytest.mark.parametrize("key", sorted(BY_KEY))
def test_a_slider_takes_numbers_of_its_range_only(key: str, value: object) -> None:
    with pytest.raises(ParameterError, match=key):
        BY_KEY[key].checked(value)


def test_an_unknown_slider_is_told_with_its_nearest() -> None:
    with pytest.raises(ParameterError, match="front_gap_m"):
        turn({"front_gapm": 3.0})


@pytest.mark.parametrize("name", shipped("scenes"))
def test_front_and_rear_are_the_nearest_in_the_lane(name: str) -> None:
    scene = load_scene(name)
    front, rear = front_and_rear(scene)
    for index, sign in ((front, 1.0), (rear, -1.0)):
        lane = [
            (abs(car.initial[0]), k)
            for k, car in enumerate(scene.neighbour)
            if sign * car.initial[0] > 0.0 and abs(car.initial[1] - scene.host.d_m) < 0.6 * scene.road.lane_width_m
        ]
        if lane:
            assert index == min(lane)[1]
    stand = positions(scene, SigmoidSettings())
    assert (stand["front_gap_m"] is None) == (front is None)
    assert (stand["rear_speed_mps"] is None) == (rear is None)


def test_a_scene_without_a_front_car_has_no_gap_to_turn() -> None:
    path = models_folder() / "scenes" / "rear-closing.toml"
    document = read_toml(path)
    scene = scene_from_document(document, path)
    with pytest.raises(ParameterError, match="no front car"):
        turned(scene, document, {"front_gap_m": 10.0})


def test_bodies_that_would_overlap_are_told(tmp_path: Path) -> None:
    document = {**DOCUMENT, "neighbour": [*DOCUMENT["neighbour"], {"name": "third", "s_m": 12.0, "speed_mps": 5.0}]}
    scene = scene_from_document(document, PATH)
    with pytest.raises(InputError, match="overlaps"):
        scene_from_document(turned(scene, document, {"front_gap_m": 5.0}) | {"neighbour": [
            {"name": "a", "s_m": 9.5, "speed_mps": 5.0}, {"name": "b", "s_m": 10.0, "speed_mps": 5.0}]}, PATH)  # fmt: skip
