"""Where Python meets C: what a compiled library holds, how its functions are called, and where it comes from.

A `Library` names its C texts (`native/c`) and gives each function a signature, one letter for each argument: `i` and `l` whole numbers
(int, 64 bits), `d` a number, `a` an array that is read (None: a null pointer), `w` one that is written, `p` an address that the caller
keeps (`address`); what it returns stands behind `>`. Arrays must be contiguous. Nobody else knows how a library came to be.
"""

from __future__ import annotations

import ctypes
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from os import environ
from typing import Any

from mcdas_opt.native.build import text_of
from mcdas_opt.native.compile_cache import SWITCH, NoLibraryError, cache_folder, load, say_once

_in_place: Any = (ctypes.c_char * 0).from_buffer  # of something that can be written into: handed over as its address


class _Read:
    """An array, or None."""

    @staticmethod
    def from_param(array: Any) -> Any:
        try:
            return _in_place(array)
        except TypeError:
            if array is None:
                return None
            if not array.flags.c_contiguous:
                raise
            return ctypes.c_void_p(array.__array_interface__["data"][0])  # read-only


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
_FIELDS: dict[str, Any] = {"whole": ctypes.c_longlong, "double": ctypes.c_double}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Library:
    """C texts that are compiled with the same flags into one library, and what may be called of them."""

    texts: tuple[str, ...]
    builds: tuple[str, ...]  # compiler flags, best first; the last are portable
    functions: Mapping[str, str]  # signatures
    _loaded: dict[str, ctypes.CDLL | None] = field(default_factory=dict, init=False, repr=False)

    def loaded(self, before: str = "") -> ctypes.CDLL | None:
        """The library, with `before` in front of its texts, built on first use; None where it cannot be had, or must not be used."""
        if environ.get(SWITCH) == "0":
            return None
        try:
            return self._loaded[before]
        except KeyError:
            return self._first(before)

    def _first(self, before: str) -> ctypes.CDLL | None:
        try:
            found: ctypes.CDLL | None = self.load(before)
        except NoLibraryError as error:
            from mcdas_opt.native.form import warn_interpreted

            found = None
            warn_interpreted(str(error))
        self._loaded[before] = found
        return found

    def load(self, before: str = "", builds: Sequence[str] = (), announce: Callable[[str], None] = say_once) -> ctypes.CDLL:
        """The same, asked for anew, with other `builds`; raises `NoLibraryError`, which says why there is none."""
        sources = tuple(before + text_of(name) for name in self.texts)
        found = load(sources, builds or self.builds, folder=cache_folder(), announce=announce)
        for name, signature in self.functions.items():
            function, (given, _, returned) = getattr(found, name), signature.partition(">")
            function.argtypes, function.restype = [ARGUMENTS[letter] for letter in given], ARGUMENTS.get(returned)
        return found

    def forget(self) -> None:
        """The next call asks for it anew."""
        self._loaded.clear()


def wanted() -> bool:
    """Whether compiled forms may be used: MCDAS_OPT_COMPILE=0 forbids them."""
    return environ.get(SWITCH) != "0"


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
