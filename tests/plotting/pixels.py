"""What a picture shows: its pixels, from a file or a figure, and where in it a place of its axes lies."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from mcdas_opt.plotting import style

Pixels = NDArray[np.int64]


def pixels(shown: Path | Figure | Image.Image) -> Pixels:
    """(height, width, 3) of a file that is decoded whole, of a figure at its own resolution, or of a picture."""
    if isinstance(shown, Figure):
        shown = style.picture(shown)
    if isinstance(shown, Path):
        with Image.open(shown) as opened:
            shown = opened.convert("RGB")
    return np.asarray(shown.convert("RGB"), dtype=np.int64)


def coloured(shown: Pixels, colour: str, tolerance: int = 12) -> NDArray[np.bool_]:
    """(height, width): where the picture has this colour."""
    return np.asarray(np.abs(shown - np.round(255.0 * np.array(to_rgb(colour)))).max(axis=2) <= tolerance)


def at(shown: Pixels, axes: Any, x: float, y: float) -> tuple[int, int, int]:
    """The colour at a place in the data's units."""
    right, up = axes.transData.transform((x, y))
    row, column = shown.shape[0] - 1 - int(up), int(right)
    red, green, blue = shown[row, column].tolist()
    return red, green, blue


def as_bytes(colour: str) -> tuple[int, int, int]:
    red, green, blue = (round(255.0 * part) for part in to_rgb(colour))
    return red, green, blue
