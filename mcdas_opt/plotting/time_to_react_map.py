"""Time to react over (front gap, rear closing speed), with the paper's Table 1 drawn over it as it is printed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mcdas_opt.plotting import style
from mcdas_opt.situation.table1 import D_PR_M, MODES
from mcdas_opt.time_to_react.library import KINDS
from mcdas_opt.time_to_react.sweep import EscapeSweep

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LEVELS = (0.0, 0.25, 0.5, 1.0, 2.0, 4.0, 10.0)


def time_to_react_map(sweep: EscapeSweep) -> Figure:
    """Four panels, one for each manoeuvre: coloured by its last moment where it is open, hatched where it is closed."""
    from matplotlib import colormaps
    from matplotlib.colors import BoundaryNorm
    from matplotlib.patches import Patch

    with style.styled():
        fig = style.figure(9.6, 6.6)
        panels = fig.subplots(2, 2, sharex=True, sharey=True)
        norm = BoundaryNorm(_LEVELS, 256)
        mesh = None
        for k, (axes, title) in enumerate(zip(panels.flat, KINDS, strict=True)):
            moments = np.ma.masked_invalid(sweep.last_moment_s[k])
            axes.set_facecolor("#ececef")
            mesh = axes.pcolormesh(sweep.front_gap_m, sweep.closing_mps, moments, cmap=colormaps["cividis"], norm=norm, shading="nearest")
            closed = np.isnan(sweep.last_moment_s[k]).astype(float)
            if closed.any() and not closed.all():
                axes.contour(sweep.front_gap_m, sweep.closing_mps, closed, levels=[0.5], colors=style.BLACK, linewidths=1.4)
            axes.set_title(title if not closed.all() else f"{title}: closed everywhere")
            axes.grid(False)
            _table1(axes, sweep)
        for axes in panels[1]:
            axes.set_xlabel("gap to the car ahead [m]")
        for axes in panels[:, 0]:
            axes.set_ylabel("rear closing speed [m/s]")
        assert mesh is not None
        bar = fig.colorbar(mesh, ax=panels, shrink=0.85, ticks=_LEVELS, format="%g")
        bar.set_label("last moment to start [s]")
        fig.suptitle(
            f"Time to react at {sweep.host_mps:.1f} m/s, front car at {sweep.front_mps:.1f} m/s, rear car {sweep.rear_gap_m:.0f} m behind",
            fontsize=11, fontweight="bold", x=0.01, ha="left",
        )  # fmt: skip
        handles = [Patch(facecolor="#ececef", edgecolor=style.BLACK, label="closed now and later")]
        handles.append(Patch(fill=False, edgecolor=style.VERMILION, lw=1.8, hatch="//", label=_table1_words(sweep)))
        fig.legend(handles=handles, loc="outside lower left", ncols=2, frameon=False)
    return fig


def _table1(axes: Axes, sweep: EscapeSweep) -> None:
    """Outlines and hatches where Table 1 has a row."""
    has = (sweep.table1_row > 0).astype(float)
    if not has.any():
        return
    hatched = axes.contourf(sweep.front_gap_m, sweep.closing_mps, has, levels=[0.5, 1.5], hatches=["//"], colors="none")
    hatched.set_edgecolor(style.VERMILION)
    hatched.set_linewidth(0.0)
    axes.contour(sweep.front_gap_m, sweep.closing_mps, has, levels=[0.5], colors=style.VERMILION, linewidths=1.8)


def _table1_words(sweep: EscapeSweep) -> str:
    rows = sorted(set(sweep.table1_row[sweep.table1_row > 0].tolist()))
    if not rows:
        return f"Table 1 has no mode anywhere here (rear gap {'at least' if sweep.rear_gap_m >= D_PR_M else 'below'} {D_PR_M:g} m)"
    return f"Table 1, literally: {', '.join(MODES[row - 1] for row in rows)}; no mode elsewhere"
