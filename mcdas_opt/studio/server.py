"""Starts the studio on 127.0.0.1."""

from __future__ import annotations

from pathlib import Path

from mcdas_opt.errors import MissingExtraError
from mcdas_opt.studio.folder import Folder
from mcdas_opt.studio.guard import Guard

HOST = "127.0.0.1"


def serve(folder: Path, port: int, *, open_browser: bool) -> None:
    """Serves the page until interrupted. Raises `InputError` for a folder that is none, `MissingExtraError` without NiceGUI."""
    room = Folder(root=folder)
    try:
        from nicegui import app, ui
    except ImportError:
        raise MissingExtraError("nicegui", "web") from None
    from mcdas_opt.studio.page import register
    from mcdas_opt.studio.visit import Studio

    app.add_middleware(Guard)
    studio = Studio(room)
    app.on_startup(studio.warm)
    app.on_shutdown(studio.close)
    register(studio)
    ui.run(
        host=HOST,
        port=port,
        title="mcdas-opt studio",
        show=open_browser,
        reload=False,
        tailwind=False,
        show_welcome_message=False,
        binding_refresh_interval=None,
        reconnect_timeout=10.0,
        ws_max_size=1_000_000,
    )
