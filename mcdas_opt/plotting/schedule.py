"""A gain schedule drawn: a, b and the manoeuvre's length over speed, one line a friction, the paper's own beside them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mcdas_opt.domain.gain_schedule import GainSchedule
from mcdas_opt.plotting import style
from mcdas_opt.reference.literal import A_PER_M, SETTLING_X_M, B

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLOURS = (style.SKY, style.BLUE, style.GREEN, style.ORANGE, style.VERMILION)
_MARKS = ("o", "s", "^", "D", "v")


def schedule_sheet(schedule: GainSchedule, offset_m: float = 0.0) -> Figure:
    """At the crossing nearest to `offset_m`."""
    j = int(np.argmin(np.abs(np.array(schedule.offset_m) - offset_m)))
    speeds = 3.6 * np.array(schedule.speed_mps)
    panels = (
        (schedule.a_per_m, "a [1/m]", A_PER_M, "paper: a = -0.4"),
        (schedule.b, "b [-]", B, "paper: b = 50"),
        (schedule.length_m, "length [m]", SETTLING_X_M, "paper: 20 m"),
    )
    with style.styled():
        fig = style.figure(9.6, 3.4)
        for axes, (table, label, paper, words) in zip(fig.subplots(1, 3), panels, strict=True):
            for i, friction in enumerate(schedule.friction):
                mark, colour = _MARKS[i % len(_MARKS)], _COLOURS[i % len(_COLOURS)]
                axes.plot(speeds, table[i, j], color=colour, marker=mark, ms=3.5, lw=1.5, label=f"friction {friction:g}")
            axes.axhline(paper, color=style.LITERAL, ls="--", lw=1.2, label=words)
            axes.set(xlabel="speed [km/h]", ylabel=label)
            axes.set_title(label.split(" ")[0])
            axes.legend()
    return fig
