"""The page itself: NiceGUI carries tabs and messages, our own scripts draw."""

from __future__ import annotations

import asyncio
import tempfile
import types
import uuid
from collections.abc import Awaitable, Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from mcdas_opt import __version__
from mcdas_opt.errors import McdasError
from mcdas_opt.plotting.player import drive_document
from mcdas_opt.plotting.web import look_of, palette, script, style_sheet
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.studio.desk import methods
from mcdas_opt.studio.folder import Folder
from mcdas_opt.studio.guard import LARGEST_BODY
from mcdas_opt.studio.hands import Hands
from mcdas_opt.studio.knobs import KNOBS
from mcdas_opt.studio.picture import Picture
from mcdas_opt.studio.session import Session

_WEB = Path(__file__).resolve().parent / "web"
_SCRIPTS = ("knobs.js", "escapes.js", "image.js", "asking.js", "sandwich.js")


class _StoppedError(Exception):
    """The browser wants the drive no longer."""


class Studio:
    """Everything that the pages of one server share: the folder, the processes that answer, the sessions of open pages.

    What takes longer than an answer (drives, logs, parking) is computed on one thread for all pages: the solvers behind it are not
    made to be built on several at once.
    """

    def __init__(self, folder: Folder) -> None:
        self.folder = folder
        self.hands = Hands(methods())
        self.worker = ThreadPoolExecutor(max_workers=1, thread_name_prefix="studio")
        self.visits: dict[str, Visit] = {}

    async def warm(self) -> None:
        """Lets the processes start and build their solvers before anybody asks."""
        async for _ in self.hands.answer(Session(self.folder).question({})):
            pass

    def close(self) -> None:
        self.hands.close()
        self.worker.shutdown(wait=False, cancel_futures=True)

    async def compute(self, work: Callable[[], Any]) -> Any:
        """Runs `work` on the studio's thread."""
        return await asyncio.get_running_loop().run_in_executor(self.worker, work)

    async def receive(self, key: str, name: str, body: bytes) -> dict[str, Any]:
        """A file that a page sent, opened in that page's session."""
        visit = self.visits.get(key)
        if visit is None:
            return {"error": "this page is no longer known: load it again"}
        with tempfile.TemporaryDirectory(prefix="mcdas-studio-") as folder:
            suffix = Path(name).suffix.lower()
            file = Path(folder) / f"sent{suffix if suffix.isascii() and len(suffix) < 8 else ''}"
            file.write_bytes(body)
            try:
                visit.waiting = await self.compute(lambda: visit.session.receive(file, Path(name).name))
            except McdasError as error:
                return {"error": str(error)}
        return {"name": name}


class Visit:
    """One open page: hears the browser's events, and tells it the parts of answers."""

    def __init__(self, studio: Studio, session: Session, tell: Callable[[dict[str, Any]], None]) -> None:
        self.studio, self.session, self.tell = studio, session, tell
        self.waiting: dict[str, Any] | None = None
        self._stopped = False

    async def open(self, wish: Mapping[str, Any]) -> None:
        loop = asyncio.get_running_loop()

        def progress(done: int, of: int) -> None:
            if done % 20 == 0:
                loop.call_soon_threadsafe(self.tell, {"part": "progress", "done": done, "of": of})

        await self._safely(lambda: self.session.open(str(wish.get("kind")), str(wish.get("name")), progress), self.tell)
        self.tell({"part": "stopped"})

    def uploaded(self) -> None:
        if self.waiting is not None:
            self.tell(self.waiting)
            self.waiting = None

    async def ask(self, wish: Mapping[str, Any]) -> None:
        """Answers in parts; the last one, `done`, always comes."""
        token = wish.get("token")
        try:
            question = self.session.question(_values(wish), wish.get("moment"))
            self.tell({"part": "picture", "name": question.name, **Picture(question.situation, question.vehicle).document()})
            async for part in self.studio.hands.answer(question):
                self.tell(part)
        except McdasError as error:
            self.tell({"part": "problem", "text": str(error)})
        finally:
            self.tell({"part": "done", "token": token})

    async def drive(self, wish: Mapping[str, Any]) -> None:
        """Drives the closed loop to its end, telling how far it is; `stop` ends it."""
        loop = asyncio.get_running_loop()
        self._stopped = False

        def progress(done: int, of: int) -> None:
            if self._stopped:
                raise _StoppedError
            loop.call_soon_threadsafe(self.tell, {"part": "progress", "done": done, "of": of})

        def run() -> dict[str, Any]:
            values = _values(wish)
            scene, settings = self.session.turned(values), self.session.settings(values)
            return drive_document(simulate(scene, str(wish.get("planner")), settings=settings, progress=progress))

        try:
            await self._safely(run, lambda drive: self.tell({"part": "drive", "drive": drive}))
        except _StoppedError:
            self.tell({"part": "stopped"})

    def stop(self) -> None:
        self._stopped = True

    async def save(self, wish: Mapping[str, Any], download: Callable[[str, str], None]) -> None:
        await self._safely(lambda: self.session.toml(_values(wish)), lambda named: download(*named))

    async def _safely(self, work: Callable[[], Any], then: Callable[[Any], None]) -> None:
        """`work` on the studio's thread, its outcome to `then`; bad input is told to the page."""
        try:
            then(await self.studio.compute(work))
        except McdasError as error:
            self.tell({"part": "problem", "text": str(error)})


def _values(wish: Mapping[str, Any]) -> dict[str, object]:
    values = wish.get("values")
    return dict(values) if isinstance(values, Mapping) else {}


def scripts() -> str:
    """Every script of the page but Vue's doors."""
    own = "\n".join((_WEB / name).read_text(encoding="utf-8") for name in _SCRIPTS)
    return f"{script()}\n{own}"


def styles() -> str:
    return f"{style_sheet()}\n{(_WEB / 'studio.css').read_text(encoding='utf-8')}"


def register(studio: Studio) -> None:
    """Declares the page, its scripts and the door for files on NiceGUI's application."""
    from fastapi import Request, Response
    from nicegui import app, ui
    from nicegui.element import Element

    parent: Any = Element
    view: Any = types.new_class("SandwichView", (parent,), {"component": _WEB / "sandwich_view.js"})

    def _scripts() -> Response:
        return Response(scripts(), media_type="text/javascript")

    def _styles() -> Response:
        return Response(styles(), media_type="text/css")

    async def _file(request: Request, page: str, name: str) -> dict[str, Any]:
        return await studio.receive(page, name, await request.body())

    async def _page() -> None:
        key = uuid.uuid4().hex
        ui.add_head_html(f'<link rel="stylesheet" href="/studio/pictures.css?{__version__}">')
        ui.add_head_html(f'<script src="/studio/pictures.js?{__version__}"></script>')
        session = await studio.compute(lambda: Session(studio.folder))
        with ui.element("header").classes("mcdas-header"):
            ui.html("<h1>mcdas-opt studio</h1>", sanitize=False)
            with ui.tabs() as tabs:
                sandwich = ui.tab("Sandwich")
        setup = {
            "knobs": [{name: getattr(knob, name) for name in knob.__slots__} for knob in KNOBS],
            "planners": [{"name": name, **look_of(name)} for name in studio.hands.planners],
            "shelf": await studio.compute(session.shelf),
            "upload": {"url": f"/studio/file?page={key}", "most": LARGEST_BODY},
        }
        with ui.tab_panels(tabs, value=sandwich, animated=False).classes("w-full"), ui.tab_panel(sandwich):
            stage = view()
            stage._props["look"] = palette()
            stage._props["setup"] = setup
        visit = Visit(studio, session, lambda part: stage.run_method("hear", part))
        studio.visits[key] = visit
        ui.context.client.on_delete(lambda: studio.visits.pop(key, None))

        def on(event: str, handler: Callable[[Mapping[str, Any]], Awaitable[None] | None]) -> None:
            stage.on(event, lambda e: handler(e.args if isinstance(e.args, Mapping) else {}))

        on("ready", lambda _: visit.tell(session.opened()))
        on("open", visit.open)
        on("uploaded", lambda _: visit.uploaded())
        on("ask", visit.ask)
        on("drive", visit.drive)
        on("stop", lambda _: visit.stop())
        on("save", lambda wish: visit.save(wish, lambda name, text: ui.download.content(text, name)))

    app.add_api_route("/studio/pictures.js", _scripts, methods=["GET"])
    app.add_api_route("/studio/pictures.css", _styles, methods=["GET"])
    app.add_api_route("/studio/file", _file, methods=["POST"], response_model=None)
    ui.page("/", title="mcdas-opt studio")(_page)
