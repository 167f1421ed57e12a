"""What the table says: shares with their intervals, distributions, and planners compared pair by pair; one kind of traffic at a time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations
from typing import Any

import numpy as np

from mcdas_opt.evaluation.case import Traffic
from mcdas_opt.evaluation.statistics import Pairs, Share, quantiles

Record = dict[str, Any]
Test = Callable[[Record], bool]

SHORT_S = 0.5  # of a drive: less is not counted as following too closely, or as beyond ISO 15622
FACES = ("front", "rear", "side")
DISTRIBUTIONS = (
    "min_clearance_m",
    "min_ttc_front_s",
    "min_ttc_rear_s",
    "max_lateral_acceleration_mps2",
    "max_deceleration_mps2",
    "max_jerk_mps3",
    "max_steering_rate_radps",
    "settling_error_m",
    "least_headway_s",
    "outside_iso_s",
)


def failed(row: Record) -> bool:
    """The planner raised, hung or took its process with it."""
    return bool(row["ended"] != "drove")


def collided(row: Record) -> bool:
    """Whoever does not answer is counted as if it had hit: else failing would be a way to look safe."""
    return row["outcome"] == "collision" or failed(row)


def lost(row: Record) -> bool:
    """Not driven safely to the end: a collision, a departure from the road, or a failure."""
    return bool(row["outcome"] != "safe")


def _hits(face: str) -> Test:
    return lambda row: bool(row["hit"] == face)


def summarise(
    rows: Sequence[Record], cycles_ms: Sequence[Sequence[float]], took_s: Sequence[float], planners: Sequence[str]
) -> dict[str, Any]:
    """By planner: figures for each kind of traffic that there is, the cycle time over all of its plans, and its drives per second."""
    found: dict[str, Any] = {}
    for planner in planners:
        mine = [row for row in rows if row["planner"] == planner]
        times = [ms for row, cycles in zip(rows, cycles_ms, strict=True) if row["planner"] == planner for ms in cycles]
        found[planner] = {kind: figures([row for row in mine if row["traffic"] == kind]) for kind in kinds(rows)}
        took = [s for row, s in zip(rows, took_s, strict=True) if row["planner"] == planner and s > 0.0]
        found[planner]["cycle_ms"] = cycle_figures(times) | {"drives_per_s": len(took) / sum(took) if took else None}
    return found


def kinds(rows: Sequence[Record]) -> list[str]:
    return [kind.value for kind in Traffic if any(row["traffic"] == kind.value for row in rows)]


def figures(rows: Sequence[Record]) -> dict[str, Any]:
    """Of one planner in one kind of traffic."""
    avoidable = with_label(rows, "A")
    shares: dict[str, Share] = {
        "collisions_on_A": share(avoidable, collided),
        "collisions_on_A_or_undecided": share(with_label(rows, "A?"), collided),
        "collisions_on_C": share(with_label(rows, "C"), collided),
        "collisions_on_U": share(with_label(rows, "U"), collided),
        "collisions_on_A_late": share(with_label(rows, "A", "label_late"), collided),
        "lost_on_A": share(avoidable, lost),
        "lost_on_A_with_room": share(with_label(rows, "A", "label_with_room"), lost),
        "collisions": share(rows, collided),
        "lost": share(rows, lost),
        **{f"{face}_hits": share(rows, _hits(face)) for face in FACES},
        **{f"{face}_hits_on_A": share(avoidable, _hits(face)) for face in FACES},
        "road_departures": share(rows, lambda row: row["outcome"] == "left_road"),
        "road_departures_on_A": share(avoidable, lambda row: row["outcome"] == "left_road"),
        "false_interventions": share([row for row in rows if row["nominal"]], lambda row: bool(row["intervention"]) or failed(row)),
        "short_headways": _longer(rows, "short_headway_s"),
        "beyond_iso": _longer([row for row in rows if row["nominal"]], "outside_iso_s"),
        "followers_braked": Share(k=sum(row["followers_braked"] for row in rows), n=sum(row["lane_changes"] for row in rows)),
        "ordinary_again": share([row for row in rows if row["ordinary_again"] is not None], lambda row: bool(row["ordinary_again"])),
        "failures": share(rows, failed),
        "unverified_plans": Share(k=sum(row["unverified_plans"] for row in rows), n=sum(row["plans"] for row in rows)),
        "fallback_plans": Share(k=sum(row["fallbacks"] for row in rows), n=sum(row["plans"] for row in rows)),
    }
    impacts = [row["impact_speed_mps"] for row in with_label(rows, "U") if row["outcome"] == "collision"]
    families = {
        name: {
            "collisions_on_A": share(with_label(part, "A"), collided).to_dict(),
            "lost_on_A": share(with_label(part, "A"), lost).to_dict(),
            "collisions": share(part, collided).to_dict(),
            "lost": share(part, lost).to_dict(),
        }
        for name, part in by_family(rows).items()
    }
    return {
        "scenes": len(rows),
        "labels": {letter: len(with_label(rows, letter)) for letter in ("A", "C", "U", "?", "-")},
        **{name: value.to_dict() for name, value in shares.items()},
        "impact_speed_on_U_mps": quantiles(impacts),
        **{name: quantiles([row[name] for row in rows]) for name in DISTRIBUTIONS},
        "families": families,
    }


def _longer(rows: Sequence[Record], column: str) -> Share:
    """Drives in which it lasted for more than SHORT_S."""
    return share([row for row in rows if row[column] is not None], lambda row: bool(row[column] > SHORT_S))


def pairs(rows: Sequence[Record], planners: Sequence[str]) -> list[dict[str, Any]]:
    """Exact McNemar for each two planners: losses on A, and losses on every scene, apart for each kind of traffic."""
    found = []
    for kind in kinds(rows):
        of_kind = [row for row in rows if row["traffic"] == kind]
        for measure, letters in (("lost on A", "A"), ("lost", None)):
            chosen = of_kind if letters is None else with_label(of_kind, letters)
            for first, second in combinations(planners, 2):
                one = {row["index"]: lost(row) for row in chosen if row["planner"] == first}
                two = {row["index"]: lost(row) for row in chosen if row["planner"] == second}
                both = one.keys() & two.keys()
                pair = Pairs(
                    first=first,
                    second=second,
                    n=len(both),
                    only_first=sum(one[k] and not two[k] for k in both),
                    only_second=sum(two[k] and not one[k] for k in both),
                )
                if pair.n:
                    found.append({"traffic": kind, "measure": measure, **pair.to_dict()})
    return found


def cycle_figures(times_ms: Sequence[float]) -> dict[str, Any]:
    """Wall-clock time of a plan, and plans per second of planning."""
    found = quantiles(times_ms, (0.5, 0.99, 0.999))
    total = float(np.sum(times_ms))
    return {**found, "plans_per_s": 1e3 * len(times_ms) / total if total > 0.0 else None}


def contradictions(rows: Sequence[Record]) -> list[Record]:
    """Drives that were safe where the oracle has proven that nobody can be: a fault of the oracle."""
    return [row for row in rows if row["label"] == "U" and row["outcome"] == "safe"]


def worst(rows: Sequence[Record], planner: str, count: int = 20) -> list[Record]:
    """A planner's worst scenes: avoidable ones first, failures and collisions by impact speed, then departures, then narrow escapes."""
    order = {letter: rank for rank, letter in enumerate("A?-CU")}

    def key(row: Record) -> tuple[Any, ...]:
        clearance = row["min_clearance_m"]
        fate = 0 if collided(row) else 1 if lost(row) else 2
        severity = -(row["impact_speed_mps"] or 0.0) if fate < 2 else (1e9 if clearance is None else clearance)
        return fate == 2, order[row["label"]] if fate < 2 else 0, fate, severity, row["index"]

    return sorted((row for row in rows if row["planner"] == planner), key=key)[:count]


def with_label(rows: Sequence[Record], letters: str, column: str = "label") -> list[Record]:
    return [row for row in rows if row[column] in letters]


def by_family(rows: Sequence[Record]) -> dict[str, list[Record]]:
    found: dict[str, list[Record]] = {}
    for row in rows:
        found.setdefault(row["family"], []).append(row)
    return found


def share(rows: Sequence[Record], test: Test) -> Share:
    return Share(k=sum(1 for row in rows if test(row)), n=len(rows))
