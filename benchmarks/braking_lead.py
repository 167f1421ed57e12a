"""A car ahead that brakes now and then: one distribution, driven by the cheap baseline all at once, or by any planner in the loop."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mcdas_opt.baselines.competent_driver import BRAKING_MPS2, JERK_MPS3, REACTION_S, RELEASE_MPS2
from mcdas_opt.catalogue.scenes import Scene, scene_from_document
from mcdas_opt.domain.rules import Array, non_negative, require_every
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.record import Outcome

DIMENSIONS = 4
_LENGTH_M = 4.5
_STEP_S = 0.02
_DURATION_S = 12.0
_MISSING_MPS2 = 8.0  # what an impact speed is braked away with, for the way that was missing
_MOST_BRAKING_MPS2 = 8.8


@dataclass(frozen=True, slots=True, kw_only=True)
class BrakingLead:
    """Medians and spreads (standard deviations of a normal, or of a logarithm); chosen for this study, of no recorded origin."""

    speed_mps: float = 25.0
    speed_spread_mps: float = 3.0
    headway_s: float = 2.0
    headway_spread: float = 0.25
    braking_mps2: float = 2.5
    braking_spread: float = 0.35
    faster_mps: float = 0.0
    faster_spread_mps: float = 1.0

    def __post_init__(self) -> None:
        require_every(self, non_negative)

    def drawn(self, u: Array) -> tuple[Array, Array, Array, Array]:
        """Speed of the host, of the lead, the gap between them and the lead's deceleration (n,), from normals (n, 4)."""
        speed = np.maximum(self.speed_mps + self.speed_spread_mps * u[:, 0], 5.0)
        gap = self.headway_s * np.exp(self.headway_spread * u[:, 1]) * speed
        braking = np.minimum(self.braking_mps2 * np.exp(self.braking_spread * u[:, 2]), _MOST_BRAKING_MPS2)
        lead = np.maximum(speed - self.faster_mps - self.faster_spread_mps * u[:, 3], 1.0)
        return speed, lead, gap, braking

    def scene(self, u: Array) -> Scene:
        """The scene of one row (4,): the lead brakes to a stop from 0.5 s on."""
        speed, lead, gap, braking = (float(value[0]) for value in self.drawn(np.asarray(u).reshape(1, DIMENSIONS)))
        motion = [{"start_s": 0.5, "acceleration_mps2": -braking}]
        document = {
            "duration_s": _DURATION_S,
            "host": {"speed_mps": speed},
            "neighbour": [{"name": "lead", "s_m": gap + _LENGTH_M, "speed_mps": lead, "motion": motion}],
        }
        return scene_from_document(document, Path("braking-lead.toml"))

    def baseline_gap(self, u: Array) -> Array:
        """Signed gaps (n,) under the competent driver of UN R157 as a point with perfect sight, all rows at once.

        He answers the lead's braking, not a time to collision: half a second after it begins he has lifted his foot, 0.75 s later
        the brake builds up, to 0.774 g.
        """
        v, lead, gap, braking = self.drawn(np.asarray(u, dtype=np.float64))
        least, missing = gap.copy(), np.zeros_like(gap)
        for k in range(round(_DURATION_S / _STEP_S)):
            t = (k + 0.5) * _STEP_S - 0.5
            pressed = t - 0.5 - REACTION_S
            asked = min(JERK_MPS3 * pressed, BRAKING_MPS2) if pressed > 0.0 else RELEASE_MPS2 * (t > 0.5)
            after = np.maximum(v - asked * _STEP_S, 0.0)
            ahead = np.maximum(lead - braking * _STEP_S, 0.0) if t > 0.0 else lead
            gap = gap + 0.5 * _STEP_S * (lead + ahead - v - after)
            v, lead = after, ahead
            hit = (gap <= 0.0) & (missing == 0.0)
            missing = np.where(hit, -(np.maximum(v - lead, 0.01) ** 2) / (2.0 * _MISSING_MPS2), missing)
            least = np.minimum(least, gap)
        return np.where(missing < 0.0, missing, least)

    def driven_gap(self, u: Array, planner: str, plant: str = "kinematic") -> Array:
        """Signed gaps (n,) of a registered planner in the closed loop, one drive a row."""
        return np.array([self._driven(row, planner, plant) for row in np.asarray(u, dtype=np.float64)])

    def _driven(self, row: Array, planner: str, plant: str) -> float:
        run = simulate(self.scene(row), planner=planner, plant=plant)
        if run.outcome is Outcome.COLLISION:
            return -(max(run.impact_speed_mps, 0.01) ** 2) / (2.0 * _MISSING_MPS2)
        return -0.01 if run.outcome is Outcome.LEFT_ROAD or run.min_clearance_m is None else run.min_clearance_m
