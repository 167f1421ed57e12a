"""Our planner at the wheel of highway-env's ego, against its own IDM/MOBIL agent, on the same seeded episodes.

    pip install 'mcdas-opt[gym]'
    python benchmarks/highway.py --episodes 200 --vehicles 25 --frequency 10 --workers 2 --out /tmp/highway.jsonl

A row is an episode and an agent; rows that are already in --out are not driven again. The ego begins behind everybody, so that of 25 cars
it meets as many as of highway-v0's 50. Collisions are counted whoever is to blame. Time gaps: of the time behind somebody (4 s or less),
the share under 0.8 and 0.5 s that no cut-in had made, and the least.
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

from mcdas_opt.evaluation.statistics import Pairs, Share
from mcdas_opt.interop.gym.highway import CYCLE_S, EpisodeSettings, HighwayDriver, episode, make_highway
from mcdas_opt.simulation.ordinary import HEADWAYS_S

AGENTS = ("mpc", "idm-mobil")
_SEAT: dict[str, Any] = {}


def _drive(job: tuple[int, str, EpisodeSettings]) -> dict[str, Any]:
    seed, agent, settings = job
    if not _SEAT:
        _SEAT.update(env=make_highway(settings), driver=HighwayDriver())
    done = episode(_SEAT["env"], seed, _SEAT["driver"] if agent == "mpc" else None)
    return asdict(done)


def _rows(jobs: list[tuple[int, str, EpisodeSettings]], workers: int) -> Iterator[dict[str, Any]]:
    if workers == 1:
        yield from map(_drive, jobs)
        return
    with multiprocessing.get_context("spawn").Pool(workers) as pool:
        yield from pool.imap_unordered(_drive, jobs)


def report(rows: list[dict[str, Any]]) -> str:
    lines = [
        "agent       collisions  95 % interval   off road  mean speed  lane changes  under 0.8 s  under 0.5 s  least gap  "
        "fallback / unavoidable / unverified"
    ]
    for agent in AGENTS:
        mine = [row for row in rows if row["agent"] == agent]
        if not mine:
            continue
        hit = Share(k=sum(row["collided"] for row in mine), n=len(mine))
        low, high = hit.interval
        speed = sum(row["mean_speed_mps"] for row in mine) / len(mine)
        counts = [sum(row[name] or 0 for row in mine) for name in ("fallbacks", "unavoidable", "unverified_plans")]
        plans = " / ".join(map(str, counts)) if agent == "mpc" else "-"
        driven = [row["ordinary"] for row in mine]
        following = max(sum(one["following_s"] for one in driven), CYCLE_S)
        shares = {limit: sum(one["short_headway_s"][k] for one in driven) / following for k, limit in enumerate(HEADWAYS_S)}
        least = min((one["least_headway_s"] for one in driven if one["least_headway_s"] is not None), default=math.inf)
        lines.append(
            f"{agent:<10}  {hit.k:>4}/{hit.n:<5}  {low:.3f} .. {high:.3f}  {sum(not row['on_road'] for row in mine):>8}  "
            f"{speed:>6.2f} m/s  {sum(row['lane_changes'] for row in mine):>12}  "
            f"{100 * shares[0.8]:>9.2f} %  {100 * shares[0.5]:>9.2f} %  {least:>7.2f} s  {plans}"
        )
    hits = {(row["agent"], row["seed"]): row["collided"] for row in rows}
    pairs = [(hits["mpc", seed], hits["idm-mobil", seed]) for agent, seed in hits if agent == "mpc" and ("idm-mobil", seed) in hits]
    ours, theirs = sum(a and not b for a, b in pairs), sum(b and not a for a, b in pairs)
    compared = Pairs(first="mpc", second="idm-mobil", n=len(pairs), only_first=ours, only_second=theirs)
    lines.append(f"pairs {len(pairs)}: only mpc collided {ours}, only idm-mobil {theirs}; McNemar p = {compared.p:.3g}")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--episodes", type=int, default=200)
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--duration", type=float, default=40.0, help="of an episode [s]")
    parser.add_argument("--vehicles", type=int, default=50)
    parser.add_argument("--frequency", type=int, default=20, help="of highway-env's simulation [Hz], a multiple of 10")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--out", type=Path, default=None, help="rows as JSON lines, grown and resumed")
    arguments = parser.parse_args()
    settings = EpisodeSettings(duration_s=arguments.duration, vehicles=arguments.vehicles, frequency_hz=arguments.frequency)
    rows: list[dict[str, Any]] = []
    if arguments.out is not None and arguments.out.is_file():
        rows = [json.loads(line) for line in arguments.out.read_text("utf-8").splitlines()]
    done = {(row["seed"], row["agent"]) for row in rows}
    seeds = range(arguments.first_seed, arguments.first_seed + arguments.episodes)
    jobs = [(seed, agent, settings) for seed in seeds for agent in AGENTS if (seed, agent) not in done]
    for row in _rows(jobs, arguments.workers):
        rows.append(row)
        if arguments.out is not None:
            with arguments.out.open("a", encoding="utf-8") as file:
                file.write(json.dumps(row) + "\n")
    print(report(sorted(rows, key=lambda row: (row["seed"], row["agent"]))))


if __name__ == "__main__":
    main()
