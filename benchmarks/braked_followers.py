"""Who brakes hard after a lane change in SUMO's traffic: would he have braked as hard had the host kept its lane?

    python -m benchmarks.braked_followers --seeds 271-311 [--config motorway] [--drivers mpc,sumo] [--workers 1] [--out FILE.json]

Each seed is driven once. Then, for each of its lane changes that has a follower, SUMO is run again from the start with the same seed and
the host is put where it was, step by step: the same traffic comes about. Run once like this, it shows that it does ("again"). Run once
more, the host stays where it was across the road from where it begins to move over, as far along the road as it was ("kept"). A follower
who brakes by more than 4 m/s^2 in the lane change's seconds, and not in the same seconds of the run in which the host kept its lane, was
made to brake by the lane change.
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

from mcdas_opt.cli.progress import progress_bar
from mcdas_opt.cli.sumo import seeds_of
from mcdas_opt.evaluation.statistics import Pairs, Share
from mcdas_opt.interop.sumo.connection import Connection, started
from mcdas_opt.interop.sumo.driver import SUMO, SumoDriver
from mcdas_opt.interop.sumo.episode import EpisodeSettings, sumo_config, wait_for
from mcdas_opt.simulation.ordinary import HARD_MPS2, WATCHED_S, Snapshot, instant, lane_changes

STILL_M = 0.004  # a step in which the host moves less across the road is before it changes lanes
ANOTHER_LANE_M = 1.0  # who is so much farther across the road a step later is counted from another lane


@dataclass(frozen=True, slots=True, kw_only=True)
class Braking:
    """The hardest braking of a lane change's follower [m/s^2]: as driven, as run again, and had the host kept its lane. `time_s` and
    `gap_m` are of when the host's centre crosses the line; `mode` is the plan's then."""

    seed: int
    driver: str
    time_s: float
    mode: str
    follower: str
    gap_m: float
    host_mps: float
    follower_mps: float
    driven_mps2: float
    again_mps2: float
    kept_mps2: float


@dataclass(frozen=True, slots=True)
class Pose:
    """As `moveToXY` takes it: where the front is [m], and the compass's heading [deg]."""

    x_m: float
    y_m: float
    angle_deg: float

    def beside(self, left_m: float, road_yaw_rad: float) -> Pose:
        """The same, so much to the left across the road, and along it."""
        x_m, y_m = self.x_m - left_m * math.sin(road_yaw_rad), self.y_m + left_m * math.cos(road_yaw_rad)
        return Pose(x_m, y_m, 90.0 - math.degrees(road_yaw_rad))


def brakings(settings: EpisodeSettings, seed_and_driver: tuple[int, str]) -> tuple[int, list[Braking]]:
    """How many lane changes a drive has, and of those with a follower what he does."""
    seed, driver = seed_and_driver
    snapshots, poses = _driven(settings, seed, driver)
    instants = [instant(one.time_s, one.host, one.others) for one in snapshots]
    changes = list(lane_changes(instants))
    found = []
    for change in changes:
        if change.follower is None:
            continue
        now = snapshots[change.index]
        follower = next(other for other in now.others if other.id == change.follower)
        watched = [k for k, one in enumerate(snapshots) if WATCHED_S[0] <= one.time_s - now.time_s <= WATCHED_S[1]]
        begins = _begins(snapshots, change.index)
        hardest = partial(_hardest, settings, seed, change.follower, watched)
        taken_over = 0 if driver != SUMO else begins
        found.append(
            Braking(
                seed=seed,
                driver=driver,
                time_s=now.time_s,
                mode="" if now.plan is None else now.plan.mode.value,
                follower=change.follower,
                gap_m=now.host.s_m - follower.s_m - 0.5 * (now.host.length_m + follower.length_m),
                host_mps=now.host.speed_mps,
                follower_mps=follower.speed_mps,
                driven_mps2=min(instants[k].accelerations_mps2.get(change.follower, 0.0) for k in watched),
                again_mps2=hardest(poses, taken_over),
                kept_mps2=hardest(_kept(snapshots, poses, begins), taken_over),
            )
        )
    return len(changes), found


def _driven(settings: EpisodeSettings, seed: int, method: str) -> tuple[list[Snapshot], list[Pose]]:
    """The drive, and where SUMO had the host after each step."""
    with started(settings.config, seed) as sumo:
        wait_for(sumo, settings)
        driver = SumoDriver(sumo, settings.ego, method, look_m=settings.look_m)
        poses: list[Pose] = []
        end = float(sumo.simulation.getEndTime())
        while driver.step() and not driver.contacts and not 0.0 < end <= driver.snapshots[-1].time_s:
            poses.append(_pose(sumo, settings.ego))
        return driver.snapshots[: len(poses)], poses


def _pose(sumo: Connection, ego: str) -> Pose:
    x, y, _ = sumo.vehicle.getPosition3D(ego)
    return Pose(x, y, sumo.vehicle.getAngle(ego))


def _begins(snapshots: Sequence[Snapshot], crossed: int) -> int:
    """The step at which the host begins to move over to where it is in the step `crossed`."""
    toward = math.copysign(1.0, _across_m(snapshots[crossed - 1], snapshots[crossed]))
    k = crossed
    while k > 1 and toward * _across_m(snapshots[k - 1], snapshots[k]) > STILL_M:
        k -= 1
    return k


def _across_m(before: Snapshot, now: Snapshot) -> float:
    """How far the host has moved to the left in a step; nothing where its road is counted from another lane since."""
    moved = now.host.d_m - before.host.d_m
    return moved if abs(moved) < ANOTHER_LANE_M else 0.0


def _kept(snapshots: Sequence[Snapshot], poses: Sequence[Pose], begins: int) -> list[Pose]:
    """The poses of a host that does not move across the road from the step `begins` on."""
    kept, moved_m = list(poses[:begins]), 0.0
    for k in range(begins, len(poses)):
        moved_m += _across_m(snapshots[k - 1], snapshots[k])
        road_yaw_rad = math.radians(90.0 - poses[k].angle_deg) - snapshots[k].host.heading_rad
        kept.append(poses[k].beside(-moved_m, road_yaw_rad))
    return kept


def _hardest(settings: EpisodeSettings, seed: int, follower: str, watched: Sequence[int], poses: Sequence[Pose], taken_over: int) -> float:
    """The hardest braking of somebody in the steps `watched` [m/s^2, negative], with the host put there from the step `taken_over` on."""
    with started(settings.config, seed) as sumo:
        wait_for(sumo, settings)
        hardest, ego = 0.0, settings.ego
        for k in range(watched[-1] + 1):
            if k == taken_over:
                sumo.vehicle.setSpeedMode(ego, 0)
                sumo.vehicle.setLaneChangeMode(ego, 0)
            if k >= taken_over:
                pose = poses[k]
                sumo.vehicle.moveToXY(ego, "", -1, pose.x_m, pose.y_m, pose.angle_deg, keepRoute=1, matchThreshold=100.0)
            sumo.simulationStep()
            if k >= watched[0] and follower in sumo.vehicle.getIDList():
                hardest = min(hardest, float(sumo.vehicle.getAcceleration(follower)))
        return hardest


def told(driver: str, changes: int, found: Iterable[Braking]) -> str:
    """The counts of a driver, as lines."""
    found = list(found)
    hard = [(one.driven_mps2 < -HARD_MPS2, one.again_mps2 < -HARD_MPS2, one.kept_mps2 < -HARD_MPS2) for one in found]
    made = sum(again and not kept for _, again, kept in hard)
    spared = sum(kept and not again for _, again, kept in hard)
    p = Pairs(first="changed", second="kept", n=len(found), only_first=made, only_second=spared).p
    return "\n".join(
        [
            f"{driver}: {changes} lane changes, {len(found)} with a follower, who brakes hard",
            f"  as driven                                {_counted(sum(one for one, _, _ in hard), changes)}",
            f"  as run again                             {_counted(sum(again for _, again, _ in hard), changes)}",
            f"  in the same seconds, had the host stayed {_counted(sum(kept for _, _, kept in hard), changes)}",
            f"  since the host changed, not otherwise    {_counted(made, changes)}",
            f"  had the host stayed, not otherwise       {_counted(spared, changes)}; McNemar p = {p:.2g}",
        ]
    )


def _counted(k: int, n: int) -> str:
    low, high = Share(k=k, n=n).interval
    return f"{k} of {n} [{100.0 * low:.1f}, {100.0 * high:.1f} %]"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--config", default="motorway", metavar="NAME")
    parser.add_argument("--ego", default="ego")
    parser.add_argument("--seeds", default="271-311")
    parser.add_argument("--drivers", default=f"mpc,{SUMO}")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--out", type=Path)
    chosen = parser.parse_args()
    settings = EpisodeSettings(config=sumo_config(chosen.config), ego=chosen.ego)
    drivers = chosen.drivers.split(",")
    drives = [(seed, driver) for seed in seeds_of(chosen.seeds) for driver in drivers]
    changes, found = dict.fromkeys(drivers, 0), []
    with multiprocessing.get_context("spawn").Pool(chosen.workers) as pool, progress_bar("drives") as progress:
        for k, (number, braked) in enumerate(pool.imap(partial(brakings, settings), drives)):
            changes[drives[k][1]] += number
            found += braked
            progress(k + 1, len(drives))
    for driver in drivers:
        print(told(driver, changes[driver], (one for one in found if one.driver == driver)))
    if chosen.out is not None:
        chosen.out.write_text(
            json.dumps({"changes": changes, "brakings": [asdict(one) for one in found]}, indent=1) + "\n", encoding="utf-8"
        )


if __name__ == "__main__":
    main()
