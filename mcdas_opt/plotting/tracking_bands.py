"""Figures 7-9 of the paper as distributions: the tracked paths, the filter's errors, the predicted crash position."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.plotting import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BAND = (2.5, 97.5)


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackingBands:
    """A Monte Carlo study: true positions (samples,), errors of estimates (runs, samples) [m], predicted crash positions [m]."""

    t_s: Array
    rear_x_m: Array
    front_x_m: Array
    host_x_m: Array
    rear_error_x: Array
    rear_error_y: Array
    front_error_x: Array
    front_error_y: Array
    crash_m: Array
    true_crash_m: float
    zone_m: tuple[float, float]
    chosen: str


def draw_trajectory_band(bands: TrackingBands, who: Literal["rear", "front"]) -> Figure:
    """Figure 7 (rear) or 8 (front): the estimated path beside the true one, and the band of the estimation error over x."""
    rear = who == "rear"
    x = bands.rear_x_m if rear else bands.front_x_m
    ex, ey = (bands.rear_error_x, bands.rear_error_y) if rear else (bands.front_error_x, bands.front_error_y)
    colour = style.REAR if rear else style.FRONT
    number, name, speed = ("7", "rear vehicle", 60) if rear else ("8", "front vehicle", 40)
    with style.styled():
        fig = style.figure(8.0, 6.6)
        top, across, along = fig.subplots(3, 1, sharex=True, height_ratios=[1.0, 1.2, 1.2])
        style.draw_road(top, Road(lanes_left=1, lanes_right=1), x[0] - 8.0, x[-1] + 8.0)
        top.plot(x, 0 * x, color=style.BLUE, lw=1.2, label="true path", zorder=3)
        top.plot(x + ex[0], ey[0], "o--", color=colour, ms=3.5, lw=1.0, label="estimated path, one run", zorder=5)
        for k in (0, -1):
            style.draw_body(top, x[k], 0.0, 0.0, 4.5, 1.8, style.BLUE, alpha=0.35)
            style.draw_body(top, x[k] + ex[0, k], ey[0, k], 0.0, 4.5, 1.8, colour, alpha=0.55)
        top.set(ylabel="y [m], left up", title=f"Figure {number}: estimated trajectory of the {name}, {speed} km/h, 11 samples of 0.5 s")
        top.legend(loc="upper center", ncols=2, bbox_to_anchor=(0.5, 0.97))
        for axes, error, what in ((across, ey, "y"), (along, ex, "x")):
            _band(axes, x, error, colour)
            axes.set_ylabel(f"estimated {what} - true {what} [m]")
        for sign in (-1, 1):
            across.axhline(0.2 * sign, color=style.GREY, ls=":", lw=1.2, label="the paper's ±0.2 m at the start" if sign > 0 else None)
        across.set_ylim(-0.25, 0.34)
        across.legend(loc="upper center", ncols=3)
        along.set_xlabel("x from the rear vehicle's start [m]")
        fig.supxlabel(_wrapped(bands.chosen), fontsize=7.5, color=style.EDGE)
    return fig


def draw_figure_9(bands: TrackingBands) -> Figure:
    """Figure 9: rear and host over time until they meet, and the crash position that the filter predicts on the way."""
    meeting = (bands.true_crash_m - bands.rear_x_m[0]) / (bands.rear_x_m[-1] / bands.t_s[-1])
    low, high = bands.zone_m
    with style.styled():
        fig = style.figure(9.0, 4.6)
        left, right = fig.subplots(1, 2, width_ratios=[1.25, 1.0])
        t = np.array([0.0, meeting])
        for x, colour, name in ((bands.rear_x_m, style.REAR, "rear, 60 km/h"), (bands.host_x_m, style.HOST, "host, 40 km/h")):
            rate = (x[-1] - x[0]) / bands.t_s[-1]
            left.plot(t, x[0] + rate * t, color=colour, label=f"true path, {name}")
        estimate = bands.rear_x_m + bands.rear_error_x[0]
        left.plot(bands.t_s, estimate, "o", color=style.REAR, mfc="white", ms=4, label="estimates of the rear, one run")
        left.plot([meeting], [bands.true_crash_m], marker="X", color=style.BLACK, ms=9, ls="none", label="they meet", zorder=6)
        left.set(xlabel="time [s]", ylabel="x from the rear vehicle's start [m]", title="Figure 9: rear and host until the crash")
        _band(right, bands.t_s, bands.crash_m, style.GREEN)
        right.axhline(bands.true_crash_m, color=style.BLACK, lw=1.0, ls="--", label=f"truth, {bands.true_crash_m:.0f} m = 3 x gap")
        right.set(
            xlabel="time of the prediction [s]",
            ylabel="predicted crash position [m]",
            ylim=(96.0, 138.0),
            title="crash position as the filter predicts it",
        )
        for axes in (left, right):
            axes.axhspan(low, high, color=style.YELLOW, alpha=0.35, lw=0, label="the paper's crash zone", zorder=0)
        left.legend(loc="lower right")
        right.legend(loc="upper right")
        fig.supxlabel(_wrapped(bands.chosen), fontsize=7.5, color=style.EDGE)
    return fig


def _band(axes: Axes, x: Array, values: Array, colour: str) -> None:
    low, middle, high = np.percentile(values, [_BAND[0], 50.0, _BAND[1]], axis=0)
    axes.fill_between(x, low, high, color=colour, alpha=0.25, lw=0, label=f"95 % of {len(values)} runs")
    axes.plot(x, values[:12].T, color=colour, lw=0.5, alpha=0.5)
    axes.plot(x, middle, color=colour, label="median")


def _wrapped(text: str) -> str:
    import textwrap

    return "\n".join(textwrap.wrap(text, 120))
