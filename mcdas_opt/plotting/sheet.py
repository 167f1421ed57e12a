"""A figure that notebooks show, whether or not pyplot is in use."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure


class Sheet(Figure):
    """On the Agg canvas; nobody has to show it. `to_png` makes a PNG of a figure."""

    def __init__(self, to_png: Callable[[Figure], bytes], **how: Any) -> None:
        super().__init__(**how)
        self._to_png = to_png
        FigureCanvasAgg(self)

    def _repr_png_(self) -> bytes:
        return self._to_png(self)
