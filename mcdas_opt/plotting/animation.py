"""A drive as a moving picture, as a sheet of moments, or in three of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.rules import Array
from mcdas_opt.plotting import style
from mcdas_opt.plotting.bands import STATUSES
from mcdas_opt.plotting.birdseye import BirdsEye, framed, legend_handles, scale_bar
from mcdas_opt.plotting.moments import Moment, moment_at, moments, view_of
from mcdas_opt.plotting.strips import StripChart, mark_times, strips_of
from mcdas_opt.plotting.style import figure, styled
from mcdas_opt.plotting.time_to_react_strip import TimeToReactStrip, has_escapes
from mcdas_opt.plotting.words import TOLD
from mcdas_opt.simulation.record import Outcome, Simulation

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from PIL.Image import Image


MOST_FRAMES = 100
_WIDTH_IN, _DPI = 9.6, 100
_LAST_FRAME_MS = 2000
_STRIP_IN, _ROWS_IN = 1.55, 0.8  # of height, for the times to react over the drive
_BEFORE_S = 1.0  # the moment before the end that tells most


def film(simulation: Simulation, path: Path) -> Path:
    """Writes the drive as an animation (.gif)."""
    scenes = moments(simulation, at_most=MOST_FRAMES)
    return save_gif(frames(simulation, scenes), np.diff([moment.time_s for moment in scenes]), path)


def save_gif(pictures: Sequence[Image], steps_s: Array, path: Path) -> Path:
    """Pictures in real time, `steps_s` (n - 1,) apart; the last one stays for a while."""
    durations = [*(max(round(100.0 * step) * 10, 20) for step in steps_s.tolist()), _LAST_FRAME_MS]
    first, *rest = _one_palette(pictures)
    first.save(path, save_all=True, append_images=rest, duration=durations, loop=0, optimize=False, disposal=1)
    return path


def frames(simulation: Simulation, scenes: Sequence[Moment]) -> list[Image]:
    """A picture of each of these moments."""
    with style.styled():
        stage = _Stage(simulation)
        return [stage.picture(moment) for moment in scenes]


def sheet(simulation: Simulation, count: int = 5) -> Figure:
    """A figure: the drive at `count` moments, evenly spread and the end among them, over strip charts."""
    from matplotlib.lines import Line2D

    view = view_of(simulation)
    times = np.linspace(0.0, simulation.duration_s, count).tolist()
    row = (_WIDTH_IN - 0.6) * view.aspect + 0.28
    strip_in = _STRIP_IN if has_escapes(simulation) else 0.0
    height = count * row + 2.65 + strip_in
    with style.styled():
        fig = style.figure(_WIDTH_IN, height)
        fig.set_layout_engine("none")
        fig.text(0.02, 1.0 - 0.2 / height, drive_heading(simulation), fontsize=11, fontweight="bold", va="center")
        fig.text(
            0.98, 1.0 - 0.2 / height, outcome_words(simulation), fontsize=10, ha="right", va="center", color=_outcome_colour(simulation)
        )
        fig.text(0.97, 1.0 - 0.5 / height, simulation.among_others, fontsize=8, ha="right", va="center")
        for k, t in enumerate(times):
            axes = fig.add_axes((0.03, 1.0 - (0.35 + (k + 1) * row) / height, 0.94, (row - 0.28) / height))
            moment = moment_at(simulation, t)
            BirdsEye(axes, simulation.scene.true_road, view, simulation.trajectory).show(moment)
            axes.set_title(f"{t:.1f} s   {moment.action}: {plan_words(moment.plan)}", fontsize=9, fontweight="normal", pad=3)
            framed(axes)
        scale_bar(axes, view)
        bottom = _charts(fig, simulation, 0.48 / height, 1.25 / height)
        for axes, chart in bottom:
            mark_times(axes, times)
            chart.show(simulation.duration_s)
        if strip_in:
            mark_times(_times_to_react(fig, simulation, 2.7 / height, _ROWS_IN / height)[0], times)
        handles = [*legend_handles(), Line2D([], [], color=style.BLACK, lw=0.7, alpha=0.35, label="moments shown above")]
        fig.legend(handles=handles, loc="lower center", bbox_to_anchor=(0.5, 1.95 / height), ncols=4, frameon=False)
    return fig


def drive_heading(simulation: Simulation) -> str:
    """What was driven, by whom, with which plant and seed."""
    return f"{simulation.name} · {simulation.planner} · {simulation.driven_with}"


def plan_words(plan: Plan) -> str:
    """Status, verdict, and what the driver is told."""
    judged = "" if plan.verdict.passed else ", failed by the judge"
    return f"{plan.status.value}{judged}{TOLD[plan.alert]}"


def outcome_words(simulation: Simulation) -> str:
    """How the drive ended."""
    if simulation.error:
        return f"plant failed at {simulation.duration_s:.2f} s"
    if simulation.outcome is Outcome.COLLISION:
        return f"collision with {simulation.collided_with} at {simulation.impact_speed_mps:.1f} m/s"
    if simulation.outcome is Outcome.LEFT_ROAD:
        return f"left the road at {simulation.duration_s:.1f} s"
    return "safe" if simulation.min_clearance_m is None else f"safe, never nearer than {simulation.min_clearance_m:.2f} m"


class _Stage:
    """The animation's figure: what stands still is drawn once, what moves is drawn over it for every frame."""

    def __init__(self, simulation: Simulation) -> None:
        view = view_of(simulation)
        bird = (_WIDTH_IN - 0.3) * view.aspect
        strip_in = _STRIP_IN if has_escapes(simulation) else 0.0
        height = round((0.62 + bird + 0.5 + 1.75 + strip_in) * _DPI / 2) * 2 / _DPI
        self._simulation = simulation
        self._fig = style.figure(_WIDTH_IN, height)
        self._fig.set_layout_engine("none")
        self._fig.set_dpi(_DPI)
        self._fig.text(0.016, 1.0 - 0.2 / height, drive_heading(simulation), fontsize=11, fontweight="bold", va="center")
        axes = self._fig.add_axes((0.015, 1.0 - (0.62 + bird) / height, 0.97, bird / height))
        self._bird = BirdsEye(axes, simulation.scene.true_road, view, simulation.trajectory)
        framed(axes)
        scale_bar(axes, view)
        self._axes = axes
        self._charts: list[tuple[Axes, StripChart | TimeToReactStrip]] = [*_charts(self._fig, simulation, 0.45 / height, 1.2 / height)]
        if strip_in:
            self._charts.append(_times_to_react(self._fig, simulation, 2.62 / height, _ROWS_IN / height))
        self._fig.legend(handles=legend_handles(), loc="lower center", bbox_to_anchor=(0.5, 1.9 / height), ncols=3, frameon=False)
        common: dict[str, Any] = {"va": "center", "fontsize": 10}
        top = 1.0 - 0.2 / height
        self._clock = self._fig.text(0.984, top, "", ha="right", family="DejaVu Sans Mono", **common)
        low = 1.0 - 0.45 / height
        self._badge = self._fig.text(
            0.02, low, "", color="white", fontweight="bold", va="center", fontsize=9, bbox={"boxstyle": "round,pad=0.28", "lw": 0}
        )
        self._words = self._fig.text(0.984, low, "", ha="right", va="center", fontsize=9)
        self._background: Any = None

    def picture(self, moment: Moment) -> Image:
        from PIL import Image

        canvas: Any = self._fig.canvas
        moving = [*self._bird.artists, self._clock, self._badge, self._words]
        if self._background is None:
            for artist in [*moving, *(a for _, chart in self._charts for a in chart.artists)]:
                artist.set_animated(True)
            canvas.draw()
            self._background = canvas.copy_from_bbox(self._fig.bbox)
        canvas.restore_region(self._background)
        self._bird.show(moment)
        self._say(moment)
        renderer = canvas.get_renderer()
        for artist in sorted(self._bird.artists, key=lambda a: a.get_zorder()):
            self._axes.draw_artist(artist)
        for axes, chart in self._charts:
            chart.show(moment.time_s)
            for artist in chart.artists:
                axes.draw_artist(artist)
        for artist in (self._clock, self._badge, self._words):
            artist.draw(renderer)
        return Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3].copy())

    def _say(self, moment: Moment) -> None:
        plan = moment.plan
        self._clock.set_text(f"t = {moment.time_s:.1f} s   {moment.speed_mps:4.1f} m/s ({3.6 * moment.speed_mps:.0f} km/h)")
        self._badge.set_text(moment.action)
        box: Any = self._badge.get_bbox_patch()
        box.set_facecolor(STATUSES[plan.status] if plan.verdict.passed else style.VERMILION)
        words = plan_words(plan) if moment.ended is None else outcome_words(self._simulation)
        self._words.set_text(words)


def _charts(fig: Figure, simulation: Simulation, bottom: float, height: float) -> list[tuple[Axes, StripChart]]:
    left, gap, strips = 0.047, 0.05, strips_of(simulation)
    width = (0.985 - left - (len(strips) - 1) * gap) / len(strips)
    charts = []
    for k, strip in enumerate(strips):
        axes = fig.add_axes((left + k * (width + gap), bottom, width, height))
        charts.append((axes, StripChart(axes, strip, simulation.duration_s)))
    return charts


def _times_to_react(fig: Figure, simulation: Simulation, bottom: float, height: float) -> tuple[Axes, TimeToReactStrip]:
    axes = fig.add_axes((0.09, bottom, 0.895, height))
    strip = TimeToReactStrip(axes, simulation)
    strip.show(simulation.duration_s)
    return axes, strip


def _outcome_colour(simulation: Simulation) -> str:
    return style.GREEN if simulation.is_safe else style.VERMILION


def _one_palette(pictures: Sequence[Image]) -> list[Image]:
    """All frames in one palette, the 255 commonest colours: nothing flickers, and what stands still is stored once."""
    from PIL import Image

    counts: Counter[tuple[int, int, int]] = Counter()
    for k in np.linspace(0, len(pictures) - 1, min(6, len(pictures))).astype(int):
        for count, colour in pictures[k].getcolors(pictures[k].width * pictures[k].height) or []:
            counts[colour] += count
    palette = np.array([colour for colour, _ in counts.most_common(255)], dtype=np.int64)
    index = np.full(1 << 24, -1, dtype=np.int16)  # of every colour met so far
    painted = []
    for picture in pictures:
        packed = np.asarray(picture).astype(np.int64) @ np.array([1 << 16, 1 << 8, 1])
        new = np.unique(packed[index[packed] < 0])
        channels = np.stack([new >> 16, (new >> 8) & 255, new & 255], axis=-1)
        index[new] = ((channels[:, None] - palette) ** 2).sum(axis=-1).argmin(axis=1)
        frame = Image.fromarray(index[packed].astype(np.uint8), mode="P")
        frame.putpalette(palette.astype(np.uint8).tobytes())
        painted.append(frame)
    return painted


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
