"""What the judge says."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

from mcdas_opt.domain.rules import all_of, require_numbers, require_type, true_or_false, word


class ViolationKind(StrEnum):
    """Every rule that a judge may find broken, in traffic and in parking; the value is what a person reads."""

    COLLISION = "collision"
    PREDICTION = "prediction"
    SAMPLING = "sampling"
    NOT_FINITE = "not finite"
    OUT_OF_RANGE = "out of range"
    TIME_ORDER = "time not monotone"
    START_TIME = "start time"
    START_POSITION = "start position"
    START_HEADING = "start heading"
    START_SPEED = "start speed"
    START_ACCELERATION = "start acceleration"
    START_STEERING = "start steering"
    SIDESLIP = "sideslip"
    SPEED = "speed"
    ACCELERATION = "acceleration"
    JERK = "jerk"
    STEERING_ANGLE = "steering angle"
    STEERING_RATE = "steering rate"
    FRICTION = "friction circle"
    LEFT_EDGE = "left road edge"
    RIGHT_EDGE = "right road edge"
    ROAD_END = "road end"
    RESIDUAL = "dynamics residual"
    REINTEGRATED_END = "re-integrated end"
    FORWARD_SPEED = "forward speed"
    REVERSE_SPEED = "reverse speed"
    INTEGRAL = "pose is not the integral"
    CLEARANCE = "clearance"
    PUBLISHED_CLEARANCE = "clearance as published"
    START_CLEARANCE = "clearance at the start"
    GOAL_CLEARANCE = "clearance at the goal"
    END_POSITION = "end position"
    END_HEADING = "end heading"
    END_SPEED = "end speed"
    NO_PATH = "no path found"


_CLEARANCES = frozenset(
    {ViolationKind.CLEARANCE, ViolationKind.PUBLISHED_CLEARANCE, ViolationKind.START_CLEARANCE, ViolationKind.GOAL_CLEARANCE}
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Violation:
    """One broken rule: its worst value, when, and the limit that it broke (tolerance not counted in); `body` names the neighbour or the
    obstacle that it is about. `name` puts kind and body in words."""

    name: str = field(init=False)
    t_s: float
    value: float
    limit: float
    unit: str
    kind: ViolationKind
    body: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "kind", word("kind", self.kind, ViolationKind))
        require_numbers(self, ("t_s", "value", "limit"))
        require_type("unit", self.unit, str)
        require_type("body", self.body, str)
        object.__setattr__(self, "name", self._name())

    def _name(self) -> str:
        if self.kind is ViolationKind.COLLISION:
            return f"collision with {self.body}"
        if self.kind is ViolationKind.PREDICTION:
            return f"prediction of {self.body} not finite"
        if self.kind in _CLEARANCES:
            return f"{self.kind.value}: {'overlap with' if self.value < 0.0 else 'distance to'} {self.body}"
        return self.kind.value

    def __str__(self) -> str:
        if self.kind is ViolationKind.COLLISION:
            return f"{self.name}, {-self.value:.2g} {self.unit} deep, at {self.t_s:.2f} s"
        return f"{self.name} {self.value:.3g} {self.unit} at {self.t_s:.2f} s, limit {self.limit:.3g}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """`passed` exactly when there is no violation."""

    violations: tuple[Violation, ...] = ()
    passed: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "violations", all_of("violations", self.violations, Violation))
        true_or_false("passed", self.passed)
        object.__setattr__(self, "passed", not self.violations)

    @property
    def only_collides(self) -> bool:
        """Whether nothing is wrong but collisions; true of a verdict that passed."""
        return all(violation.kind is ViolationKind.COLLISION for violation in self.violations)

    @property
    def reason(self) -> str:
        """The first violation in words, or 'passed'."""
        return "passed" if self.passed else "; ".join(str(v) for v in self.violations[:2])
