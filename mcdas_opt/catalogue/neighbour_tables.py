"""The tables of a scene file that say who is there, and how they move."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, PrivateAttr, model_validator

from mcdas_opt.catalogue.part import Acceleration, NonNegative, Part, Place, Positive, Speed
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.track import LONGEST_M
from mcdas_opt.domain.vocabulary import BodyKind

Size = Annotated[float, Field(ge=0.01, le=LONGEST_M)]


class MotionPart(Part):
    """One scripted piece: an acceleration piece, a lateral piece, or both at once."""

    start_s: Annotated[NonNegative, Field(description="when the piece begins")]
    acceleration_mps2: Annotated[Acceleration | None, Field(description="held until until_speed_mps")] = None
    until_speed_mps: Annotated[Speed | None, Field(description="default 0 when braking, the speed limit when accelerating")] = None
    lateral_to_m: Annotated[Place | None, Field(description="a move across the road, quintic in time; needs a speed above 1 m/s")] = None
    duration_s: Annotated[Positive | None, Field(description="of the lateral move")] = None

    @model_validator(mode="after")
    def _one_channel_at_least(self) -> Self:
        if self.acceleration_mps2 is None and self.lateral_to_m is None:
            raise ValueError("a motion piece needs acceleration_mps2 or lateral_to_m")
        if self.lateral_to_m is not None and self.duration_s is None:
            raise ValueError("lateral_to_m needs duration_s")
        if self.lateral_to_m is None and self.duration_s is not None:
            raise ValueError("duration_s belongs to lateral_to_m")
        if self.acceleration_mps2 is None and self.until_speed_mps is not None:
            raise ValueError("until_speed_mps belongs to acceleration_mps2")
        return self


class NeighbourPart(Part):
    name: Annotated[str, Field(description="a label; roles come from geometry")] = ""
    s_m: Annotated[Place | None, Field(description="body centre, relative to the host's at t = 0")] = None
    d_m: Annotated[Place | None, Field(description="body centre across the road; default 0")] = None
    speed_mps: Annotated[Speed | None, Field(description="along the road at t = 0; with a heading_rad that way")] = None
    heading_rad: Annotated[
        float | None,
        Field(
            ge=-math.pi, le=math.pi, description="relative to the road there: it drives straight on in the plane instead of along the road"
        ),
    ] = None
    oncoming: Annotated[bool, Field(description="true: it comes along the road towards the host")] = False
    kind: Annotated[BodyKind | None, Field(strict=False, description="what it is, for whoever can tell")] = None
    length_m: Annotated[Size, Field(description="of its body")] = 4.5
    width_m: Annotated[Size, Field(description="of its body")] = 1.8
    behaviour: Annotated[Literal["scripted", "idm"], Field(description="idm follows whoever is ahead in its lane")] = "scripted"
    reaction_s: Annotated[NonNegative, Field(description="of an idm neighbour")] = 1.0
    motion: Annotated[
        list[MotionPart], Field(description="scripted pieces in time order; before and after them the speed is held", default_factory=list)
    ]
    trajectory: Annotated[str | None, Field(description="instead of state and motion: a CSV of t_s, s_m, d_m, heading_rad, speed_mps")] = (
        None
    )
    leaves: Annotated[bool, Field(description="with a trajectory: gone after its last row; else it drives on from there")] = False
    _samples: Array | None = PrivateAttr(default=None)

    @model_validator(mode="after")
    def _either_state_or_trajectory(self) -> Self:
        state = {"s_m": self.s_m, "d_m": self.d_m, "speed_mps": self.speed_mps, "heading_rad": self.heading_rad}
        if self.trajectory is not None:
            given = [k for k, v in state.items() if v is not None] + (["motion"] if self.motion else [])
            if given:
                raise ValueError(f"trajectory and {given[0]} exclude each other")
            if self.behaviour == "idm":
                raise ValueError("a recorded trajectory cannot follow by idm")
            if self.oncoming:
                raise ValueError("trajectory and oncoming exclude each other: its rows say where it drives")
            return self
        if self.leaves:
            raise ValueError("leaves needs a trajectory, after which it is gone")
        for key in ("s_m", "speed_mps"):
            if state[key] is None:
                raise ValueError(f"missing key {key} (or trajectory)")
        if self.behaviour == "idm" and self.motion:
            raise ValueError("a motion script and behaviour idm exclude each other")
        if self.heading_rad is not None and self.behaviour == "idm":
            raise ValueError("heading_rad and behaviour idm exclude each other: who follows drives along the road")
        if self.heading_rad is not None and any(piece.lateral_to_m is not None for piece in self.motion):
            raise ValueError("heading_rad and lateral_to_m exclude each other: who has a heading drives straight on")
        if self.oncoming and self.heading_rad is not None:
            raise ValueError("oncoming and heading_rad exclude each other: who has a heading drives straight on")
        if self.oncoming and self.behaviour == "idm":
            raise ValueError("oncoming and behaviour idm exclude each other: who follows drives the host's way")
        starts = [piece.start_s for piece in self.motion]
        if starts != sorted(starts):
            raise ValueError("motion pieces must stand in time order")
        return self

    @property
    def samples(self) -> Array | None:
        """(n, 5) recorded t, s, d, heading, speed; None for a neighbour with a state of its own."""
        return self._samples

    def take(self, samples: Array) -> None:
        """Its recorded motion, once its file has been read."""
        self._samples = samples

    @property
    def initial(self) -> tuple[float, float, float, float]:
        """(s, d, heading, speed) at t = 0."""
        if self._samples is not None:
            t = self._samples[:, 0]
            s, d, psi, v = (float(np.interp(0.0, t, self._samples[:, k])) for k in (1, 2, 3, 4))
            return s - max(float(t[0]), 0.0) * v * math.cos(psi), d, psi, v
        assert self.s_m is not None
        assert self.speed_mps is not None
        heading = math.pi if self.oncoming else self.heading_rad or 0.0
        return self.s_m, self.d_m or 0.0, heading, self.speed_mps
