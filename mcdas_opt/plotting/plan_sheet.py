"""One plan as a picture, still or moving: the road from above with what is predicted, and what the plan asks of the car."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.safe_end import EndKind
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.geometry.rectangle import corners
from mcdas_opt.plotting import style
from mcdas_opt.plotting.animation import MOST_FRAMES, save_gif
from mcdas_opt.plotting.asked import situation_of
from mcdas_opt.plotting.birdseye import BirdsEye, Camera, framed, legend_handles, scale_bar
from mcdas_opt.plotting.moments import View
from mcdas_opt.plotting.outlook import Outlook
from mcdas_opt.plotting.strips import name_limit
from mcdas_opt.plotting.time_to_react_timeline import draw_timeline
from mcdas_opt.plotting.words import because, doing, ending, sentence

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

_WIDTH_IN, _FRAME_S = 9.6, 0.1
_LINE = 150  # characters
_NAMED_S = 2  # at its outline after so many seconds what somebody may do besides is named


def plan_sheet(plan: Plan, after_s: float = 0.0) -> Figure:
    """The road from above so long after now, and where everybody is believed to be after each second, over the plan's charts with their
    limits and the timeline of the times to react."""
    from textwrap import shorten, wrap

    situation, vehicle = situation_of(plan)
    outlook = Outlook(situation, vehicle)
    view = outlook.view()
    bird = (_WIDTH_IN - 0.3) * view.aspect
    timeline = 0.0 if plan.escapes is None else 2.3
    why = wrap(because(plan), _LINE, max_lines=2, placeholder=" …")
    head = 0.87 + 0.2 * len(why)
    height = head + 0.15 + bird + 0.5 + 1.7 + timeline
    with style.styled():
        fig = style.figure(_WIDTH_IN, height)
        fig.set_layout_engine("none")
        is_open = plan.safe_end is not None and plan.safe_end.kind is EndKind.OPEN
        colour = style.GREEN if plan.verdict.passed and not is_open else style.VERMILION
        end = style.VERMILION if is_open else "#444444"
        fig.text(0.02, 1.0 - 0.22 / height, f"{plan.planner} {doing(plan)}", fontsize=11, fontweight="bold", va="center")
        fig.text(0.02, 1.0 - 0.47 / height, shorten(sentence(plan), _LINE, placeholder=" …"), fontsize=9, va="center", color=colour)
        fig.text(
            0.02, 1.0 - 0.69 / height, shorten(f"its end: {ending(plan)}", _LINE, placeholder=" …"), fontsize=8.5, va="center", color=end
        )
        for k, line in enumerate(why):
            fig.text(0.02, 1.0 - (0.89 + 0.19 * k) / height, line, fontsize=8.5, va="center", color="#444444")
        axes = fig.add_axes((0.015, 1.0 - (head + bird) / height, 0.97, bird / height))
        _from_above(axes, situation, vehicle, plan, outlook, view, after_s)
        fig.legend(
            handles=[*legend_handles(driven=False), *([_later()] if after_s == 0.0 else [])],
            loc="center",
            bbox_to_anchor=(0.5, 1.0 - (head + bird + 0.17) / height),
            ncols=3,
            frameon=False,
        )
        charts = outlook.charts()
        left, gap = 0.05, 0.045
        width = (0.985 - left - gap * (len(charts) - 1)) / len(charts)
        quantities = outlook.quantities(plan.trajectory)
        for k, chart in enumerate(charts):
            below = fig.add_axes((left + k * (width + gap), (0.45 + timeline) / height, width, 1.2 / height))
            _chart(below, chart, plan.trajectory.t_s, quantities[chart["key"]])
            if after_s > 0.0:
                below.axvline(after_s, color=style.BLACK, lw=1.0, alpha=0.6, zorder=2)
        if plan.escapes is not None:
            draw_timeline(fig.add_axes((0.1, 0.48 / height, 0.62, 1.45 / height)), plan.escapes)
    return fig


def film(plan: Plan, path: Path) -> Path:
    """Writes the plan as it would be driven, in real time, as an animation (.gif)."""
    x = plan.trajectory
    last = float(x.t_s[-1]) if np.isfinite(x.states).all() else 0.0
    times = np.linspace(0.0, last, min(round(last / _FRAME_S), MOST_FRAMES) + 1)
    pictures = [style.picture(plan_sheet(plan, float(t))) for t in times]
    return save_gif(pictures, np.diff(times), path)


def _from_above(axes: Axes, situation: Situation, vehicle: Vehicle, plan: Plan, outlook: Outlook, view: View, after_s: float) -> None:
    begun = replace(plan.trajectory, t_s=plan.trajectory.t_s + situation.time_s)
    BirdsEye(axes, situation.road, view, begun).show(outlook.moment(plan, after_s))
    if after_s == 0.0:
        _seconds_later(axes, situation, vehicle, plan, outlook, view)
    framed(axes)
    scale_bar(axes, view)


def _seconds_later(axes: Axes, situation: Situation, vehicle: Vehicle, plan: Plan, outlook: Outlook, view: View) -> None:
    """Outlines of everybody after one second, two seconds ..., each fainter than the one before; dashed, and named, of what somebody may do
    besides."""
    from matplotlib.patches import Polygon
    from matplotlib.patheffects import withStroke

    camera, x = Camera(situation.road, situation.host.s_m), plan.trajectory
    if not np.isfinite(x.states).all():
        return
    named: dict[str, tuple[float, float]] = {}
    for t in range(1, int(x.t_s[-1] + 1e-9) + 1):
        at = [float(np.interp(t, x.t_s, column)) for column in (x.s_m, x.d_m, x.heading_rad)]
        shapes = [(at, vehicle.length_m, vehicle.width_m, style.HOST, "")]
        for body, colour, name, supposed in zip(outlook.bodies, outlook.colours(), outlook.names(), outlook.supposed, strict=True):
            then = body.at(np.array(float(t)))
            pose = [float(then.s_m), float(then.d_m), float(then.heading_rad)]
            shapes.append((pose, body.length_m, body.width_m, colour, name if supposed else ""))
        for pose, length, width, colour, name in shapes:
            px, py, yaw = (float(q) for q in camera.place(*pose))
            if -view.back_m < px < view.ahead_m:
                dashed = {"ls": (0, (4, 2.5))} if name else {}
                faint = max(0.75 - 0.15 * t, 0.2)
                outline = corners(px, py, yaw, length, width)
                axes.add_patch(Polygon(outline, closed=True, fill=False, edgecolor=colour, lw=1.0, alpha=faint, zorder=2.5, **dashed))
                if name and t <= _NAMED_S:
                    named[name] = px, float(outline[:, 1].min())
    for k, (name, place) in enumerate(named.items()):
        word = axes.annotate(
            name, place, (0, -2 - 9 * (k % 3)), textcoords="offset points", ha="center", va="top", fontsize=7, color="#444444", zorder=6
        )
        word.set_path_effects([withStroke(linewidth=2.2, foreground="white", alpha=0.8)])


def _later() -> Patch:
    from matplotlib.patches import Patch

    return Patch(fill=False, edgecolor=style.HOST, alpha=0.6, label="where everybody is believed to be after each second")


def _chart(axes: Axes, chart: dict[str, object], t_s: np.ndarray, values: np.ndarray) -> None:
    low, high = float(str(chart["low"])), float(str(chart["high"]))
    axes.set(xlim=(0.0, max(float(t_s[-1]), 1.0)), ylim=(low, high), xlabel="time [s]")
    axes.set_title(f"{chart['title']} [{chart['unit']}]", fontsize=8.5, fontweight="normal")
    limits = chart["limits"]
    assert isinstance(limits, list)
    for value, word, hard in limits:
        if low <= value <= high:
            colour = style.VERMILION if hard else style.GREY
            axes.axhline(value, color=colour, lw=1.1, dashes=(4, 3), zorder=1)
            name_limit(axes, value, word, colour, t_s, values, [other for other, _, _ in limits if other != value])
    axes.plot(t_s, values, color=style.PLAN, lw=1.8, zorder=3)
