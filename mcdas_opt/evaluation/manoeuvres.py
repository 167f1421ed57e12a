"""Longitudinal manoeuvres, each written out: a host, a distance, and a lead's speed over time."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, ValidationInfo, model_validator

from mcdas_opt.catalogue.part import Part
from mcdas_opt.catalogue.scenes import Scene, scene_from_document
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.interop.host_motion import HostMotion

_LENGTH_M = 4.5
_RECORDED_S = 0.5  # between two samples of a recorded lead's speed, whose acceleration is constant in between


class Manoeuvre(Part):
    """`gap_m` is bumper to bumper; the lead holds its first speed until the first of `lead_at_s` and its last from the last on.

    `lead_file`, beside the suite, is a recording of its speed instead (CSV of t_s, speed_mps), from `lead_from_s` on. With `idm_gap_m` the
    host follows a driver by the IDM, who follows the lead with that gap; with `rear_gap_m` another follows the host. `limit_mps` is the
    road's.
    """

    name: Annotated[str, Field(description="of the manoeuvre")]
    about: Annotated[str, Field(description="its source")] = ""
    duration_s: Annotated[Annotated[float, Field(gt=0.0)], Field(description="of the drive")]
    host_mps: Annotated[Annotated[float, Field(ge=0.0)], Field(description="the host's speed at the start")]
    desired_mps: Annotated[Annotated[float, Field(gt=0.0)], Field(description="speed that it wants")]
    gap_m: Annotated[float | None, Field(description="to the lead, bumper to bumper")] = None
    lead_mps: Annotated[list[Annotated[float, Field(ge=0.0)]], Field(description="the lead's speeds, at lead_at_s")] = Field(
        default_factory=list
    )
    lead_at_s: Annotated[list[Annotated[float, Field(ge=0.0)]], Field(description="times of lead_mps")] = Field(default_factory=list)
    lead_file: Annotated[str | None, Field(description="instead: a CSV of t_s, speed_mps beside the suite")] = None
    lead_from_s: Annotated[Annotated[float, Field(ge=0.0)], Field(description="where in lead_file it begins")] = 0.0
    idm_gap_m: Annotated[
        Annotated[float, Field(gt=0.0)] | None, Field(description="to the lead of a driver in between, by the Intelligent Driver Model")
    ] = None
    rear_gap_m: Annotated[
        Annotated[float, Field(gt=0.0)] | None, Field(description="to the host of a driver behind, by the Intelligent Driver Model")
    ] = None
    friction: Annotated[Annotated[float, Field(gt=0.0, le=1.5)], Field(description="of the road")] = 0.9
    limit_mps: Annotated[Annotated[float, Field(gt=0.0)], Field(description="the road's speed limit")] = 40.0
    nominal: Annotated[bool, Field(description="nothing in it needs an intervention")] = False
    vehicle: Annotated[str, Field(description="a shipped vehicle or a path")] = "sedan"
    sensors: Annotated[dict[str, Any], Field(description="as in a scene")] = Field(default_factory=dict)

    @model_validator(mode="before")
    @classmethod
    def _recorded(cls, document: Any, info: ValidationInfo) -> Any:
        """Fills in the speeds of the recording."""
        if not isinstance(document, dict) or not isinstance(document.get("lead_file"), str):
            return document
        if "lead_mps" in document or "lead_at_s" in document:
            raise ValueError("lead_file and lead_mps exclude each other")
        beside = info.context.parent if isinstance(info.context, Path) else Path()
        motion = HostMotion.read(beside / document["lead_file"])
        start, duration = float(document.get("lead_from_s", 0.0)), float(document.get("duration_s", 0.0))
        if start + duration > float(motion.t_s[-1]):
            raise ValueError(f"lead_file ends after {motion.t_s[-1]:g} s: lead_from_s and duration_s ask for {start + duration:g} s")
        t = np.arange(start, start + duration + _RECORDED_S, _RECORDED_S)
        speeds = np.interp(t, motion.t_s, motion.speed_mps).tolist()
        return document | {"lead_at_s": np.round(t - start, 9).tolist(), "lead_mps": speeds}

    @model_validator(mode="after")
    def _profile_is_whole(self) -> Self:
        if len(self.lead_mps) != len(self.lead_at_s) or (self.gap_m is None) != (not self.lead_mps):
            raise ValueError("gap_m, lead_mps and lead_at_s belong together, the lists equally long")
        if self.idm_gap_m is not None and self.gap_m is None:
            raise ValueError("idm_gap_m needs a gap_m and a lead")
        if any(after <= before for before, after in pairwise(self.lead_at_s)):
            raise ValueError("lead_at_s must increase")
        return self

    def scene(self, index: int, seed: int) -> Scene:
        """The manoeuvre as a scene of one lane; `seed` is the measurement noise's."""
        neighbours: list[dict[str, Any]] = []
        between_m = 0.5 * (load_vehicle(self.vehicle).length_m + _LENGTH_M)
        if self.rear_gap_m is not None:
            neighbours.append({"name": "rear", "s_m": -self.rear_gap_m - between_m, "speed_mps": self.host_mps, "behaviour": "idm"})
        if self.gap_m is not None:
            apart = self.gap_m + between_m
            if self.idm_gap_m is not None:
                neighbours.append({"name": "between", "s_m": apart, "speed_mps": self.lead_mps[0], "behaviour": "idm"})
                apart += self.idm_gap_m + _LENGTH_M
            lead: dict[str, Any] = {"name": "lead", "s_m": apart, "speed_mps": self.lead_mps[0]}
            motion = speed_script(self.lead_at_s, self.lead_mps)
            neighbours.append(lead | ({"motion": motion} if motion else {}))
        name = f"{self.name}-{index}"
        document = {
            "name": name,
            "duration_s": self.duration_s,
            "seed": seed,
            "road": {"speed_limit_mps": self.limit_mps} | ({} if self.friction == 0.9 else {"friction": self.friction}),
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
