"""A scene's document as TOML text."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any


def to_toml(document: Mapping[str, Any]) -> str:
    """A document of plain values, tables and lists of tables, to any depth, as TOML that reads back the same; None is left out."""
    return "\n\n".join(_tables(document, "")).strip() + "\n"


def _tables(table: Mapping[str, Any], path: str) -> list[str]:
    plain = [f"{key} = {_value(value)}" for key, value in table.items() if not _is_table(value) and value is not None]
    parts = ["\n".join(plain)] if plain else []
    for key, value in table.items():
        inner = f"{path}{key}"
        if isinstance(value, Mapping):
            parts += _headed(f"[{inner}]", _tables(value, f"{inner}."))
        elif _is_table(value):
            for row in value:
                parts += _headed(f"[[{inner}]]", _tables(row, f"{inner}."))
    return parts


def _headed(heading: str, parts: list[str]) -> list[str]:
    """The heading stands on top of its own plain values, if any."""
    if parts and not parts[0].startswith("["):
        return [f"{heading}\n{parts[0]}", *parts[1:]]
    return [heading, *parts]


def _is_table(value: Any) -> bool:
    rows = isinstance(value, Sequence) and not isinstance(value, str) and len(value) > 0 and all(isinstance(v, Mapping) for v in value)
    return isinstance(value, Mapping) or rows


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and not math.isfinite(value):
        return "nan" if math.isnan(value) else "inf" if value > 0.0 else "-inf"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(each) for each in value) + "]"
    return json.dumps(str(value), ensure_ascii=False).replace("\x7f", "\\u007f")
