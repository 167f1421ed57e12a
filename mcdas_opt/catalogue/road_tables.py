"""The tables of a scene file that say what the road is, lane by lane, and where the host is to be."""

from __future__ import annotations

from abc import abstractmethod
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from mcdas_opt.catalogue.part import NonNegative, Pair, Part, Positive
from mcdas_opt.domain.destination import Destination
from mcdas_opt.domain.lane import Lane
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.errors import ParameterError


class _Recorded(Part):
    """A table that stands for a record, whose rules it keeps."""

    @abstractmethod
    def record(self) -> object: ...

    @model_validator(mode="after")
    def _is_sound(self) -> Self:
        try:
            self.record()
        except ParameterError as error:
            raise ValueError(str(error)) from None
        return self


class LanePart(_Recorded):
    """One lane where it is not as the road says of all; a list of pairs is in the order of s."""

    lane: Annotated[int, Field(description="which: 0 is the host's at the start, 1 the next to the left, -1 to the right")]
    width_m: Annotated[
        list[Pair], Field(description="knots [s_m, width_m], linear in between; 0: there is no lane; without any, the road's")
    ] = Field(default=[])
    speed_limit_mps: Annotated[
        Annotated[float, Field(gt=0.0, le=100.0)] | list[Pair],
        Field(description="one number, or steps [s_m, limit_mps], each from there on; without any, the road's"),
    ] = Field(default=[])
    closed_m: Annotated[list[Pair], Field(description="stretches [from_s_m, to_s_m] that nobody may drive on")] = Field(default=[])
    oncoming: Annotated[bool, Field(description="true: its traffic comes towards the host; no lane to change into")] = False
    shoulder: Annotated[bool, Field(description="true: road without traffic of its own, and no lane to change into")] = False
    merges: Annotated[
        Literal["left", "right", "none"], Field(description="of lane 0 alone: to which side its traffic goes where it narrows or is closed")
    ] = "none"

    def record(self) -> Lane:
        """The lane; one limit holds all along."""
        given = self.speed_limit_mps
        limits = [[0.0, given]] if isinstance(given, float) else given
        width, limit, closed = (tuple((s, value) for s, value in pairs) for pairs in (self.width_m, limits, self.closed_m))
        return Lane(
            lane=self.lane,
            width_m=width,
            speed_limit_mps=limit,
            closed_m=closed,
            oncoming=self.oncoming,
            shoulder=self.shoulder,
            merges=Side(self.merges),
        )


class RoadPart(_Recorded):
    """The road."""

    lane_width_m: Annotated[Positive, Field(description="of every lane")] = 3.7
    lanes_left: Annotated[int, Field(ge=0, description="lanes to the left of the host's lane, same direction")] = 0
    lanes_right: Annotated[int, Field(ge=0, description="lanes to its right")] = 0
    shoulder_left_m: Annotated[NonNegative, Field(description="drivable beyond the outermost left lane")] = 0.0
    shoulder_right_m: Annotated[NonNegative, Field(description="drivable beyond the outermost right lane")] = 0.0
    friction: Annotated[float, Field(gt=0.0, le=1.5, description="what the plant has")] = 0.9
    speed_limit_mps: Annotated[
        float, Field(gt=0.0, le=100.0, description="binds ordinary driving; escaping may exceed it, and the plan says so")
    ] = 36.0  # more is km/h by mistake
    curvature: Annotated[
        Annotated[list[Pair], Field(min_length=1)],
        Field(description="knots [s_m, kappa_1pm], linear in between, held at both ends; a left turn is positive"),
    ] = Field(default=[[0.0, 0.0]])
    road_end_s_m: Annotated[float | None, Field(description="where the road ends; without it, nowhere")] = None
    lane: Annotated[list[LanePart], Field(description="lanes that are not the same all along")] = Field(default=[])

    def record(self, friction: float | None = None) -> Road:
        """The road, with the friction that its reader believes (default the road's own)."""
        values = self.model_dump(exclude={"curvature", "friction", "lane"})
        knots = tuple((s, k) for s, k in self.curvature)
        lanes = tuple(lane.record() for lane in self.lane)
        return Road(**values, curvature=knots, friction=self.friction if friction is None else friction, lanes=lanes)


class DestinationPart(_Recorded):
    """Where the host is to be, and when, counted from the scene's beginning."""

    s_m: Annotated[Pair | None, Field(description="between which places; without it, anywhere")] = None
    lane: Annotated[int | None, Field(description="in which lane; without it, in any")] = None
    time_s: Annotated[Pair | None, Field(description="between which times; without it, at any")] = None
    d_m: Annotated[Pair | None, Field(description="between which offsets from the road's line; without it, at any")] = None
    speed_mps: Annotated[Pair | None, Field(description="how fast it is to be then; without it, at any speed")] = None
    heading_rad: Annotated[Pair | None, Field(description="how far turned off the road then; without it, by any angle")] = None

    def record(self) -> Destination:
        """The destination."""
        windows = (self.s_m, self.time_s, self.d_m, self.speed_mps, self.heading_rad)
        place, times, offsets, speeds, headings = (None if pair is None else (pair[0], pair[1]) for pair in windows)
        return Destination(s_m=place, lane=self.lane, time_s=times, d_m=offsets, speed_mps=speeds, heading_rad=headings)
