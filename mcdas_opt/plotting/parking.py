"""A parking manoeuvre drawn: the swept body among its obstacles, curvature and speed over the path, and as a moving picture."""

from __future__ import annotations

import io
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mcdas_opt.domain.parking import Parking, ParkingCase, ParkingTrajectory
from mcdas_opt.domain.rules import Array
from mcdas_opt.errors import ParameterError
from mcdas_opt.geometry.clearance import Body, body_corners
from mcdas_opt.parking.path import counted
from mcdas_opt.plotting import style
from mcdas_opt.plotting.asked import case_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from PIL.Image import Image

    from mcdas_opt.parking.closed_loop.sight import Visitor

_FORWARD, _REVERSE = style.BLUE, style.ORANGE
_MOST_FRAMES, _FRAME_DPI = 90, 90


def film(parking: Parking, path: Path) -> Path:
    """Writes an animation (.gif); needs an answer with a trajectory."""
    return save_gif(*frames(parking), path)


def save_gif(pictures: list[Image], milliseconds: list[int], path: Path) -> Path:
    """Writes what `moving` made."""
    pictures[0].save(path, save_all=True, append_images=pictures[1:], duration=milliseconds, loop=0)
    return path


def sheet(parking: Parking) -> Figure:
    """The swept body above; curvature and speed over the path below."""
    case, trajectory = case_of(parking), _local(parking)
    with style.styled():
        fig = style.figure(9.6, 8.2)
        above, curvature, speed = fig.subplots(3, 1, height_ratios=[2.6, 1.0, 1.0])
        _plane(above, case, trajectory)
        corners = body_corners(trajectory.poses, Body.of(case.vehicle))
        step = max(1, len(trajectory) // 60)
        gears = trajectory.gears
        for k in range(0, len(trajectory), step):
            above.fill(*corners[k].T, facecolor="none", edgecolor=_FORWARD if gears[k] > 0 else _REVERSE, lw=0.5, alpha=0.45)
        _body(above, corners[0], style.GREY, "start")
        _body(above, corners[-1], style.GREEN, "goal")
        _path(above, trajectory, gears)
        title = f"{case.name}, {parking.planner}: {parking.duration_s:.1f} s, {counted(parking.gear_changes or 0)}, "
        above.set_title(title + f"least clearance {100.0 * (parking.min_clearance_m or 0.0):.1f} cm")
        fig.legend(loc="outside right upper")
        _profiles(curvature, speed, case, trajectory)
    return fig


def frames(parking: Parking) -> tuple[list[Image], list[int]]:
    """A manoeuvre as `moving` pictures."""
    return moving(case_of(parking), _local(parking))


def moving(case: ParkingCase, trajectory: ParkingTrajectory, people: Sequence[Visitor] = ()) -> tuple[list[Image], list[int]]:
    """Palette images in real time, at most `_MOST_FRAMES` of them, with their durations [ms]; the gear is written on each.

    The trajectory in the case's own frame; `people` are drawn while they are there.
    """
    from PIL import Image

    t = trajectory.t_s
    count = min(_MOST_FRAMES, max(2, int(t[-1] / 0.1)))
    at = np.searchsorted(t, np.linspace(t[0], t[-1], count)).clip(0, len(t) - 1)
    corners = body_corners(trajectory.poses, Body.of(case.vehicle))
    goal = body_corners(case.goal[None], Body.of(case.vehicle))[0]
    gears = trajectory.gears
    changes = np.concatenate([[0], np.cumsum(np.diff(gears) != 0)])
    pictures = []
    with style.styled():
        fig = style.figure(8.0, 4.2)
        axes = fig.subplots()
        for k in at:
            axes.clear()
            _plane(axes, case, trajectory)
            _body(axes, goal, style.GREEN, "goal", alpha=0.25)
            _path(axes, trajectory, gears, until=int(k) + 1)
            _body(axes, corners[k], _FORWARD if gears[k] > 0 else _REVERSE, "car")
            for person in people:
                if person.there(float(t[k])):
                    axes.fill(*person.outline().T, facecolor=style.VERMILION, edgecolor=style.BLACK, zorder=7)
            word = "forward" if gears[k] > 0 else "reverse"
            axes.set_title(f"{t[k]:.1f} s, {word}, {abs(trajectory.speed_mps[k]):.1f} m/s, gear changes so far: {changes[k]}")
            store = io.BytesIO()
            fig.savefig(store, format="png", dpi=_FRAME_DPI)
            fig.set_layout_engine("none")  # every frame keeps the first one's layout
            store.seek(0)
            pictures.append(Image.open(store).convert("P", palette=Image.Palette.ADAPTIVE, colors=64))
    milliseconds = [max(20, int(1000.0 * (t[b] - t[a]))) for a, b in pairwise(at)]
    return pictures, [*milliseconds, 2000]


def _local(parking: Parking) -> ParkingTrajectory:
    if parking.trajectory is None:
        raise ParameterError("trajectory", None, "there is nothing to draw: the case was refused")
    x_m, y_m = case_of(parking).origin_m
    return parking.trajectory.moved(-x_m, -y_m)


def _plane(axes: Axes, case: ParkingCase, trajectory: ParkingTrajectory) -> None:
    corners = body_corners(np.vstack([trajectory.poses, case.goal]), Body.of(case.vehicle)).reshape(-1, 2)
    yard(axes, case, corners)


def yard(axes: Axes, case: ParkingCase, shown: Array) -> None:
    """The obstacles, as far as what is shown (n, 2) and a metre around it."""
    (left, low), (right, high) = shown.min(0) - 1.0, shown.max(0) + 1.0
    for outline in case.obstacles:
        axes.fill(*outline.T, facecolor="#c9c9ce", edgecolor=style.EDGE, lw=1.0, zorder=1)
    x, y = (_axis(name, origin_m) for name, origin_m in zip("xy", case.origin_m, strict=True))
    axes.set(xlim=(left, right), ylim=(low, high), aspect="equal", xlabel=x, ylabel=y)
    axes.grid(False)


def _axis(name: str, origin_m: float) -> str:
    """An axis' label: of the file's coordinate, less the origin where there is one."""
    return f"{name} [m]" if origin_m == 0.0 else f"{name} {'-' if origin_m > 0.0 else '+'} {abs(origin_m):.15g} m [m]"


def _body(axes: Axes, corners: Array, colour: str, label: str, alpha: float = 0.55) -> None:
    axes.fill(*corners.T, facecolor=colour, edgecolor=style.BLACK, lw=1.0, alpha=alpha, zorder=3, label=label)
    axes.plot(*corners[[0, 3]].T, color=style.BLACK, lw=2.4, zorder=4)  # the front


def _path(axes: Axes, trajectory: ParkingTrajectory, gears: Array, until: int | None = None) -> None:
    for sign, colour, label in ((1.0, _FORWARD, "forward"), (-1.0, _REVERSE, "reverse")):
        mask = np.where(gears == sign, 1.0, np.nan)[:until]
        x, y = trajectory.x_m[:until] * mask, trajectory.y_m[:until] * mask
        axes.plot(x, y, color=colour, lw=2.0, zorder=5, label=f"rear axle, {label}")


def _profiles(curvature: Axes, speed: Axes, case: ParkingCase, trajectory: ParkingTrajectory) -> None:
    v = trajectory.speed_mps
    distance = np.concatenate([[0.0], np.cumsum(0.5 * np.abs(v[1:] + v[:-1]) * np.diff(trajectory.t_s))])
    top = np.tan(case.vehicle.steering_max_rad) / case.vehicle.wheelbase_m
    curvature.plot(distance, np.tan(trajectory.steering_rad) / case.vehicle.wheelbase_m, color=style.PURPLE)
    for limit in (top, -top):
        curvature.axhline(limit, color=style.GREY, ls="--", lw=1.0)
    curvature.set_ylabel("curvature [1/m]")
    speed.plot(distance, v, color=style.BLUE)
    for limit in (case.limits.forward_mps, -case.limits.reverse_mps):
        speed.axhline(limit, color=style.GREY, ls="--", lw=1.0)
    speed.axhline(0.0, color=style.BLACK, lw=0.8)
    speed.set(ylabel="speed [m/s]", xlabel="distance driven [m] (dashed: limits)")
    curvature.sharex(speed)
