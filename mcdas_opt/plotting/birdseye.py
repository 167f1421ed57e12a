"""The road from above, following the host: bodies, tracks with their uncertainty, the plan and what was driven."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.geometry.rectangle import corners
from mcdas_opt.geometry.window import REACH_M, frame_near
from mcdas_opt.plotting import style
from mcdas_opt.plotting.moments import Moment, Shown, View
from mcdas_opt.plotting.plane import SIGMAS

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

_NAMED_M = 150.0  # whoever is out of the picture and nearer than this is named at its edge
_EDGE_PT = 4.0
_TALL_PT, _WIDE_PT = 10.0, 4.6  # of a word, and of one of its letters
_DASH_M, _GAP_M = 3.0, 6.0
_ROUND = np.linspace(0.0, 2.0 * math.pi, 41)
TRACK = style.PURPLE
Box = tuple[float, float, float, float]  # from and to along, from and to across [m]


class Camera:
    """Turns the road's frame into a picture in which the road at the host's s points to the right and lies at (0, 0)."""

    def __init__(self, road: Road, s_m: float) -> None:
        self._frame, self._s = frame_near(road, s_m), s_m
        x, y, theta = self._frame.to_plane(np.array(s_m), np.zeros(()), np.zeros(()))
        self._x, self._y, self._theta = float(x), float(y), float(theta)

    def place(self, s: Any, d: Any, psi: Any = 0.0) -> tuple[Array, Array, Array]:
        """(right, up, angle) of poses; what is farther than the frame reaches is put at its end."""
        s, d, psi = np.broadcast_arrays(*(np.asarray(q, dtype=np.float64) for q in (s, d, psi)))
        near = np.clip(s, self._s - 0.9 * REACH_M, self._s + 0.9 * REACH_M)
        x, y, yaw = self._frame.to_plane(near, d, psi)
        c, n = math.cos(self._theta), math.sin(self._theta)
        dx, dy = x - self._x, y - self._y
        return c * dx + n * dy, -n * dx + c * dy, yaw - self._theta


class BirdsEye:
    """One set of axes that shows one moment after another; `artists` is everything that moves, in drawing order."""

    def __init__(self, axes: Axes, road: Road, view: View, driven: Trajectory) -> None:
        from matplotlib.collections import LineCollection
        from matplotlib.lines import Line2D
        from matplotlib.patches import Polygon

        self._axes, self._road, self._view, self._driven = axes, road, view, driven
        axes.set(xlim=(-view.back_m, view.ahead_m), ylim=(view.right_m, view.left_m), aspect="equal")
        axes.grid(False)
        self._asphalt = Polygon(np.zeros((4, 2)), closed=True, facecolor=style.ASPHALT, lw=0, zorder=0)
        axes.add_patch(self._asphalt)
        self._edges = [Line2D([], [], color=style.EDGE, lw=1.3, zorder=1) for _ in range(2)]
        self._dashes = LineCollection([], colors=style.MARKING, linewidths=1.8, zorder=1)
        self._end = Line2D([], [], color=style.VERMILION, lw=3.0, zorder=1)
        self._trail = Line2D([], [], color=style.BLACK, lw=1.0, alpha=0.55, zorder=2)
        self._planned = Line2D([], [], color=style.PLAN, lw=2.2, alpha=0.9, zorder=3, solid_capstyle="round")
        self._seconds = Line2D([], [], color=style.PLAN, marker="o", ms=3.6, mec="white", mew=0.6, lw=0, zorder=3.1)
        for line in (*self._edges, self._end, self._trail, self._planned, self._seconds):
            axes.add_line(line)
        axes.add_collection(self._dashes, autolim=False)
        self._bodies: list[Artist] = []

    @property
    def artists(self) -> list[Artist]:
        road = [self._asphalt, *self._edges, self._dashes, self._end]
        return [*road, self._trail, self._planned, self._seconds, *self._bodies]

    def show(self, moment: Moment) -> None:
        """Replaces what was shown before."""
        camera = Camera(self._road, moment.host.pose[0])
        self._show_road(camera, moment.host.pose[0])
        self._show_paths(camera, moment)
        for artist in self._bodies:
            artist.remove()
        self._bodies = []
        away, taken = [], []
        for shown in (*moment.others, moment.host):
            x, y, yaw = (float(q) for q in camera.place(*shown.pose))
            shape = corners(x, y, yaw, shown.length_m, shown.width_m)
            if self._sees(shape):
                self._show_body(shown, shape, (x, y, yaw), moment)
                taken.append(self._box(shown.name, shape))
            elif not shown.supposed:
                away.append((math.hypot(x, y - moment.host.pose[1]), x, y, shown.name))
        for word, place, side in words_at_the_edge(away, self._view, self._metres_a_point, taken):
            self._bodies.append(self._word(word, place, 0, ha=side, va="center", fontsize=7.5, color="#222222"))
        for track in moment.tracks:
            self._show_track(camera, track)

    def _show_road(self, camera: Camera, s_m: float) -> None:
        road, view = self._road, self._view
        low, high = s_m - view.back_m - 15.0, s_m + view.ahead_m + 15.0
        if road.road_end_s_m is not None:
            high = min(high, road.road_end_s_m)
        s = np.array([low, high]) if road.is_straight and road.edges is None else np.arange(low, high + 2.0, 2.0)
        sides = [camera.place(s, d)[:2] for d in (road.right_edge_at(s), road.left_edge_at(s))]
        self._asphalt.set_xy(np.concatenate([np.column_stack(sides[0]), np.column_stack(sides[1])[::-1]]))
        for line, side in zip(self._edges, sides, strict=True):
            line.set_data(*side)
        starts = np.arange(math.floor(low / (_DASH_M + _GAP_M)), math.ceil(high / (_DASH_M + _GAP_M))) * (_DASH_M + _GAP_M)
        along = np.clip(starts[:, None] + np.array([0.0, _DASH_M]), low, high)
        lanes = road.markings_at(along)
        self._dashes.set_segments([segment for d in lanes for segment in np.stack(camera.place(along, d)[:2], axis=-1)])
        if road.road_end_s_m is not None:
            across = np.array([float(d) for d in (road.right_edge_at(road.road_end_s_m), road.left_edge_at(road.road_end_s_m))])
            self._end.set_data(*camera.place(road.road_end_s_m, across)[:2])

    def _show_paths(self, camera: Camera, moment: Moment) -> None:
        past = self._driven.t_s <= moment.time_s + 1e-9
        self._trail.set_data(*camera.place(self._driven.s_m[past], self._driven.d_m[past])[:2])
        x = moment.plan.trajectory
        left = np.flatnonzero(x.t_s >= moment.time_s - moment.plan.time_s - 1e-9)
        finite = np.isfinite(x.s_m) & np.isfinite(x.d_m)
        rows = left[finite[left]]
        self._planned.set_data(*camera.place(x.s_m[rows], x.d_m[rows])[:2])
        marks = np.arange(1.0, float(x.t_s[-1]) + 1e-9)
        self._seconds.set_data(*camera.place(np.interp(marks, x.t_s, x.s_m), np.interp(marks, x.t_s, x.d_m))[:2])

    def _sees(self, shape: Array) -> bool:
        (left, low), (right, high) = shape.min(axis=0), shape.max(axis=0)
        view = self._view
        return bool(right > -view.back_m and left < view.ahead_m and high > view.right_m and low < view.left_m)

    @property
    def _metres_a_point(self) -> float:
        figure = self._axes.figure
        wide_pt = 72.0 / figure.dpi * figure.bbox.width * self._axes.get_position(original=True).width
        return float((self._view.back_m + self._view.ahead_m) / wide_pt)

    def _show_body(self, shown: Shown, shape: Array, place: tuple[float, float, float], moment: Moment) -> None:
        from matplotlib.lines import Line2D
        from matplotlib.patches import Polygon

        x, y, yaw = place
        if shown.supposed:
            self._bodies += self._supposed(shown, shape)
            return
        edge = {"edgecolor": style.VERMILION, "lw": 2.4} if shown.name in moment.struck else {"edgecolor": style.BLACK, "lw": 0.8}
        body = Polygon(shape, closed=True, facecolor=shown.colour, zorder=4, joinstyle="round", **edge)
        self._axes.add_patch(body)
        a, b = 0.22 * shown.length_m, 0.4 * shown.width_m
        c, n = math.cos(yaw), math.sin(yaw)
        ends = [(x + c * a - n * q, y + n * a + c * q) for q in (-b, b)]
        screen = Line2D(*zip(*ends, strict=True), color="white", lw=1.6, zorder=4.1, solid_capstyle="butt")
        self._axes.add_line(screen)
        self._bodies += [body, screen]
        self._bodies.append(self._named(shown.name, shape))

    def _supposed(self, shown: Shown, shape: Array) -> list[Artist]:
        """A pale, dashed outline, named below."""
        from matplotlib.colors import to_rgb
        from matplotlib.patches import Polygon

        outline = Polygon(
            shape, closed=True, facecolor=(*to_rgb(shown.colour), 0.25), edgecolor=shown.colour, lw=1.2, ls=(0, (4, 2.5)), zorder=3.5
        )
        self._axes.add_patch(outline)
        below = float(shape[:, 0].mean()), float(shape[:, 1].min())
        return [outline, self._word(shown.name, below, -2, ha="center", va="top", fontsize=7, color="#444444")]

    def _box(self, name: str, shape: Array) -> Box:
        """What a body and its name over it take."""
        (left, low), (right, _) = shape.min(axis=0), shape.max(axis=0)
        x, top = self._over(name, shape)
        half = 0.5 * _WIDE_PT * len(name) * self._metres_a_point
        return min(float(left), x - half), max(float(right), x + half), float(low), top + (_TALL_PT + 2.0) * self._metres_a_point

    def _over(self, name: str, shape: Array) -> tuple[float, float]:
        """Over a body, and within the picture where the body is partly out of it."""
        view, point = self._view, self._metres_a_point
        half, tall = 0.5 * _WIDE_PT * len(name) * point, (_TALL_PT + 2.0) * point
        x = min(max(float(shape[:, 0].mean()), -view.back_m + half), view.ahead_m - half)
        top = float(shape[:, 1].max())
        return x, top if top < view.left_m else view.left_m - tall

    def _named(self, name: str, shape: Array) -> Artist:
        return self._word(name, self._over(name, shape), 2, ha="center", va="bottom", fontsize=7.5, color="#222222")

    def _word(self, text: str, at: tuple[float, float], points: float, **how: Any) -> Artist:
        """So many points above `at`."""
        from matplotlib.patheffects import withStroke

        word = self._axes.annotate(text, at, (0, points), textcoords="offset points", zorder=6, annotation_clip=True, **how)
        word.set_path_effects([withStroke(linewidth=2.6, foreground="white")])
        return word

    def _show_track(self, camera: Camera, track: Track) -> None:
        from matplotlib.lines import Line2D

        s, d = ellipse(track)
        for width, colour in ((3.4, "white"), (1.6, TRACK)):  # a white halo, to be told from any body
            ring = Line2D(*camera.place(s, d)[:2], color=colour, lw=width, zorder=5)
            middle = Line2D(*camera.place([track.s_m], [track.d_m])[:2], color=colour, marker="o", ms=1.4 + width, mew=0, lw=0, zorder=5)
            for artist in (ring, middle):
                self._axes.add_line(artist)
                self._bodies.append(artist)


def words_at_the_edge(
    away: Sequence[tuple[float, float, float, str]], view: View, metres_a_point: float, taken: Sequence[Box] = ()
) -> list[tuple[str, tuple[float, float], str]]:
    """Who is out of the picture, and how far from the host: word, its place (x, y) [m] and the side that it is aligned to.

    `away` is distance, x, y [m] and name of each. The nearest comes first; a word stands above or below its place where that is
    `taken`, and not at all where there is no room.
    """
    words: list[tuple[str, tuple[float, float], str]] = []
    boxes = list(taken)
    tall, margin = _TALL_PT * metres_a_point, _EDGE_PT * metres_a_point
    for distance, x, y, name in sorted(one for one in away if one[0] <= _NAMED_M):
        far, beyond = f"{name} ({distance:.0f} m)", x > view.ahead_m
        word = f"{far} ▶" if beyond else f"{'◀' if x < -view.back_m else '▲' if y > 0.0 else '▼'} {far}"
        wide = _WIDE_PT * len(word) * metres_a_point
        left = min(max(x - 0.5 * wide, -view.back_m + margin), view.ahead_m - wide - margin)
        middle = min(max(y, view.right_m + 0.5 * tall + margin), view.left_m - 0.5 * tall - margin)
        for at in (middle, middle + tall, middle - tall, middle + 2.0 * tall, middle - 2.0 * tall):
            box = (left, left + wide, at - 0.49 * tall, at + 0.49 * tall)
            over = any(box[0] < q[1] and box[1] > q[0] and box[2] < q[3] and box[3] > q[2] for q in boxes)
            if not over and view.right_m <= box[2] and box[3] <= view.left_m:
                boxes.append(box)
                words.append((word, (left + wide if beyond else left, at), "right" if beyond else "left"))
                break
    return words


def ellipse(track: Track) -> tuple[Array, Array]:
    """(s, d) around the track's position at so many standard deviations."""
    spread = track.covariance[np.ix_([0, 2], [0, 2])]
    values, vectors = np.linalg.eigh(spread)
    ring = vectors @ (np.sqrt(np.maximum(values, 0.0))[:, None] * np.stack([np.cos(_ROUND), np.sin(_ROUND)]))
    return track.s_m + SIGMAS * ring[0], track.d_m + SIGMAS * ring[1]


def framed(axes: Axes) -> None:
    """A thin frame around the road, and no scales."""
    axes.set(xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set(visible=True, color="#c8c8c8", lw=0.8)


def scale_bar(axes: Axes, view: View) -> None:
    x, y = view.ahead_m - 13.0, view.right_m + 0.6
    axes.plot([x, x + 10.0], [y, y], color=style.BLACK, lw=2.0, solid_capstyle="butt", zorder=8)
    axes.annotate("10 m", (x, y), (-4, 0), textcoords="offset points", ha="right", va="center", fontsize=7, zorder=8)


def legend_handles(driven: bool = True) -> list[Any]:
    """What the lines mean."""
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], color=style.PLAN, lw=2.2, marker="o", ms=3.6, mec="white", mew=0.6, label="plan, a dot a second"),
        Line2D([], [], color=style.BLACK, lw=1.0, alpha=0.55, label="driven"),
        Line2D([], [], color=TRACK, lw=1.5, marker="o", ms=3.0, mew=0, label=f"track with its {SIGMAS:g} sigma"),
    ]
    return handles if driven else [handles[0], handles[2]]
