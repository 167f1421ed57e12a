"""The form that every key of a scene is edited in, made from the model that checks scenes: no key is written down twice."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from mcdas_opt.catalogue.data_files import shipped
from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.catalogue.sensors import IDEAL, NONE
from mcdas_opt.domain.rules import unit_of
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.studio.folder import Folder

_KINDS = {"number": "number", "integer": "whole", "boolean": "flag"}


def form(folder: Folder) -> list[dict[str, Any]]:
    """A field for every key: `key, label, unit, kind, about, needed`, and what its kind needs.

    Kinds: number and whole (`low`, `high`), text, word (`words`), flag, pairs (of numbers), table and tables (`fields`).
    """
    document = _schema()
    return _fields(document, document["$defs"], _files(folder), "")


@lru_cache(maxsize=1)
def _schema() -> dict[str, Any]:
    """The same for every page, and what took longest of making one."""
    return Scene.model_json_schema()


def _files(folder: Folder) -> dict[str, list[str]]:
    """Keys whose words are files, and those files."""
    sensors = [IDEAL, NONE, *shipped("sensors")]
    return {"host.vehicle": [*shipped("vehicles"), *folder.vehicles()]} | {f"sensors.{sector.value}": sensors for sector in Sector}


def _fields(part: dict[str, Any], parts: dict[str, Any], files: dict[str, list[str]], within: str) -> list[dict[str, Any]]:
    found = []
    for key, entry in part["properties"].items():
        path, unit = f"{within}.{key}".lstrip("."), unit_of(key)
        label = key.removesuffix("_" + key.rpartition("_")[2]) if unit else key
        field = {
            "key": key,
            "label": label.replace("_", " "),
            "unit": unit,
            "about": entry.get("description", ""),
            "needed": key in part.get("required", ()),
        }
        found.append(field | _kind(entry, parts, files, path))
    return found


def _kind(entry: dict[str, Any], parts: dict[str, Any], files: dict[str, list[str]], path: str) -> dict[str, Any]:
    forms = [one for one in entry.get("anyOf", [entry]) if one.get("type") != "null"]
    if path in files:
        return {"kind": "word", "words": files[path]}
    items = next((one["items"] for one in forms if one.get("type") == "array"), None)
    inner = forms[0] if items is None else items
    if "$ref" in inner:
        held = parts[inner["$ref"].rpartition("/")[2]]
        if "enum" in held:
            return {"kind": "word", "words": held["enum"]}
        return {"kind": "table" if items is None else "tables", "fields": _fields(held, parts, files, path)}
    if items is not None:
        return {"kind": "pairs" if items.get("type") == "array" else "pair"}
    if "enum" in inner:
        return {"kind": "word", "words": inner["enum"]}
    low, high = inner.get("minimum", inner.get("exclusiveMinimum")), inner.get("maximum", inner.get("exclusiveMaximum"))
    return {"kind": _KINDS.get(inner.get("type", ""), "text"), "low": low, "high": high}
