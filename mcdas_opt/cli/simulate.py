"""`mcdas-opt simulate`: a drive in closed loop."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mcdas_opt.cli import options
from mcdas_opt.cli.progress import progress_bar
from mcdas_opt.cli.screen import JsonOption, PlannerOption, SceneArgument, check_picture, console, facts_table, give, number

if TYPE_CHECKING:
    from mcdas_opt.catalogue.scenes import Scene
    from mcdas_opt.interop.commonroad.scenario import CommonRoadScene
    from mcdas_opt.simulation.record import Simulation


def simulate(
    scene: SceneArgument,
    planner: PlannerOption = "mpc",
    params: options.Params = None,
    plant: options.Plant = "kinematic",
    controller: options.Controller = None,
    motion_sensors: options.MotionSensors = "ideal",
    seed: options.NoiseSeed = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", help="Draw the drive: .gif, .png (a sheet of moments), or .html (plays and scrubs)."),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """The closed loop: sensors, tracker, planner, plant and traffic until the scene's end, a collision, or the road's edge.

    Example: mcdas-opt simulate curved-road --plant dynamic --out drive.html
    """
    from mcdas_opt.planning.parameter_files import planner_with
    from mcdas_opt.simulation.car import PlantError
    from mcdas_opt.simulation.controller import planned_for
    from mcdas_opt.simulation.loop import simulate as run

    check_picture(out)
    title = f"{planner}: {scene}"
    read, scenario = _read(scene)
    reserve = partial(planned_for, slips=plant != "kinematic")
    driver = planner if params is None else planner_with(params, read.vehicle, planner, reserve)
    try:
        with progress_bar("drive") as progress:
            drive = run(read, driver, plant, seed, controller=controller, progress=progress, motion_sensors=motion_sensors)
    except PlantError as error:
        if error.drive is not None:
            _show(error.drive, f"{title}, until the plant failed", out, as_json, scenario)
        raise
    _show(drive, title, out, as_json, scenario)


def _read(scene: str) -> tuple[Scene, CommonRoadScene | None]:
    """The scene, and the CommonRoad scenario that it is made of, if it is."""
    from mcdas_opt.catalogue.scenes import load_scene, of_a_format

    path = Path(scene)
    if path.suffix.lower() != ".xml" or not path.is_file():
        return load_scene(scene), None
    with of_a_format("xml", path):
        from mcdas_opt.interop.commonroad.scenario import read_scenario

        scenario = read_scenario(path)
    return scenario.scene, scenario


def _show(drive: Simulation, title: str, out: Path | None, as_json: bool, scenario: CommonRoadScene | None) -> None:
    give(drive, lambda: _print(drive, title, _of_scenario(drive, scenario)), out, as_json=as_json)


def _of_scenario(drive: Simulation, scenario: CommonRoadScene | None) -> list[tuple[str, object]]:
    """What became of the goal, which of CommonRoad's is judged by itself, and how many of its obstacles are in the scene."""
    if scenario is None:
        reached = drive.destination_reached_s
        return [("destination", drive.destination if reached is None else f"reached after {reached:.1f} s")] if drive.destination else []
    from mcdas_opt.evaluation.commonroad_campaign import why_missed
    from mcdas_opt.interop.commonroad.solution import goal_reached_s

    reached = goal_reached_s(scenario, drive.trajectory)
    goal = f"not reached: {why_missed(scenario.goal_is_off, drive)}" if reached is None else f"reached after {reached:.1f} s"
    return [("goal", goal), ("obstacles", f"{len(scenario.obstacles)} in the scene, {len(scenario.left_out)} left out")]


def _print(drive: Simulation, title: str, more: list[tuple[str, object]]) -> None:
    ended = f"{drive.ended} after {drive.duration_s:.2f} s"
    if drive.collided_with is not None:
        ended += f", with {drive.collided_with} at {drive.impact_speed_mps:.1f} m/s"
    others = [f"{count} {word}" for count, word in ((drive.fallbacks, "fallback"), (drive.unavoidable, "unavoidable")) if count]
    rows: list[tuple[str, object]] = [
        ("outcome", ended),
        ("modes", ", ".join(f"{t:.1f} s {mode}" for t, mode in drive.modes)),
        *more,
        ("lane changes", f"{drive.lane_changes or 'none'} completed"),
        ("least clearance", number(drive.min_clearance_m, "m")),
        ("least time to collision", f"front {number(drive.min_ttc_front_s, 's')}, rear {number(drive.min_ttc_rear_s, 's')}"),
        ("largest lateral acceleration", f"{drive.max_lateral_acceleration_mps2:.2f} m/s^2"),
        ("largest jerk along", f"{drive.max_jerk_mps3:.1f} m/s^3"),
        ("largest steering rate", f"{drive.max_steering_rate_radps:.3f} rad/s"),
        ("plans", ", ".join([str(drive.plans), *others])),
        ("unverified plans", drive.unverified_plans),
        ("cycle", f"p50 {drive.cycle_ms.p50:.1f} ms, p99 {drive.cycle_ms.p99:.1f} ms, max {drive.cycle_ms.max:.1f} ms"),
        ("plant", drive.plant),
        ("seed", drive.seed),
    ]
    if drive.among_others:
        rows.append(("neighbours", drive.among_others))
    console().print(facts_table(f"{title}, {drive.driven_with}", rows))
