"""The lane problem of somebody who only wants to get through: every neighbour beyond a given line, nothing else wanted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from mcdas_opt.ocp.lane_mpc import LaneProblem, SlackPenalty
from mcdas_opt.ocp.terms import Constraint, Cost, Effort, FrictionCircle, RoadEdges, RoadEnd, Stage


@dataclass(frozen=True, slots=True, kw_only=True)
class BeyondLine:
    """All four corners of the body on the positive side of a line: (cos, sin) of its angle . corner >= offset, in the road's frame."""

    slot: int
    slack: str = "collision"

    @property
    def name(self) -> str:
        return f"line {self.slot + 1} [m]"

    @property
    def parameters(self) -> Sequence[str]:
        return (f"line{self.slot}_angle", f"line{self.slot}_offset")

    def rows(self, stage: Stage) -> list[Any]:
        angle, offset = (stage.p[name] for name in self.parameters)
        m, vehicle = stage.m, stage.vehicle
        along = m.cos(stage.psi - angle)
        across = m.sin(stage.psi - angle)
        centre = stage.s * m.cos(angle) + stage.d * m.sin(angle)
        reach = [
            x * 0.5 * vehicle.length_m * along - y * 0.5 * vehicle.width_m * across
            for x, y in ((1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0))
        ]
        return [offset - centre - r for r in reach]


def _costs() -> tuple[Cost, ...]:
    return (
        Effort(quantity="psi", unit="rad", weight=0.1, terminal_weight=10.0),
        Effort(quantity="a", unit="m/s^2", weight=1e-3),
        Effort(quantity="jerk", unit="m/s^3", weight=1e-4),
        Effort(quantity="delta_rate", unit="rad/s", weight=1e-2),
    )


def _penalties() -> dict[str, SlackPenalty]:
    return {
        "friction": SlackPenalty(linear=100.0, quadratic=100.0, scale=0.05),
        "road": SlackPenalty(linear=200.0, quadratic=100.0, scale=0.03),
        "collision": SlackPenalty(linear=100.0, quadratic=50.0, scale=0.05),
    }


@dataclass(frozen=True, slots=True, kw_only=True)
class SideConstrainedLaneProblem(LaneProblem):
    """`neighbours` lines; the whole of every limit may be used."""

    road_margin_m: float = 0.01
    limit_margin: float = 1.0
    costs: tuple[Cost, ...] = field(default_factory=_costs)
    penalties: dict[str, SlackPenalty] = field(default_factory=_penalties)

    @property
    def constraints(self) -> tuple[Constraint, ...]:
        lines = tuple(BeyondLine(slot=i) for i in range(self.neighbours))
        return (FrictionCircle(), RoadEdges(margin=self.road_margin_m), RoadEnd(), *lines)
