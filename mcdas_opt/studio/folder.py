"""The folder that the studio was given: the only place whose files it reads."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from mcdas_opt.catalogue.data_files import models_folder, read_toml, shipped
from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.errors import InputError, check_file_name, writing
from mcdas_opt.evaluation.table import CSV, TIMINGS

_MOST_FILES = 400
_OUTSIDE = "lies outside of the folder that the studio was started with"
_TELLING = frozenset({"host", "wheelbase_m", "slot", "goal", "obstacle"})
_LARGEST_LISTED = 300_000  # bytes; larger ones are opened by name
_MOST_SEEN, _DEEPEST = 20_000, 5


class ExistsError(InputError):
    """A scene of that name is there already."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Folder:
    """Names of files relative to `root`; symbolic links that lead out of it are out of it."""

    root: Path

    def __post_init__(self) -> None:
        require_types(self)
        check_file_name(self.root)
        root = self.root.resolve()
        if not root.is_dir():
            raise InputError(self.root, "", None, "no such folder")
        object.__setattr__(self, "root", root)

    def file(self, name: str) -> Path:
        """The file of that name. Raises `InputError` for one outside of the folder, or that is none."""
        check_file_name(name)
        path = self.root / name
        if not self._inside(path):
            raise InputError(name, "", None, _OUTSIDE)
        if not path.is_file():
            raise InputError(name, "", None, "no such file in the folder that the studio was started with")
        return path.resolve()

    def _inside(self, path: Path) -> bool:
        try:
            return path.resolve().is_relative_to(self.root)
        except (OSError, ValueError):
            return False

    def names(self, *suffixes: str) -> list[str]:
        """Files with one of these suffixes, at most `_MOST_FILES` and `_DEEPEST` folders down; hidden folders are left out.

        Of a folder with very many entries only the first `_MOST_SEEN` are looked at: all can still be opened by name.
        """
        found: list[str] = []
        seen = 0
        for folder, below, files in os.walk(self.root):
            here = Path(folder)
            deep = len(here.relative_to(self.root).parts)
            below[:] = sorted(name for name in below if not name.startswith(".")) if deep < _DEEPEST else []
            for name in sorted(files):
                path = here / name
                if path.suffix.lower() in suffixes and not name.startswith(".") and self._inside(path) and path.is_file():
                    found.append(path.relative_to(self.root).as_posix())
            seen += len(files) + len(below)
            if seen > _MOST_SEEN or len(found) >= _MOST_FILES:
                break
        return sorted(found[:_MOST_FILES])

    def scenes(self) -> list[str]:
        """Files that hold a scene: those with a host."""
        return [name for name in self.names(".toml") if "host" in self.holds(name)]

    def vehicles(self) -> list[str]:
        """Files that hold a vehicle."""
        return [name for name in self.names(".toml") if "wheelbase_m" in self.holds(name)]

    def cases(self) -> list[str]:
        """Files that hold a parking case."""
        held = {name: self.holds(name) for name in self.names(".toml")}
        return [name for name, keys in held.items() if keys & {"slot", "goal", "obstacle"} and "host" not in keys]

    def logs(self) -> list[str]:
        """Files that may be recordings of radar; what lies beside one or is a benchmark's is none."""
        found = self.names(".log", ".csv")
        return [name for name in found if not name.endswith((".host.csv", ".truth.csv", CSV, TIMINGS))]

    def results(self) -> list[str]:
        """Tables of benchmark rows."""
        return [name for name in self.names(".csv") if Path(name).name == CSV]

    def save(self, path: Path, text: str, *, replace: bool) -> None:
        """Writes a scene. Raises `InputError` outside of the folder or over what is none, `ExistsError` over one unless `replace`."""
        name = path.relative_to(self.root).as_posix() if path.is_relative_to(self.root) else path.name
        check_file_name(name)
        if not self._inside(path):
            raise InputError(name, "", None, _OUTSIDE)
        if path.exists() and "host" not in self.holds(name):
            raise InputError(name, "", None, "is there already, and holds no scene: choose another name")
        with writing(name):
            try:
                with path.open("w" if replace else "x", encoding="utf-8") as file:
                    file.write(text)
            except FileExistsError:
                raise ExistsError(name, "", None, "is there already: replace it, or choose another name") from None

    def holds(self, name: str) -> frozenset[str]:
        """The outermost keys of a file by which it is known what it holds, none of a very large one; read once as long as its time and
        size stay."""
        path = self.root / name
        try:
            found = path.stat()
        except OSError:
            return frozenset()
        return _keys_of(path, found.st_mtime_ns, found.st_size)

    def confine(self, document: object, source: Path) -> None:
        """Refuses a scene or a case that names files outside of the folder: its vehicle, its sensors, its recorded trajectories.

        Shipped names are always allowed; others are sought beside `source`. Raises `InputError` that names the key.
        """
        if not isinstance(document, dict):
            return
        beside = source.parent
        for key, kind, name in _named(document):
            if kind is not None and "/" not in name and name in (*shipped(kind), "ideal", "none"):
                continue
            try:
                check_file_name(name)
            except InputError as error:
                raise InputError(source.name, key, name, error.rule) from None
            if not self._inside(beside / name) or (Path(name).exists() and not self._inside(Path(name))):
                raise InputError(source.name, key, name, _OUTSIDE)


@lru_cache(maxsize=4 * _MOST_FILES)
def _keys_of(path: Path, mtime_ns: int, size: int) -> frozenset[str]:
    if size > _LARGEST_LISTED:
        return frozenset()
    try:
        return _TELLING & read_toml(path).keys()
    except InputError:
        return frozenset()


def _named(document: dict[str, object]) -> list[tuple[str, str | None, str]]:
    """(key, kind of shipped file, name) of every file that a scene names."""
    found: list[tuple[str, str | None, str]] = []
    vehicle = document.get("vehicle")
    if isinstance(vehicle, dict) and isinstance(vehicle.get("name"), str):  # of a parking case
        found.append(("vehicle.name", "vehicles", vehicle["name"]))
    host, sensors, cars = document.get("host"), document.get("sensors"), document.get("neighbour")
    if isinstance(host, dict) and isinstance(host.get("vehicle"), str):
        found.append(("host.vehicle", "vehicles", host["vehicle"]))
    if isinstance(sensors, dict):
        found += [(f"sensors.{key}", "sensors", name) for key, name in sensors.items() if isinstance(name, str)]
    if isinstance(cars, list):
        for k, car in enumerate(cars):
            if isinstance(car, dict) and isinstance(car.get("trajectory"), str):
                found.append((f"neighbour[{k}].trajectory", None, car["trajectory"]))
    return found


def shipped_file(kind: str, name: str, suffix: str = ".toml") -> Path:
    """A shipped file by its bare name. Raises `InputError`; a path is none."""
    if name not in shipped(kind, suffix):
        raise InputError(name, "", None, f"no shipped {kind[:-1]} of that name")
    return models_folder() / kind / f"{name}{suffix}"


def download_name(name: str, otherwise: str) -> str:
    """A file name for what is called `name`, of letters, digits and `-_.`; `otherwise` where nothing is left of it."""
    kept = "".join(c if c.isalnum() or c in "-_." else "-" for c in name).strip("-.")
    return f"{kept or otherwise}.toml"
