"""Records how SUMO's own driver drives in the shipped motorway: the leaders of the suite `ordinary`.

    pip install 'mcdas-opt[sumo]'
    python benchmarks/recorded_leaders.py --seeds 11,12,13 --out benchmarks/suites/leaders

A file a seed: t_s, speed_mps, every half second, from the ego's departure to its arrival.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from mcdas_opt.interop.sumo.episode import EpisodeSettings, drive, sumo_config

EVERY = 5  # steps of 0.1 s


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="11,12,13")
    parser.add_argument("--config", default="motorway")
    parser.add_argument("--out", type=Path, default=Path("benchmarks/suites/leaders"))
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    settings = EpisodeSettings(config=sumo_config(arguments.config), ego="ego")
    for seed in map(int, arguments.seeds.split(",")):
        driven = drive(settings, seed, "sumo").snapshots[::EVERY]
        begin = driven[0].time_s
        lines = [f"{one.time_s - begin:.1f},{one.host.speed_mps:.2f}" for one in driven]
        (arguments.out / f"{arguments.config}-{seed}.csv").write_text("\n".join(["t_s,speed_mps", *lines]) + "\n", "utf-8")


if __name__ == "__main__":
    main()
