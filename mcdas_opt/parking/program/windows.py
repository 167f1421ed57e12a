"""Long zigzags, a window of phases at a time with its ends fixed; windows overlap, so that what one fixes the next one frees."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.rules import non_negative, positive, require
from mcdas_opt.parking.cost import ParkingCosts
from mcdas_opt.parking.program.exchange import Exchanged, ExchangeSettings, exchange
from mcdas_opt.parking.program.manoeuvre import PIECE, Manoeuvre
from mcdas_opt.parking.program.structure import finer, in_pieces
from mcdas_opt.parking.soundness import is_sound
from mcdas_opt.parking.world import World
from mcdas_opt.verification.parking_judge import judge_parking

WHOLE_UP_TO = 24  # gear changes that are still solved in one piece
_ROUNDS_UNSOUND = 6
_DRIFT_M = 1e-3  # of a window's roll-out from its fixed end: made up for
_CLOSING_M = 0.1  # trust region of the whole at the end, where the windows do not fit together
_FINE_M = 0.2  # trust region on the finer grid


@dataclass(frozen=True, slots=True, kw_only=True)
class WindowSettings:
    """A window holds `phases` gears and the next one starts `stride` gears later. A second pass cuts elsewhere: everywhere up to
    `fine_up_to` gear changes, beyond that only where a window had no answer.
    """

    whole_up_to: int = WHOLE_UP_TO
    phases: int = 14
    stride: int = 8
    rounds: int = 4
    fine_up_to: int = 60  # gear changes that are gone through once more on a grid of half the spacing, ...
    fine_stride: int = 12  # ... in windows that begin so many gears apart

    def __post_init__(self) -> None:
        require_types(self)
        for name, count in (("phases", self.phases), ("stride", self.stride), ("rounds", self.rounds), ("fine_stride", self.fine_stride)):
            positive(name, count)
        require(self, non_negative, "whole_up_to", "fine_up_to")


def improve(
    case: ParkingCase,
    world: World,
    first: Manoeuvre,
    costs: ParkingCosts,
    settings: ExchangeSettings,
    windows: WindowSettings | None = None,
) -> Exchanged:
    """The exchange loop over the whole manoeuvre, or over windows of it when it has many gears."""
    windows = windows or WindowSettings()
    if first.gear_changes <= windows.whole_up_to:
        return exchange(case, world, first, costs, settings)
    settings = replace(settings, restarts=0, nearly_later_m=settings.nearly_m)  # in slots that leave millimetres, neither helps
    inner = replace(settings, rounds=windows.rounds, rounds_unsound=_ROUNDS_UNSOUND)
    again = first.gear_changes <= windows.fine_up_to
    if again:  # ends fixed in contact leave no more clearance to ask for, and what a window leaves undone the next pass does
        inner = replace(inner, nearly_m=0.0, nearly_later_m=0.0, patience=0, drift_m=_DRIFT_M)
    passes = _Pass(case, world, costs, inner, first)
    unanswered = passes.through(0, windows.phases, windows.stride)
    if again or unanswered:
        passes.through(-(windows.stride // 2), windows.phases, windows.stride, None if again else unanswered)
    if not _sound(case, passes.current):
        closed = replace(settings, rounds=2, rounds_unsound=5, trust_region_m=_CLOSING_M, trust_region_rad=0.5 * _CLOSING_M)
        done = exchange(case, world, passes.current, costs, closed)  # windows without an answer leave gaps of millimetres that add up
        passes.rounds, passes.iterations = passes.rounds + done.rounds, passes.iterations + done.iterations
        if done.best is None:
            return replace(done, rounds=passes.rounds, iterations=passes.iterations)
        passes.current = done.best
    coarse = passes.current
    if coarse.gear_changes <= windows.fine_up_to:
        passes.current = in_pieces(finer(case, coarse), PIECE)
        passes.settings = replace(inner, trust_region_m=_FINE_M, trust_region_rad=0.5 * _FINE_M)
        passes.through(0, windows.phases, windows.fine_stride)
        if not _sound(case, passes.current):
            passes.current = coarse
    return Exchanged(passes.current, passes.current, 0.0, passes.rounds, passes.iterations)


@dataclass(slots=True)
class _Pass:
    """Windows solved one after another; `current` is the manoeuvre with all answers so far in their places."""

    case: ParkingCase
    world: World
    costs: ParkingCosts
    settings: ExchangeSettings
    current: Manoeuvre
    iterations: int = 0
    rounds: int = 0

    def through(self, phase: int, phases: int, stride: int, only: list[tuple[int, int]] | None = None) -> list[tuple[int, int]]:
        """From `phase` on; with `only`, the windows that overlap one of those. Windows without an answer, by their phases."""
        unanswered: list[tuple[int, int]] = []
        while True:
            cusps = _cusps(self.current)
            if phase >= len(cusps) - 1:
                break
            begin, end = max(phase, 0), min(phase + phases, len(cusps) - 1)
            phase += stride
            if only is not None and not any(begin < until and since < end for since, until in only):
                continue
            if not self._window(cusps[begin], cusps[end]):
                unanswered.append((begin, end))
            if end == len(cusps) - 1:
                break
        return unanswered

    def _window(self, low: int, high: int) -> bool:
        """Whether the intervals from `low` to `high` have an answer, their ends fixed; the answer is put in where it is quicker."""
        current, case = self.current, self.case
        part = Manoeuvre(current.nodes[low : high + 1], current.steps[low:high], current.gears[low:high], current.segments[low:high])
        last = high == len(current.steps)
        piece = replace(
            case,
            start=part.nodes[0, :3],
            goal=case.goal if last else part.nodes[-1, :3],
            start_steering_rad=float(np.clip(part.nodes[0, 4], -case.vehicle.steering_max_rad, case.vehicle.steering_max_rad)),
        )
        done = exchange(piece, self.world, part, self.costs, self.settings, None if last else float(part.nodes[-1, 4]))
        self.iterations += done.iterations
        self.rounds += done.rounds
        better = done.best if done.best is not None and done.best.duration_s < part.duration_s else part
        self.current = _spliced(current, low, high, better)
        return done.best is not None


def _sound(case: ParkingCase, manoeuvre: Manoeuvre) -> bool:
    return is_sound(judge_parking(case, manoeuvre.trajectory(case)), case.limits.clearance_m)


def _cusps(manoeuvre: Manoeuvre) -> list[int]:
    """Nodes at rest where a gear ends: before the standstill that leads to the next gear; first and last node included."""
    found = [0]
    gear = 0.0
    for k, now in enumerate(manoeuvre.gears):
        if now != 0.0 and gear != 0.0 and now != gear:
            at = k
            while at > 0 and manoeuvre.gears[at - 1] == 0.0:
                at -= 1
            found.append(at)
        gear = now if now != 0.0 else gear
    return [*found, len(manoeuvre.steps)]


def _spliced(whole: Manoeuvre, low: int, high: int, part: Manoeuvre) -> Manoeuvre:
    """The part instead of the intervals from `low` to `high`; its segments stay apart from those around it."""
    nodes = np.concatenate([whole.nodes[:low], part.nodes, whole.nodes[high + 1 :]])
    steps = np.concatenate([whole.steps[:low], part.steps, whole.steps[high:]])
    gears = np.concatenate([whole.gears[:low], part.gears, whole.gears[high:]])
    behind = whole.segments[high:]
    shift = part.segments[-1] + 1 - behind[:1].sum()
    before = whole.segments[:low] - whole.segments[low - 1 : low].sum() + part.segments[0] - 1
    segments = np.concatenate([before, part.segments, behind + shift])
    return replace(whole, nodes=nodes, steps=steps, gears=gears, segments=segments)
