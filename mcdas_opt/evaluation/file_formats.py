"""Every file that a user writes: its keys with units, defaults and ranges, and its JSON Schema, read from the models that check it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel

from mcdas_opt.catalogue.motion import MotionFile
from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.catalogue.sensors import SensorFile
from mcdas_opt.catalogue.vehicles import VehicleFile
from mcdas_opt.domain.rules import unit_of
from mcdas_opt.errors import ParameterError, nearest
from mcdas_opt.evaluation.families import Family
from mcdas_opt.evaluation.suites import SuiteFile
from mcdas_opt.parking.case_file import ParkingFile

MODELS: dict[str, type[BaseModel]] = {
    "scene": Scene,
    "vehicle": VehicleFile,
    "sensor": SensorFile,
    "motion": MotionFile,
    "parking-case": ParkingFile,
    "suite": SuiteFile,
    "family": Family,
}
_DIALECT = "https://json-schema.org/draft/2020-12/schema"
_BOUNDS = {"exclusiveMinimum": "> {:g}", "minimum": ">= {:g}", "exclusiveMaximum": "< {:g}", "maximum": "<= {:g}"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Key:
    """One key of a file. `table` is where it stands: empty at the top, `[host]`, or `[[neighbour]]` for one of several."""

    table: str
    name: str
    kind: str
    unit: str
    default: str
    allowed: str
    about: str


def schema(kind: str) -> dict[str, Any]:
    """The JSON Schema of a kind of file, every quantity with its unit. Raises `ParameterError` for a kind that is none."""
    if kind not in MODELS:
        raise ParameterError("kind", kind, nearest(kind, MODELS))
    document = MODELS[kind].model_json_schema()
    for part in (document, *document.get("$defs", {}).values()):
        for name, entry in part.get("properties", {}).items():
            unit = unit_of(name)
            about = entry.get("description", "")
            if unit:
                entry["description"] = f"{about} [{unit}]".strip()
    return {"$schema": _DIALECT, "$id": f"mcdas-opt/{kind}", **document, "title": f"mcdas-opt {kind}"}


def keys(kind: str) -> tuple[Key, ...]:
    """Every key of a kind of file, in the order in which it may stand. Raises `ParameterError` for a kind that is none."""
    if kind not in MODELS:
        raise ParameterError("kind", kind, nearest(kind, MODELS))
    document = MODELS[kind].model_json_schema()
    return tuple(_of_table("", document, document.get("$defs", {})))


def _of_table(table: str, part: dict[str, Any], parts: dict[str, Any]) -> Iterator[Key]:
    inner: list[tuple[str, dict[str, Any]]] = []
    for name, entry in part.get("properties", {}).items():
        held, several = _table_behind(entry, parts)
        if held is not None:
            if len(_forms(entry)) > 1:  # a plain value, too
                yield _key(table, name, entry, part, parts)
            path = f"{table.strip('[]')}.{name}".lstrip(".")
            inner.append((f"[[{path}]]" if several else f"[{path}]", held))
            continue
        yield _key(table, name, entry, part, parts)
    for path, held in inner:
        yield from _of_table(path, held, parts)


def _key(table: str, name: str, entry: dict[str, Any], part: dict[str, Any], parts: dict[str, Any]) -> Key:
    return Key(
        table=table,
        name=name,
        kind=_kind(entry, parts),
        unit=unit_of(name),
        default=_default(name, entry, part),
        allowed=_allowed(entry, parts),
        about=entry.get("description", ""),
    )


def _table_behind(entry: dict[str, Any], parts: dict[str, Any]) -> tuple[dict[str, Any] | None, bool]:
    """The table that a key holds, and whether there may be several; None for a plain value."""
    for one in _forms(entry):
        several = one.get("type") == "array"
        reference = (one.get("items", {}) if several else one).get("$ref", "")
        held = parts.get(reference.rpartition("/")[2])
        if held is not None and "properties" in held:
            return held, several
    return None, False


def _forms(entry: dict[str, Any]) -> list[dict[str, Any]]:
    """What a key may hold, but for nothing at all."""
    return [one for one in entry.get("anyOf", [entry]) if one.get("type") != "null"]


def _kind(entry: dict[str, Any], parts: dict[str, Any]) -> str:
    words = {"number": "number", "integer": "whole number", "string": "text", "boolean": "true or false", "object": "table"}
    said = []
    for one in _forms(entry):
        if "enum" in one or "const" in one:
            said.append("word")
        elif one.get("type") == "array":
            said.append(f"list of {_kind(one['items'], parts)}" if "items" in one else "list")
        elif "$ref" in one:
            said.append(_kind(parts.get(one["$ref"].rpartition("/")[2], {}), parts))
        else:
            said.append(words.get(one.get("type", ""), "value"))
    return " or ".join(dict.fromkeys(word for word in said if word != "whole number" or "number" not in said))


def _default(name: str, entry: dict[str, Any], part: dict[str, Any]) -> str:
    if name in part.get("required", ()):
        return "required"
    default = entry.get("default")
    if default is None or default in ("", [], {}):
        return ""
    return str(default).lower() if isinstance(default, bool) else f"{default:g}" if isinstance(default, float) else str(default)


def _allowed(entry: dict[str, Any], parts: dict[str, Any]) -> str:
    said = []
    for form in _forms(entry):
        one = parts.get(form["$ref"].rpartition("/")[2], {}) if "$ref" in form else form
        if "enum" in one:
            said.append(", ".join(map(str, one["enum"])))
        said.append(" and ".join(text.format(one[bound]) for bound, text in _BOUNDS.items() if bound in one))
        if "minItems" in one:
            said.append(f"at least {one['minItems']}")
    return "; ".join(filter(None, said))
