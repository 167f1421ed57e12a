"""The same avoidable scenes on every plant, as it is and with what is wrong: safe or lost, cycles without a way out, spins, and why.

    python benchmarks/plants.py mid-vehicle --scenes 300 --seed 8100 --out rows.jsonl
    python benchmarks/plants.py sandwich,curved --scenes 6 --plants kinematic,dynamic        # a quick look: half a minute
    python benchmarks/plants.py mid-vehicle --scenes 60 --plants dynamic,multi-body --conditions as-is,mass,cog-rear,tyres,noise
    python benchmarks/plants.py sandwich,curved --scenes 20 --plants dynamic --controllers stanley,mpc-single-track

Avoidable scenes of one or more suites (the oracle drives the kinematic vehicle), and all of one whose traffic reacts, with the host's
vehicle replaced by the one named, are driven by a planner on all plants with the same seeds. On every plant the road's friction is the peak
of the tyres' force over their load. Of each avoidable scene that a plant loses it is asked whether it can follow the oracle's own drive:
tracked by the same controller, without any planner. Avoidable is said of a car that has grip in every direction; "survivable" are the
scenes that this car came through, driven by the planner or along the oracle's drive.

Conditions: `CONDITIONS` below. Parameters are wrong in the plant alone: planner, controller and observer have the vehicle's file. `--out`
keeps every row; a run that was stopped goes on with the same command.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import tempfile
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import Scan
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.verdict import Verdict
from mcdas_opt.domain.vocabulary import Mode
from mcdas_opt.evaluation.case import Case
from mcdas_opt.evaluation.labels import Kind, label_scene, wants_label
from mcdas_opt.evaluation.statistics import Pairs, Share
from mcdas_opt.evaluation.suites import expand
from mcdas_opt.simulation.car import PlantError
from mcdas_opt.simulation.driver import Driver
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.plant import Plant, make_plant
from mcdas_opt.simulation.record import Outcome, Simulation

SPUN_RAD = 0.35  # sideslip of the rear axle at which a drive counts as one that spun, ...
SPUN_MPS = 5.0  # ... if it is not about to stand
FELT_LOW = 0.7  # of the friction there is


@dataclass(frozen=True, kw_only=True)
class Condition:
    """What is not as the planner has it, but for delays, which the vehicle's file says."""

    heavier: float = 1.0  # mass and yaw inertia
    cog_back_m: float = 0.0
    stiffness: float = 1.0  # of the tyres
    believed: float = 1.0  # friction, over the road's
    sensors: str = "ideal"
    steering_delay_s: float = 0.0
    brake_build_up_s: float = 0.0

    def plant(self, name: str, vehicle: Vehicle, road: Road, state: HostState) -> Plant:
        """The plant of that name, of a car that is not the one of the file."""
        c = Chassis.of(vehicle)
        has = replace(
            vehicle,
            mass_kg=self.heavier * c.mass_kg,
            yaw_inertia_kgm2=self.heavier * c.yaw_inertia_kgm2,
            cog_to_front_axle_m=c.cog_to_front_axle_m + self.cog_back_m,
            axle_load_front_kg=None,
            axle_load_rear_kg=None,
            cornering_stiffness_front_nprad=self.stiffness * c.cornering_stiffness_front_nprad,
            cornering_stiffness_rear_nprad=self.stiffness * c.cornering_stiffness_rear_nprad,
        )
        return make_plant(name, has, road, state)


CONDITIONS = {
    "as-is": Condition(),
    "mass": Condition(heavier=1.2),
    "cog-front": Condition(cog_back_m=-0.12),
    "cog-rear": Condition(cog_back_m=0.12),
    "mass-cog-front": Condition(heavier=1.2, cog_back_m=-0.12),
    "mass-cog-rear": Condition(heavier=1.2, cog_back_m=0.12),
    "tyres": Condition(stiffness=0.75),
    "friction-0.5": Condition(believed=0.5),
    "friction-0.75": Condition(believed=0.75),
    "friction-1.25": Condition(believed=1.25),
    "friction-1.5": Condition(believed=1.5),
    "noise": Condition(sensors="production"),
    "delay-50": Condition(steering_delay_s=0.05, brake_build_up_s=0.15),
    "delay-100": Condition(steering_delay_s=0.1, brake_build_up_s=0.15),
}


@dataclass(frozen=True)
class OraclesDrive(Driver):
    """A driver that goes on along one trajectory, whatever happens."""

    trajectory: Trajectory
    name: str = "the oracle's drive"

    def step(self, measurements: Sequence[Scan], host: HostState, now: float, **asked: object) -> Plan:
        t = self.trajectory.t_s
        later = t > now + 1e-9
        here = [np.interp(now, t, column) for column in self.trajectory.states.T]
        states = np.vstack([here, self.trajectory.states[later]])
        rest = Trajectory.from_states(np.concatenate([[0.0], t[later] - now]), states, np.zeros((len(states), 2)))
        return Plan(planner=self.name, mode=Mode.HOLD, verdict=Verdict(), prediction="none", trajectory=rest)


@dataclass(frozen=True, kw_only=True)
class Row:
    """One drive; `followed`: how the oracle's own drive ended on this plant, where the planner's was lost."""

    suite: str
    index: int
    plant: str
    controller: str
    condition: str
    ended: str
    unavoidable: int
    cycles: int
    unverified: int
    spun: bool
    felt: float  # least friction that plans were made with, over the road's
    sideslip_rad: float
    friction: float
    last: str  # of the last plans: what was tried when it was lost
    followed: str = ""


def ended(drive: Simulation) -> str:
    return drive.collided_with or "off the road" if drive.outcome is not Outcome.SAFE else "safe"


def row(suite: str, case: Case, plant: str, controller: str, condition: str, drive: Simulation, followed: str) -> Row:
    history = drive.history
    slip = np.abs(np.where(history.states[:, 3] > SPUN_MPS, history.sideslip_rad, 0.0))
    last = drive.cycles[-1].plan
    return Row(
        suite=suite,
        index=case.index,
        plant=plant,
        controller=controller,
        condition=condition,
        ended=ended(drive),
        unavoidable=drive.unavoidable,
        cycles=drive.plans,
        unverified=drive.unverified_plans,
        spun=bool(slip.max() > SPUN_RAD),
        felt=float(history.friction.min() / case.scene.road.friction),
        sideslip_rad=float(slip.max()),
        friction=case.scene.road.friction,
        last=f"{last.status.value}, {last.mode.value}, {drive.duration_s:.1f} s",
        followed=followed,
    )


def with_vehicle(scene: Scene, vehicle: str, condition: Condition) -> Scene:
    document = scene.model_dump(exclude_unset=True)
    document["host"]["vehicle"] = vehicle
    if condition.believed != 1.0:
        document["host"]["assumed_friction"] = min(condition.believed * scene.road.friction, 1.5)
    return Scene.model_validate(document)


def vehicle_file(vehicle: str, condition: Condition, folder: Path) -> str:
    """The vehicle's name, or a file of it with the condition's actuators."""
    if condition.steering_delay_s == 0.0:
        return vehicle
    source = Path(vehicle) if Path(vehicle).suffix else Path(__file__).parent.parent / "models" / "vehicles" / f"{vehicle}.toml"
    path = folder / f"{source.stem}-{condition.steering_delay_s:g}.toml"
    delays = f"[actuators]\nsteering_delay_s = {condition.steering_delay_s}\nbrake_build_up_s = {condition.brake_build_up_s}\n"
    path.write_text(f"{source.read_text()}\n{delays}")
    return str(path)


@dataclass(frozen=True, kw_only=True)
class Asked:
    """What every scene is asked."""

    planner: str
    plants: Sequence[str]
    vehicle: str
    controllers: Sequence[str]
    conditions: Sequence[str]
    done: frozenset[tuple[object, ...]]


def rows_of(one: tuple[str, Case], *, asked: Asked) -> list[Row]:
    """A row for each plant, controller and condition that has none yet; none for a scene that is not avoidable."""
    suite, given = one
    wanted = [
        (plant, controller, condition)
        for condition in asked.conditions
        for controller in asked.controllers
        for plant in asked.plants
        if (suite, given.index, plant, controller, condition) not in asked.done
    ]
    if not wanted or (suite, given.index, "", "", "") in asked.done:
        return []
    label = label_scene(with_vehicle(given.scene, asked.vehicle, CONDITIONS["as-is"])) if wants_label(given) else None
    if label is not None and label.kind is not Kind.A:
        return [
            Row(
                suite=suite, index=given.index, plant="", controller="", condition="", ended="not avoidable", unavoidable=0, cycles=0,
                unverified=0, spun=False, felt=1.0, sideslip_rad=0.0, friction=given.scene.road.friction, last="",
            )
        ]  # fmt: skip
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for plant, controller, name in wanted:
            condition = CONDITIONS[name]
            scene = with_vehicle(given.scene, vehicle_file(asked.vehicle, condition, Path(folder)), condition)
            drive_as = partial(
                simulate,
                scene,
                plant=partial(condition.plant, plant),
                controller=controller or None,
                motion_sensors=condition.sensors,
            )
            try:
                drive, followed = drive_as(asked.planner), ""
            except PlantError as error:
                if error.drive is None:
                    raise
                drive, followed = error.drive, ""
            if drive.outcome is not Outcome.SAFE and label is not None and label.witness is not None:
                followed = ended(drive_as(OraclesDrive(label.witness)))
            rows.append(row(suite, given, plant, controller, name, drive, followed))
    return rows


def report(rows: Sequence[Row], asked: Asked) -> None:
    heads = ("safe", "of survivable", "unavoidable cycles", "spun", f"felt < {FELT_LOW:g}", "sideslip p99 [rad]", "unverified")
    first = rows_as(rows, asked.plants[0], asked.controllers[0], asked.conditions[0])
    print(
        f"{'plant':>12} {'controller':>17} {'condition':>15} {heads[0]:>22}", *(f"{head:>{len(head) + 1}}" for head in heads[1:]), " lost"
    )
    for condition in asked.conditions:
        for controller in asked.controllers:
            for plant in asked.plants:
                own = rows_as(rows, plant, controller, condition)
                if not own:
                    continue
                share = Share(k=sum(row.ended == "safe" for row in own.values()), n=len(own))
                low, high = (100 * q for q in share.interval)
                lost = ", ".join(f"{n} {how}" for how, n in sorted(Counter(row.ended for row in own.values()).items()) if how != "safe")
                followed = [row for row in own.values() if row.ended != "safe" and row.followed == "safe"]
                counts = (
                    f"{share.k}/{share.k + len(followed)}",
                    sum(row.unavoidable for row in own.values()),
                    sum(row.spun for row in own.values()),
                    sum(row.felt < FELT_LOW for row in own.values()),
                    f"{np.percentile([row.sideslip_rad for row in own.values()], 99):.3f}",
                    sum(row.unverified for row in own.values()),
                )
                table = (f"{count:>{len(head) + 1}}" for head, count in zip(heads[1:], counts, strict=True))
                print(
                    f"{plant:>12} {controller or 'default':>17} {condition:>15} {f'{share.k}/{share.n} [{low:.0f}, {high:.0f}] %':>22}",
                    *table,
                    f" {lost}{against(own, first)}",
                )
    for row in rows:
        if row.ended not in ("safe", "not avoidable"):
            followed = f"; the oracle's own drive, followed: {row.followed}" if row.followed else ""
            facts = f"friction {row.friction:g}, felt {row.felt:.2f} of it, sideslip {row.sideslip_rad:.2f} rad"
            name = f"{row.plant} {row.controller} {row.condition}".replace("  ", " ")
            print(f"  {row.suite} {row.index} {name}: {row.ended} ({row.last}); {facts}, {row.unavoidable} cycles unavoidable{followed}")


def rows_as(rows: Sequence[Row], plant: str, controller: str, condition: str) -> dict[tuple[str, int], Row]:
    return {(row.suite, row.index): row for row in rows if (row.plant, row.controller, row.condition) == (plant, controller, condition)}


def against(own: dict[tuple[str, int], Row], first: dict[tuple[str, int], Row]) -> str:
    """Scenes lost here alone, and by the table's first row alone."""
    shared = own.keys() & first.keys()
    if own is first or own == first or not shared:
        return ""
    here = sum(own[key].ended != "safe" and first[key].ended == "safe" for key in shared)
    there = sum(own[key].ended == "safe" and first[key].ended != "safe" for key in shared)
    pairs = Pairs(first="first", second="own", n=len(shared), only_first=there, only_second=here)
    return f"  (lost here alone {here}, by the first row alone {there}, p = {pairs.p:.2g})"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("suites", nargs="?", default="mid-vehicle", help="names, with commas between")
    parser.add_argument("--planner", default="mpc")
    parser.add_argument("--plants", default="kinematic,dynamic,std,multi-body")
    parser.add_argument("--vehicle", default="bmw_320i", help="what std and multi-body are; or a vehicle file")
    parser.add_argument("--controllers", default="", help="track the plans; default the plant's")
    parser.add_argument("--conditions", default="as-is", help=f"of {', '.join(CONDITIONS)}; or all")
    parser.add_argument("--scenes", type=int, default=40, help="of each suite")
    parser.add_argument("--seed", type=int, default=8100)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, help="a JSON line for every drive; goes on where it ended")
    arguments = parser.parse_args()
    conditions = list(CONDITIONS) if arguments.conditions == "all" else arguments.conditions.split(",")
    unknown = [name for name in conditions if name not in CONDITIONS]
    if unknown:
        parser.error(f"--conditions: {', '.join(unknown)}: must be of {', '.join(CONDITIONS)}")
    load_vehicle(arguments.vehicle)
    settings = [arguments.suites, arguments.scenes, arguments.seed, arguments.planner, arguments.vehicle]
    rows: list[Row] = []
    if arguments.out is not None and arguments.out.exists():
        kept = [json.loads(line) for line in arguments.out.read_text().splitlines()]
        if kept and kept[0] != settings:
            parser.error(f"--out: {arguments.out} holds rows of {kept[0]}, not of {settings}")
        rows = [Row(**one) for one in kept[1:]]
    elif arguments.out is not None:
        arguments.out.write_text(json.dumps(settings) + "\n")
    asked = Asked(
        planner=arguments.planner,
        plants=arguments.plants.split(","),
        vehicle=arguments.vehicle,
        controllers=arguments.controllers.split(","),
        conditions=conditions,
        done=frozenset((row.suite, row.index, row.plant, row.controller, row.condition) for row in rows),
    )
    cases = [(suite, case) for suite in arguments.suites.split(",") for case in expand(suite, arguments.scenes, arguments.seed).cases]
    with multiprocessing.get_context("spawn").Pool(arguments.workers) as pool:
        for found in pool.imap(partial(rows_of, asked=asked), cases):
            rows += found
            if arguments.out is not None and found:
                with arguments.out.open("a") as out:
                    out.writelines(json.dumps(asdict(one)) + "\n" for one in found)
    driven = len({(row.suite, row.index) for row in rows if row.plant})
    print(f"{arguments.suites}, seed {arguments.seed}, {arguments.planner}, {arguments.vehicle}: {driven} asked of {len(cases)} scenes")
    report(rows, asked)


if __name__ == "__main__":
    main()
