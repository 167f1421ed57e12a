"""False alerts on ordinary following: `python benchmarks/escape_alerts.py [--platoon FOLDER] [--scenes N] [--every K]`.

Recorded platoons (five cars one behind the other, 10 Hz): every inner car is the host once, with the car ahead and the car behind as
its tracks; nobody was ever in danger, so that every alert is a false one. And the benign suite in closed loop, sensors and all.
"""

from __future__ import annotations

import argparse
import csv
from collections import Counter
from pathlib import Path

import numpy as np

from mcdas_opt import simulate
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import WarningSettings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Alert
from mcdas_opt.evaluation.families import load_family
from mcdas_opt.time_to_react.alert import alert
from mcdas_opt.time_to_react.escapes import escapes

_SMOOTH = 5  # samples over which the host's acceleration is taken


def platoon(path: Path, settings: WarningSettings, every: int) -> Counter[str]:
    """Alerts of every inner car of one recording; two lanes beside, which nobody uses, would only make it easier, so there are none."""
    with path.open() as file:
        rows = [{k: float(v) for k, v in row.items() if v} for row in csv.DictReader(file)]
    told: Counter[str] = Counter()
    vehicle, road = Vehicle(), Road()
    for host in (2, 3, 4):
        before = Alert.NONE
        for k in range(_SMOOTH, len(rows), every):
            row = rows[k]
            columns = [f"veh{n}_{c}" for n in (host - 1, host, host + 1) for c in "xyv"]
            if any(not np.isfinite(row.get(c, np.nan)) for c in columns):
                continue
            ahead, behind = (float(np.hypot(*(row[f"veh{host}_{c}"] - row[f"veh{n}_{c}"] for c in "xy"))) for n in (host - 1, host + 1))
            past = rows[k - _SMOOTH]
            pace = max(row[f"veh{host}_v"], 0.0)
            acceleration = (pace - past.get(f"veh{host}_v", pace)) / max(row["t"] - past["t"], 1e-3)
            situation = Situation(
                host=HostState(speed_mps=pace, acceleration_mps2=float(np.clip(acceleration, -8.0, 3.0))),
                coverage=Coverage(),
                tracks=(
                    Track(id="front", s_m=ahead, d_m=0.0, speed_s_mps=row[f"veh{host - 1}_v"]),
                    Track(id="rear", s_m=-behind, d_m=0.0, speed_s_mps=row[f"veh{host + 1}_v"]),
                ),
                road=road,
            )
            before = alert(escapes(situation, vehicle), settings, before)
            told[before] += 1
    return told


def benign(scenes: int, seed: int) -> Counter[str]:
    told: Counter[str] = Counter()
    for scene in load_family("benign").scenes(scenes, seed):
        told.update(cycle.plan.alert for cycle in simulate(scene).cycles)
    return told


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--platoon", type=Path, default=Path(__file__).resolve().parents[2] / "shared" / "data" / "cats_platoon")
    parser.add_argument("--scenes", type=int, default=10)
    parser.add_argument("--seed", type=int, default=3)
    parser.add_argument("--every", type=int, default=1)
    chosen = parser.parse_args()
    for path in sorted(chosen.platoon.glob("*.csv")):
        told = platoon(path, WarningSettings(), chosen.every)
        print(f"{path.name}: {sum(told.values())} cycles, {told[Alert.WARN]} warnings, {told[Alert.ACT]} interventions", flush=True)
    told = benign(chosen.scenes, chosen.seed)
    print(f"benign suite: {sum(told.values())} cycles, {told[Alert.WARN]} warnings, {told[Alert.ACT]} interventions")


if __name__ == "__main__":
    main()
