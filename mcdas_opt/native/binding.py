"""How Python and C understand each other: what a function takes, where a struct's fields lie, and numbers as macros.

A function has a signature, one letter for each argument: `i` and `l` whole numbers (int, 64 bits), `d` a number, `a` an array that is read
(None: a null pointer), `w` one that is written, `p` an address that the caller keeps (`address`); what it returns stands behind `>`. Arrays
must be contiguous.
"""

from __future__ import annotations

import ctypes
import re
from collections.abc import Callable, Mapping
from ctypes import addressof, c_char
from functools import cache
from typing import Any

from mcdas_opt.native.build import text_of

_first_byte: Any = c_char.from_buffer
_KEPT = 64
_FIELDS: dict[str, Any] = {"whole": ctypes.c_longlong, "double": ctypes.c_double}


def address(array: Any) -> int:
    """The address of a contiguous numpy array, valid as long as it lives; a tenth of the time of `array.ctypes.data` where it can be
    written into.
    """
    try:
        return addressof(_first_byte(array))
    except (TypeError, ValueError):  # read-only, or empty
        return int(array.__array_interface__["data"][0])


class LastAddress:
    """`address` of an array that is mostly the one of the last call: a read-only one's takes a microsecond to find."""

    def __init__(self) -> None:
        self._known: tuple[Any, int] = None, 0

    def of(self, array: Any) -> int:
        """Keeps the array until the next one comes."""
        known = self._known
        if known[0] is not array:
            known = self._known = array, address(array)
        return known[1]


_in_place: Any = (ctypes.c_char * 0).from_buffer  # of something that can be written into: handed over as its address


_read_only: dict[int, tuple[Any, ctypes.c_void_p]] = {}  # the last arrays that could not be written into, by their id, and where they lie


class _Read:
    """An array, or None."""

    @staticmethod
    def from_param(array: Any) -> Any:
        if array is None:
            return None
        if array.flags.writeable:
            return _in_place(array)
        known = _read_only.get(id(array))
        if known is not None:
            return known[1]
        if not array.flags.c_contiguous:
            raise TypeError("an array that is handed over must be contiguous")
        if len(_read_only) >= _KEPT:
            _read_only.clear()
        there = ctypes.c_void_p(array.__array_interface__["data"][0])
        _read_only[id(array)] = array, there
        return there


class _Written:
    from_param = staticmethod(_in_place)


ARGUMENTS: dict[str, Any] = {
    "i": ctypes.c_int,
    "l": ctypes.c_longlong,
    "d": ctypes.c_double,
    "p": ctypes.c_void_p,
    "a": _Read,
    "w": _Written,
}


def interruptible(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function of C, out of which Ctrl-C comes as itself: whatever is raised while an argument is taken leaves ctypes as an
    `ArgumentError` that only names it.
    """

    def call(*arguments: Any) -> Any:
        try:
            return function(*arguments)
        except ctypes.ArgumentError as error:
            if KeyboardInterrupt.__name__ in str(error):
                raise KeyboardInterrupt from None
            raise

    return call


@cache
def record(text: str, name: str) -> type[ctypes.Structure]:
    """The struct of that name in a C text: its fields are declared there alone. Pointers are addresses (`address`)."""
    found = re.search(rf"typedef struct {{([^{{}}]*)}} {name};", text_of(text))
    if found is None:
        raise LookupError(f"{text} has no struct {name}")
    fields: list[tuple[str, Any]] = []
    for kind, names in re.findall(r"(?:const )?(\w+) ([^;]+);", re.sub(r"/\*.*?\*/", "", found[1], flags=re.DOTALL)):
        for one in map(str.strip, names.split(",")):
            fields.append((one.lstrip("*"), ctypes.c_void_p if one.startswith("*") else _FIELDS.get(kind) or record(text, kind)))
    return type(name, (ctypes.Structure,), {"_fields_": fields})


def defined(numbers: Mapping[str, Any]) -> str:
    """Numbers, and tuples of them, as macros, to stand before a text."""
    return "".join(f"#define {name} {_written(value)}\n" for name, value in numbers.items())


def _written(value: Any) -> str:
    return f"{{{', '.join(map(_written, value))}}}" if isinstance(value, tuple) else repr(value)
