"""What one open page looks at: a scene under its sliders, or a moment of a log."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from mcdas_opt.catalogue.data_files import read_toml, shipped
from mcdas_opt.catalogue.scene_file import scene_file
from mcdas_opt.catalogue.scenes import Scene, scene_from_document
from mcdas_opt.domain.settings import Settings, SigmoidSettings
from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.studio import logs, results
from mcdas_opt.studio.folder import Folder, download_name, shipped_file
from mcdas_opt.studio.knobs import KNOBS, SIGMOID, positions, sigmoid_of, turned
from mcdas_opt.studio.planner_cache import Question, first_look

FIRST = "sandwich-60-40"

Progress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Looked:
    """What is looked at: a scene with the document that it came from (`row` of a benchmark's `table`, if any), or a log."""

    scene: Scene
    document: dict[str, Any]
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
        self._at = _scene(shipped_file("scenes", FIRST))

    def data_files(self) -> list[dict[str, Any]]:
        """What can be opened, in groups."""
        return [
            {"label": "shipped scenes", "kind": "shipped", "names": [FIRST, *(name for name in shipped("scenes") if name != FIRST)]},
            {"label": "scenes of the folder", "kind": "scene", "names": self.folder.scenes()},
            {"label": "shipped logs", "kind": "shipped-log", "names": list(shipped("logs", ".log"))},
            {"label": "logs of the folder", "kind": "log", "names": self.folder.logs()},
            {"label": "benchmark results of the folder", "kind": "results", "names": self.folder.results()},
        ]

    def open(self, kind: str, name: str, progress: Progress | None = None) -> dict[str, Any]:
        """Opens one of the data files. Raises `InputError` for what is not there, or lies outside of the folder."""
        if kind == "shipped":
            self._at = _scene(shipped_file("scenes", name))
        elif kind == "scene":
            self._at = self._confined(self.folder.file(name), name)
        elif kind == "shipped-log":
            self._at = self._log(shipped_file("logs", name, ".log"), name, progress)
        elif kind == "log":
            self._at = self._log(self.folder.file(name), name, progress)
        elif kind == "results":
            self._at = self._results(self.folder.file(name), name)
        elif kind == "row" and self._at.table is not None:
            self._at = _row(self._at.table, name)
        else:
            raise ParameterError("kind", kind, "must be shipped, scene, shipped-log, log, results, or row of a table that is open")
        return self.opened()

    def receive(self, file: Path, name: str, progress: Progress | None = None) -> dict[str, Any]:
        """Opens a file that the browser sent; `name` is what it was called there. Raises `InputError` that uses that name."""
        try:
            if Path(name).suffix.lower() == ".toml":
                self._at = self._confined(file, name)
            elif results.is_results(file):
                self._at = self._results(file, name)
            else:
                self._at = self._log(file, name, progress)
        except InputError as error:
            told = error.file.replace(str(file), name).replace(file.name, name)
            raise InputError(told, error.key, error.value, error.rule) from None
        return self.opened()

    def opened(self) -> dict[str, Any]:
        """Where the sliders stand, and the moments of a log."""
        at = self._at
        if at.log is None:
            rows = None if at.table is None else at.table.offered()
            stand = positions(at.scene, at.sigmoid)
            return {"part": "opened", "name": at.scene.name, "positions": stand, "rows": rows, "row": str(at.row), "planner": at.planner}
        sigmoid = asdict(at.sigmoid)
        stand = {knob.key: sigmoid.get(knob.key) for knob in KNOBS}
        return {
            "part": "opened",
            "name": at.log.name,
            "positions": stand,
            "moments": at.log.times_s,
            "moment": at.log.first_threat,
            "note": logs.NOTE,
        }

    def question(self, values: Mapping[str, object], moment: object = None) -> Question:
        """The situation under the sliders, or at a moment of the log. Raises `InputError` or `ParameterError`."""
        at = self._at
        sigmoid = sigmoid_of(at.sigmoid, values)
        if at.log is not None:
            situation = at.log.situation(moment if isinstance(moment, int) else at.log.first_threat)
            return Question(name=at.log.name, situation=situation, vehicle=at.log.vehicle, sigmoid=sigmoid)
        scene = self.turned(values)
        return Question(name=scene.name, situation=first_look(scene), vehicle=scene.vehicle, sigmoid=sigmoid)

    def turned(self, values: Mapping[str, object]) -> Scene:
        """The scene with the sliders' values."""
        at = self._at
        if not set(values) - set(SIGMOID):
            return at.scene
        return scene_from_document(turned(at.scene, at.document, values), at.path)

    def settings(self, values: Mapping[str, object]) -> Settings:
        """The closed form's settings with the sliders' values."""
        return Settings(sigmoid=sigmoid_of(self._at.sigmoid, values))

    def toml(self, values: Mapping[str, object]) -> tuple[str, str]:
        """File name and text of the scene with the sliders' values."""
        scene = self.turned(values)
        return download_name(scene.name, "scene"), scene_file(scene)

    def _confined(self, path: Path, name: str) -> Looked:
        document = read_toml(path)
        if "host" not in document and {"slot", "goal", "obstacle"} & set(document):
            raise InputError(name, "", None, "is a parking case: open it on the parking tab")
        self.folder.confine(document, path if path.is_relative_to(self.folder.root) else self.folder.root / name)
        return _scene(path)

    def _results(self, path: Path, name: str) -> Looked:
        table = results.read(path, name)
        return _row(table, table.offered()[0][0])

    def _log(self, path: Path, name: str, progress: Progress | None) -> Looked:
        at = self._at
        return Looked(scene=at.scene, document=at.document, path=at.path, log=replace(logs.read(path, progress), name=name))


def _row(table: results.Results, name: str) -> Looked:
    number, scene, planner = table.row(name)
    document = scene.model_dump(mode="json", exclude_defaults=True, exclude_none=True)
    return Looked(scene=scene, document=document, path=Path(scene.file), table=table, row=number, planner=planner)


def _scene(path: Path) -> Looked:
    document = read_toml(path)
    return Looked(scene=scene_from_document(document, path), document=document, path=path)
