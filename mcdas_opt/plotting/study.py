"""A study drawn: its Pareto front in three planes, and which values mattered."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

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
    """Each pair of comforts, collisions by colour; every trial driven to its end, the front ringed, the defaults and the chosen one."""
    everyone, best = np.array(objectives).reshape(-1, 4), np.array(front).reshape(-1, 4)
    with style.styled():
        fig = style.figure(11.0, 6.0)
        fig.suptitle(title, x=0.01, ha="left", fontsize=10.5, fontweight="bold")
        grid = fig.add_gridspec(2, 3, height_ratios=[1.3, 1.0 if importance else 0.15])
        most = max(100.0 * float(everyone[:, 0].max(initial=0.0)), 10.0)
        planes = []
        for column, (i, j) in enumerate(((1, 2), (1, 3), (2, 3))):
            axes = fig.add_subplot(grid[0, column])
            planes.append(axes)
            shade: Any = {"cmap": "cividis_r", "vmin": 0.0, "vmax": most}
            dots = axes.scatter(everyone[:, i], everyone[:, j], c=100.0 * everyone[:, 0], s=26, lw=0.4, edgecolor=style.GREY, **shade)
            axes.scatter(best[:, i], best[:, j], s=80, facecolor="none", edgecolor=style.BLUE, lw=1.3, label="front")
            if default is not None:
                axes.scatter(
                    [default[i]], [default[j]], s=70, marker="s", facecolor="none", edgecolor=style.ORANGE, lw=1.8, label="defaults"
                )
            axes.scatter([chosen[i]], [chosen[j]], s=90, marker="*", color=style.VERMILION, label="chosen")
            axes.set(xlabel=_LABELS[i - 1], ylabel=_LABELS[j - 1])
            axes.margins(0.12)
        fig.colorbar(dots, ax=planes, label="collisions [%]", pad=0.01)
        fig.legend(*planes[-1].get_legend_handles_labels(), loc="upper right", ncols=3)
        bars = fig.add_subplot(grid[1, :])
        names = list(importance)[::-1]
        if names:
            bars.barh(names, [importance[name] for name in names], color=style.GREEN)
            bars.set_xlabel("importance for the score (PED-ANOVA) [-]")
        else:
            bars.text(0.5, 0.5, "too few trials to tell which values mattered", ha="center", va="center", transform=bars.transAxes)
            bars.set_axis_off()
    return fig
