"""The ranges that a family's scenes come from, as a suite file tells them."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from mcdas_opt.catalogue.part import Part
from mcdas_opt.domain.road import MOST_LANES
from mcdas_opt.domain.rules import FASTEST_MPS
from mcdas_opt.evaluation.spread import Number, Spread, largest

_MOST_CARS = 20  # in a lane


class RoadSpread(Part):
    """`bend_mps2` is the lateral acceleration that the road's one bend asks of the host at its speed; positive bends to the left."""

    lane_width_m: Number = 3.7
    friction: Number = 0.9
    lanes_left: Number = 1
    lanes_right: Number = 1
    bend_mps2: Number = 0.0

    @model_validator(mode="after")
    def _few_lanes(self) -> Self:
        for name, lanes in (("lanes_left", self.lanes_left), ("lanes_right", self.lanes_right)):
            if largest(lanes) > MOST_LANES:
                raise ValueError(f"{name} must be at most {MOST_LANES}")
        return self


class HostSpread(Part):
    """`eager_mps`: by how much its desired speed exceeds its own at the start."""

    vehicle: str = "sedan"
    speed_mps: Number
    eager_mps: Number = 0.0

    @model_validator(mode="after")
    def _as_a_car(self) -> Self:
        if largest(self.speed_mps) > FASTEST_MPS:
            raise ValueError(f"speed_mps must be at most {FASTEST_MPS:g}")
        return self


class FrontSpread(Part):
    """Somebody ahead. Its speed is its own or so much less than the host's; `ttc_s` is the time to collision that it begins at.

    `braking_share` is the share of its speed that it brakes away (1 is to a stop), `until_mps` the speed it brakes down to. `overlap`
    is the share of the host's width that it stands in the way of, negative to the left of the host's middle, positive to the right.
    """

    gap_m: Number | None = None
    headway_s: Number | None = None
    ttc_s: Number | None = None
    slower_mps: Number = 0.0
    speed_mps: Number | None = None
    offset_m: Number = 0.0
    overlap: Number | None = None
    braking_mps2: Number = 0.0
    braking_share: Number = 1.0
    until_mps: Number | None = None
    length_m: Number = 4.5
    width_m: Number = 1.8

    @model_validator(mode="after")
    def _one_distance(self) -> Self:
        if [self.gap_m, self.headway_s, self.ttc_s].count(None) != 2:
            raise ValueError("needs one of gap_m, headway_s and ttc_s")
        return self


class RearSpread(Part):
    gap_m: Number | None = None
    headway_s: Number | None = None
    faster_mps: Number = 0.0
    braking_mps2: Number = 0.0
    after_s: Number = 1.5
    follows: bool = False
    reaction_s: Number = 1.0

    @model_validator(mode="after")
    def _one_distance(self) -> Self:
        if (self.gap_m is None) == (self.headway_s is None):
            raise ValueError("needs gap_m or headway_s, not both")
        return self


class SideSpread(Part):
    """Cars in each next lane there is: how many, how far ahead of the host, at which share of its speed."""

    cars: Number = 0
    ahead_m: Number = 0.0
    speed_ratio: Number = 1.0

    @model_validator(mode="after")
    def _few_cars(self) -> Self:
        if largest(self.cars) > _MOST_CARS:
            raise ValueError(f"cars must be at most {_MOST_CARS}")
        return self


class BlockadeSpread(Part):
    """In each next lane a car that does as the front car does, `stagger_m` farther ahead."""

    stagger_m: Number = 0.0


class CutInSpread(Part):
    """Somebody from the lane to `side` (1 left, -1 right) who moves into the host's at the event, bumper `gap_m` ahead of the host's.

    `lateral_mps` is the largest sideways speed; from the event on it accelerates too.
    """

    gap_m: Number
    slower_mps: Number
    lateral_mps: Number
    acceleration_mps2: Number = 0.0
    side: Number = Spread(one_of=[1.0, -1.0])


class CutOutSpread(Part):
    """The front car leaves to `side` at the event, `ahead_m` before it would meet somebody who stands in the host's lane."""

    ahead_m: Number
    lateral_mps: Number
    side: Number = Spread(one_of=[1.0, -1.0])


class Ranges(Part):
    """Everything that a scene is drawn from: road, host, who drives about it, and the sensors."""

    duration_s: Annotated[float, Field(gt=0.0)] = 8.0
    event_s: Number = 0.0
    road: RoadSpread = RoadSpread()
    host: HostSpread
    front: FrontSpread | None = None
    rear: RearSpread | None = None
    side: SideSpread = SideSpread()
    blockade: BlockadeSpread | None = None
    cut_in: CutInSpread | None = None
    cut_out: CutOutSpread | None = None
    sensors: dict[str, Any] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _parts_fit(self) -> Self:
        if self.front is None and (self.blockade is not None or self.cut_out is not None):
            raise ValueError("blockade and cut_out need a front")
        return self
