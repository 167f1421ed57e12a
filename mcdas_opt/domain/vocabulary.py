"""The closed sets of words of the contract."""

from __future__ import annotations

from enum import StrEnum


class Mode(StrEnum):
    """What the car does. `HOLD` keeps lane and speed; `EVADE` steers out, to the side that `Side` names."""

    HOLD = "hold"
    CRUISE = "cruise"
    BRAKE = "brake"
    ACCELERATE = "accelerate"
    EVADE = "evade"
    PARK = "park"


class Side(StrEnum):
    LEFT = "left"
    RIGHT = "right"
    NONE = "none"

    @property
    def sign(self) -> int:
        """Of an offset or a lane's number to that side: both count to the left."""
        return 1 if self is Side.LEFT else -1 if self is Side.RIGHT else 0


class Role(StrEnum):
    """Where a neighbour is, by geometry: front and rear in the host's own lane, left and right in the next lanes."""

    FRONT = "front"
    REAR = "rear"
    LEFT = "left"
    RIGHT = "right"
    OTHER = "other"


class BodyKind(StrEnum):
    """What a neighbour is, where somebody can tell."""

    CAR = "car"
    LORRY = "lorry"
    MOTORCYCLE = "motorcycle"
    BICYCLE = "bicycle"
    PEDESTRIAN = "pedestrian"
    OTHER = "other"


class Sector(StrEnum):
    """The four directions in which a sensor may look from the host."""

    FRONT = "front"
    REAR = "rear"
    LEFT = "left"
    RIGHT = "right"


class Status(StrEnum):
    """`PLANNED`: the planner's own answer. `FALLBACK`: from the fallback ladder. `UNAVOIDABLE`: nothing passes; least severe."""

    PLANNED = "planned"
    FALLBACK = "fallback"
    UNAVOIDABLE = "unavoidable"


class Request(StrEnum):
    DRIVE = "drive"
    PARK = "park"


class Alert(StrEnum):
    """`WARN`: the last comfortable moment of every candidate has passed. `ACT`: the last possible one is near."""

    NONE = "none"
    WARN = "warn"
    ACT = "act"
