"""A lane that ends beside a column: does the host find a gap, how fast does it merge, and who has to brake for it?

    python -m benchmarks.merging --seeds 16,17,18 [--scenes 26] [--workers 1] [--out NEW.json] [--against OLD.json]

Two lanes, of which the host's ends, on either side, 8 to 20 s ahead at the host's speed (10 to 33 m/s; it wants up to 5 m/s more).
Beside it up to 14 vehicles at 10 to 30 m/s, 0.8 to 2.5 s apart: in every other scene they drive by the Intelligent Driver Model, and make
room for whoever is ahead of them, in the others they hold their speed. Counted are drives that merge, those that stand still before their
lane's end, contacts and fallback cycles; told are the speed while merging and the hardest braking of the follower, as long as it follows
the host. `--against` pairs with what an earlier run has put `--out`, McNemar's test beside it.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.cli.progress import progress_bar
from mcdas_opt.evaluation.statistics import Pairs, Share
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.record import Outcome, Simulation

LANE_M, TAPER_M, LENGTH_M, VEHICLES = 3.7, 60.0, 4.6, 14
STANDING_MPS = 0.5
FARTHEST_BEHIND_M = -390.0  # that a scene may hold
FOLLOWED_S = 6.0  # after the host is in the lane: until then a follower's braking is for it
_SLOWEST_MPS, _LATER_S, _LONGEST_S = 9.0, 5.0, 48.0  # the drive is over so long after such a host would be at the end


@dataclass(frozen=True, slots=True, kw_only=True)
class Merging:
    """One drive: what it was, and what came of it."""

    seed: int
    index: int
    reacts: bool
    host_mps: float
    column_mps: float
    end_m: float
    merged_at_mps: float | None
    stood: bool
    contact: bool
    fallbacks: int
    plans: int
    hardest_mps2: float


def scene(index: int, seed: int) -> Scene:
    """The drive of that number."""
    rng = np.random.default_rng([seed, index])
    host_mps, column_mps = float(rng.uniform(10.0, 33.0)), float(rng.uniform(10.0, 30.0))
    side, end_m = ("left", "right")[int(rng.integers(2))], host_mps * float(rng.uniform(8.0, 20.0)) + TAPER_M
    gaps = LENGTH_M + column_mps * rng.uniform(0.8, 2.5, VEHICLES)
    overtakes_m = end_m * (1.0 - column_mps / host_mps)  # of the column, at constant speed: its middle is near the host by then
    places = np.cumsum(gaps) - 0.5 * gaps.sum() + float(rng.uniform(0.0, 1.0)) * overtakes_m
    document = {
        "name": f"merging-{seed}-{index}",
        "duration_s": min(end_m / max(min(host_mps, column_mps), _SLOWEST_MPS) + _LATER_S, _LONGEST_S),
        "seed": index,
        "road": {
            f"lanes_{side}": 1,
            "lane": [{"lane": 0, "width_m": [[end_m - TAPER_M, LANE_M], [end_m, 0.0]], "merges": side}],
        },
        "host": {"speed_mps": host_mps, "desired_speed_mps": host_mps + float(rng.uniform(0.0, 5.0))},
        "neighbour": [
            {
                "name": f"v{k}",
                "s_m": float(place),
                "d_m": LANE_M if side == "left" else -LANE_M,
                "speed_mps": column_mps,
                "length_m": LENGTH_M,
                "behaviour": "scripted" if index % 2 else "idm",
            }
            for k, place in enumerate(places)
            if place > FARTHEST_BEHIND_M
        ],
    }
    return Scene.model_validate(document)


def driven(which: tuple[int, int]) -> Merging:
    """The drive of that seed and number."""
    seed, index = which
    drawn = scene(index, seed)
    drive = simulate(drawn)
    host = drive.trajectory
    is_there = np.abs(host.d_m) > 0.5 * LANE_M
    crossed = int(np.argmax(is_there)) if is_there.any() else None
    return Merging(
        seed=seed,
        index=index,
        reacts=drawn.neighbour[0].behaviour == "idm",
        host_mps=drawn.host.speed_mps,
        column_mps=drive.neighbours[0].speed_mps[0].item(),
        end_m=drawn.true_road.lanes[0].width_m[-1][0],
        merged_at_mps=None if crossed is None else float(host.speed_mps[crossed]),
        stood=bool((host.speed_mps[:crossed] < STANDING_MPS).any()),
        contact=drive.outcome is not Outcome.SAFE,
        fallbacks=drive.fallbacks + drive.unavoidable,
        plans=drive.plans,
        hardest_mps2=0.0 if crossed is None else hardest_braking_mps2(drive, crossed),
    )


def hardest_braking_mps2(drive: Simulation, crossed: int) -> float:
    """Of who is next behind in the column when the host's centre comes into its lane, from then on."""
    host = drive.trajectory
    behind = [one for one in drive.neighbours if one.s_m[crossed] < host.s_m[crossed]]
    if not behind:
        return 0.0
    follower = max(behind, key=lambda one: one.s_m[crossed])
    ahead = slice(crossed, int(np.searchsorted(host.t_s, host.t_s[crossed] + FOLLOWED_S)))
    speeds, times = follower.speed_mps[ahead], host.t_s[ahead]
    return max([0.0, *(-np.diff(speeds) / np.diff(times)).tolist()])


def told(name: str, drives: Sequence[Merging]) -> str:
    """One line of the table."""
    merged = Share(k=sum(one.merged_at_mps is not None for one in drives), n=len(drives))
    low, high = merged.interval
    shares = [one.merged_at_mps / one.column_mps for one in drives if one.merged_at_mps is not None]
    hardest = [one.hardest_mps2 for one in drives if one.merged_at_mps is not None and one.reacts]
    return (
        f"{name:8s} merged {merged.k} of {merged.n} [{100 * low:.0f}, {100 * high:.0f} %], without standing"
        f" {sum(one.merged_at_mps is not None and not one.stood for one in drives)}; stood {sum(one.stood for one in drives)};"
        f" contacts {sum(one.contact for one in drives)}; fallback cycles {sum(one.fallbacks for one in drives)} of"
        f" {sum(one.plans for one in drives)}; merging speed, of the column's: median {np.median(shares):.2f}, least {min(shares):.2f};"
        f" followers brake: median {np.median(hardest):.1f}, p90 {np.quantile(hardest, 0.9):.1f}, hardest {max(hardest):.1f} m/s^2"
    )


def paired(old: Sequence[Merging], new: Sequence[Merging]) -> str:
    """Of the same drives, before and since: which merge without having stood."""
    before = {(one.seed, one.index): one.merged_at_mps is not None and not one.stood for one in old}
    since = {(one.seed, one.index): one.merged_at_mps is not None and not one.stood for one in new}
    both = sorted(before.keys() & since.keys())
    gained, lost = [key for key in both if since[key] > before[key]], [key for key in both if since[key] < before[key]]
    p = Pairs(first="old", second="new", n=len(both), only_first=len(lost), only_second=len(gained)).p
    return f"paired {len(both)}, merged without standing: gained {len(gained)} {gained}, lost {len(lost)} {lost}, McNemar p = {p:.2g}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="1")
    parser.add_argument("--scenes", type=int, default=26)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--against", type=Path)
    args = parser.parse_args()
    wanted = [(int(seed), index) for seed in args.seeds.split(",") for index in range(args.scenes)]
    drives: list[Merging] = []
    with multiprocessing.get_context("spawn").Pool(args.workers) as pool, progress_bar("drives") as progress:
        for one in pool.imap(driven, wanted):
            drives.append(one)
            progress(len(drives), len(wanted))
    if args.out is not None:
        args.out.write_text(json.dumps([asdict(one) for one in drives], indent=1) + "\n", "utf-8")
    for one in drives:
        print(one)
    print(told("all", drives))
    if args.against is not None:
        old = [Merging(**one) for one in json.loads(args.against.read_text("utf-8"))]
        print(told("against", old))
        print(paired(old, drives))


if __name__ == "__main__":
    main()
