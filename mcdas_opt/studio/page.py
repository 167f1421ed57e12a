"""The page itself: NiceGUI carries tabs and messages, our own scripts draw."""

from __future__ import annotations

import types
import uuid
from collections.abc import Awaitable, Callable, Mapping
from pathlib import Path
from typing import Any

from mcdas_opt import __version__
from mcdas_opt.plotting.web import script, style_sheet
from mcdas_opt.studio.connection import Connection
from mcdas_opt.studio.open_pages import OpenPages
from mcdas_opt.studio.page_session import PageSession
from mcdas_opt.studio.parking_session import ParkingSession
from mcdas_opt.studio.parking_tab import ParkingTab
from mcdas_opt.studio.request_filter import LARGEST_BODY
from mcdas_opt.studio.sandwich_tab import SandwichTab

_WEB = Path(__file__).resolve().parent / "web"
_SCRIPTS = (
    "files.js",
    "knobs.js",
    "form.js",
    "times_to_react.js",
    "image.js",
    "asking.js",
    "scene_editor.js",
    "drives.js",
    "sandwich_tab.js",
    "parking_tab.js",
)
_LISTED_S = 60.0  # how long the first page of a large folder may take
Handler = Callable[[Mapping[str, Any]], Awaitable[None] | None]


def scripts() -> str:
    """Every script of the page but Vue's doors."""
    own = "\n".join((_WEB / name).read_text(encoding="utf-8") for name in _SCRIPTS)
    return f"{script()}\n{own}"


def styles() -> str:
    return f"{style_sheet()}\n{(_WEB / 'studio.css').read_text(encoding='utf-8')}"


def register(pages: OpenPages) -> None:
    """Declares the page, its scripts and the door for files on NiceGUI's application."""
    from nicegui import app, ui
    from nicegui.element import Element
    from starlette.responses import JSONResponse, Response

    studio = pages.studio
    base: Any = Element
    sandwich_view: Any = types.new_class("SandwichTabView", (base,), {"component": _WEB / "sandwich_tab_view.js"})
    parking_view: Any = types.new_class("ParkingTabView", (base,), {"component": _WEB / "parking_tab_view.js"})

    def listen(stage: Any, connection: Connection, handlers: dict[str, Handler]) -> None:
        def heard(handler: Handler) -> Callable[[Any], Awaitable[None] | None]:
            def hear(event: Any) -> Awaitable[None] | None:
                work = handler(event.args if isinstance(event.args, Mapping) else {})
                return None if work is None else connection.serve(work)

            return hear

        for name, handler in handlers.items():
            stage.on(name, heard(handler))

    def download_to(stage: Any) -> Callable[[str, str], None]:
        def download(name: str, text: str) -> None:
            with stage:  # NiceGUI finds by it whom the file is for
                ui.download.content(text, name)

        return download

    def connection_of(stage: Any) -> Connection:
        return Connection(lambda part: stage.run_method("hear", part))

    async def receive(request: Any) -> Any:
        told = request.query_params
        return JSONResponse(await pages.receive(told.get("page", ""), told.get("name", ""), await request.body()))

    app.add_route("/studio/pictures.js", lambda _: Response(scripts(), media_type="text/javascript"), methods=["GET"])
    app.add_route("/studio/pictures.css", lambda _: Response(styles(), media_type="text/css"), methods=["GET"])
    app.add_route("/studio/file", receive, methods=["POST"])

    async def _page() -> None:
        key = uuid.uuid4().hex
        setup = await studio.setup(key)
        ui.add_head_html(f'<link rel="stylesheet" href="/studio/pictures.css?{__version__}">')
        ui.add_head_html(f'<script src="/studio/pictures.js?{__version__}"></script>')
        ui.add_body_html(f"<script>window.mcdas.setup = {setup};</script>")
        ui.add_body_html('<p class="mcdas-loading" role="status">loading the studio …</p>')  # until its scripts are there
        sandwich, parking = SandwichTab(studio.folder), ParkingTab(studio.folder)
        with ui.element("header").classes("mcdas-header"):
            ui.html("<h1>mcdas-opt studio</h1>", sanitize=False)
            with ui.tabs() as tabs:
                traffic, place = ui.tab("Sandwich"), ui.tab("Parking")
        with ui.tab_panels(tabs, value=traffic, animated=False):
            with ui.tab_panel(traffic):
                stage = sandwich_view()
                stage._props["upload"] = {"url": f"/studio/file?page={key}", "most": LARGEST_BODY}
            with ui.tab_panel(place):
                yard = parking_view()
        to_sandwich, to_parking = connection_of(stage), connection_of(yard)
        session = PageSession(studio, sandwich, to_sandwich)
        parking_session = ParkingSession(studio, parking, to_parking)
        pages.add(key, session)

        def gone() -> None:
            session.leave()
            to_parking.close()
            pages.remove(key)

        ui.context.client.on_delete(gone)
        listen(
            stage,
            to_sandwich,
            {
                "ready": session.ready,
                "open": session.open,
                "uploaded": lambda _: session.uploaded(),
                "ask": session.ask,
                "drive": session.drive,
                "stop": lambda _: session.stop(),
                "download": lambda wish: session.download(wish, download_to(stage)),
                "save": session.save,
            },
        )
        listen(
            yard,
            to_parking,
            {
                "ready": lambda _: parking_session.ready(),
                "open": parking_session.open,
                "park": parking_session.park,
                "save": lambda wish: parking_session.save(wish, download_to(yard)),
            },
        )

    ui.page("/", title="mcdas-opt studio", response_timeout=_LISTED_S)(_page)
