"""One candidate manoeuvre, stage by stage: proposed, driven (or refused), checked, costed, ended. Each stage holds the one before."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from mcdas_opt.domain.plan import Candidate
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.safe_end import SafeEnd
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.verdict import Verdict
from mcdas_opt.domain.vocabulary import Mode, Side
from mcdas_opt.planning.front.headway import ORDINARY_MPS2
from mcdas_opt.planning.lanes.manoeuvre import Manoeuvre
from mcdas_opt.reference.offset_path import OffsetPath

_STEADY_MPS2 = 0.3  # a plan that stays under it within a second neither brakes nor accelerates


@dataclass(frozen=True, slots=True, kw_only=True)
class Proposed:
    """What to aim at: keep the lane towards a speed, or steer along a path. `refusal` says why it is not even tried.

    `guess` (N + 1, 6) are states that the optimiser begins from; None: those of the path. `is_delayed`: it begins later. `speeds_mps`
    (N + 1) is the speed to drive at each node; None: `speed_mps` is asked for at once. `is_comfortable`: nothing presses, and its
    acceleration and jerk are bound by what a person finds comfortable. `relies_on_followers`: who is expected to brake by
    its end may make that safe; `keeps_room_behind`: the optimiser minds the gap to a follower, not only not to be hit.
    """

    name: str
    mode: Mode
    side: Side
    path: OffsetPath
    speed_mps: float
    manoeuvre: Manoeuvre | None = None
    refusal: str = ""
    guess: Array | None = field(default=None, compare=False)
    is_delayed: bool = False
    speeds_mps: Array | None = field(default=None, compare=False)
    is_comfortable: bool = False
    relies_on_followers: bool = False
    keeps_room_behind: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class Refused:
    """A proposal that came to no trajectory: why, and how many iterations that took."""

    proposed: Proposed
    reason: str
    iterations: int = 0

    def row(self) -> Candidate:
        """What the plan says of it."""
        return Candidate(name=self.proposed.name, cost=None, passed=False, refusal=self.reason)


@dataclass(frozen=True, slots=True, kw_only=True)
class Driven:
    """The trajectory that a proposal became; `converged`: no cap on iterations cut its solution short."""

    proposed: Proposed
    trajectory: Trajectory
    iterations: int = 0
    converged: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class Checked:
    """The judge's verdict on a trajectory; `departure`: the side to which it leaves the lane that it was to keep."""

    driven: Driven
    verdict: Verdict
    departure: Side = Side.NONE
    departure_is_watched: bool = True

    @property
    def proposed(self) -> Proposed:
        return self.driven.proposed

    @property
    def trajectory(self) -> Trajectory:
        return self.driven.trajectory

    @property
    def refusal(self) -> str:
        """Why it may not leave as a plan; empty where it may."""
        if not self.verdict.passed:
            return self.verdict.reason
        if self.departure is Side.NONE:
            return ""
        return f"leaves its lane to the {self.departure.value}{'' if self.departure_is_watched else ', where nobody watches'}"

    @property
    def driven_mode(self) -> Mode:
        """What it does: of one that keeps its lane told by its acceleration within a second, not by what it was meant to do."""
        proposed, strongest = self.proposed, strongest_mps2(self.trajectory)
        if proposed.side is not Side.NONE or agrees(proposed.mode, strongest):
            return proposed.mode
        if abs(strongest) < _STEADY_MPS2:
            return Mode.HOLD
        return Mode.ACCELERATE if strongest > 0.0 else Mode.BRAKE

    @property
    def shortfall_m(self) -> float:
        """The room that was short of passing: the deepest overlap; infinite where something else is wrong."""
        if not self.verdict.only_collides:
            return math.inf
        return max((violation.limit - violation.value for violation in self.verdict.violations), default=0.0)

    def proposed_as(self, proposed: Proposed) -> Checked:
        """The same trajectory under another proposal."""
        return replace(self, driven=replace(self.driven, proposed=proposed))

    def named_as_driven(self) -> Checked:
        """The same, its mode what it does."""
        return self.proposed_as(replace(self.proposed, mode=self.driven_mode))


def strongest_mps2(trajectory: Trajectory) -> float:
    """The acceleration of largest size from 0.5 to 1 s, or at its end: before, a plan still has what the host happens to have."""
    t = trajectory.t_s
    first = trajectory.acceleration_mps2[(t >= min(0.5, float(t[-1])) - 1e-9) & (t <= 1.0 + 1e-9)]
    return float(first[int(np.argmax(np.abs(first)))])


def agrees(mode: Mode, strongest_mps2: float) -> bool:
    """Whether what keeps its lane does what the mode says."""
    if mode is Mode.BRAKE:
        return strongest_mps2 <= -_STEADY_MPS2
    if mode is Mode.ACCELERATE:
        return strongest_mps2 >= _STEADY_MPS2
    return mode is not Mode.EVADE and abs(strongest_mps2) <= ORDINARY_MPS2  # holding and cruising do no more


@dataclass(frozen=True, slots=True, kw_only=True)
class Costed:
    """Its cost, by the same measure for all; None where the order of trial decides and not the cost."""

    checked: Checked
    cost: float | None

    @property
    def proposed(self) -> Proposed:
        return self.checked.proposed

    @property
    def trajectory(self) -> Trajectory:
        return self.checked.trajectory

    def row(self) -> Candidate:
        """What the plan says of it."""
        refusal = self.checked.refusal
        return Candidate(name=self.proposed.name, cost=self.cost, passed=not refusal, refusal=refusal)


class Continuation(NamedTuple):
    """A trajectory continued to a safe end, where there is one; the judge's verdict on all of it, and how it ends (None: nobody looked)."""

    trajectory: Trajectory
    verdict: Verdict
    end: SafeEnd | None

    @property
    def is_sound(self) -> bool:
        """Judged, to an end that is safe."""
        return self.verdict.passed and self.end is not None and self.end.safe


@dataclass(frozen=True, slots=True, kw_only=True)
class Ended:
    """A candidate with its continuation: what leaves as a plan."""

    candidate: Costed
    continuation: Continuation

    @property
    def proposed(self) -> Proposed:
        return self.candidate.proposed

    @property
    def is_sound(self) -> bool:
        return self.continuation.is_sound
