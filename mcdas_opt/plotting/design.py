"""A designed sigmoid: the path from above, and what it asks of the car, beside the paper's own."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.sigmoid_design import SigmoidDesign
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.dynamics.sigmoid import renormalised, sigmoid
from mcdas_opt.plotting import style
from mcdas_opt.reference.literal import A_PER_M, Y_MAX_M, B

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SAMPLES = 600


def design_sheet(
    design: SigmoidDesign,
    *,
    speed_mps: float,
    lane_width_m: float,
    length_m: float,
    lateral_limit_mps2: float,
    jerk_limit_mps3: float,
    vehicle: Vehicle,
    title: str,
) -> Figure:
    """Path, lateral acceleration K^2 y'' and lateral jerk over x; the paper's a = -0.4, b = 50 dashed, cut off where it leaves the axes."""
    sign = float(design.side.sign)
    x = np.linspace(0.0, design.end_m, _SAMPLES)
    gain = design.reach_m * (design.b + 1.0) / (design.b - 1.0)
    paper_reach = Y_MAX_M + sign * design.offset_m
    bend, third = _derivatives(x, design.a_per_m, design.b, gain)
    paper_bend, paper_third = _derivatives(x, A_PER_M, B, paper_reach)
    y = design.reach_m * renormalised(x, design.a_per_m, design.b, np)
    paper_y = paper_reach * (sigmoid(x, A_PER_M, B, np) - 1.0 / (1.0 + B))
    with style.styled():
        fig = style.figure(9.2, 6.4)
        above, push, jolt = fig.subplots(3, 1, sharex=True, height_ratios=[1.5, 1.0, 1.0])
        lanes = {"lanes_left": 1} if design.side is Side.LEFT else {"lanes_right": 1}
        road = Road(lane_width_m=lane_width_m, lanes_left=lanes.get("lanes_left", 0), lanes_right=lanes.get("lanes_right", 0))
        ahead = design.end_m + 6.0
        style.draw_road(above, road, -6.0, ahead)
        style.draw_body(above, 0.0, 0.0, 0.0, vehicle.length_m, vehicle.width_m, style.HOST, alpha=0.35)
        above.plot(x, sign * y, color=style.CORRECTED, label=f"designed: a = {design.a_per_m:.4f} 1/m, b = {design.b:.1f}")
        above.plot(x, sign * paper_y, color=style.LITERAL, ls="--", lw=1.3, label="paper: a = -0.4 1/m, b = 50")
        reached = float(np.interp(length_m, x, y))
        above.plot([length_m], [sign * reached], "o", color=style.BLACK, ms=5, label=f"within 0.1 m of the lane centre: {length_m:.1f} m")
        above.set(ylabel="y, left [m]", xlim=(-6.0, ahead), title=title)
        above.legend(loc="upper left" if sign > 0.0 else "lower left", ncols=3)
        if sign > 0.0:
            above.set_ylim(road.right_edge_m - 0.3, road.left_edge_m + 2.2)
        else:
            above.set_ylim(road.right_edge_m - 2.2, road.left_edge_m + 0.3)
        v = speed_mps
        _profile(push, x, sign * v**2 * bend, sign * v**2 * paper_bend, lateral_limit_mps2, "lateral acc. [m/s²]")
        _profile(jolt, x, sign * v**3 * third, sign * v**3 * paper_third, jerk_limit_mps3, "lateral jerk [m/s³]")
        jolt.set_xlabel("x [m]")
    return fig


def _derivatives(x: Array, a: float, b: float, gain: float) -> tuple[Array, Array]:
    """Second and third derivative of gain S(x)."""
    shape = sigmoid(x, a, b, np)
    q = shape * (1.0 - shape)
    return gain * a**2 * q * (1.0 - 2.0 * shape), -gain * a**3 * q * (1.0 - 6.0 * q)


def _profile(axes: Axes, x: Array, ours: Array, paper: Array, limit: float, label: str) -> None:
    axes.plot(x, paper, color=style.LITERAL, ls="--", lw=1.3)
    axes.plot(x, ours, color=style.CORRECTED)
    for level in (limit, -limit):
        axes.axhline(level, color=style.VERMILION, lw=1.0, ls=":")
    peak = float(np.abs(paper).max())
    room = 1.35 * max(limit, float(np.abs(ours).max())) if peak > limit else 1.35 * limit
    axes.set(ylabel=label, ylim=(-room, room))
    words = f"limit {limit:.3g}; designed {float(np.abs(ours).max()):.3g}; paper {peak:.3g}"
    axes.text(0.995, 0.96, words, transform=axes.transAxes, ha="right", va="top", fontsize=8.0)
