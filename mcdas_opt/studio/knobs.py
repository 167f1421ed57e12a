"""The sliders: what each one reads from a scene, and how a scene with other values is made."""

from __future__ import annotations

import copy
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.domain.settings import SigmoidSettings
from mcdas_opt.errors import ParameterError, nearest


@dataclass(frozen=True, slots=True, kw_only=True)
class Knob:
    """A number that can be turned. `also`: another unit that is shown beside its own, `kmh` or `deg`."""

    key: str
    label: str
    unit: str
    low: float
    high: float
    step: float
    group: str
    also: str = ""

    def checked(self, value: object) -> float:
        """`value` as a number in the knob's range. Raises `ParameterError`."""
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            raise ParameterError(self.key, value, "must be a number")
        if not self.low - 1e-9 <= value <= self.high + 1e-9:
            raise ParameterError(self.key, value, f"must lie in [{self.low:g}, {self.high:g}]", self.unit.strip("-"))
        return float(value)


KNOBS = (
    Knob(key="front_gap_m", label="gap to the front car", unit="m", low=2.0, high=80.0, step=0.5, group="gaps"),
    Knob(key="rear_gap_m", label="gap to the rear car", unit="m", low=2.0, high=80.0, step=0.5, group="gaps"),
    Knob(key="front_offset_m", label="front car's offset, left positive", unit="m", low=-2.5, high=2.5, step=0.05, group="gaps"),
    Knob(key="host_speed_mps", label="host", unit="m/s", low=0.0, high=50.0, step=0.1, group="speeds", also="kmh"),
    Knob(key="front_speed_mps", label="front car", unit="m/s", low=0.0, high=50.0, step=0.1, group="speeds", also="kmh"),
    Knob(key="rear_speed_mps", label="rear car", unit="m/s", low=0.0, high=50.0, step=0.1, group="speeds", also="kmh"),
    Knob(key="friction", label="friction", unit="-", low=0.1, high=1.2, step=0.01, group="road"),
    Knob(key="a_per_m", label="a (literal; corrected scales it with speed)", unit="1/m", low=-1.5, high=-0.05, step=0.01, group="sigmoid"),
    Knob(key="b", label="b", unit="-", low=5.0, high=200.0, step=1.0, group="sigmoid"),
    Knob(key="y_max_m", label="y_max (literal)", unit="m", low=1.0, high=6.0, step=0.05, group="sigmoid"),
)
BY_KEY = {knob.key: knob for knob in KNOBS}
_SAME_LANE = 0.65  # of the lane's width: nearer to the host's line than this is in its way
SIGMOID = ("a_per_m", "b", "y_max_m")  # these turn the closed form, not the scene


def front_and_rear(scene: Scene) -> tuple[int | None, int | None]:
    """Indices of the nearest neighbours ahead and behind in the host's lane, at the start."""
    near: dict[bool, tuple[float, int]] = {}
    for k in range(len(scene.neighbour)):
        s, d, _, _ = scene.neighbour[k].initial
        if abs(d - scene.host.d_m) < _SAME_LANE * scene.road.lane_width_m:
            ahead = s > 0.0
            near[ahead] = min(near.get(ahead, (math.inf, k)), (abs(s), k))
    return (near[True][1] if True in near else None), (near[False][1] if False in near else None)


def positions(scene: Scene, sigmoid: SigmoidSettings) -> dict[str, float | None]:
    """Where every knob stands; None for one that this scene has not: no such car, or one whose motion is recorded."""
    found: dict[str, float | None] = {"friction": scene.road.friction, "host_speed_mps": scene.host.speed_mps}
    found |= {"a_per_m": sigmoid.a_per_m, "b": sigmoid.b, "y_max_m": sigmoid.y_max_m}
    for name, index in zip(("front", "rear"), front_and_rear(scene), strict=True):
        car = None if index is None else scene.neighbour[index]
        if car is None or car.trajectory is not None:
            continue
        s, d, _, v = car.initial
        found[f"{name}_gap_m"] = abs(s) - 0.5 * (car.length_m + scene.vehicle.length_m)
        found[f"{name}_speed_mps"] = v
        if name == "front":
            found["front_offset_m"] = d - scene.host.d_m
    return {knob.key: found.get(knob.key) for knob in KNOBS}


def turned(scene: Scene, document: Mapping[str, Any], values: Mapping[str, object]) -> dict[str, Any]:
    """The scene's document with other values of its knobs. Raises `ParameterError` for a knob that is unknown, or not this scene's."""
    made: dict[str, Any] = copy.deepcopy(dict(document))
    host, road = made.setdefault("host", {}), made.setdefault("road", {})
    cars = dict(zip(("front", "rear"), front_and_rear(scene), strict=True))
    for key, raw in values.items():
        if key not in BY_KEY:
            raise ParameterError("knob", key, nearest(key, BY_KEY))
        if key in SIGMOID:
            continue
        value = BY_KEY[key].checked(raw)
        if key == "friction":
            road["friction"] = value
            host.pop("assumed_friction", None)
        elif key == "host_speed_mps":
            host["speed_mps"] = value
        else:
            side, _, what = key.partition("_")
            index = cars[side]
            if index is None or scene.neighbour[index].trajectory is not None:
                raise ParameterError(key, raw, f"this scene has no {side} car that can be moved")
            car = made["neighbour"][index]
            if what == "gap_m":
                away = value + 0.5 * (scene.neighbour[index].length_m + scene.vehicle.length_m)
                car["s_m"] = away if side == "front" else -away
            elif what == "offset_m":
                car["d_m"] = scene.host.d_m + value
            else:
                car["speed_mps"] = value
    return made


def sigmoid_of(before: SigmoidSettings, values: Mapping[str, object]) -> SigmoidSettings:
    """The closed form's settings with other values of their knobs."""
    new: dict[str, Any] = {key: BY_KEY[key].checked(values[key]) for key in SIGMOID if key in values}
    return replace(before, **new)
