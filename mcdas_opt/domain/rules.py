"""Rules that a record's fields must keep: each raises `ParameterError` with name, value, rule and unit."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import fields
from enum import StrEnum
from functools import cache
from operator import attrgetter
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.errors import ParameterError, degrees_perhaps

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Array = NDArray[np.float64]
Rule = Callable[[str, float, str], float]
T = TypeVar("T")
W = TypeVar("W", bound=StrEnum)
FARTHEST_M = 1e9  # along a road: there places are still told apart to 0.1 um
FASTEST_MPS = 1e4  # beyond is no number of traffic; what no car can drive is judged in the situation
_LEAST, _MOST = 1e-9, 1e9  # of a setting that must not be 0
_UNITS = {
    "m": "m",
    "s": "s",
    "kg": "kg",
    "rad": "rad",
    "mps": "m/s",
    "mps2": "m/s^2",
    "mps3": "m/s^3",
    "radps": "rad/s",
    "radps2": "rad/s^2",
    "kgm2": "kg m^2",
    "nprad": "N/rad",
    "hz": "1/s",
    "1pm": "1/m",
}


def unit_of(name: str) -> str:
    """The unit that a field's name ends in: `speed_mps` is in m/s; empty for a number without one."""
    quantity, _, unit = name.rpartition("_")
    return f"1/{unit}" if quantity.endswith("_per") else _UNITS.get(unit, "")


def require(record: object, rule: Rule, *names: str, of: str = "") -> None:
    """Every named field of a record keeps the rule; `of` is the key under which the record stands."""
    for name in names:
        rule(f"{of}.{name}" if of else name, attrgetter(name)(record), unit_of(name))


def require_every(record: DataclassInstance, rule: Rule) -> None:
    """Every real number among a record's fields keeps the rule; every whole number is at least 0."""
    for field in fields(record):
        if field.type == "float":
            require(record, rule, field.name)
        elif field.type == "int":
            whole(field.name, attrgetter(field.name)(record))


def as_floats(record: object, names: tuple[str, ...]) -> None:
    """Makes every named field (two or more) of a frozen record a finite float."""
    for name, value in zip(names, _reader(names)(record), strict=True):
        if type(value) is not float or not math.isfinite(value):
            object.__setattr__(record, name, finite(name, value, unit_of(name)))


@cache
def _reader(names: tuple[str, ...]) -> Callable[[object], tuple[Any, ...]]:
    return attrgetter(*names)


def finite(name: str, value: float, unit: str = "") -> float:
    """`value` as a float; it must be a finite number."""
    if type(value) is float and math.isfinite(value):
        return value
    if not _is_number(value):
        raise ParameterError(name, value, "must be a number", unit)
    try:
        real = float(value)
    except OverflowError:  # of an integer of hundreds of digits
        raise ParameterError(name, value, "must be finite", unit) from None
    if not math.isfinite(real):
        raise ParameterError(name, real, "must be finite", unit)
    return real


def require_numbers(record: object, names: tuple[str, ...]) -> None:
    """Every named field (two or more) of a record is a number; it may be infinite, as an integer of hundreds of digits is, or none.

    Numbers of numpy and other subclasses become plain ones: single precision overflows beside them, and its rounding would go on.
    """
    for name, value in zip(names, _reader(names)(record), strict=True):
        if type(value) is not float:
            if not _is_number(value):
                raise ParameterError(name, value, "must be a number", unit_of(name))
            try:
                plain = float(value)
            except OverflowError:
                plain = math.inf if value > 0 else -math.inf
            if type(value) is not int or math.isinf(plain):
                object.__setattr__(record, name, plain)


def _is_number(value: object) -> bool:
    """A truth value is none, nor is a stretch of time, which numpy takes for a whole number."""
    return isinstance(value, (int, float, np.floating, np.integer)) and not isinstance(value, (bool, np.timedelta64))


def is_text(text: str) -> bool:
    """Whether it can be written and drawn."""
    return text.isascii() or not any("\ud800" <= letter <= "\udfff" for letter in text)


def require_type(name: str, value: object, *kinds: type) -> None:
    """`value` is a record of one of these types."""
    if not isinstance(value, kinds):
        raise ParameterError(name, value, "must be a " + " or a ".join(kind.__name__ for kind in kinds))


def require_type_if_given(name: str, value: object, *kinds: type) -> None:
    """The same of what may be left out."""
    if value is not None:
        require_type(name, value, *kinds)


def not_a_class(name: str, value: object) -> None:
    """`value` is an object; the class of one was forgotten to be called."""
    if isinstance(value, type):
        raise ParameterError(name, value, f"is a class: give {value.__name__}(...)")


def all_of(name: str, value: Iterable[T] | None, kind: type[T]) -> tuple[T, ...]:
    """`value`, which is a list or a tuple of records of that type, as a tuple: itself where it is one."""
    if isinstance(value, (list, tuple)):
        for k, one in enumerate(value):
            if not isinstance(one, kind):
                raise ParameterError(f"{name}[{k}]", one, f"must be a {kind.__name__}")
        return tuple(value)
    raise ParameterError(name, value, f"must be a list of {kind.__name__}")


def true_or_false(name: str, value: object) -> bool:
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    raise ParameterError(name, value, "must be true or false")


def word(name: str, value: object, kind: type[W]) -> W:
    """`value` as one of a closed set of words; its text will do."""
    try:
        return kind(str(value))
    except ValueError:
        raise ParameterError(name, value, "must be one of " + ", ".join(kind)) from None


def all_finite(values: Array) -> bool:
    """Whether no number of these is infinite or none: at once where the sum of their squares is finite."""
    return math.isfinite(np.vdot(values, values)) or bool(np.isfinite(values).all())


def integer(name: str, value: int) -> int:
    if not _is_number(value) or isinstance(value, (float, np.floating)):
        raise ParameterError(name, value, "must be a whole number")
    return int(value)


def whole(name: str, value: int, least: int = 0) -> int:
    """`value` as an integer of at least `least`."""
    if integer(name, value) < least:
        raise ParameterError(name, value, f"must be at least {least}")
    return int(value)


def positive(name: str, value: float, unit: str = "") -> float:
    if finite(name, value, unit) <= 0.0:
        raise ParameterError(name, value, "must be greater than 0", unit)
    return float(value)


def measurable(name: str, value: float, unit: str = "") -> float:
    """Positive, and neither next to nothing nor beyond measure: its square can be divided by."""
    if not _LEAST <= positive(name, value, unit) <= _MOST:
        raise ParameterError(name, value, f"must lie in [{_LEAST:g}, {_MOST:g}]", unit)
    return float(value)


def negative(name: str, value: float, unit: str = "") -> float:
    if finite(name, value, unit) >= 0.0:
        raise ParameterError(name, value, "must be less than 0", unit)
    return float(value)


def non_negative(name: str, value: float, unit: str = "") -> float:
    if finite(name, value, unit) < 0.0:
        raise ParameterError(name, value, "must be at least 0", unit)
    return float(value)


def bounded(name: str, value: float, unit: str = "") -> float:
    """At least 0, and not beyond measure."""
    if non_negative(name, value, unit) > _MOST:
        raise ParameterError(name, value, f"must be at most {_MOST:g}", unit)
    return float(value)


def within(name: str, value: float, low: float, high: float, unit: str = "") -> float:
    if not low <= finite(name, value, unit) <= high:
        asked = degrees_perhaps(value) if unit == "rad" else ""
        raise ParameterError(name, value, f"must lie in [{low:g}, {high:g}]{asked}", unit)
    return float(value)


def angle(name: str, value: float, turns: int = 1) -> float:
    """An angle [rad] of at most so many full turns: of more, it is in degrees."""
    most = 2.0 * math.pi * turns + 1e-9
    return within(name, value, -most, most, "rad")


def at_most(name: str, value: float, other: str, bound: float) -> None:
    """Two fields of a record that are a pair: the one must not exceed the other."""
    if value > bound:
        raise ParameterError(name, value, f"must be at most {other} = {bound:g}", unit_of(name))


def floats(name: str, value: Any, rule: str, unit: str = "") -> Array:
    """`value` as a new array of floats, of any shape; an entry may be no number. Neither texts nor complex numbers are floats."""
    try:
        given = np.asarray(value)
        if given.dtype.kind not in "USVcmM":
            return given.astype(np.float64)
    except (TypeError, ValueError, OverflowError):
        pass
    raise ParameterError(name, value, rule, unit)


def vector(name: str, value: Any, unit: str = "", length: int | None = None) -> Array:
    """`value` as a read-only float vector; every entry finite."""
    array = floats(name, value, "must be a list of numbers", unit)
    if array.ndim != 1 or (length is not None and array.size != length):
        wanted = "a list of numbers" if length is None else f"a list of {length} numbers"
        raise ParameterError(name, f"shape {array.shape}", f"must be {wanted}", unit)
    if not np.all(np.isfinite(array)):
        k = int(np.flatnonzero(~np.isfinite(array))[0])
        raise ParameterError(f"{name}[{k}]", float(array[k]), "must be finite", unit)
    array.setflags(write=False)
    return array


def covariance(name: str, value: Any, size: int, unit: str = "") -> Array:
    """`value` as a read-only symmetric positive semi-definite matrix."""
    array = floats(name, value, f"must be a {size} x {size} matrix", unit)
    if array.shape == (size, size) and _plainly_definite(array.tolist()):
        array.setflags(write=False)
        return array
    if array.shape != (size, size):
        raise ParameterError(name, f"shape {array.shape}", f"must be a {size} x {size} matrix", unit)
    if not np.all(np.isfinite(array)):
        raise ParameterError(name, "non-finite entry", "must be finite", unit)
    if np.any(np.diag(array) < 0.0):
        raise ParameterError(name, float(np.diag(array).min()), "must have no negative variance", unit)
    scale = max(1.0, float(np.abs(array).max()))
    if np.abs(array - array.T).max() > 1e-6 * scale or np.linalg.eigvalsh(array).min() < -1e-6 * scale:
        raise ParameterError(name, "matrix", "must be symmetric and positive semi-definite", unit)
    array.setflags(write=False)
    return array


def _plainly_definite(rows: list[list[float]]) -> bool:
    """Whether a matrix is symmetric to the bit, with Cholesky's pivots well above rounding, but for rows of zeros (what is known exactly):
    then no eigenvalues need be asked for."""
    lower: list[list[float]] = []
    for i, row in enumerate(rows):
        mine: list[float] = []
        pivot = row[i]
        for j, other in enumerate(lower):
            if row[j] != rows[j][i]:
                return False
            left = row[j]
            for k in range(j):
                left -= mine[k] * other[k]
            left /= other[j]
            pivot -= left * left
            mine.append(left)
        is_exact = not any(row)
        if not is_exact and not 1e-9 * row[i] < pivot < math.inf:  # nor what is no number
            return False
        mine.append(1.0 if is_exact else math.sqrt(pivot))
        lower.append(mine)
    return True
