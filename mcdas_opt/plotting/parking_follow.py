"""A followed parking manoeuvre drawn: what was planned and what was driven, speed over time, and what happened when."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.geometry.clearance import Body, body_corners
from mcdas_opt.parking.closed_loop.record import ParkingDrive
from mcdas_opt.plotting import style
from mcdas_opt.plotting.asked import case_of
from mcdas_opt.plotting.parking import moving, save_gif, yard

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BODIES = 40
_SHOWN = 110  # letters of an event


def film(drive: ParkingDrive, path: Path) -> Path:
    """Writes an animation (.gif)."""
    return save_gif(*moving(case_of(drive), drive.trajectory, drive.visitors), path)


def sheet(drive: ParkingDrive) -> Figure:
    """The plane above: body, planned and driven paths, people. Below: speed, and the distance to what was planned, over time."""
    with style.styled():
        fig = style.figure(9.6, 7.8)
        above, speed, off = fig.subplots(3, 1, height_ratios=[2.6, 1.0, 1.0])
        _plane(above, case_of(drive), drive)
        fig.legend(loc="outside right upper")
        t = drive.trajectory.t_s
        speed.plot(t, drive.trajectory.speed_mps, color=style.BLUE)
        speed.axhline(0.0, color=style.BLACK, lw=0.8)
        speed.set_ylabel("speed [m/s]")
        apart = _to_plans(drive)
        off.plot(t, 100.0 * apart, color=style.PURPLE)
        off.set(ylabel="off the plans [cm]", xlabel="time [s]")
        off.set_ylim(bottom=0.0)
        off.sharex(speed)
        for axes in (speed, off):
            for event in drive.events:
                axes.axvline(event.time_s, color=style.VERMILION, ls=":", lw=1.2)
        if drive.events:
            told = [f"{event.time_s:.1f} s  {_short(event.text)}" for event in drive.events[:6]]
            fig.supxlabel("\n".join(told), x=0.06, ha="left", fontsize=8, color=style.VERMILION)
    return fig


def _plane(axes: Axes, truth: ParkingCase, drive: ParkingDrive) -> None:
    driven = drive.trajectory
    corners = body_corners(driven.poses, Body.of(truth.vehicle))
    for k in range(0, len(driven), max(1, len(driven) // _BODIES)):
        axes.fill(*corners[k].T, facecolor="none", edgecolor=style.SKY, lw=0.5, alpha=0.6)
    axes.fill(*corners[-1].T, facecolor=style.BLUE, edgecolor=style.BLACK, lw=1.0, alpha=0.45, label="car at the end", zorder=3)
    goal = body_corners(truth.goal[None], Body.of(truth.vehicle))[0]
    axes.fill(*goal.T, facecolor="none", edgecolor=style.GREEN, lw=1.6, ls="--", label="goal", zorder=4)
    for number, plan in enumerate(drive.references):
        axes.plot(plan.x_m, plan.y_m, color=style.GREY, lw=2.6, alpha=0.7, label="planned" if number == 0 else None, zorder=5)
    axes.plot(driven.x_m, driven.y_m, color=style.BLUE, lw=1.2, label="driven (rear axle)", zorder=6)
    for number, visitor in enumerate(drive.visitors):
        axes.fill(*visitor.outline().T, facecolor=style.VERMILION, edgecolor=style.BLACK, label="person" if number == 0 else None, zorder=7)
    shown = np.concatenate([corners.reshape(-1, 2), goal, *(visitor.outline() for visitor in drive.visitors)])
    yard(axes, truth, shown)
    axes.set_title(f"{drive.name}, {drive.planner}: {drive_words(drive)}")


def drive_words(drive: ParkingDrive) -> str:
    """How it went, in a sentence."""
    least = "" if drive.min_clearance_m is None else f", least clearance {100.0 * drive.min_clearance_m:.1f} cm"
    again = f", {drive.replans} plan{'' if drive.replans == 1 else 's'} anew" if drive.replans else ""
    return f"{drive.outcome} after {drive.duration_s:.1f} s{least}{again}"


def _short(text: str) -> str:
    return text if len(text) <= _SHOWN else text[: _SHOWN - 1] + "…"


def _to_plans(drive: ParkingDrive) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Distance [m] of the driven rear axle from the nearest planned place."""
    here = drive.trajectory.poses[:, :2]
    if not drive.references:
        return np.zeros(len(here))
    planned = np.concatenate([plan.poses[:, :2] for plan in drive.references])
    first, second = planned[:-1], planned[1:]
    edge = second - first
    square = np.maximum((edge * edge).sum(1), 1e-12)
    apart = np.empty(len(here))
    for k, place in enumerate(here):
        share = np.clip(((place - first) * edge).sum(1) / square, 0.0, 1.0)
        nearest = first + share[:, None] * edge
        apart[k] = np.hypot(*(place - nearest).T).min()
    return apart
