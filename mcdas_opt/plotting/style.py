"""One visual language for every picture: colours by meaning, fonts, roads and bodies."""

from __future__ import annotations

import math
from contextlib import AbstractContextManager
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mcdas_opt.domain.road import Road

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.patches import Polygon
    from PIL.Image import Image

# Okabe and Ito (2008), "Color Universal Design": told apart by every kind of colour vision.
BLACK, GREY = "#000000", "#7f7f7f"
ORANGE, SKY, GREEN, YELLOW, BLUE, VERMILION, PURPLE = "#E69F00", "#56B4E9", "#009E73", "#F0E442", "#0072B2", "#D55E00", "#CC79A7"

HOST, FRONT, REAR, NEIGHBOUR = BLUE, ORANGE, VERMILION, GREY
LITERAL, CORRECTED, PLAN = PURPLE, GREEN, BLUE
ASPHALT, MARKING, EDGE = "#e9e9ec", "#ffffff", "#55555a"

RC: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "text.parse_math": False,  # names are data
    "axes.titlesize": 10.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#d8d8d8",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.8,
    "legend.frameon": True,
    "legend.framealpha": 0.9,
    "legend.edgecolor": "none",
    "legend.fontsize": 8.0,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
}


def styled() -> AbstractContextManager[None]:
    """Everything drawn inside this context follows the style; nothing outside it changes."""
    import matplotlib

    return matplotlib.rc_context(RC)


def figure(width_in: float, height_in: float) -> Figure:
    """An empty figure on the Agg canvas, laid out by constraints. Call it inside `styled()`."""
    from mcdas_opt.plotting.sheet import Sheet

    return Sheet(png_bytes, figsize=(width_in, height_in), layout="constrained")


def save_png(fig: Figure, path: Path, dpi: int = 150) -> Path:
    """Writes a PNG without a version stamp, so that the same figure is the same bytes."""
    with styled():
        fig.savefig(path, dpi=dpi, format="png", metadata={"Software": None})
    return path


def png_bytes(fig: Figure) -> bytes:
    """A figure as PNG, the same bytes for the same figure."""
    held = BytesIO()
    with styled():
        fig.savefig(held, dpi=110, format="png", metadata={"Software": None})
    return held.getvalue()


def save_still(fig: Figure, path: Path) -> None:
    """Writes a PNG, SVG or PDF, by the suffix."""
    if path.suffix.lower() == ".png":
        save_png(fig, path)
        return
    with styled():
        fig.savefig(path, metadata={"Date": None} if path.suffix.lower() == ".svg" else {"CreationDate": None})


def picture(fig: Figure) -> Image:
    """A figure as one picture of an animation."""
    import PIL.Image

    fig.set_dpi(100)
    canvas: Any = fig.canvas
    canvas.draw()
    return PIL.Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3].copy())


def draw_road(axes: Axes, road: Road, s_from_m: float, s_to_m: float) -> None:
    """A straight road seen from above, s along x and d along y (left is up): asphalt, edges, dashed lane markings."""
    s = np.array([s_from_m, s_to_m]) if road.edges is None else np.linspace(s_from_m, s_to_m, 400)
    low, high = (np.broadcast_to(d, s.shape) for d in (road.right_edge_at(s), road.left_edge_at(s)))
    axes.fill_between(s, low, high, color=ASPHALT, lw=0, zorder=0)
    for d in (low, high):
        axes.plot(s, d, color=EDGE, lw=1.4, zorder=1)
    for d in road.markings_at(s):
        axes.plot(s, d, color=MARKING, lw=1.6, dashes=(6, 5), zorder=1)
    axes.grid(False)


def draw_body(axes: Axes, x_m: float, y_m: float, yaw_rad: float, length_m: float, width_m: float, colour: str, **how: Any) -> Polygon:
    """A car's rectangle centred at (x, y) with a windscreen line towards its front."""
    from matplotlib.patches import Polygon

    c, s = math.cos(yaw_rad), math.sin(yaw_rad)

    def placed(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
        return [(x_m + c * px - s * py, y_m + s * px + c * py) for px, py in points]

    a, b = 0.5 * length_m, 0.5 * width_m
    style = {"facecolor": colour, "edgecolor": BLACK, "lw": 0.7, "zorder": 4, **how}
    body = Polygon(placed([(a, b), (-a, b), (-a, -b), (a, -b)]), closed=True, **style)
    axes.add_patch(body)
    (x0, y0), (x1, y1) = placed([(0.3 * length_m, 0.8 * b), (0.3 * length_m, -0.8 * b)])
    axes.plot([x0, x1], [y0, y1], color="white", lw=1.2, zorder=style["zorder"] + 0.1, alpha=style.get("alpha"))
    return body
