"""A plan, a drive or a parking manoeuvre as a page that plays and scrubs: one self-contained HTML file, no network."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from mcdas_opt.domain.parking import Parking, ParkingCase, ParkingTrajectory
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.clearance import Body, body_corners
from mcdas_opt.parking.closed_loop.record import ParkingDrive, ParkingOutcome
from mcdas_opt.plotting import style, web
from mcdas_opt.plotting.animation import drive_heading, outcome_words, plan_words
from mcdas_opt.plotting.asked import case_of, situation_of
from mcdas_opt.plotting.bands import Decided, bands_document
from mcdas_opt.plotting.moments import HOST, Moment, moment_at, neighbour_colours, view_of
from mcdas_opt.plotting.outlook import Outlook
from mcdas_opt.plotting.parking_follow import drive_words
from mcdas_opt.plotting.plane import Ground, chart, line, plan_path, rounded, view_document
from mcdas_opt.plotting.strips import Strip, strips_of
from mcdas_opt.simulation.record import Simulation

_BEYOND_M = 110.0  # road drawn before the first and beyond the last place of the host
_POSE_EVERY_S = 0.05
_CHART_EVERY_S = 0.02


def drive_page(simulation: Simulation) -> str:
    return web.page(drive_heading(simulation), "Drive", drive_document(simulation))


def parking_page(parking: Parking) -> str:
    """The manoeuvre, or the refusal."""
    case = case_of(parking)
    return web.page(f"{case.name} · {parking.planner}", "Parking", parking_document(case, parking))


def follow_page(drive: ParkingDrive) -> str:
    return web.page(f"{drive.name} · {drive.planner}, driven", "Parking", follow_document(case_of(drive), drive))


def plan_page(plan: Plan) -> str:
    """The plan in its situation, looking ahead."""
    outlook = Outlook(*situation_of(plan))
    shown = {**web.look_of(plan.planner), **outlook.plan(plan)}
    return web.page(f"plan · {plan.planner}", "PlanPage", {"picture": outlook.document(), "plan": shown})


def drive_document(simulation: Simulation) -> dict[str, Any]:
    """Everything that the script's `Drive` shows: poses in the plane, tracks and plans of every cycle, charts with their limits."""
    x, road = simulation.trajectory, simulation.scene.true_road
    ground = Ground(road, float(x.s_m.min()) - _BEYOND_M, float(x.s_m.max()) + _BEYOND_M)
    t = np.append(np.arange(0.0, simulation.duration_s, _POSE_EVERY_S), simulation.duration_s)

    def over(column: Array) -> Array:
        return np.asarray(np.interp(t, x.t_s, column))

    car = simulation.scene.vehicle
    host = ground.place(over(x.s_m), over(x.d_m), over(x.heading_rad))
    colours = neighbour_colours(simulation)
    others = [
        {
            "name": other.name,
            "length": other.length_m,
            "width": other.width_m,
            "colour": colour,
            "poses": rounded(ground.place(over(other.s_m), over(other.d_m), over(other.heading_rad)), 3),
        }
        for other, colour in zip(simulation.neighbours, colours, strict=True)
    ]
    struck = [HOST, simulation.collided_with] if simulation.collided_with is not None else []
    times = [cycle.time_s for cycle in simulation.cycles]
    decided = [Decided.of(cycle.time_s, cycle.plan, passed=cycle.plan.verdict.passed) for cycle in simulation.cycles]
    return {
        "duration": simulation.duration_s,
        "road": ground.document(),
        "view": view_document(view_of(simulation)),
        "poses_t": rounded(t, 3),
        "camera": rounded(ground.place(over(x.s_m), 0.0), 4),
        "speed": rounded(over(x.speed_mps)),
        "host": {"name": HOST, "length": car.length_m, "width": car.width_m, "colour": style.HOST, "poses": rounded(host, 3)},
        "others": others,
        "t": rounded(times, 3),
        "cycles": [_cycle(ground, moment_at(simulation, t)) for t in times],
        "charts": [_chart(strip, simulation.duration_s) for strip in strips_of(simulation)],
        **bands_document(decided, simulation.duration_s),
        "outcome": outcome_words(simulation),
        "safe": simulation.is_safe,
        "struck": struck,
    }


def parking_document(case: ParkingCase, parking: Parking) -> dict[str, Any]:
    """Everything that the script's `Parking` shows; without a trajectory, only the place and the reason."""
    driven = None if parking.trajectory is None else parking.trajectory.moved(-case.origin_m[0], -case.origin_m[1])
    document: dict[str, Any] = {
        "yard": _yard(case, driven),
        "status": parking.status,
        "sound": parking.passed,
        "words": parking_words(parking),
        "manoeuvre": None,
    }
    return document if driven is None else {**document, **_manoeuvre(case, driven)}


def follow_document(truth: ParkingCase, drive: ParkingDrive) -> dict[str, Any]:
    """The same for a manoeuvre that was driven, with the people who stood in the way."""
    driven = _thinned(drive.trajectory)
    people = [{"outline": rounded(one.outline(), 3), "from": one.from_s, "until": one.until_s} for one in drive.visitors]
    return {
        "yard": {**_yard(truth, driven), "people": people},
        "status": str(drive.outcome),
        "sound": drive.outcome is ParkingOutcome.PARKED,
        "words": drive_words(drive),
        **_manoeuvre(truth, driven),
    }


def _thinned(driven: ParkingTrajectory) -> ParkingTrajectory:
    """Samples some `_POSE_EVERY_S` apart, the last one included."""
    shown = np.unique(np.searchsorted(driven.t_s, np.append(np.arange(driven.t_s[0], driven.t_s[-1], _POSE_EVERY_S), driven.t_s[-1])))
    return ParkingTrajectory(**{name: column[shown] for name, column in asdict(driven).items()})


def _yard(case: ParkingCase, driven: ParkingTrajectory | None) -> dict[str, Any]:
    car, body = case.vehicle, Body.of(case.vehicle)
    poses = np.array([case.start, case.goal]) if driven is None else np.vstack([driven.poses, case.start, case.goal])
    swept = body_corners(poses, body).reshape(-1, 2)
    (x0, y0), (x1, y1) = swept.min(axis=0) - 1.2, swept.max(axis=0) + 1.2
    return {
        "obstacles": [rounded(outline, 3) for outline in case.obstacles],
        "bounds": rounded([x0, y0, x1, y1]),
        "car": {"length": car.length_m, "width": car.width_m, "centre": car.centre_m},
        "start": rounded(case.start, 4),
        "goal": rounded(case.goal, 4),
    }


def _manoeuvre(case: ParkingCase, driven: ParkingTrajectory) -> dict[str, Any]:
    car = case.vehicle
    t, gears = driven.t_s - driven.t_s[0], driven.gears
    curvature = np.tan(driven.steering_rad) / car.wheelbase_m
    top = float(np.tan(car.steering_max_rad) / car.wheelbase_m)
    forward, reverse = case.limits.forward_mps, -case.limits.reverse_mps
    speed = driven.speed_mps
    lasts, curved = driven.duration_s, [(top, "steering lock", True), (-top, "steering lock", True)]
    fastest, slowest = 1.15 * max(forward, float(speed.max())), 1.15 * min(reverse, float(speed.min()))
    driving, bending = [line(t, speed, style.HOST)], [line(t, curvature, style.PURPLE, 4)]
    return {
        "duration": lasts,
        "manoeuvre": {
            "t": rounded(t, 3),
            "poses": rounded(driven.poses, 4),
            "gears": [int(g) for g in gears],
            "changes": [0, *np.cumsum(np.diff(gears) != 0).tolist()],
            "speed": rounded(speed),
        },
        "charts": [
            chart(
                "speed", "m/s", slowest, fastest, [(forward, "forward", True), (reverse, "reverse", True)], duration=lasts, lines=driving
            ),
            chart("curvature", "1/m", -1.2 * top, 1.2 * top, curved, duration=lasts, lines=bending),
        ],
    }


def parking_words(parking: Parking) -> str:
    """The answer in a sentence."""
    if parking.trajectory is None or not parking.passed:
        return parking.reason
    clearance = "" if parking.min_clearance_m is None else f", never nearer than {100.0 * parking.min_clearance_m:.1f} cm"
    changes = f"{parking.gear_changes} gear change{'' if parking.gear_changes == 1 else 's'}"
    return f"{parking.duration_s:.1f} s, {parking.path_m:.1f} m driven, {changes}{clearance}; passed by the judge"


def _cycle(ground: Ground, moment: Moment) -> dict[str, Any]:
    plan = moment.plan
    path, seconds = plan_path(ground, plan.trajectory)
    return {
        "action": moment.action,
        "status": plan.status.value,
        "sound": plan.verdict.passed,
        "words": plan_words(plan),
        "plan": path,
        "seconds": seconds,
        "tracks": [ground.track(track) for track in moment.tracks],
    }


def _chart(strip: Strip, duration_s: float) -> dict[str, Any]:
    title, _, unit = strip.title.partition(" [")
    every = max(1, round(_CHART_EVERY_S / max(float(strip.t_s[1] - strip.t_s[0]), 1e-9))) if len(strip.t_s) > 1 else 1
    limits = [(value, word, word != "desired") for value, word in strip.limits]
    lines = [line(strip.t_s[::every], strip.values[::every], style.HOST)]
    return chart(title, unit.removesuffix("]"), strip.low, strip.high, limits, duration=duration_s, lines=lines)
