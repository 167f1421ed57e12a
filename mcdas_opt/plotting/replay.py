"""Pictures of a replay: tracks against truth with the error strips below, or every track over time where there is no truth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vocabulary import Mode, Role, Sector
from mcdas_opt.plotting.bands import MODES
from mcdas_opt.plotting.style import BLACK, FRONT, GREEN, GREY, HOST, NEIGHBOUR, PURPLE, REAR, SKY, figure, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from mcdas_opt.interop.replay_record import Cycle, Replay
    from mcdas_opt.interop.truth import SectorComparison

SIGMAS = 2.0
_COUNTED_S = 1e5  # a drive that begins later than this counts time from long ago, as Unix time does
_COLOURS = {Sector.FRONT: FRONT, Sector.REAR: REAR}
ROLES = {Role.FRONT: FRONT, Role.REAR: REAR, Role.LEFT: GREEN, Role.RIGHT: PURPLE, Role.OTHER: NEIGHBOUR}


def replay_figure(replay: Replay) -> Figure:
    """The tracks of a whole recording."""
    return draw_tracks(replay.cycles, f"{replay.name}  ·  tracks{f', planned by {replay.planner}' if replay.planner else ''}")


def draw_against_truth(sectors: Mapping[Sector, SectorComparison]) -> Figure:
    """A column per sector: position along, range rate, and the errors of raw detections and tracks with the tracker's own bounds."""
    with styled():
        fig = figure(5.6 * len(sectors) + 0.4, 8.6)
        axes = fig.subplots(5, len(sectors), sharex="col", squeeze=False, height_ratios=[1.5, 1.5, 1.0, 1.0, 1.0])
        for column, (sector, found) in enumerate(sectors.items()):
            _sector(list(axes[:, column]), sector, found)
            for row in range(2, 5):
                axes[row, column].sharey(axes[row, 0])
        drawn = [axes[row, column].get_legend_handles_labels() for row in (0, 2) for column in range(len(sectors))]
        keys = {text: handle for handles, texts in drawn for handle, text in zip(handles, texts, strict=True)}
        fig.legend(list(keys.values()), list(keys), loc="outside lower center", ncols=5)
        fig.suptitle("Tracks against truth", fontsize=11, fontweight="bold", x=0.01, ha="left")
    return fig


def draw_tracks(cycles: Sequence[Cycle], title: str = "Tracks of a recording") -> Figure:
    """Position along and speed of every track, coloured by role, with the host's speed and the mode as a band below."""
    from matplotlib.patches import Patch

    with styled():
        fig = figure(9.6, 6.4)
        above, below, band = fig.subplots(3, 1, sharex=True, height_ratios=[2.2, 1.6, 0.18])
        began_s = cycles[0].t_s if abs(cycles[0].t_s) > _COUNTED_S else 0.0
        for role, colour in ROLES.items():
            rows = [(c.t_s - began_s, t.s_m, t.speed_s_mps) for c in cycles for t in c.tracks if t.role is role]
            if rows:
                t, s, v = np.array(rows).T
                above.plot(t, s, ".", ms=2.2, color=colour, label=role.value)
                below.plot(t, v, ".", ms=1.8, color=colour)
        times = np.array([c.t_s - began_s for c in cycles])
        above.axhline(0.0, color=BLACK, lw=0.8)
        below.plot(times, [c.host.speed_mps for c in cycles], color=HOST, lw=1.4, label="host")
        above.set_ylabel("along, from the host [m]")
        below.set_ylabel("speed [m/s]")
        _modes(band, times, [c.mode for c in cycles])
        band.set_xlabel(f"time since {began_s:.10g} s [s]" if began_s else "time [s]")
        handles, labels = above.get_legend_handles_labels()
        more, names = below.get_legend_handles_labels()
        patches = [Patch(color=MODES[mode], label=f"mode {mode.value}") for mode in dict.fromkeys(c.mode for c in cycles)]
        keys, texts = handles + more + patches, labels + names + [str(patch.get_label()) for patch in patches]
        fig.legend(keys, texts, loc="outside lower center", ncols=8, markerscale=3)
        above.set_title(title)
        for axes in (above, below, band):
            axes.margins(x=0.01)
    return fig


def _sector(axes: Sequence[Axes], sector: Sector, found: SectorComparison) -> None:
    colour, t = _COLOURS[sector], found.t_s
    place, rate, *strips = axes
    breaks = f"{found.breaks} track break{'' if found.breaks == 1 else 's'}"
    place.set_title(f"{sector.value} radar, {breaks}")
    for axis, k, label in ((place, 0, "along, from the radar [m]"), (rate, 2, "range rate [m/s]")):
        axis.plot(t, found.tracked_points[:, k], color=colour, lw=2.6, label=f"track, {sector.value}")
        axis.plot(t, found.true_points[:, k], color=BLACK, lw=0.9, ls=(0, (4, 3)), label="truth")
        axis.set_ylabel(label)
    names = ("error along [m]", "error across [m]", "error of rate [m/s]")
    for k, (axis, label) in enumerate(zip(strips, names, strict=True)):
        bound = SIGMAS * found.tracked_sds[:, k]
        axis.plot(found.raw_t_s, found.raw_errors[:, k], ".", color=GREY, ms=1.6, alpha=0.55, label="raw detections")
        axis.fill_between(t, -bound, bound, color=SKY, alpha=0.35, lw=0, label="2 sd, as the tracker claims")
        axis.plot(t, (found.tracked_points - found.true_points)[:, k], color=colour, lw=1.0)
        axis.set_ylabel(label)
        reach = np.nanpercentile(np.abs(found.raw_errors[:, k]), 99.0) if np.isfinite(found.raw_errors[:, k]).any() else 1.0
        axis.set_ylim(-1.1 * reach, 1.1 * reach)
    strips[-1].set_xlabel("time [s]")


def _modes(axis: Axes, times: Array, modes: Sequence[Mode]) -> None:
    start = 0
    for k in range(1, len(modes) + 1):
        if k == len(modes) or modes[k] is not modes[start]:
            end = times[min(k, len(modes) - 1)]
            axis.axvspan(float(times[start]), float(end), color=MODES[modes[start]], lw=0)
            start = k
    axis.set_yticks([])
    axis.set_ylabel("mode", rotation=0, ha="right", va="center")
    axis.grid(False)
