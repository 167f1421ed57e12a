"""Long zigzags, a window of phases at a time with its ends held; windows overlap, so that what one holds the next one frees."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.ocp.parking_records import ParkingCosts
from mcdas_opt.planning.parking.exchange import Exchanged, ExchangeSettings, exchange
from mcdas_opt.planning.parking.manoeuvre import Manoeuvre
from mcdas_opt.planning.parking.world import World
from mcdas_opt.verification.parking_judge import judge_parking


@dataclass(frozen=True, slots=True, kw_only=True)
class WindowSettings:
    """A window holds `phases` gears and the next one starts `stride` gears later. Passes after the first cut elsewhere, and only where a
    window had no answer.
    """

    whole_up_to: int = 24  # gear changes that are still solved in one piece
    phases: int = 14
    stride: int = 8
    passes: int = 2
    rounds: int = 4
    rounds_unsound: int = 6
    closing_m: float = 0.1  # trust of the whole at the end, where the windows do not fit together


def improve(
    case: ParkingCase, world: World, first: Manoeuvre, costs: ParkingCosts, settings: ExchangeSettings, windows: WindowSettings
) -> Exchanged:
    """The exchange loop over the whole manoeuvre, or over windows of it when it has many gears."""
    if first.gear_changes <= windows.whole_up_to:
        return exchange(case, world, first, costs, settings)
    current, iterations, rounds = first, 0, 0
    settings = replace(settings, restarts=0, nearly_later_m=settings.nearly_m)  # in slots that leave millimetres, neither helps
    inner = replace(settings, rounds=windows.rounds, rounds_unsound=windows.rounds_unsound)
    unanswered: list[tuple[int, int]] = []  # windows, by their phases
    for number in range(windows.passes):
        again, unanswered = unanswered, []
        phase = 0 if number == 0 else -(windows.stride // 2)  # the second pass cuts elsewhere
        while True:
            cusps = _cusps(current)
            if phase >= len(cusps) - 1:
                break
            begin, end = max(phase, 0), min(phase + windows.phases, len(cusps) - 1)
            phase += windows.stride
            if number > 0 and not any(begin < until and since < end for since, until in again):
                continue
            low, high = cusps[begin], cusps[end]
            part = Manoeuvre(
                current.nodes[low : high + 1], current.steps[low:high], current.gears[low:high], current.segments[low:high], current.name
            )
            piece = replace(
                case,
                start=part.nodes[0, :3],
                goal=case.goal if high == len(current.steps) else part.nodes[-1, :3],
                start_steering_rad=float(np.clip(part.nodes[0, 4], -case.vehicle.steering_max_rad, case.vehicle.steering_max_rad)),
            )
            last = high == len(current.steps)
            done = exchange(piece, world, part, costs, inner, None if last else float(part.nodes[-1, 4]))
            iterations += done.iterations
            rounds += done.rounds
            better = done.best if done.best is not None and done.best.duration_s < part.duration_s else part
            if done.best is None:
                unanswered.append((begin, end))
            current = _spliced(current, low, high, better)
            if last:
                break
    if judge_parking(case, current.trajectory(case)).verdict.passed:
        return Exchanged(current, current, 0.0, rounds, iterations)
    closed = replace(settings, rounds=2, rounds_unsound=5, trust_m=windows.closing_m, trust_rad=0.5 * windows.closing_m)
    done = exchange(case, world, current, costs, closed)  # windows without an answer leave gaps of millimetres that add up
    return replace(done, rounds=done.rounds + rounds, iterations=done.iterations + iterations)


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
