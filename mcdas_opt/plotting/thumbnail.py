"""A drive in one picture: three moments from above, the last one its end."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mcdas_opt.plotting.birdseye import BirdsEye
from mcdas_opt.plotting.moments import moment_at, view_of
from mcdas_opt.plotting.style import figure, styled
from mcdas_opt.simulation.record import Outcome, Simulation

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_BEFORE_S = 1.0  # the moment before the end that tells most


def draw_thumbnail(simulation: Simulation) -> Figure:
    """The beginning, a second before the end (of a safe drive: where the others came nearest), and the end."""
    view, end = view_of(simulation), simulation.duration_s
    told = max(end - _BEFORE_S, 0.5 * end)
    if simulation.outcome is Outcome.SAFE and simulation.neighbours:
        told = float(simulation.history.t_s[int(simulation.history.clearance_m.argmin())])
    times = sorted({0.0, round(told, 2), end})
    row = 5.4 * view.aspect + 0.26
    with styled():
        fig = figure(5.6, len(times) * row + 0.06)
        fig.set_layout_engine("none")
        height = fig.get_figheight()
        for k, t in enumerate(times):
            axes = fig.add_axes((0.018, 1.0 - ((k + 1) * row) / height, 0.964, (row - 0.26) / height))
            moment = moment_at(simulation, t)
            BirdsEye(axes, simulation.scene.true_road, view, simulation.trajectory).show(moment)
            axes.set(xticks=[], yticks=[])
            axes.set_title(f"{t:.1f} s  {moment.speed_mps:.1f} m/s  {moment.action}", fontsize=8, fontweight="normal", pad=2)
            for spine in axes.spines.values():
                spine.set_visible(False)
    return fig
