"""Whether a record's fields hold what their annotations say."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields
from enum import StrEnum
from functools import cache, partial
from operator import attrgetter
from types import NoneType, UnionType
from typing import TYPE_CHECKING, Any, Protocol, Union, get_args, get_origin, get_type_hints

import numpy as np

from mcdas_opt.domain.rules import finite, integer, require_type, true_or_false, unit_of, word
from mcdas_opt.errors import ParameterError

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Check = Callable[[str, Any], object]


def require_types(record: DataclassInstance) -> None:
    """Every field that the constructor takes holds what is declared: a finite number, a whole number, a truth value, a text, a word of a
    closed set (its text will do), a record, a tuple of these (a list will do). Arrays, protocols and `object` are left to other rules.

    Raises `ParameterError`; of a tuple it names the place.
    """
    for name, read, sound, check in _checks(type(record)):
        value = read(record)
        if type(value) not in sound:
            check(name, value)


@cache
def _checks(kind: type[DataclassInstance]) -> tuple[tuple[str, Callable[[object], Any], frozenset[type], Check], ...]:
    """Of each field its name, how to read it, the types whose every value will do, and what to ask of a value of any other."""
    hints = get_type_hints(kind)
    found = [(field.name, hints[field.name], _check(hints[field.name], unit_of(field.name))) for field in fields(kind) if field.init]
    return tuple((name, attrgetter(name), _sound(hint), check) for name, hint, check in found if check is not None)


def _sound(hint: Any) -> frozenset[type]:
    """The types whose every value is one of the declared type. Not `float`: a number has to be finite."""
    parts = get_args(hint) if (get_origin(hint) or hint) in (Union, UnionType) else (hint,)
    return frozenset(part for part in parts if isinstance(part, type) and part is not float)


def _check(hint: Any, unit: str) -> Check | None:
    """None where any value will do."""
    kind, parts = get_origin(hint) or hint, get_args(hint)
    if kind in (Union, UnionType):
        given = [part for part in parts if part is not NoneType]
        check = _check(given[0], unit) if len(given) == 1 else _record(*given)
        return check if check is None or NoneType not in parts else partial(_if_given, check)
    if kind is tuple:
        checks = [_check(part, unit) for part in parts if part is not Ellipsis]
        return partial(_every, checks[0], _sound(parts[0])) if Ellipsis in parts else partial(_each, checks)
    if kind is float:
        return lambda name, value: finite(name, value, unit)
    if kind is int:
        return integer
    if kind is bool:
        return true_or_false
    if not isinstance(kind, type) or kind in (object, np.ndarray) or Protocol in kind.__mro__:
        return None
    return (lambda name, value: word(name, value, kind)) if issubclass(kind, StrEnum) else _record(kind)


def _record(*kinds: type) -> Check:
    return lambda name, value: require_type(name, value, *kinds)


def _if_given(check: Check, name: str, value: Any) -> None:
    if value is not None:
        check(name, value)


def _every(check: Check | None, sound: frozenset[type], name: str, value: Any) -> None:
    _listed(name, value)
    if check is not None and not sound.issuperset(map(type, value)):
        for k, one in enumerate(value):
            check(f"{name}[{k}]", one)


def _each(checks: Sequence[Check | None], name: str, value: Any) -> None:
    if len(_listed(name, value)) != len(checks):
        raise ParameterError(name, value, f"must be a list of {len(checks)}")
    for k, (check, one) in enumerate(zip(checks, value, strict=True)):
        if check is not None:
            check(f"{name}[{k}]", one)


def _listed(name: str, value: Any) -> Sequence[Any]:
    if isinstance(value, (list, tuple)):
        return value
    raise ParameterError(name, value, "must be a list")
