"""Starts the studio on 127.0.0.1."""

from __future__ import annotations

import socket
import sys
from collections.abc import Callable
from pathlib import Path

from mcdas_opt.errors import ParameterError, of_extra
from mcdas_opt.studio.folder import Folder
from mcdas_opt.studio.request_filter import RequestFilter

HOST = "127.0.0.1"


def serve(folder: Path, port: int, *, open_browser: bool, announce: Callable[[], None] = lambda: None) -> None:
    """Serves the page until interrupted; `announce` is called when nothing more stands in the way.

    Raises `InputError` for a folder that is none, `ParameterError` for a port that is taken, `MissingExtraError` without NiceGUI.
    """
    room = Folder(root=folder)
    _check_free(port)
    with of_extra("nicegui", "web"):
        from nicegui import app, ui
    from mcdas_opt.studio.open_pages import OpenPages
    from mcdas_opt.studio.page import register
    from mcdas_opt.studio.studio import Studio

    app.add_middleware(RequestFilter)
    pages = OpenPages(Studio(room))
    app.on_startup(pages.studio.warm)
    app.on_shutdown(pages.close)
    register(pages)
    announce()
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


def _check_free(port: int) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as trial:
        if sys.platform != "win32":  # there it would share a port that is taken
            trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            trial.bind((HOST, port))
        except OSError as error:
            raise ParameterError("port", port, f"cannot be listened on: {error.strerror}; name another with --port") from None
