"""Pictures of a benchmark: losses by family, clearance against comfort, and how long plans take."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.plotting import style
from mcdas_opt.plotting.style import figure, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = (style.BLUE, style.VERMILION, style.GREEN, style.ORANGE, style.PURPLE, style.SKY, style.GREY, style.BLACK)
_FARTHEST_M = 6.0  # clearance beyond this is drawn at the edge
_HARDEST_MPS2 = 13.0  # so is acceleration: a wall brakes harder than tyres
_ABREAST = 3  # panels
Interval = tuple[float, float, float, int]  # rate, low, high, n


def draw_families(shares: Mapping[str, Mapping[str, Interval]], planners: Sequence[str], says: str) -> Figure:
    """`shares[family][planner]`: a bar for each with its interval; families from top to bottom."""
    families = list(shares)
    with styled():
        fig = figure(8.8, 0.9 + len(families) * (0.24 * len(planners) + 0.22))
        axes = fig.subplots()
        tall = 0.84 / len(planners)
        for k, planner in enumerate(planners):
            rows = [(i, shares[family][planner]) for i, family in enumerate(families) if planner in shares[family]]
            y = np.array([i + (k - 0.5 * (len(planners) - 1)) * tall for i, _ in rows])
            rate, low, high = (np.array([found[part] for _, found in rows]) for part in range(3))
            colour = _COLOURS[k % len(_COLOURS)]
            axes.barh(y, 100.0 * rate, height=0.86 * tall, color=colour, alpha=0.85, label=planner, zorder=2)
            axes.hlines(y, 100.0 * low, 100.0 * high, color=style.BLACK, lw=1.1, zorder=3)
            axes.plot(100.0 * rate, y, marker="|", ms=4.5, color=style.BLACK, lw=0, zorder=3)
        counts = [max((found[3] for found in shares[family].values()), default=0) for family in families]
        axes.set_yticks(
            range(len(families)),
            [f"{family}\n{count} scene{'' if count == 1 else 's'}" for family, count in zip(families, counts, strict=True)],
        )
        axes.set(xlim=(0.0, 100.0), ylim=(len(families) - 0.5, -0.5), xlabel=says)
        axes.grid(axis="y", visible=False)
        fig.legend(loc="outside upper center", ncols=min(len(planners), 4), frameon=False)
    return fig


def draw_scatter(points: Mapping[str, Array]) -> Figure:
    """`points[planner]` (n, 3): least clearance [m], largest acceleration [m/s^2], and 1 where the drive was lost. A panel each."""
    planners = list(points)
    columns = min(len(planners), _ABREAST)
    rows = -(-len(planners) // columns)
    with styled():
        fig = figure(2.8 * columns + 0.8, 2.5 * rows + 0.9)
        grid = fig.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
        for k, axes in enumerate(grid.flat):
            if k >= len(planners):
                axes.set_axis_off()
                continue
            found = points[planners[k]]
            safe = found[:, 2] == 0.0
            x, y = np.clip(found[:, 1], 0.0, _HARDEST_MPS2), np.clip(found[:, 0], 0.0, _FARTHEST_M)
            axes.plot(x[safe], y[safe], "o", ms=3.0, mew=0, alpha=0.45, color=style.BLUE, label="safe")
            axes.plot(x[~safe], y[~safe], "x", ms=3.6, mew=1.0, alpha=0.8, color=style.VERMILION, label="lost")
            axes.set_title(f"{planners[k]}\n{int((~safe).sum())} of {len(found)} lost", fontsize=9)
            axes.set(xlim=(-0.3, _HARDEST_MPS2 + 0.3), ylim=(-0.3, _FARTHEST_M + 0.3))
            axes.tick_params(labelbottom=k + columns >= len(planners))  # the lowest of its column, where the last row is short
        fig.supxlabel(f"largest acceleration [m/s²] ({_HARDEST_MPS2:g}: that or more)", fontsize=9)
        fig.supylabel(f"least clearance [m] ({_FARTHEST_M:g}: that or more)", fontsize=9)
        _legend(fig, grid.flat[0])
    return fig


def draw_cycle_times(times_ms: Mapping[str, Array]) -> Figure:
    """The share of plans that took longer than so many milliseconds, both axes logarithmic."""
    from matplotlib.ticker import LogFormatter

    with styled():
        fig = figure(8.0, 3.8)
        axes = fig.subplots()
        for k, (planner, times) in enumerate(times_ms.items()):
            if not times.size:
                continue
            ordered = np.sort(np.maximum(times, 1e-2))
            left = 1.0 - np.arange(ordered.size) / ordered.size
            axes.step(ordered, left, where="post", color=_COLOURS[k % len(_COLOURS)], lw=1.6, label=f"{planner} ({times.size} plans)")
        for level, name in ((0.5, "p50"), (0.01, "p99"), (0.001, "p99.9")):
            axes.axhline(level, color=style.GREY, lw=0.8, ls=(0, (4, 3)), zorder=1)
            axes.annotate(
                name, (1.0, level), (3, 0), xycoords=("axes fraction", "data"), textcoords="offset points", va="center", fontsize=8
            )
        axes.set(xscale="log", yscale="log", xlabel="time for a plan [ms]", ylabel="share of plans that took longer", ylim=(None, 1.15))
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_formatter("{x:g}")
        axes.xaxis.set_minor_formatter(LogFormatter(labelOnlyBase=False, minor_thresholds=(1.5, 0.6)))
        if any(times.size for times in times_ms.values()):  # else no planner made a single plan
            fig.legend(loc="outside upper center", ncols=3, frameon=False)
    return fig


def _legend(fig: Figure, axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    fig.legend(handles, labels, loc="outside upper right", ncols=2, frameon=False, markerscale=1.6)
