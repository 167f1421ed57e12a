"""Longitudinal manoeuvres, each written out: a host, a distance, and a lead's speed over time."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from mcdas_opt.catalogue.scenes import Scene, scene_from_document
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.evaluation.spread import Part

_LENGTH_M = 4.5


class Manoeuvre(Part):
    """`gap_m` is bumper to bumper; the lead holds its first speed until the first of `lead_at_s` and its last from the last on."""

    name: str
    about: str = ""
    duration_s: Annotated[float, Field(gt=0.0)]
    host_mps: Annotated[float, Field(ge=0.0)]
    desired_mps: Annotated[float, Field(gt=0.0)]
    gap_m: float | None = None
    lead_mps: list[Annotated[float, Field(ge=0.0)]] = Field(default_factory=list)
    lead_at_s: list[Annotated[float, Field(ge=0.0)]] = Field(default_factory=list)
    vehicle: str = "sedan"
    sensors: dict[str, Any] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _profile_is_whole(self) -> Self:
        if len(self.lead_mps) != len(self.lead_at_s) or (self.gap_m is None) != (not self.lead_mps):
            raise ValueError("gap_m, lead_mps and lead_at_s belong together, the lists equally long")
        if any(after <= before for before, after in pairwise(self.lead_at_s)):
            raise ValueError("lead_at_s must increase")
        return self

    def scene(self, index: int, seed: int) -> Scene:
        """The manoeuvre as a scene of one lane; `seed` is the measurement noise's."""
        neighbours = []
        if self.gap_m is not None:
            apart = self.gap_m + 0.5 * (load_vehicle(self.vehicle).length_m + _LENGTH_M)
            lead: dict[str, Any] = {"name": "lead", "s_m": apart, "speed_mps": self.lead_mps[0]}
            motion = speed_script(self.lead_at_s, self.lead_mps)
            neighbours.append(lead | ({"motion": motion} if motion else {}))
        name = f"{self.name}-{index}"
        document = {
            "name": name,
            "duration_s": self.duration_s,
            "seed": seed,
            "road": {"speed_limit_mps": 40.0},
            "host": {"vehicle": self.vehicle, "speed_mps": self.host_mps, "desired_speed_mps": self.desired_mps},
            "neighbour": neighbours,
            "sensors": dict(self.sensors),
        }
        return scene_from_document(document, Path(f"{name}.toml"))


def speed_script(at_s: list[float], speeds_mps: list[float]) -> list[dict[str, Any]]:
    """Pieces of constant acceleration through (time, speed) pairs."""
    pieces = []
    for (t, v), (after, then) in pairwise(zip(at_s, speeds_mps, strict=True)):
        rate = (then - v) / (after - t)
        pieces.append({"start_s": t, "acceleration_mps2": rate, **({"until_speed_mps": then} if rate else {})})
    return pieces
