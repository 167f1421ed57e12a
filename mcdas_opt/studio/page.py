"""The page itself: NiceGUI carries tabs and messages, our own scripts draw."""

from __future__ import annotations

import types
import uuid
from collections.abc import Awaitable, Callable, Mapping
from pathlib import Path
from typing import Any

from mcdas_opt import __version__
from mcdas_opt.parking.park import PLANNERS as PARKERS
from mcdas_opt.plotting.web import PLANNERS as PICTURED
from mcdas_opt.plotting.web import look_of, palette, script, style_sheet
from mcdas_opt.studio import lot as parking
from mcdas_opt.studio.guard import LARGEST_BODY
from mcdas_opt.studio.knobs import KNOBS, Knob
from mcdas_opt.studio.session import Session
from mcdas_opt.studio.visit import LotVisit, Studio, Visit

_WEB = Path(__file__).resolve().parent / "web"
_SCRIPTS = ("knobs.js", "escapes.js", "image.js", "asking.js", "sandwich.js", "lot.js")
Handler = Callable[[Mapping[str, Any]], Awaitable[None] | None]


def scripts() -> str:
    """Every script of the page but Vue's doors."""
    own = "\n".join((_WEB / name).read_text(encoding="utf-8") for name in _SCRIPTS)
    return f"{script()}\n{own}"


def styles() -> str:
    return f"{style_sheet()}\n{(_WEB / 'studio.css').read_text(encoding='utf-8')}"


def register(studio: Studio) -> None:
    """Declares the page, its scripts and the door for files on NiceGUI's application."""
    from nicegui import app, ui
    from nicegui.element import Element
    from starlette.responses import JSONResponse, Response

    base: Any = Element
    sandwich_view: Any = types.new_class("SandwichView", (base,), {"component": _WEB / "sandwich_view.js"})
    lot_view: Any = types.new_class("LotView", (base,), {"component": _WEB / "lot_view.js"})

    def put(view: Any, setup: dict[str, Any]) -> Any:
        """A view of the page with what it needs to begin."""
        stage = view()
        stage._props.update(look=palette(), setup=setup)
        return stage

    def listen(stage: Any, handlers: dict[str, Handler]) -> None:
        def heard(handler: Handler) -> Callable[[Any], Awaitable[None] | None]:
            return lambda event: handler(event.args if isinstance(event.args, Mapping) else {})

        for name, handler in handlers.items():
            stage.on(name, heard(handler))

    def download(name: str, text: str) -> None:
        ui.download.content(text, name)

    async def receive(request: Any) -> Any:
        told = request.query_params
        return JSONResponse(await studio.receive(told.get("page", ""), told.get("name", ""), await request.body()))

    app.add_route("/studio/pictures.js", lambda _: Response(scripts(), media_type="text/javascript"), methods=["GET"])
    app.add_route("/studio/pictures.css", lambda _: Response(styles(), media_type="text/css"), methods=["GET"])
    app.add_route("/studio/file", receive, methods=["POST"])

    async def _page() -> None:
        key = uuid.uuid4().hex
        ui.add_head_html(f'<link rel="stylesheet" href="/studio/pictures.css?{__version__}">')
        ui.add_head_html(f'<script src="/studio/pictures.js?{__version__}"></script>')
        session, lot = Session(studio.folder), parking.Lot(studio.folder)
        with ui.element("header").classes("mcdas-header"):
            ui.html("<h1>mcdas-opt studio</h1>", sanitize=False)
            with ui.tabs() as tabs:
                traffic, place = ui.tab("Sandwich"), ui.tab("Parking")
        with ui.tab_panels(tabs, value=traffic, animated=False):
            with ui.tab_panel(traffic):
                stage = put(
                    sandwich_view,
                    {
                        "knobs": _knobs(KNOBS),
                        "planners": _planners(studio.hands.planners),
                        "shelf": session.shelf(),
                        "upload": {"url": f"/studio/file?page={key}", "most": LARGEST_BODY},
                    },
                )
            with ui.tab_panel(place):
                yard = put(lot_view, {"knobs": _knobs(parking.KNOBS), "planners": list(PARKERS), "shelf": lot.shelf()})
        visit = Visit(studio, session, lambda part: stage.run_method("hear", part))
        lot_visit = LotVisit(studio, lot, lambda part: yard.run_method("hear", part))
        studio.visits[key] = visit

        def gone() -> None:
            visit.stop()
            studio.visits.pop(key, None)

        ui.context.client.on_delete(gone)
        listen(
            stage,
            {
                "ready": lambda _: visit.tell(session.opened()),
                "open": visit.open,
                "uploaded": lambda _: visit.uploaded(),
                "ask": visit.ask,
                "drive": visit.drive,
                "stop": lambda _: visit.stop(),
                "save": lambda wish: visit.save(wish, download),
            },
        )
        listen(
            yard,
            {
                "ready": lambda _: lot_visit.tell(lot.opened()),
                "open": lot_visit.open,
                "park": lot_visit.park,
                "save": lambda wish: lot_visit.save(wish, download),
            },
        )

    ui.page("/", title="mcdas-opt studio")(_page)


def _knobs(knobs: tuple[Knob, ...]) -> list[dict[str, Any]]:
    return [{name: getattr(knob, name) for name in knob.__slots__} for knob in knobs]


def _planners(names: tuple[str, ...]) -> list[dict[str, Any]]:
    """Every planner with its look; ours are shown, the others when they are asked for."""
    others = [name for name in names if name not in PICTURED]
    return [{"name": name, "shown": name in PICTURED, **look_of(name, others)} for name in names]
