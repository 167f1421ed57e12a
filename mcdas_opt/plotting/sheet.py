"""A figure that notebooks show, whether or not pyplot is in use."""

from __future__ import annotations

from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure


class Sheet(Figure):
    """On the Agg canvas; nobody has to show it."""

    def __init__(self, **how: Any) -> None:
        super().__init__(**how)
        FigureCanvasAgg(self)

    def _repr_png_(self) -> bytes:
        from mcdas_opt.plotting.style import png_bytes

        return png_bytes(self)
