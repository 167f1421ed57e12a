"""Parking, measured: the slot sweep, the 84-start grid, TPCAP cases, random slots, mazes, leaving. Writes a CSV, prints a table.

    python benchmarks/parking.py slots [--ratios 1.6,1.4] [--planners nlp,search] [--out FILE.csv] [--draw FILE.png]
    python benchmarks/parking.py leaving [--ratios 1.6,1.4]
    python benchmarks/parking.py grid [--limits study|contract] [--every N]
    python benchmarks/parking.py tpcap FOLDER
    python benchmarks/parking.py random [--number 200] [--seed 1]
    python benchmarks/parking.py mazes
    python benchmarks/parking.py closed-forms

A planner is one of `park`'s, or the program in a variant: nlp:duals (the other form of the collision checks), nlp:two-arc, nlp:sigmoid,
nlp:continuation, nlp:one-more, nlp:plain (one kind of guess alone). Durations and paths repeat; seconds are the machine's: `cpu_s` where
others use it too. `--draw` makes the sweep's figure from the rows.
"""

from __future__ import annotations

import argparse
import csv
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mcdas_opt.domain.parking import Parking, ParkingCase
from mcdas_opt.errors import InputError
from mcdas_opt.evaluation.statistics import Share
from mcdas_opt.parking.case_file import load_parking_case, parking_case_from_document, slot_case
from mcdas_opt.parking.closed_form import CLOSED_FORMS
from mcdas_opt.parking.park import park
from mcdas_opt.parking.program.exchange import ExchangeSettings
from mcdas_opt.parking.settings import ParkSettings
from mcdas_opt.parking.shortest_slot import shortest_slot

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CAR_M = 4.5
WALL_M = float(np.hypot(4.5, 1.8)) + 0.1  # the sedan's diagonal and two clearances
RATIOS = (2.6, 2.2, 2.0, 1.8, 1.6, 1.5, 1.4, 1.35, 1.3, 1.25, 1.2, 1.15, 1.12, 1.1, 1.06)
PLANNERS = ("nlp", "search", "closed-form-corrected", "two-arc", "closed-form")
VARIANTS = {
    "nlp:duals": ParkSettings(exchange=ExchangeSettings(form="duals")),
    "nlp:plain": ParkSettings(guesses=("search",), polish_up_to=0, left_out=0, starts=1),
    "nlp:one-more": ParkSettings(guesses=("one-more",), polish_up_to=0, left_out=0),
    "nlp:two-arc": ParkSettings(guesses=("two-arc",), polish_up_to=0, left_out=0),
    "nlp:sigmoid": ParkSettings(guesses=("sigmoid",), polish_up_to=0, left_out=0),
    "nlp:continuation": ParkSettings(guesses=("continuation",), polish_up_to=0, left_out=0),
}
COLUMNS = (
    "case",
    "planner",
    "status",
    "duration_s",
    "gear_changes",
    "min_clearance_m",
    "first_s",
    "total_s",
    "cpu_s",
    "sound",
    "tried",
    "reason",
)
STUDY_VEHICLE = {
    "wheelbase_m": 2.7,
    "front_overhang_m": 1.0,
    "rear_overhang_m": 1.0,
    "width_m": 2.0,
    "steering_max_rad": 0.6,
    "steering_rate_max_radps": 0.6,
}


def slots(ratios: tuple[float, ...]) -> Iterator[tuple[str, ParkingCase]]:
    for ratio in ratios:
        yield f"{ratio:.2f} L", slot_case(ratio * CAR_M)


def grid(limits: str, every: int) -> Iterator[tuple[str, ParkingCase]]:
    """The 84 starts of the published OBCA study (Zhang, Liniger and Borrelli, IEEE TCST 2021)."""
    vehicle: dict[str, object] = dict(STUDY_VEHICLE)
    bounds: dict[str, float] = {"forward_mps": 2.0, "reverse_mps": 1.0, "acceleration_mps2": 0.4}
    if limits == "contract":
        vehicle |= {"steering_max_rad": 0.55, "steering_rate_max_radps": 0.5}
        bounds = {}
    walls = [
        [[-20.0, 0.0], [-3.0, 0.0], [-3.0, 5.0], [-20.0, 5.0]],
        [[3.0, 0.0], [20.0, 0.0], [20.0, 5.0], [3.0, 5.0]],
        [[-3.0, 0.0], [3.0, 0.0], [3.0, 2.5], [-3.0, 2.5]],
        [[-20.0, 11.0], [20.0, 11.0], [20.0, 12.0], [-20.0, 12.0]],
    ]
    starts = [(float(x), float(y)) for x in range(-10, 11) for y in (6.5, 7.5, 8.5, 9.5)]
    for x, y in starts[::every]:
        document = {
            "vehicle": vehicle,
            "start": {"x_m": x, "y_m": y, "heading_rad": 0.0},
            "goal": {"x_m": -1.35, "y_m": 4.0, "heading_rad": 0.0},
            "obstacle": [{"vertices_m": wall} for wall in walls],
            "limits": bounds,
        }
        yield f"({x:g}, {y:g})", parking_case_from_document(document)


def tpcap(folder: Path) -> Iterator[tuple[str, ParkingCase]]:
    for path in sorted(folder.glob("Case*.csv"), key=lambda p: int("".join(c for c in p.stem if c.isdigit()))):
        yield path.stem, load_parking_case(path, clearance_m=0.05)


def random_cases(number: int, seed: int) -> Iterator[tuple[str, ParkingCase]]:
    """Slots of 1.12 to 2 car lengths, depths, streets and starts drawn at random; drawn again when the start stands in something."""
    rng = np.random.default_rng(seed)
    made = 0
    while made < number:
        length = CAR_M * rng.uniform(1.12, 2.0)
        street = rng.uniform(3.5, 6.0)
        start = {"x_m": rng.uniform(-3.0, length + 4.0), "y_m": rng.uniform(1.0, street - 1.0), "heading_rad": rng.uniform(-0.4, 0.4)}
        slot = {"length_m": float(length), "depth_m": float(rng.uniform(2.0, 2.4)), "street_m": float(street)}
        try:
            case = parking_case_from_document({"slot": slot, "start": {k: float(v) for k, v in start.items()}})
        except InputError:
            continue
        made += 1
        yield f"{made}: {length / CAR_M:.2f} L", case


def leaving(ratios: tuple[float, ...]) -> Iterator[tuple[str, ParkingCase]]:
    for name, case in slots(ratios):
        yield name, replace(case, start=case.goal, goal=case.start)


def mazes() -> Iterator[tuple[str, ParkingCase]]:
    """Hard ones of our own: turning round in alleys (whose open ends are used, and closed), a chicane, a bay with 10 cm to either side,

    a right angle.
    """

    def box(x0: float, y0: float, x1: float, y1: float) -> list[list[float]]:
        return [[x0, y0], [x1, y0], [x1, y1], [x0, y1]]

    def alley(width: float) -> list[list[list[float]]]:
        return [box(-14.0, -1.0, 14.0, 0.0), box(-14.0, width, 14.0, width + 1.0)]

    def closed(width: float) -> list[list[list[float]]]:
        return [*alley(width), box(-15.0, -1.0, -14.0, width + 1.0), box(14.0, -1.0, 15.0, width + 1.0)]

    cases: dict[str, tuple[tuple[float, float, float], tuple[float, float, float], list[list[list[float]]]]] = {
        "turn round in 7 m": ((0.0, 3.5, 0.0), (2.7, 3.5, np.pi), alley(7.0)),
        "turn round in 6 m": ((0.0, 3.0, 0.0), (2.7, 3.0, np.pi), alley(6.0)),
        "turn round in 5.4 m": ((0.0, 2.7, 0.0), (2.7, 2.7, np.pi), alley(5.4)),
        "turn round in 6 m, both ends closed": ((0.0, 3.0, 0.0), (2.7, 3.0, np.pi), closed(6.0)),
        "turn round in 5.4 m, both ends closed": ((0.0, 2.7, 0.0), (2.7, 2.7, np.pi), closed(5.4)),
        "chicane": (
            (-4.0, 1.4, 0.0),
            (16.0, 1.4, 0.0),
            [*alley(6.0), box(4.0, 2.6, 4.4, 6.0), box(10.0, 0.0, 10.4, 3.4)],
        ),
        "bay of 2 m": (
            (-4.0, 2.4, 0.0),
            (0.0, -4.0, 0.5 * np.pi),
            [box(-9, -5, -1, 0), box(1, -5, 9, 0), box(-9, 4.8, 9, 5.5), box(-9, -6, 9, -5.1)],
        ),
        "right angle of 3 m": (
            (-7.0, 1.5, 0.0),
            (1.5, 7.0, 0.5 * np.pi),
            [box(-12.0, 3.0, 0.0, 14.0), box(-12.0, -1.0, 4.0, 0.0), box(3.0, 0.0, 4.0, 14.0)],
        ),
        "perpendicular bay of 2.4 m, aisle of 5.4 m": (
            (-5.0, 1.6, 0.0),
            (0.0, -3.9, 0.5 * np.pi),
            [box(-9, -5, -1.2, 0), box(1.2, -5, 9, 0), box(-9, 5.4, 9, 6.0), box(-9, -6, 9, -5.1)],
        ),
        "slot of 1.25 L against a wall": (
            (6.6, 1.4, 0.0),
            (1.46, -1.05, 0.0),
            [box(-6, -2.1, 0, 4.5), box(5.625, -2.1, 12, 0), box(-6, -2.6, 12, -2.1), box(-6, 4.5, 12, 5)],
        ),
        "slot of 1.3 L behind a pillar": (
            (7.5, 1.6, 0.0),
            (1.58, -1.05, 0.0),
            [box(-6, -2.1, 0, 0), box(5.85, -2.1, 14, 0), box(-6, -2.6, 14, -2.1), box(-6, 5, 14, 5.5), box(1.2, 3.2, 1.6, 3.6)],
        ),
        "dead end of 6.2 m, turned round": (
            (0.0, 3.1, 0.0),
            (0.0, 3.1, np.pi),
            [box(-14, -1, 6, 0), box(-14, 6.2, 6, 7.2), box(5.0, 0.0, 6.0, 6.2)],
        ),
    }
    for name, (start, goal, walls) in cases.items():
        ends = {
            key: dict(zip(("x_m", "y_m", "heading_rad"), map(float, pose), strict=True)) for key, pose in (("start", start), ("goal", goal))
        }
        yield (
            name,
            parking_case_from_document({**ends, "obstacle": [{"vertices_m": [[float(q) for q in v] for v in wall]} for wall in walls]}),
        )


def kind(row: dict[str, object]) -> str:
    """Why a case has no answer, as a class."""
    reason = str(row["reason"])
    if row["status"] == "planned":
        return "solved"
    if "proved impossible" in reason:
        return "proved impossible"
    return "every cell searched" if "every cell" in reason else "cap on nodes"


def row(name: str, planner: str, answer: Parking, cpu_s: float) -> dict[str, object]:
    programs = [a for a in answer.attempts if a.name.startswith("nlp")]
    return {
        "case": name,
        "planner": planner,
        "status": answer.status,
        "duration_s": None if answer.duration_s is None else round(answer.duration_s, 2),
        "gear_changes": answer.gear_changes,
        "min_clearance_m": None if answer.min_clearance_m is None else round(answer.min_clearance_m, 4),
        "first_s": round(answer.timing_ms["first"] / 1e3, 2),
        "total_s": round(answer.timing_ms["total"] / 1e3, 2),
        "cpu_s": round(cpu_s, 2),
        "sound": sum(a.passed for a in programs),
        "tried": len(programs),
        "reason": answer.reason,
    }


def slot_sweep(rows: list[dict[str, str]], shortest_m: dict[str, float | None], car_m: float, wall_m: float | None = None) -> Figure:
    """Driving time over slot length for each planner (rows as they are written), and where each closed form gives up.

    `shortest_m` is the shortest slot of each closed form, `wall_m` that of a rectangle that turns on the spot; lengths are shown in car
    lengths.
    """
    from mcdas_opt.plotting import style

    colours = {"nlp": style.BLUE, "search": style.ORANGE, "two-arc": style.GREEN, "closed-form-corrected": style.PURPLE}
    colours["closed-form"] = style.VERMILION
    markers = {"nlp": "o", "search": "s"}
    with style.styled():
        fig = style.figure(8.4, 4.6)
        axes = fig.subplots()
        for planner in markers:
            good = [r for r in rows if r["planner"] == planner and r["status"] == "planned"]
            points = sorted((float(r["case"].split()[0]), float(r["duration_s"])) for r in good)
            axes.plot(*np.array(points).reshape(-1, 2).T, marker=markers[planner], ms=5, color=colours[planner], label=planner)
        for planner, length in shortest_m.items():
            if length is not None:
                axes.axvline(length / car_m, color=colours[planner], ls="--", lw=1.4, label=f"{planner} needs {length / car_m:.2f} L")
        if wall_m is not None:
            axes.axvline(wall_m / car_m, color=style.GREY, lw=1.4, label=f"turning on the spot needs {wall_m / car_m:.2f} L")
        axes.set_yscale("log")
        axes.set_xlabel("slot length [car lengths]")
        axes.set_ylabel("driving time [s]")
        axes.set_title("Parallel slots: who parks where, and how fast")
        axes.legend(loc="upper right", bbox_to_anchor=(0.93, 1.0))
    return fig


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("suite", choices=("slots", "leaving", "grid", "tpcap", "random", "mazes", "closed-forms"))
    parser.add_argument("folder", nargs="?", type=Path, default=Path("../shared/data/tpcap"))
    parser.add_argument("--ratios", default=",".join(str(r) for r in RATIOS))
    parser.add_argument("--planners", default=None)
    parser.add_argument("--limits", choices=("study", "contract"), default="contract")
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--number", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=None)
    parser.add_argument("--draw", type=Path, default=None)
    arguments = parser.parse_args()
    if arguments.suite == "closed-forms":
        for name in CLOSED_FORMS:
            length = shortest_slot(name)
            print(f"{name}: {'none up to 20 m' if length is None else f'{length:.2f} m = {length / CAR_M:.2f} L'}")
        return
    suites = {
        "leaving": lambda: leaving(tuple(float(r) for r in arguments.ratios.split(","))),
        "mazes": mazes,
        "slots": lambda: slots(tuple(float(r) for r in arguments.ratios.split(","))),
        "grid": lambda: grid(arguments.limits, arguments.every),
        "tpcap": lambda: tpcap(arguments.folder),
        "random": lambda: random_cases(arguments.number, arguments.seed),
    }
    default = ",".join(PLANNERS) if arguments.suite == "slots" else "nlp"
    rows = []
    for name, case in suites[arguments.suite]():
        for planner in (arguments.planners or default).split(","):
            begin = time.process_time()
            answer = park(replace(case, name=name), planner.split(":")[0], settings=VARIANTS.get(planner))
            rows.append(row(name, planner, answer, time.process_time() - begin))
            print(*(rows[-1][column] for column in COLUMNS), sep=" | ", flush=True)
    for planner in dict.fromkeys(str(r["planner"]) for r in rows):
        own = [r for r in rows if r["planner"] == planner]
        classes = {name: sum(kind(r) == name for r in own) for name in dict.fromkeys(kind(r) for r in own)}
        low, high = Share(k=classes.get("solved", 0), n=len(own)).interval
        first, cpu = (sorted(float(str(r[column])) for r in own) for column in ("first_s", "cpu_s"))
        half = len(own) // 2
        print(
            f"{planner}: {classes.get('solved', 0)}/{len(own)} [{low:.3f}, {high:.3f}] {classes}; first answer median {first[half]:.2f} s, "
            f"worst {first[-1]:.2f} s; computing median {cpu[half]:.2f} s, worst {cpu[-1]:.2f} s"
        )
    if arguments.out is not None:
        with arguments.out.open("w", newline="") as file:
            writer = csv.DictWriter(file, COLUMNS)
            writer.writeheader()
            writer.writerows(rows)
    if arguments.draw is not None:
        from mcdas_opt.plotting.style import save_png

        text = [{key: str(value) for key, value in r.items()} for r in rows]
        save_png(slot_sweep(text, {name: shortest_slot(name) for name in CLOSED_FORMS}, CAR_M, WALL_M), arguments.draw)


if __name__ == "__main__":
    main()
