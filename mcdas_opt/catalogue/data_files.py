"""Where the shipped data is, and how a name or a path becomes a file."""

from __future__ import annotations

import math
import os
import stat
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar, get_args

from pydantic import ValidationError

from mcdas_opt.catalogue.part import Part
from mcdas_opt.domain.parsing import LARGEST_JSON, LARGEST_TOML, parsed_json, parsed_toml
from mcdas_opt.errors import InputError, check_file_name, degrees_perhaps, nearest, reading

LARGEST_TEXT = 200_000_000  # characters
LARGEST_RECORDING = 500_000_000  # bytes

Model = TypeVar("Model", bound=Part)


@lru_cache(maxsize=4)
def data_folder(packaged: str, checkout: str) -> Path:
    """The package's folder `packaged`, else the `checkout`'s."""
    package = Path(__file__).resolve().parent.parent
    for folder in (package / packaged, package.parent / checkout):
        if folder.is_dir():
            return folder
    raise InputError(package, checkout, None, "the data folder is missing: reinstall the package")


def models_folder() -> Path:
    return data_folder("_models", "models")


def shipped(kind: str, suffix: str = ".toml") -> tuple[str, ...]:
    """Names of the shipped files of a kind ('vehicles', 'sensors', 'scenes' ...)."""
    return _names(models_folder() / kind, suffix)


@lru_cache(maxsize=32)
def _names(folder: Path, suffix: str) -> tuple[str, ...]:
    return tuple(sorted(path.stem for path in folder.glob(f"*{suffix}")))


def find(kind: str, name: str, suffix: str = ".toml", beside: Path | None = None) -> Path:
    """The file behind `name`: a path (also relative to the folder `beside`), or the name of a shipped file."""
    check_file_name(name)
    direct = [Path(name)] + ([beside / name] if beside is not None else [])
    for path in direct:
        if os.path.isfile(path):  # false, too, for a name that is too long beside the other file
            return path
    packaged = models_folder() / kind / f"{name}{suffix}"
    if os.path.isfile(packaged):
        return packaged
    known = shipped(kind, suffix)
    if "/" in name or name.endswith(suffix):
        raise InputError(name, "", None, f"no such file; shipped {kind}: {', '.join(known)}")
    raise not_shipped(name, kind[:-1], known)


def not_shipped(name: str, what: str, known: Sequence[str]) -> InputError:
    """For a name that is neither a path nor one of the shipped: which is near, and all there are."""
    near = nearest(name, known)
    listed = near if near.startswith("known") else f"{near} (known: {', '.join(known)})"
    return InputError(name, "", None, f"no such file, and no shipped {what} of that name; {listed}")


def check_is_file(path: Path) -> None:
    """Raises `InputError` for what is no regular file: a pipe that nobody writes to would be waited for."""
    with reading(path):
        found = path.stat()
    if not stat.S_ISREG(found.st_mode):
        raise InputError(path, "", None, "cannot be read: is no regular file")


def read_text(path: Path, largest: int = LARGEST_TEXT) -> str:
    """A file of at most `largest` characters; of a larger one no more than that is read. Raises `InputError` that names it."""
    check_is_file(path)
    try:
        with path.open(encoding="utf-8-sig") as file:  # spreadsheets write a byte order mark
            text = file.read(largest + 1)
    except (OSError, ValueError) as error:
        raise InputError(path, "", None, f"cannot be read: {error}") from None
    if len(text) > largest:
        raise InputError(path, "", None, f"must be at most {largest} characters long")
    return text


def finite_cell(cell: str, path: Path, key: str) -> float:
    """A cell of a table as a number. Raises `InputError` that names the file and `key`."""
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(path, key, cell, "must be a finite number")
    return value


def read_bytes(path: Path, largest: int = LARGEST_RECORDING) -> bytes:
    """A file of at most `largest` bytes; of a larger one no more than that is read. Raises `InputError` that names it."""
    check_is_file(path)
    with reading(path), path.open("rb") as file:
        content = file.read(largest + 1)
    if len(content) > largest:
        raise InputError(path, "", None, f"must be at most {largest} bytes long")
    return content


def read_toml(path: Path) -> dict[str, Any]:
    return parsed_toml(read_text(path, LARGEST_TOML), path)


def read_json(path: Path) -> Any:
    return parsed_json(read_text(path, LARGEST_JSON), path)


def checked(model: type[Model], document: Any, file: object, context: Any = None) -> Model:
    """`document` as a pydantic `model`; one fault becomes an `InputError` with file, key path, value, rule, nearest key.

    Of several faults an unknown key is told first: a misspelt key is missing too. An `InputError` of a validator stands as it is.
    """
    try:
        return model.model_validate(document, context=context)
    except ValidationError as error:
        other = _other_kind(model, document)
        raise InputError(file, "", None, other) if other else told(error, model, file) from None


def told(error: ValidationError, model: type[Part], file: object) -> InputError:
    """What pydantic found wrong with a `model`, as `checked` tells it."""
    faults = error.errors()
    first = next((fault for fault in faults if fault["type"] == "extra_forbidden"), faults[0])
    cause = first.get("ctx", {}).get("error")
    if isinstance(cause, InputError):
        return cause
    key = "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in first["loc"]).lstrip(".")
    if first["type"] == "extra_forbidden":
        known = _fields_at(model, first["loc"][:-1])
        return InputError(file, key, None, f"unknown key; {nearest(str(first['loc'][-1]), known)}")
    angle = degrees_perhaps(first.get("input")) if key.endswith("_rad") else ""
    rule = _RULES.get(first["type"], first["msg"].removeprefix("Value error, "))
    value = first.get("input")
    shown = None if first["type"] == "missing" or isinstance(value, (dict, list)) else value
    return InputError(file, key, shown, rule[0].lower() + rule[1:] + angle)


def _other_kind(model: type[Part], document: Any) -> str:
    """What a document is, by its outermost keys, where it is of another kind than the `model`; else empty."""
    wanted = model.KIND
    if not wanted or not isinstance(document, dict):
        return ""
    kinds = [kind for kind, (keys, _) in _KINDS.items() if keys & document.keys()]
    if not kinds and "host" in document and "host" not in model.model_fields:
        kinds = ["scene"]
    if not kinds or wanted in kinds:
        return ""
    return f"is a {kinds[0]} ({_KINDS[kinds[0]][1]}), where a {wanted} is wanted"


# the outermost keys that only a file of that kind has, and what takes such a file
_KINDS = {
    "parking case": (frozenset({"slot", "goal", "obstacle"}), "mcdas-opt park"),
    "vehicle": (frozenset({"wheelbase_m"}), "--vehicle"),
    "suite": (
        frozenset({"family", "manoeuvre", "recorded", "part", "front", "rear", "side", "blockade", "cut_in", "cut_out", "event_s", "grid"}),
        "mcdas-opt benchmark",
    ),
    "scene": (frozenset({"neighbour", "destination"}), "mcdas-opt plan, simulate"),
}
_RULES = {"missing": "missing key", "model_type": "must be a table", "list_type": "must be a list", "dict_type": "must be a table"}


def _fields_at(model: type[Part], location: tuple[int | str, ...]) -> set[str]:
    """Field names of the sub-model at `location`."""
    current: Any = model
    for part in location:
        if isinstance(part, int) or not (isinstance(current, type) and issubclass(current, Part)):
            continue
        field = next((f for name, f in current.model_fields.items() if part in (name, f.alias)), None)
        current = _inner(field.annotation) if field is not None else None
    return set(current.model_fields) if isinstance(current, type) and issubclass(current, Part) else set()


def _inner(annotation: Any) -> Any:
    """The pydantic model inside an annotation such as `tuple[Model, ...]` or `Model | None`."""
    if isinstance(annotation, type) and issubclass(annotation, Part):
        return annotation
    for argument in get_args(annotation):
        found = _inner(argument)
        if found is not None:
            return found
    return None
