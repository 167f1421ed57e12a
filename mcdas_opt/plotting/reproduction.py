"""Figures 10-12 of the paper: the lateral motion, literal beside corrected. ISO axes (y to the left, up), the paper's offsets."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.geometry.rectangle import corners, separation
from mcdas_opt.plotting import style
from mcdas_opt.reference.literal import Y_MAX_M, LiteralPath, literal_path
from mcdas_opt.reference.offset_path import OffsetPath, corrected
from mcdas_opt.reference.steering_demand import peak_lateral_acceleration

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

KMH = 1.0 / 3.6
_ROAD = Road(lanes_left=1, lanes_right=1)
_CAR = Vehicle()
_BOUND_MPS2 = 4.0
_FRONT_S_M = 14.0  # centre of the standing front vehicle of Figures 10 and 11
_EDGE_ROOM_M = 0.2  # kept between the body and the road's edge by the corrected path
_SLOW_KMH = 20.0  # a speed at which 4 m/s^2 leads around it


def _corrected(side: Side, off_left_m: float, speed_kmh: float, front_s_m: float) -> OffsetPath:
    """To the middle of the next lane, bent by the offset beside the front vehicle, outwards no further than the road allows."""
    room = 0.5 * (_ROAD.lane_width_m - _CAR.width_m) - _EDGE_ROOM_M
    if side is Side.LEFT:
        target, bend = Y_MAX_M, min(off_left_m, room)
    else:
        target, bend = -Y_MAX_M, max(off_left_m, -room)
    return corrected(0.0, 0.0, target, speed_kmh * KMH, _BOUND_MPS2, bend_m=bend, bend_s_m=front_s_m, bend_width_m=8.0)


def _clearance(path: LiteralPath | OffsetPath, front_d_m: float) -> tuple[float, float]:
    """Least signed separation [m] of the host's body on the path from the standing front vehicle, and the s at which it is reached."""
    s = np.linspace(0.0, 40.0, 801)
    host = corners(s, path.d(s), np.arctan(path.slope(s)), _CAR.length_m, _CAR.width_m)
    apart = separation(host, corners(_FRONT_S_M, front_d_m, 0.0, 4.5, 1.8))
    return float(apart.min()), float(s[int(np.argmin(apart))])


def _swept(axes: Axes, path: LiteralPath | OffsetPath, until_m: float, colour: str) -> None:
    s = np.linspace(0.0, until_m, 400)
    for sign in (-1, 1):
        axes.plot(*_flank(path, s, sign), color=colour, lw=0.8, alpha=0.8)
    axes.fill_between(s, path.d(s) - 0.5 * _CAR.width_m, path.d(s) + 0.5 * _CAR.width_m, color=colour, alpha=0.15, lw=0)


def _flank(path: LiteralPath | OffsetPath, s: Array, sign: int) -> tuple[Array, Array]:
    yaw = np.arctan(path.slope(s))
    return s - sign * 0.5 * _CAR.width_m * np.sin(yaw), path.d(s) + sign * 0.5 * _CAR.width_m * np.cos(yaw)


def draw_figure_10() -> Figure:
    """Figure 10: a fixed path ignores where the front vehicle stands in its lane; the offset moves the path away from it."""
    off_left = -1.0  # the front vehicle stands to the right
    with style.styled():
        fig = style.figure(8.0, 8.6)
        rows = fig.subplots(3, 1, sharex=True)
        cases: tuple[tuple[str, LiteralPath | OffsetPath, str], ...] = (
            ("fixed path, offset ignored (literal, off = 0)", literal_path(Side.RIGHT, 0.0), style.LITERAL),
            ("literal path with off = +1 m (eq 22)", literal_path(Side.RIGHT, off_left), style.LITERAL),
            (
                f"corrected path for {_SLOW_KMH:g} km/h, bent beside the front vehicle",
                _corrected(Side.RIGHT, off_left, _SLOW_KMH, _FRONT_S_M),
                style.CORRECTED,
            ),
        )
        for axes, (title, path, colour) in zip(rows, cases, strict=True):
            apart, at = _clearance(path, off_left)
            _scene(axes, 34.0)
            _swept(axes, path, 34.0, colour)
            s = np.linspace(0.0, 34.0, 400)
            axes.plot(s, path.d(s), color=colour)
            style.draw_body(axes, _FRONT_S_M, off_left, 0.0, 4.5, 1.8, style.FRONT)
            style.draw_body(axes, at, float(path.d(at)), float(np.arctan(path.slope(at))), 4.5, 1.8, style.HOST, alpha=0.55)
            touching = f"hits the front vehicle ({-apart:.2f} m deep)" if apart < 0.0 else f"passes it at {apart:.2f} m"
            axes.set(title=f"{title}: {touching}", ylim=(-6.2, 6.2), aspect="equal")
        rows[-1].set_xlabel("x [m]")
        fig.suptitle("Figure 10: a front vehicle 1 m to the right in its lane, standing at x = 14 m", fontweight="bold", fontsize=10.5)
    return fig


def draw_figure_11() -> Figure:
    """Figure 11: both sides for one offset, with the bearing psi and the range rho of eq 24 at one point."""
    off_left = -1.0
    with style.styled():
        fig = style.figure(8.5, 3.5)
        axes = fig.subplots()
        _scene(axes, 34.0)
        axes.set(ylim=(-6.2, 6.2), aspect="equal")
        style.draw_body(axes, 0.0, 0.0, 0.0, 4.5, 1.8, style.HOST)
        style.draw_body(axes, _FRONT_S_M, off_left, 0.0, 4.5, 1.8, style.FRONT)
        s = np.linspace(0.0, 34.0, 400)
        for side in (Side.LEFT, Side.RIGHT):
            label = side is Side.LEFT
            literal = literal_path(side, off_left)
            axes.plot(s, literal.d(s), color=style.LITERAL, ls="--", label="literal, eq 22-23" if label else None)
            bent = _corrected(side, off_left, _SLOW_KMH, _FRONT_S_M)
            axes.plot(s, bent.d(s), color=style.CORRECTED, label=f"corrected, {_SLOW_KMH:g} km/h" if label else None)
            x, y = 17.0, float(literal.d(17.0))
            axes.plot([0.0, x], [0.0, y], color=style.BLACK, lw=0.8, ls=":")
            axes.annotate(
                r"$\rho$", (0.3 * x, 0.3 * y), xytext=(0, 9 if label else -17), textcoords="offset points", fontsize=11, parse_math=True
            )
            bearing = np.linspace(np.arctan2(y, x), 0.5 * np.pi * np.sign(y), 40)
            axes.plot(4.2 * np.cos(bearing), 4.2 * np.sin(bearing), color=style.BLACK, lw=0.8)
            axes.annotate(r"$\psi_t$", (2.2, 2.6 * np.sign(y)), fontsize=11, ha="center", va="center", parse_math=True)
            name = "-y (LSD)" if label else "y (RSD)"
            axes.annotate("", (x, y), xytext=(x, 0.0), arrowprops={"arrowstyle": "<->", "lw": 0.8})
            axes.annotate(name, (x, 0.5 * y), xytext=(4, 0), textcoords="offset points", va="center")
        axes.annotate("", (_FRONT_S_M - 3.0, off_left), xytext=(_FRONT_S_M - 3.0, 0.0), arrowprops={"arrowstyle": "<->", "lw": 0.8})
        axes.annotate("off", (_FRONT_S_M - 3.0, 0.5 * off_left), xytext=(-5, 0), textcoords="offset points", ha="right", va="center")
        axes.axhline(0.0, color=style.BLACK, lw=0.6, ls=(0, (6, 4)))
        axes.set(xlabel="x [m]", title="Figure 11: suitable curvilinear motion for off = +1 m (front vehicle to the right)")
        fig.legend(loc="outside lower center", ncols=2)
    return fig


def draw_figure_12() -> Figure:
    """Figure 12 a-d: estimated trajectories for the paper's offsets, literal (left) and corrected (right)."""
    families: tuple[tuple[str, Sequence[float]], ...] = (
        ("a", (0.0,)),
        ("b", (-1.0, 1.0)),
        ("c", (-2.0, 2.0)),
        ("d", (-2.0, -1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0)),
    )
    with style.styled():
        fig = style.figure(10.0, 9.4)
        grid = fig.subplots(4, 2, sharex=True, sharey=True)
        colours = _offset_colours(families[-1][1])
        s, speed, front = np.linspace(0.0, 36.0, 500), 40.0, 20.0
        for row, (letter, offsets) in zip(grid, families, strict=True):
            listed = ", ".join(f"{off:+g}" if off else "0" for off in offsets) if len(offsets) < 3 else "-2 ... +2"
            for axes, kind in zip(row, ("literal", f"corrected, {speed:g} km/h"), strict=True):
                _scene(axes, 36.0)
                for off in offsets:
                    for side in (Side.LEFT, Side.RIGHT):
                        path = literal_path(side, -off) if kind == "literal" else _corrected(side, -off, speed, front)
                        leaves = np.abs(path.d(s)).max() + 0.5 * _CAR.width_m > _ROAD.left_edge_m
                        axes.plot(s, path.d(s), color=colours[off], lw=1.5, ls=":" if leaves else "-")
                style.draw_body(axes, 0.0, 0.0, 0.0, 4.5, 1.8, style.HOST)
                axes.set_title(f"12({letter}) {kind}: off = {listed} m")
            row[1].set_ylabel("")
        for axes in grid[-1]:
            axes.set_xlabel("x [m]")
        from matplotlib.lines import Line2D

        handles = [Line2D([], [], color=c, label=f"{off:+g} m" if off else "0 m") for off, c in colours.items()]
        handles.append(Line2D([], [], color=style.GREY, ls=":", label="the car leaves the road"))
        title = f"offset, right positive as in the paper; corrected: bent beside a front vehicle at x = {front:g} m, {_BOUND_MPS2:g} m/s²"
        fig.legend(handles=handles, loc="outside lower center", ncols=10, title=title)
    return fig


def draw_figure_12_demand(bound_mps2: float) -> Figure:
    """What Figure 12's paths ask of a car: lateral acceleration along the path, and its peak over speed."""
    speeds = np.linspace(20.0, 130.0, 56)
    with style.styled():
        fig = style.figure(9.5, 4.0)
        left, right = fig.subplots(1, 2)
        literal = literal_path(Side.LEFT, 0.0)
        s = np.linspace(0.0, 45.0, 900)
        v = 60.0 * KMH
        for path, colour, name in ((literal, style.LITERAL, "literal"), (_bare(60.0, bound_mps2), style.CORRECTED, "corrected")):
            left.plot(s, v**2 * path.curvature(s) / GRAVITY_MPS2, color=colour, label=name)
        left.set(xlabel="x [m]", ylabel="lateral acceleration [g]", title="along the path at 60 km/h, off = 0")
        peaks = {
            "literal": [peak_lateral_acceleration(literal, u * KMH) / GRAVITY_MPS2 for u in speeds],
            "corrected": [peak_lateral_acceleration(_bare(u, bound_mps2), u * KMH) / GRAVITY_MPS2 for u in speeds],
        }
        right.plot(speeds, peaks["literal"], color=style.LITERAL, label="literal")
        right.plot(speeds, peaks["corrected"], color=style.CORRECTED, label=f"corrected, bound {bound_mps2:g} m/s²")
        right.axhline(0.9, color=style.BLACK, lw=1.0, ls="--", label="friction 0.9")
        for kmh in (40.0, 60.0, 80.0, 100.0):
            g = peak_lateral_acceleration(literal, kmh * KMH) / GRAVITY_MPS2
            right.plot([kmh], [g], "o", color=style.LITERAL, ms=5)
            right.annotate(f"{g:.2f} g", (kmh, g), xytext=(-7, -2), textcoords="offset points", ha="right", fontsize=8)
        right.set(xlabel="speed [km/h]", ylabel="peak lateral acceleration [g]", title="peak over speed, off = 0")
        left.legend(loc="upper right")
        right.legend(loc="upper left")
        fig.suptitle("What the trajectories of Figure 12 ask of a car", fontweight="bold", fontsize=10.5)
    return fig


def _bare(speed_kmh: float, bound: float) -> OffsetPath:
    return corrected(0.0, 0.0, Y_MAX_M, speed_kmh * KMH, bound)


def _scene(axes: Axes, until_m: float) -> None:
    style.draw_road(axes, _ROAD, -4.0, until_m)
    axes.set(xlim=(-4.0, until_m), ylim=(-8.0, 8.0), ylabel="y [m], left up")


def _offset_colours(offsets: Sequence[float]) -> dict[float, str]:
    """Diverging and colour-blind safe: blue for negative, black for none, vermilion for positive."""
    from matplotlib.colors import LinearSegmentedColormap, to_hex

    ramp = LinearSegmentedColormap.from_list("offsets", [style.BLUE, style.SKY, style.BLACK, style.ORANGE, style.VERMILION])
    largest = max(abs(off) for off in offsets)
    return {off: to_hex(ramp(0.5 + 0.5 * off / largest)) for off in offsets}
