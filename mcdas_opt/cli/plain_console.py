"""A console on which text cannot move the cursor, change colours or ring."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.text import Text

from mcdas_opt.errors import printable


class PlainConsole(Console):
    """Writes out what cannot be printed, before it is laid out in lines and columns."""

    def render_str(self, text: str, **options: Any) -> Text:
        """A string as a text, wherever it stands: alone, in a title or a cell."""
        return super().render_str("\n".join(map(printable, text.split("\n"))), **options)

    def on_broken_pipe(self) -> None:
        """Leaves it to `streams.told_where_stdout_ends` how the command ends."""
        raise  # called while it is handled
