"""A few moments of traffic around the host, with speed and gap beside them: what led to a contact or a near miss."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.plotting import style
from mcdas_opt.plotting.birdseye import Camera
from mcdas_opt.simulation.ordinary import Placed, Snapshot

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOMENTS_S = (-3.0, -1.5, 0.0, 1.0)
_BEFORE_S, _AFTER_S = 6.0, 3.0
_BACK_M, _AHEAD_M = 35.0, 65.0


def draw_moments(snapshots: Sequence[Snapshot], time_s: float, other: str, title: str) -> Figure:
    """The road from above at MOMENTS_S around `time_s`, the host in blue, `other` in vermilion; then both speeds, and their gap."""
    near = [one for one in snapshots if time_s - _BEFORE_S <= one.time_s <= time_s + _AFTER_S]
    with style.styled():
        fig = style.figure(9.0, 2.0 + 1.5 * len(MOMENTS_S))
        grid = fig.add_gridspec(len(MOMENTS_S) + 1, 2, height_ratios=[1.2] * len(MOMENTS_S) + [1.6])
        for row, shift in enumerate(MOMENTS_S):
            axes = fig.add_subplot(grid[row, :])
            _show(axes, min(near, key=lambda one: abs(one.time_s - time_s - shift)), other, time_s)
        _speeds(fig.add_subplot(grid[-1, 0]), near, other, time_s)
        _gap(fig.add_subplot(grid[-1, 1]), near, other, time_s)
        fig.suptitle(title, fontsize=9, x=0.01, ha="left")
    return fig


def _show(axes: Axes, moment: Snapshot, other: str, time_s: float) -> None:
    host, road = moment.host, moment.road
    camera = Camera(road, host.s_m)
    s = np.linspace(host.s_m - _BACK_M, host.s_m + _AHEAD_M, 60)
    right, left = (np.column_stack(camera.place(s, d)[:2]) for d in (road.right_edge_m, road.left_edge_m))
    axes.fill(*np.concatenate([right, left[::-1]]).T, color=style.ASPHALT, lw=0, zorder=0)
    for lane in range(-road.lanes_right, road.lanes_left):
        axes.plot(*camera.place(s, (lane + 0.5) * road.lane_width_m)[:2], color=style.MARKING, lw=1.4, dashes=(6, 5), zorder=1)
    for body in (*moment.others, host):
        if not -_BACK_M < body.s_m - host.s_m < _AHEAD_M:
            continue
        colour = style.HOST if body is host else style.VERMILION if body.id == other else style.NEIGHBOUR
        x, y, yaw = (float(q) for q in camera.place(body.s_m, body.d_m, body.heading_rad))
        style.draw_body(axes, x, y, yaw, body.length_m, body.width_m, colour)
        axes.annotate(f"{body.speed_mps:.0f}", (x, y), ha="center", va="center", fontsize=6, color="white", zorder=6)
    if moment.plan is not None:
        path = moment.plan.trajectory
        later = path.t_s >= moment.time_s - moment.plan.time_s
        axes.plot(*camera.place(path.s_m[later], path.d_m[later])[:2], color=style.PLAN, lw=1.2, zorder=3)
    middle = 0.5 * (road.left_edge_m + road.right_edge_m)
    half = max(0.5 * (road.left_edge_m - road.right_edge_m) + 1.5, 7.0)
    axes.set(xlim=(-_BACK_M, _AHEAD_M), ylim=(middle - half, middle + half), aspect="equal")
    told = "" if moment.plan is None else f", {moment.plan.mode.value}, {moment.plan.status.value}"
    axes.set_ylabel(f"{moment.time_s - time_s:+.1f} s{told}", fontsize=6)
    axes.set(xticks=[], yticks=[])
    axes.grid(False)


def _seen(near: Sequence[Snapshot], other: str) -> list[tuple[float, Placed, Placed]]:
    return [(one.time_s, one.host, body) for one in near for body in one.others if body.id == other]


def _speeds(axes: Axes, near: Sequence[Snapshot], other: str, time_s: float) -> None:
    axes.plot([one.time_s - time_s for one in near], [one.host.speed_mps for one in near], color=style.HOST, label="host")
    seen = _seen(near, other)
    axes.plot([t - time_s for t, _, _ in seen], [body.speed_mps for _, _, body in seen], color=style.VERMILION, label=other)
    axes.axvline(0.0, color=style.GREY, lw=0.8)
    axes.set(title="speed [m/s]", xlabel="s")
    axes.legend(loc="best")


def _gap(axes: Axes, near: Sequence[Snapshot], other: str, time_s: float) -> None:
    seen = _seen(near, other)
    gaps: Array = np.array([abs(body.s_m - host.s_m) - 0.5 * (body.length_m + host.length_m) for _, host, body in seen])
    axes.plot([t - time_s for t, _, _ in seen], gaps, color=style.BLACK)
    axes.axvline(0.0, color=style.GREY, lw=0.8)
    axes.set(title=f"gap along the road to {other} [m]", xlabel="s", ylim=(min(0.0, float(gaps.min(initial=0.0))), None))
