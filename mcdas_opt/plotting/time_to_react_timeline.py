"""Time to react as a timeline: until when each manoeuvre can begin, under the road from above."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from mcdas_opt.domain.escapes import Escape, Escapes
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.verdict import Verdict
from mcdas_opt.domain.vocabulary import Alert, Mode
from mcdas_opt.plotting import style
from mcdas_opt.plotting.asked import situation_of
from mcdas_opt.plotting.birdseye import BirdsEye, framed
from mcdas_opt.plotting.outlook import Outlook
from mcdas_opt.time_to_react.constant_input import constant_input
from mcdas_opt.time_to_react.library import KINDS, LATEST_S

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WIDTH_IN = 9.6
_COMFORTABLE, _HARD, _CLOSED = style.GREEN, style.ORANGE, "#d9d9dd"
_HATCH = "///"


def time_to_react_sheet(escapes: Escapes, alert: Alert = Alert.NONE) -> Figure:
    """The road from above, with where the host gets by constant inputs, over the timeline of its times to react."""
    situation, vehicle = situation_of(escapes)
    outlook = Outlook(situation, vehicle)
    view = outlook.view()
    bird = (_WIDTH_IN - 0.3) * view.aspect
    height = 0.55 + bird + 0.35 + 2.1
    with style.styled():
        fig = style.figure(_WIDTH_IN, height)
        fig.set_layout_engine("none")
        fig.text(0.02, 1.0 - 0.26 / height, _heading(escapes, alert), fontsize=11, fontweight="bold", va="center")
        axes = fig.add_axes((0.015, 1.0 - (0.45 + bird) / height, 0.97, bird / height))
        without_reaction = _constant_inputs(situation, vehicle, escapes)
        BirdsEye(axes, situation.road, view, without_reaction.trajectory).show(outlook.moment(without_reaction))
        framed(axes)
        below = fig.add_axes((0.1, 0.5 / height, 0.62, 1.75 / height))
        draw_timeline(below, escapes)
    return fig


def draw_timeline(axes: Axes, escapes: Escapes) -> None:
    """One bar for each manoeuvre: from now to the last moment at which it can begin, and up to where that is comfortable.

    What closes it and what it asks now stand beside it. A line marks where constant inputs end.
    """
    from matplotlib.patches import Patch

    moments = [one.last_moment_s for one in escapes.candidates if one.last_moment_s is not None]
    ends = [*moments, escapes.keeping_on_s or 0.0]
    span = min(LATEST_S, max(2.0, 1.15 * max(ends)))
    for row, one in enumerate(escapes.candidates):
        y = len(KINDS) - 1 - row
        axes.barh(y, span, height=0.62, color=_CLOSED, alpha=0.45, zorder=1)
        if one.last_moment_s is not None:
            later: dict[str, Any] = {"hatch": _HATCH, "edgecolor": "white", "lw": 0.0} if one.demand_mps2 is None else {}
            axes.barh(y, max(one.last_moment_s, 0.01 * span), height=0.62, facecolor=_HARD, zorder=2, **later)
            if one.last_comfortable_s is not None:
                axes.barh(y, min(one.last_comfortable_s, one.last_moment_s), height=0.62, facecolor=_COMFORTABLE, zorder=3, **later)
        axes.annotate(
            _words(one), (1.0, y), (8, 0), xycoords=("axes fraction", "data"), textcoords="offset points",
            va="center", fontsize=8.0, linespacing=1.1, annotation_clip=False,
        )  # fmt: skip
    if escapes.keeping_on_s is not None and escapes.keeping_on_s <= span:
        axes.axvline(escapes.keeping_on_s, color=style.VERMILION, lw=2.0, zorder=4)
    axes.set(xlim=(0.0, span), ylim=(-0.55, len(KINDS) - 0.45), yticks=range(len(KINDS)), xlabel="start of the manoeuvre, from now [s]")
    axes.set_yticklabels(KINDS[::-1])
    axes.grid(False, axis="y")
    handles = [Patch(color=_COMFORTABLE, label="comfortable"), Patch(color=_HARD, label="open"), Patch(color=_CLOSED, label="closed")]
    if any(one.last_moment_s is not None and one.demand_mps2 is None for one in escapes.candidates):
        handles.append(Patch(facecolor=style.GREY, edgecolor="white", hatch=_HATCH, lw=0.0, label="open later, not just now"))
    if escapes.keeping_on_s is not None:
        handles.append(Patch(color=style.VERMILION, label="constant inputs: safe until here"))
    axes.legend(handles=handles, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=5, frameon=False, borderaxespad=0.1)


def _words(one: Escape) -> str:
    if one.last_moment_s is None:
        return f"closed by {one.closed_by}" if one.closed_by is not None else "closed"
    until = f"until {one.last_moment_s:.2f} s" if one.last_moment_s < LATEST_S else f"for {LATEST_S:g} s and more"
    closer = f", then {one.closed_by}" if one.closed_by is not None else ""
    asks = f"asks {one.demand_mps2:.1f} m/s² now" if one.demand_mps2 is not None else "cannot begin just now"
    return f"{until}{closer}\n{asks}"


def _heading(escapes: Escapes, alert: Alert) -> str:
    last = escapes.last_moment_s
    said = "no manoeuvre is left" if last is None else f"the last manoeuvre closes in {last:.2f} s"
    if last is not None and last >= LATEST_S:
        said = "a manoeuvre stays open"
    return f"escapes: {said}{'' if alert is Alert.NONE else f'; {alert}'}"


def _constant_inputs(situation: Situation, vehicle: Vehicle, escapes: Escapes) -> Plan:
    """What the car does if nobody does anything, as something to draw."""
    times = np.round(np.arange(0.0, min(escapes.keeping_on_s or 4.0, 4.0) + 0.2, 0.1), 9)
    path = constant_input(situation.host, times, vehicle, situation.road)
    states = np.column_stack([path.s_m, path.d_m, path.heading_rad, path.speed_mps, path.acceleration_mps2, path.steering_rad])
    drive = Trajectory.from_states(times, states, np.zeros((times.size - 1, 2)))
    return Plan(planner="none", mode=Mode.HOLD, verdict=Verdict(), prediction="", trajectory=drive, time_s=situation.time_s)
