"""Records to JSON documents and back. JSON holds no NaN or Infinity: they become null."""

from __future__ import annotations

import dataclasses
import enum
import math
import types
import typing
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from mcdas_opt.errors import InputError, blaming, nearest

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

SCHEMA_VERSION = 1
T = TypeVar("T", bound="DataclassInstance")


def to_document(value: Any) -> Any:
    """Anything built of records, mappings, sequences, arrays, enums and numbers, as plain JSON values."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: to_document(getattr(value, f.name)) for f in dataclasses.fields(value) if f.repr}
    if isinstance(value, enum.Enum):
        return value.value
    if isinstance(value, np.ndarray):
        return to_document(value.tolist())
    if isinstance(value, Mapping):
        return {str(k): to_document(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [to_document(v) for v in value]
    if isinstance(value, np.generic):
        return to_document(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def from_document(cls: type[T], document: Any, file: object, key: str = "") -> T:
    """The record `cls` from a JSON document; unknown, missing and wrong keys raise `InputError` with `file` and key path."""
    if not isinstance(document, Mapping):
        raise InputError(file, key.removesuffix("."), document, "must be an object")
    hints = typing.get_type_hints(cls)
    written = {f.name: f for f in dataclasses.fields(cls) if f.repr}
    fields = {name: f for name, f in written.items() if f.init}  # the others follow from these
    for name in document:
        if name not in written and not (key == "" and name == "schema_version"):
            raise InputError(file, f"{key}{name}", None, f"unknown key; {nearest(name, fields)}")
    version = document.get("schema_version", SCHEMA_VERSION)
    if key == "" and version != SCHEMA_VERSION:
        raise InputError(file, "schema_version", version, f"must be {SCHEMA_VERSION}: of another version of this package")
    arguments: dict[str, Any] = {}
    for name, field in fields.items():
        if name in document:
            arguments[name] = _value(hints[name], document[name], file, f"{key}{name}")
        elif field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
            raise InputError(file, f"{key}{name}", None, "missing key")
    with blaming(file, key):
        return cls(**arguments)


def _value(hint: Any, value: Any, file: object, key: str) -> Any:
    origin, args = typing.get_origin(hint), typing.get_args(hint)
    if origin in (typing.Union, types.UnionType):
        if value is None and type(None) in args:
            return None
        return _value(next(a for a in args if a is not type(None)), value, file, key)
    if isinstance(hint, type) and dataclasses.is_dataclass(hint):
        return from_document(hint, value, file, key + ".")
    if isinstance(hint, type) and issubclass(hint, enum.Enum):
        try:
            return hint(value)
        except ValueError:
            raise InputError(file, key, value, "must be one of " + ", ".join(str(m.value) for m in hint)) from None
    if origin is tuple and len(args) == 2 and args[1] is Ellipsis:
        if not isinstance(value, list):
            raise InputError(file, key, value, "must be a list")
        return tuple(_value(args[0], v, file, f"{key}[{i}]") for i, v in enumerate(value))
    if hint is bool and not isinstance(value, bool):
        raise InputError(file, key, value, "must be true or false")
    if hint in (float, int) and (isinstance(value, bool) or not isinstance(value, (int, float))):
        raise InputError(file, key, value, "must be a number")
    if hint is str and not isinstance(value, str):
        raise InputError(file, key, value, "must be text")
    return value
