"""The planner's answer: a plan, or a refusal with its reason."""

from __future__ import annotations

from dataclasses import dataclass, field
from operator import attrgetter
from typing import Any, ClassVar

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.doubt import Doubt
from mcdas_opt.domain.escapes import Escapes
from mcdas_opt.domain.result import Columns, Result
from mcdas_opt.domain.rules import word
from mcdas_opt.domain.safe_end import EndKind, SafeEnd
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.trajectory import Command, Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.verdict import Verdict
from mcdas_opt.domain.vocabulary import Alert, Mode, Side, Status


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """One candidate manoeuvre that was tried: its cost (None when it has none), whether the judge passed it, else why not.

    `end` is how it ends (None: nobody looked, it passed as far as it was planned)."""

    name: str
    cost: float | None
    passed: bool
    refusal: str = ""
    end: EndKind | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Timing:
    """Wall-clock milliseconds; the only part of a plan that does not repeat."""

    total: float = 0.0
    solve: float = 0.0
    verify: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Plan(Result):
    """A trajectory with its verdict. Time 0 of the trajectory is the situation's time.

    `indicator` is the side that it indicates: where it steers out, and before a lane change that it announces.
    `chosen` is the name of the candidate that it is. `converged` false: its solve was cut short at its cap on iterations; it is judged as
    any other, but its last digits say nothing. `solver` says which engine the method runs and in which form (compiled and
    interpreted agree to 1e-6, not to the byte). `safe_end` says how it ends (None: nobody looked, as with the bare closed forms).
    `escapes` is the map of the candidates that were open then, `alert` what follows from it; None and absent where it is turned off.
    `doubts` says which of the situation's tracks cannot all be true; the plan is clear of all that may be there.
    `memory` is what the method leaves for its next cycle, a frozen record of its own type: it comes back with the plan as `previous`, so
    that a manoeuvre once begun goes on instead of beginning anew. `situation` and `vehicle` are what it was asked for, to draw it in;
    `believed` is that situation with the tracks that it was planned around and judged with: others where some are doubted,
    or were just before.
    """

    drawn_by: ClassVar[str] = "mcdas_opt.plotting.plan_sheet:plan_sheet"
    moves_by: ClassVar[str] = "mcdas_opt.plotting.plan_sheet:film"
    plays_by: ClassVar[str] = "mcdas_opt.plotting.player:plan_page"

    planner: str
    mode: Mode
    side: Side = Side.NONE
    indicator: Side = Side.NONE
    warning: bool = False
    status: Status = Status.PLANNED
    reason: str = ""
    verdict: Verdict
    prediction: str
    trajectory: Trajectory
    candidates: tuple[Candidate, ...] = ()
    timing_ms: Timing = field(default_factory=Timing)
    iterations: int = 0
    converged: bool = True
    chosen: str = ""
    destination: str = ""
    solver: str = ""
    literal_mode: str | None = None
    safe_end: SafeEnd | None = None
    escapes: Escapes | None = None
    alert: Alert = Alert.NONE
    doubts: tuple[Doubt, ...] = ()
    time_s: float = 0.0
    memory: object = field(default=None, repr=False, compare=False)
    situation: Situation | None = field(default=None, repr=False, compare=False)
    believed: Situation | None = field(default=None, repr=False, compare=False)
    vehicle: Vehicle | None = field(default=None, repr=False, compare=False)

    def __post_init__(self) -> None:
        """A method may answer in words; what is no word of the contract is refused here and not at the end of a drive."""
        require_types(self)
        if not (type(self.mode) is Mode and type(self.side) is Side and type(self.status) is Status and type(self.alert) is Alert):
            for name, kind in (("mode", Mode), ("side", Side), ("status", Status), ("alert", Alert)):
                object.__setattr__(self, name, word(name, attrgetter(name)(self), kind))
        if type(self.candidates) is not tuple:
            object.__setattr__(self, "candidates", tuple(self.candidates))

    def command_at(self, t_s: float) -> Command:
        """Acceleration [m/s^2] and steering angle [rad] to ask of the car at `t_s` [s], counted from the plan's `time_s`.

        At 0 that is the measured state, and commanding it for ever changes nothing: ask for the end of the cycle, plus the actuators'
        dead time and lag. Past the end it is the last sample's. Raises `ParameterError` for a time that is negative or not finite.
        """
        return self.trajectory.command_at(t_s)

    def to_dict(self) -> dict[str, Any]:
        """The JSON document of the contract."""
        document = Result.to_dict(self)
        if self.escapes is None:
            del document["escapes"]
        return document

    def in_brief(self) -> tuple[str, str, str]:
        side = "" if self.side is Side.NONE else f" {self.side}"
        end = "nobody looked how it ends" if self.safe_end is None else f"ends {self.safe_end.kind} after {self.safe_end.t_s:.1f} s"
        refused = sum(not candidate.passed for candidate in self.candidates)
        return (
            f"Plan of {self.planner} at {self.time_s:g} s: {self.mode}{side}, {self.status}, alert {self.alert}",
            f"verdict: {self.verdict.reason}; {end}",
            f"{f'{self.chosen} of ' if self.chosen else ''}{len(self.candidates)} candidates ({refused} refused), "
            f"{self.iterations} iterations, {self.timing_ms.total:.1f} ms",
        )

    def columns(self) -> Columns:
        """The trajectory."""
        return self.trajectory.columns()


@dataclass(frozen=True, slots=True, kw_only=True)
class Refusal:
    """No plan, and why: in traffic a normal value. The fallback answers it."""

    reason: str
    candidates: tuple[Candidate, ...] = ()
    iterations: int = 0

    def __post_init__(self) -> None:
        require_types(self)
        if type(self.candidates) is not tuple:
            object.__setattr__(self, "candidates", tuple(self.candidates))
