"""Strip charts of a drive: speed, acceleration, lateral acceleration, clearance, with their limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.plotting import style
from mcdas_opt.simulation.record import Simulation

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

_WORD, _TALL = 0.45, 0.13  # of a limit, in parts of the chart
_FAR_M = 30.0  # farther away is off the chart, unless nobody ever comes nearer


@dataclass(frozen=True, slots=True, kw_only=True)
class Strip:
    """One chart: a quantity over time and the lines that it should not cross, each with a word."""

    title: str
    t_s: Array
    values: Array
    limits: tuple[tuple[float, str], ...]
    low: float
    high: float


def strips_of(simulation: Simulation) -> tuple[Strip, Strip, Strip, Strip]:
    """Speed, acceleration, lateral acceleration and clearance over the drive."""
    history, scene = simulation.history, simulation.scene
    t = history.t_s
    speed = history.states[:, 3]
    wanted = scene.desired_speed_mps
    turning = history.lateral_acceleration_mps2
    grip = scene.true_road.grip_mps2
    hardest, most = max(scene.vehicle.acceleration_min_mps2, -grip), min(scene.vehicle.acceleration_max_mps2, grip)
    clearance = history.clearance_m
    known = bool(np.isfinite(clearance).all())
    top = max(min(1.08 * float(clearance.max()), _FAR_M), 1.3 * float(clearance.min())) if known else 10.0
    return (
        Strip(
            title="speed [m/s]",
            t_s=t,
            values=speed,
            limits=((wanted, "desired"),),
            low=max(min(float(speed.min()), wanted) - 3.0, 0.0),
            high=max(float(speed.max()), wanted) + 3.0,
        ),
        Strip(
            title="acceleration [m/s²]",
            t_s=t,
            values=history.states[:, 4],
            limits=((hardest, "hardest braking"), (most, "most")),
            low=1.3 * hardest,
            high=most - 0.25 * hardest,
        ),
        Strip(
            title="lateral acceleration [m/s²]",
            t_s=t[:-1],
            values=turning,
            limits=((grip, "grip"), (-grip, "grip")),
            low=-1.15 * grip,
            high=1.15 * grip,
        ),
        Strip(
            title="clearance to the nearest [m]",
            t_s=t,
            values=np.where(np.isfinite(clearance), clearance, np.nan),
            limits=((0.0, "touch"),),
            low=-0.13 * top,
            high=top,
        ),
    )


class StripChart:
    """Draws a strip; `show(t)` reveals it up to a time and puts a dot there."""

    def __init__(self, axes: Axes, strip: Strip, duration_s: float) -> None:
        from matplotlib.lines import Line2D

        self._strip = strip
        axes.set(xlim=(0.0, duration_s), ylim=(strip.low, strip.high), xlabel="time [s]")
        axes.set_title(strip.title, fontsize=9.0, fontweight="normal")
        for value, word in strip.limits:
            colour = style.GREY if word == "desired" else style.VERMILION
            axes.axhline(value, color=colour, lw=1.1, dashes=(4, 3), zorder=1)
            others = [other for other, _ in strip.limits if other != value]
            name_limit(axes, value, word, colour, strip.t_s, strip.values, others)
        axes.plot(strip.t_s, strip.values, color=style.HOST, lw=1.0, alpha=0.25, zorder=2)
        self._line = Line2D([], [], color=style.HOST, lw=1.8, zorder=3)
        self._dot = Line2D([], [], color=style.HOST, marker="o", ms=4.5, mec="white", mew=0.8, lw=0, zorder=4, clip_on=False)
        axes.add_line(self._line)
        axes.add_line(self._dot)

    @property
    def artists(self) -> list[Artist]:
        return [self._line, self._dot]

    def show(self, time_s: float) -> None:
        past = self._strip.t_s <= time_s + 1e-9
        self._line.set_data(self._strip.t_s[past], self._strip.values[past])
        if past.any():
            at = self._strip.values[past][-1:]
            at = np.where(
                (at >= self._strip.low) & (at <= self._strip.high), at, np.nan
            )  # the dot is not cut off, but off the chart there is none
            self._dot.set_data(self._strip.t_s[past][-1:], at)


def name_limit(axes: Axes, value: float, word: str, colour: str, t_s: Array, values: Array, others: Sequence[float] = ()) -> None:
    """The word of a limit beside its line, where neither the curve nor another limit comes: at the right and above where there is the
    choice."""
    (begin, end), (low, high) = axes.get_xlim(), axes.get_ylim()
    length, tall = _WORD * (end - begin), high - low

    def room(right: bool, above: bool) -> float:
        middle = value + (0.5 if above else -0.5) * _TALL * tall
        if not low <= middle - 0.3 * _TALL * tall <= middle + 0.3 * _TALL * tall <= high:
            return -1.0
        beside = values[t_s >= end - length] if right else values[t_s <= begin + length]
        return float(np.abs(np.concatenate([beside[np.isfinite(beside)], others]) - middle).min(initial=tall)) / tall

    places = [(right, above) for right in (True, False) for above in (True, False)]
    right, above = next((place for place in places if room(*place) > 0.6 * _TALL), max(places, key=lambda place: room(*place)))
    axes.annotate(
        word,
        (1.0 if right else 0.0, value),
        (-2 if right else 3, 2 if above else -2),
        xycoords=("axes fraction", "data"),
        textcoords="offset points",
        ha="right" if right else "left",
        va="bottom" if above else "top",
        fontsize=7.0,
        color=colour,
    )


def mark_times(axes: Axes, times_s: Sequence[float]) -> None:
    """Thin lines at moments that are shown elsewhere in the figure."""
    for t in times_s:
        axes.axvline(t, color=style.BLACK, lw=0.7, alpha=0.35, zorder=1)
