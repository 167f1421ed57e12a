"""A study drawn: its Pareto front in three planes, and which values mattered."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mcdas_opt.plotting import style

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Point = Sequence[float]
_LABELS = ("peak lateral acc. [m/s²]", "peak jerk [m/s³]", "beside lane middle [m]")


def study_sheet(
    *,
    objectives: Sequence[Point],
    front: Sequence[Point],
    chosen: Point,
    default: Point | None,
    importance: Mapping[str, float],
    title: str,
) -> Figure:
    """Collisions against each comfort; every trial that was driven to its end, the front, the defaults and the chosen one."""
    everyone, best = np.array(objectives).reshape(-1, 4), np.array(front).reshape(-1, 4)
    with style.styled():
        fig = style.figure(11.0, 6.0)
        fig.suptitle(title, x=0.01, ha="left", fontsize=10.5, fontweight="bold")
        grid = fig.add_gridspec(2, 3, height_ratios=[1.3, 1.0])
        for column, label in enumerate(_LABELS, start=1):
            axes = fig.add_subplot(grid[0, column - 1])
            axes.scatter(everyone[:, column], 100.0 * everyone[:, 0], s=16, color=style.GREY, alpha=0.6, label="trial")
            axes.scatter(best[:, column], 100.0 * best[:, 0], s=30, color=style.SKY, edgecolor=style.BLUE, lw=0.8, label="front")
            if default is not None:
                axes.scatter([default[column]], [100.0 * default[0]], s=60, marker="s", color=style.ORANGE, label="defaults")
            axes.scatter([chosen[column]], [100.0 * chosen[0]], s=90, marker="*", color=style.VERMILION, label="chosen")
            axes.set(xlabel=label, ylabel="collisions [%]" if column == 1 else "")
            low, high = axes.get_ylim()
            axes.set_ylim(min(low, -2.0), max(high, 10.0))
            if column == 3:
                axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
        bars = fig.add_subplot(grid[1, :])
        names = list(importance)[::-1]
        if names:
            bars.barh(names, [importance[name] for name in names], color=style.GREEN)
            bars.set_xlabel("importance for the score (PED-ANOVA) [-]")
        else:
            bars.text(0.5, 0.5, "too few trials to tell which values mattered", ha="center", va="center", transform=bars.transAxes)
            bars.set_axis_off()
    return fig
