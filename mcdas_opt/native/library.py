"""The native library: where it lies, whether it belongs to these texts, and its functions at this processor's level."""

from __future__ import annotations

import ctypes
from os import environ
from pathlib import Path

from mcdas_opt.native.binding import ARGUMENTS, interruptible
from mcdas_opt.native.build import LIBRARY, digest
from mcdas_opt.native.form import SWITCH, wanted, warn_interpreted

_FAMILY = {"mcdas_family_speeds": "p", "mcdas_family_score": "pw", "mcdas_family_best": "palwww", "mcdas_family_states": "pllw"}

FUNCTIONS = {
    "mcdas_digest": ">l",
    "mcdas_level": ">i",
    "mcdas_separations": "lll" + 10 * "a" + "w",
    "mcdas_polygon_separations": "lll" + 7 * "a" + "w",
    "mcdas_grown": "llaaw",
    "mcdas_in_reach": "llaaaaaw",
    "mcdas_time_gaps": "llaaadaddw",
    "mcdas_missing_headway": "lllaaaaaaaww",
    "mcdas_cost_rate": "llaaalaaaw",
    "mcdas_speeds_along": "lalalaaww",
    "mcdas_ends": "llaaalaaalaaaaww",
    "mcdas_drive": "lpadalaww",
    "mcdas_follow": "ldalaaaaww",
    "mcdas_at": "pdddp",
    "mcdas_correct": "pdddp",
    "mcdas_cost": "pdddpddd>d",
    "mcdas_fixes": "laaddlplpp",
    "mcdas_to_road": "laadlplpww>l",
    "mcdas_to_plane": "laaalplpwww>l",
    "mcdas_conservative_accept": "alaaallplpalww>i",
    "mcdas_sharpest": "a" + 8 * "d" + ">d",
    **_FAMILY,
    **{f"{name}_any_length": signature for name, signature in _FAMILY.items()},
    "mcdas_escape_sound": "piaapww",
    "mcdas_escape_answer": "pppldpplp>l",
    "mcdas_size": "ll>l",
    "mcdas_prepare": "pllalaal",
    "mcdas_cold": "ppppdd>i",
    "mcdas_warm": "pppppppdd>i",
    "mcdas_newton": "pidddp",
    "mcdas_measure": "ppppppp",
    "mcdas_loop": "piippppppp>i",
}


PORTABLE = "portable"
_LEVELS = {4: ("_v4", "_v3", ""), 3: ("_v3", ""), 1: ("",)}
_loaded: dict[bool, ctypes.CDLL | None] = {}
_held: list[ctypes.CDLL | None] = []


class NoLibraryError(Exception):
    """There is no native library for what is asked; says why."""


class Held:
    """`with Held():` the form that the environment asks for now stays: to ask anew at each call took a twentieth of a cycle. What was held
    inside ends with it, though an interrupt had kept that from ending."""

    def __enter__(self) -> None:
        self._before = len(_held)
        _held.append(library())

    def __exit__(self, *raised: object) -> None:
        del _held[self._before :]


def library() -> ctypes.CDLL | None:
    """The library, loaded on first use; None where it cannot be had, which is said once, or must not be used."""
    if _held:
        return _held[-1]
    form = environ.get(SWITCH)
    if form == "0":
        return None
    try:
        return _loaded[form == PORTABLE]
    except KeyError:
        return _first(form == PORTABLE)


def _first(portable: bool) -> ctypes.CDLL | None:
    try:
        found: ctypes.CDLL | None = load()
    except NoLibraryError as error:
        found = None
        warn_interpreted(str(error))
    _loaded[portable] = found
    return found


def load(*, portable: bool = False) -> ctypes.CDLL:
    """The same, asked for anew; raises `NoLibraryError`, which says why there is none. `portable`: as with MCDAS_OPT_COMPILE=portable."""
    if not LIBRARY.is_file():
        raise NoLibraryError("the native library was not built: there was no C compiler")
    try:
        if not _is_whole(LIBRARY):
            raise OSError("it is cut off")
        found = ctypes.CDLL(str(LIBRARY))
        found.mcdas_digest.restype = ctypes.c_longlong
        if found.mcdas_digest() != digest():
            raise NoLibraryError(f"{LIBRARY} is of another version")
        levels = ("",) if portable or environ.get(SWITCH) == PORTABLE else _LEVELS[found.mcdas_level()]
        for name, signature in FUNCTIONS.items():
            given, _, returned = signature.partition(">")
            function = next(found[name + level] for level in levels if hasattr(found, name + level))
            function.argtypes, function.restype = [ARGUMENTS[letter] for letter in given], ARGUMENTS.get(returned)
            setattr(found, name, interruptible(function))
    except (OSError, AttributeError, StopIteration) as error:
        raise NoLibraryError(f"{LIBRARY} cannot be used: {error}") from None
    return found


def interpreted_because() -> str:
    """Why the interpreted form runs; empty where the compiled one does."""
    if not wanted():
        return f"{SWITCH}=0 asks for it"
    try:
        load()
    except NoLibraryError as error:
        return str(error)
    return ""


def _is_whole(path: Path) -> bool:
    """Of an ELF file, whether its section table is there, which stands last: what was cut off would end the process while it loads."""
    with path.open("rb") as file:
        head = file.read(64)
    if head[:5] != b"\x7fELF\x02" or len(head) < 64:
        return True
    table, size, count = int.from_bytes(head[40:48], "little"), int.from_bytes(head[58:60], "little"), int.from_bytes(head[60:62], "little")
    return path.stat().st_size >= table + size * count


def level_of(library: ctypes.CDLL) -> str:
    """How the names of functions end that this processor runs best."""
    return _LEVELS[library.mcdas_level()][0]


def forget() -> None:
    """The next call asks for it anew."""
    _loaded.clear()
