"""Time to react over a whole drive: of each manoeuvre, when it could begin, comfortably or at all."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from mcdas_opt.domain.escapes import Escape
from mcdas_opt.plotting import style
from mcdas_opt.simulation.record import Simulation
from mcdas_opt.time_to_react.library import KINDS

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

COLOURS = {"comfortable": style.GREEN, "open": style.ORANGE, "closed": "#d9d9dd"}  # the worse, the later
WORST_OF_S = 0.5  # single cycles flicker between kinds
_WORSE = list(COLOURS)


def has_escapes(simulation: Simulation) -> bool:
    """Whether any plan of the drive holds an escape map."""
    return any(cycle.plan.escapes is not None for cycle in simulation.cycles)


class TimeToReactStrip:
    """Draws a row for each manoeuvre over the drive's time; `show(t)` moves a line there.

    A row is the worst of the last `WORST_OF_S`; a thin one below it is each cycle by itself.
    """

    def __init__(self, axes: Axes, simulation: Simulation) -> None:
        from matplotlib.lines import Line2D
        from matplotlib.patches import Patch

        cycles = simulation.cycles
        starts = [cycle.time_s for cycle in cycles]
        ends = [*starts[1:], simulation.duration_s]
        for row in range(len(KINDS)):
            told = [None if cycle.plan.escapes is None else _kind(cycle.plan.escapes.candidates[row]) for cycle in cycles]
            for kinds, low, tall in ((worst(starts, told), -0.15, 0.55), (told, -0.4, 0.15)):
                bars: dict[str, list[tuple[float, float]]] = {kind: [] for kind in COLOURS}
                for kind, start, end in zip(kinds, starts, ends, strict=True):
                    if kind is not None and end > start:
                        bars[kind].append((start, end - start))
                for kind, spans in bars.items():
                    axes.broken_barh(spans, (len(KINDS) - 1 - row + low, tall), facecolors=COLOURS[kind], lw=0)
        axes.set(xlim=(0.0, simulation.duration_s), ylim=(-0.5, len(KINDS) - 0.5), yticks=range(len(KINDS)))
        axes.set_yticklabels(KINDS[::-1], fontsize=7.5)
        axes.set_xlabel("time [s]", labelpad=1)
        axes.grid(False)
        rows = [
            Line2D([], [], color=style.GREY, lw=lw, label=label)
            for lw, label in ((5.0, f"thick: worst of the last {WORST_OF_S:g} s"), (1.5, "thin: each cycle"))
        ]
        axes.set_title("time to react", fontsize=9.0, fontweight="normal", loc="left")
        axes.legend(
            handles=[*(Patch(color=colour, label=kind) for kind, colour in COLOURS.items()), *rows],
            loc="lower right",
            bbox_to_anchor=(1.0, 1.0),
            ncols=5,
            frameon=False,
            borderaxespad=0.1,
            fontsize=7.5,
        )
        self._line = Line2D([0.0, 0.0], [-0.5, len(KINDS) - 0.5], color=style.HOST, lw=1.6, zorder=5)
        axes.add_line(self._line)

    @property
    def artists(self) -> list[Artist]:
        return [self._line]

    def show(self, time_s: float) -> None:
        self._line.set_xdata([time_s, time_s])


def worst(starts_s: Sequence[float], kinds: Sequence[str | None]) -> list[str | None]:
    """At each cycle the worst kind of the cycles that began within the last `WORST_OF_S`; None where none of them was told."""
    found: list[str | None] = []
    for now in starts_s:
        recent = [
            kind for kind, start in zip(kinds, starts_s, strict=True) if kind is not None and now - WORST_OF_S < start + 1e-9 <= now + 2e-9
        ]
        found.append(max(recent, key=_WORSE.index, default=None))
    return found


def _kind(escape: Escape) -> str:
    if escape.last_moment_s is None:
        return "closed"
    return "open" if escape.last_comfortable_s is None else "comfortable"
