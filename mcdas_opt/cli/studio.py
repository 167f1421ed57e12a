"""`mcdas-opt studio`: the page."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mcdas_opt.cli.screen import console, leaving


def studio(
    port: Annotated[int, typer.Option("--port", min=1, max=65535, help="Where the page listens, on 127.0.0.1 only.")] = 8090,
    folder: Annotated[Path, typer.Option("--folder", help="The only folder whose scenes, logs and results the page may read.")] = Path("."),
    show: Annotated[bool, typer.Option("--show/--no-show", help="Open the page in a browser.")] = True,
) -> None:
    """The page: a sandwich that answers while a slider moves, the closed loop, and a slot to park in.

    Example: mcdas-opt studio --folder results --port 8090
    """
    from mcdas_opt.studio.server import HOST, serve

    def listening() -> None:
        console().print(f"studio: http://{HOST}:{port}  (files of {folder.resolve()}; Ctrl-C ends it)", soft_wrap=True)

    with leaving("the page is closed"):
        serve(folder, port, open_browser=show, announce=listening)
