"""What one open page looks at, and what was before it: a scene that is edited, or a moment of a log."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from mcdas_opt.catalogue.data_files import read_toml, shipped
from mcdas_opt.catalogue.scene_file import scene_document, scene_file
from mcdas_opt.catalogue.scenes import Scene, scene_from_document
from mcdas_opt.domain.settings import Settings, SigmoidSettings
from mcdas_opt.errors import InputError, ParameterError, blaming
from mcdas_opt.studio import logs, results
from mcdas_opt.studio.edits import History, check_size, edited
from mcdas_opt.studio.folder import Folder, download_name, shipped_file
from mcdas_opt.studio.handles import handles
from mcdas_opt.studio.knobs import KNOBS, SIGMOID, positions, sigmoid_of
from mcdas_opt.studio.planner_cache import Question, first_look
from mcdas_opt.studio.share import NAME, document_in, link_of

FIRST = "sandwich-60-40"

Progress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Looked:
    """What is looked at: a scene (`row` of a benchmark's `table`, if any) with the file that it came from, or a log."""

    scene: Scene
    path: Path
    sigmoid: SigmoidSettings = field(default_factory=SigmoidSettings)
    log: logs.Moments | None = None
    table: results.Results | None = None
    row: int = 0
    planner: str = ""


class SandwichTab:
    """The sandwich tab's state, exchanged as a whole: another thread may open something while the sliders ask."""

    def __init__(self, folder: Folder) -> None:
        self.folder = folder
        self._history = History(present=_scene(shipped_file("scenes", FIRST)))

    @property
    def at(self) -> Looked:
        return self._history.present

    def data_files(self) -> list[dict[str, Any]]:
        """What can be opened, in groups."""
        return [
            {"label": "shipped scenes", "kind": "shipped", "names": [FIRST, *(name for name in shipped("scenes") if name != FIRST)]},
            {"label": "scenes of the folder", "kind": "scene", "names": self.folder.scenes()},
            {"label": "shipped logs", "kind": "shipped-log", "names": list(shipped("logs", ".log"))},
            {"label": "logs of the folder", "kind": "log", "names": self.folder.logs()},
            {"label": "benchmark results of the folder", "kind": "results", "names": self.folder.results()},
        ]

    def open(self, kind: str, name: str) -> dict[str, Any]:
        """Opens one of the data files, or what a link holds. Raises as `read` does."""
        return self.look(self.read(kind, name))

    def read(self, kind: str, name: str, progress: Progress | None = None) -> Looked:
        """One of the data files, or what a link holds; changes nothing. Raises `InputError` for what is not there, or lies outside of the
        folder."""
        if kind == "shipped":
            return _scene(shipped_file("scenes", name))
        if kind == "scene":
            return self._confined(self.folder.file(name), name)
        if kind == "link":
            return self._linked(document_in(name))
        if kind == "shipped-log":
            return self._log(shipped_file("logs", name, ".log"), name, progress)
        if kind == "log":
            return self._log(self.folder.file(name), name, progress)
        if kind == "results":
            return self._results(self.folder.file(name), name)
        if kind == "row" and self.at.table is not None:
            return _row(self.at.table, name)
        raise ParameterError("kind", kind, "must be shipped, scene, link, shipped-log, log, results, or row of a table that is open")

    def read_sent(self, file: Path, name: str, progress: Progress | None = None) -> Looked:
        """A file that the browser sent; `name` is what it was called there. Raises `InputError` that uses that name."""
        try:
            if Path(name).suffix.lower() == ".toml":
                return self._confined(file, name)
            return self._results(file, name) if results.is_results(file) else self._log(file, name, progress)
        except InputError as error:
            told = error.file.replace(str(file), name).replace(file.name, name)
            raise InputError(told, error.key, error.value, error.rule) from None

    def look(self, at: Looked) -> dict[str, Any]:
        """Shows what was read, which can be undone for a scene; what is larger is not kept."""
        at = at if at.log is None else replace(at, scene=self.at.scene, path=self.at.path)
        large = at.log is not None or at.table is not None or self.at.log is not None or self.at.table is not None
        self._history = History(present=at) if large else self._history.then(at)
        return self.opened()

    def act(self, action: Mapping[str, Any]) -> None:
        """One step of editing: `do` is edit (`changes`, and the `stroke` that they belong to), undo or redo.

        Raises `InputError` or `ParameterError` for an edit that makes no scene, and changes nothing then.
        """
        do, changes = action.get("do"), action.get("changes")
        if do == "undo":
            self._history = self._history.undone()
        elif do == "redo":
            self._history = self._history.redone()
        elif do == "edit" and isinstance(changes, Mapping):
            self._history = self._history.then(self._changed(changes), action.get("stroke"))
        else:
            raise ParameterError("do", do, "must be edit with changes, undo or redo")

    def opened(self) -> dict[str, Any]:
        """What it is called, and the moments of a log."""
        at = self.at
        if at.log is None:
            rows = None if at.table is None else at.table.offered()
            return {"part": "opened", "name": at.scene.name, "rows": rows, "row": str(at.row), "planner": at.planner}
        return {
            "part": "opened",
            "name": at.log.name,
            "moments": at.log.times_s,
            "moment": at.log.first_threat,
            "note": logs.NOTE,
        }

    def state(self) -> dict[str, Any]:
        """Where the sliders stand, the scene's keys, who can be dragged, a link to it, and whether something can be undone or redone."""
        at, history = self.at, self._history
        shown = {"part": "state", "undo": bool(history.past), "redo": bool(history.future)}
        if at.log is not None:
            sigmoid = asdict(at.sigmoid)
            return {**shown, "name": at.log.name, "positions": {knob.key: sigmoid.get(knob.key) for knob in KNOBS}}
        document = scene_document(at.scene)
        shared = {"scene": document} | ({} if at.sigmoid == SigmoidSettings() else {"sigmoid": asdict(at.sigmoid)})
        return {
            **shown,
            "name": at.scene.name,
            "positions": positions(at.scene, at.sigmoid),
            "scene": at.scene.model_dump(mode="json"),
            "link": link_of(shared),
            **handles(at.scene),
        }

    def question(self, moment: object = None) -> Question:
        """The scene's situation, or that at a moment of the log. Raises `InputError`."""
        at = self.at
        if at.log is not None:
            situation = at.log.situation(moment if isinstance(moment, int) else at.log.first_threat)
            return Question(name=at.log.name, situation=situation, vehicle=at.log.vehicle, sigmoid=at.sigmoid)
        return Question(name=at.scene.name, situation=first_look(at.scene), vehicle=at.scene.vehicle, sigmoid=at.sigmoid)

    @property
    def settings(self) -> Settings:
        """The planners' settings, with the closed form's numbers."""
        return Settings(sigmoid=self.at.sigmoid)

    def toml(self) -> tuple[str, str]:
        """File name and text of the scene."""
        return download_name(self.at.scene.name, "scene"), scene_file(self.at.scene)

    def save(self, name: str, *, replace: bool) -> str:
        """Writes the scene into the folder, beside the file that it came from, under this name; that name.

        Raises `ExistsError` where a scene of that name is there and not to be replaced.
        """
        text, path = scene_file(self.at.scene), self._beside() / download_name(name.removesuffix(".toml"), "scene")
        document = scene_document(self.at.scene)
        self.folder.confine(document, path)
        self.folder.save(path, text, replace=replace)
        self._history = self._history.then(Looked(scene=scene_from_document(document, path), path=path, sigmoid=self.at.sigmoid))
        return path.relative_to(self.folder.root).as_posix()

    def _changed(self, changes: Mapping[str, object]) -> Looked:
        at = self.at
        sigmoid = sigmoid_of(at.sigmoid, changes)
        rest = {key: value for key, value in changes.items() if key not in SIGMOID}
        if not rest:
            return replace(at, sigmoid=sigmoid)
        if at.log is not None:
            raise ParameterError(next(iter(rest)), None, "a log cannot be edited")
        document, path = edited(at.scene, rest), at.path
        if not path.is_relative_to(self.folder.root) and not any(car.trajectory for car in at.scene.neighbour):
            path = self.folder.root / path.name  # files that are named from now on are the folder's
        return replace(at, scene=self._scene(document, path, path), path=path, sigmoid=sigmoid)

    def _linked(self, shared: object) -> Looked:
        """What a link holds: `scene`, and the closed form's numbers where they are not the usual ones."""
        if not isinstance(shared, dict) or not isinstance(shared.get("scene"), dict):
            raise InputError(NAME, "scene", None, "missing key")
        path, sigmoid = self.folder.root / NAME, shared.get("sigmoid", {})
        with blaming(NAME):
            scene = self._scene(shared["scene"], path, path)
        return Looked(scene=scene, path=path, sigmoid=sigmoid_of(SigmoidSettings(), sigmoid if isinstance(sigmoid, dict) else {}))

    def _beside(self) -> Path:
        folder = self.at.path.parent
        return folder if folder.is_relative_to(self.folder.root) else self.folder.root

    def _confined(self, path: Path, name: str) -> Looked:
        document = read_toml(path)
        if "host" not in document and {"slot", "goal", "obstacle"} & set(document):
            raise InputError(name, "", None, "is a parking case: open it on the parking tab")
        home = path if path.is_relative_to(self.folder.root) else self.folder.root / Path(name).name
        with blaming(name):
            return Looked(scene=self._scene(document, path, home), path=home)

    def _scene(self, document: dict[str, Any], path: Path, home: Path) -> Scene:
        """A scene that comes from outside and is to stand at `home`. Raises `InputError`, `ParameterError` for one that is too large."""
        self.folder.confine(document, home)
        check_size(document)
        return scene_from_document(document, path)

    def _results(self, path: Path, name: str) -> Looked:
        table = results.read(path, name)
        return _row(table, table.offered()[0][0])

    def _log(self, path: Path, name: str, progress: Progress | None) -> Looked:
        return Looked(scene=self.at.scene, path=self.at.path, log=replace(logs.read(path, progress), name=name))


def _row(table: results.Results, name: str) -> Looked:
    number, scene, planner = table.row(name)
    return Looked(scene=scene, path=Path(scene.file), table=table, row=number, planner=planner)


def _scene(path: Path) -> Looked:
    return _read(path, path.stat().st_mtime_ns)


@lru_cache(maxsize=64)
def _read(path: Path, _: int) -> Looked:
    """Once as long as the file stays as it is: every page begins with it."""
    return Looked(scene=scene_from_document(read_toml(path), path), path=path)
