"""The ranges that a family's scenes come from, as a suite file tells them."""

from __future__ import annotations

from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from mcdas_opt.catalogue.part import Part
from mcdas_opt.domain.road import MOST_LANES
from mcdas_opt.domain.rules import FASTEST_MPS
from mcdas_opt.evaluation.spread import Braking, Number, Spread, largest

_MOST_CARS = 20  # in a lane


class RoadSpread(Part):
    """`bend_mps2` is the lateral acceleration that the road's one bend asks of the host at its speed; positive bends to the left."""

    lane_width_m: Annotated[Number, Field(description="of every lane")] = 3.7
    friction: Annotated[Number, Field(description="of the road")] = 0.9
    lanes_left: Annotated[Number, Field(description="to the left of the host's")] = 1
    lanes_right: Annotated[Number, Field(description="to the right of the host's")] = 1
    bend_mps2: Annotated[
        Number, Field(description="lateral acceleration at the host's speed in the road's one bend, to the left positive")
    ] = 0.0

    @model_validator(mode="after")
    def _few_lanes(self) -> Self:
        for name, lanes in (("lanes_left", self.lanes_left), ("lanes_right", self.lanes_right)):
            if largest(lanes) > MOST_LANES:
                raise ValueError(f"{name} must be at most {MOST_LANES}")
        return self


class HostSpread(Part):
    """`eager_mps`: by how much its desired speed exceeds its own at the start."""

    vehicle: Annotated[str, Field(description="a shipped vehicle or a path")] = "sedan"
    speed_mps: Annotated[Number, Field(description="at the start")]
    eager_mps: Annotated[Number, Field(description="desired speed above its own at the start")] = 0.0

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

    gap_m: Annotated[Number | None, Field(description="bumper to bumper at the start; or headway_s, or ttc_s")] = None
    headway_s: Annotated[Number | None, Field(description="gap over the host's speed")] = None
    ttc_s: Annotated[Number | None, Field(description="gap over the closing speed")] = None
    slower_mps: Annotated[Number, Field(description="than the host; or speed_mps")] = 0.0
    speed_mps: Annotated[Number | None, Field(description="its own, instead of slower_mps")] = None
    offset_m: Annotated[Number, Field(description="across from the host, left positive")] = 0.0
    overlap: Annotated[Number | None, Field(description="share of the host's width that it is in the way of")] = None
    braking_mps2: Annotated[Braking, Field(description="from the event on, positive")] = 0.0
    braking_share: Annotated[Number, Field(description="of its speed that it brakes away; 1 to a stop")] = 1.0
    until_mps: Annotated[Number | None, Field(description="speed that it brakes down to")] = None
    length_m: Annotated[Number, Field(description="of its body")] = 4.5
    width_m: Annotated[Number, Field(description="of its body")] = 1.8

    @model_validator(mode="after")
    def _one_distance(self) -> Self:
        if [self.gap_m, self.headway_s, self.ttc_s].count(None) != 2:
            raise ValueError("needs one of gap_m, headway_s and ttc_s")
        return self


class RearSpread(Part):
    gap_m: Annotated[Number | None, Field(description="bumper to bumper at the start; or headway_s")] = None
    headway_s: Annotated[Number | None, Field(description="gap over its own speed")] = None
    faster_mps: Annotated[Number, Field(description="than the host")] = 0.0
    braking_mps2: Annotated[Braking, Field(description="some time after the event, positive")] = 0.0
    after_s: Annotated[Number, Field(description="that time")] = 1.5
    follows: Annotated[bool, Field(description="drives by the Intelligent Driver Model")] = False
    reaction_s: Annotated[Number, Field(description="of one who follows")] = 1.0

    @model_validator(mode="after")
    def _one_distance(self) -> Self:
        if (self.gap_m is None) == (self.headway_s is None):
            raise ValueError("needs gap_m or headway_s, not both")
        return self


class SideSpread(Part):
    """Cars in each next lane there is: how many, how far ahead of the host, at which share of its speed."""

    cars: Annotated[Number, Field(description="in each next lane")] = 0
    ahead_m: Annotated[Number, Field(description="of the host, centre to centre")] = 0.0
    speed_ratio: Annotated[Number, Field(description="their speed over the host's")] = 1.0

    @model_validator(mode="after")
    def _few_cars(self) -> Self:
        if largest(self.cars) > _MOST_CARS:
            raise ValueError(f"cars must be at most {_MOST_CARS}")
        return self


class BlockadeSpread(Part):
    """In each next lane a car that does as the front car does, `stagger_m` farther ahead."""

    stagger_m: Annotated[Number, Field(description="farther ahead than the front car")] = 0.0


class CutInSpread(Part):
    """Somebody from the lane to `side` (1 left, -1 right) who moves into the host's at the event, bumper `gap_m` ahead of the host's.

    `lateral_mps` is the largest sideways speed; from the event on it accelerates too.
    """

    gap_m: Annotated[Number, Field(description="bumper ahead of the host's at the event")]
    slower_mps: Annotated[Number, Field(description="than the host")]
    lateral_mps: Annotated[Number, Field(description="largest speed across")]
    acceleration_mps2: Annotated[Number, Field(description="from the event on")] = 0.0
    side: Annotated[Number, Field(description="that it comes from: 1 left, -1 right")] = Spread(one_of=[1.0, -1.0])


class CutOutSpread(Part):
    """The front car leaves to `side` at the event, `ahead_m` before it would meet somebody who stands in the host's lane."""

    ahead_m: Annotated[Number, Field(description="of the one who stands, when it leaves")]
    lateral_mps: Annotated[Number, Field(description="largest speed across")]
    side: Annotated[Number, Field(description="that it leaves to: 1 left, -1 right")] = Spread(one_of=[1.0, -1.0])


class Ranges(Part):
    """Everything that a scene is drawn from: road, host, who drives about it, and the sensors."""

    duration_s: Annotated[Annotated[float, Field(gt=0.0)], Field(description="of a drive")] = 8.0
    event_s: Annotated[Number, Field(description="when the front car brakes, or somebody changes lanes")] = 0.0
    road: Annotated[RoadSpread, Field(description="the road")] = RoadSpread()
    host: Annotated[HostSpread, Field(description="the car that is planned for")]
    front: Annotated[FrontSpread | None, Field(description="somebody ahead")] = None
    rear: Annotated[RearSpread | None, Field(description="somebody behind")] = None
    side: Annotated[SideSpread, Field(description="cars in the next lanes")] = SideSpread()
    blockade: Annotated[BlockadeSpread | None, Field(description="cars beside the front car")] = None
    cut_in: Annotated[CutInSpread | None, Field(description="somebody who comes in ahead")] = None
    cut_out: Annotated[CutOutSpread | None, Field(description="the front car leaves before somebody who stands")] = None
    sensors: Annotated[dict[str, Any], Field(description="as in a scene")] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _parts_fit(self) -> Self:
        if self.front is None and (self.blockade is not None or self.cut_out is not None):
            raise ValueError("blockade and cut_out need a front")
        return self
