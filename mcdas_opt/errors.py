"""What can go wrong, in two kinds: the input is bad (exit 2), or we are (exit 1). A refused plan is neither: it is a value."""

from __future__ import annotations

import difflib
import errno
import math
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager

_LONGEST_SHOWN = 200  # characters of a value in a message
_FULL_TURN_RAD = 2.0 * math.pi + 1e-9


class McdasError(Exception):
    """Root of everything this package raises on purpose."""


class ParameterError(McdasError, ValueError):
    """A value breaks a rule: names what, the value, the rule and the unit; `of` is whose value it is, where there are several."""

    def __init__(self, name: str, value: object, rule: str, unit: str = "", of: str = "") -> None:
        self.name, self.value, self.rule, self.unit, self.of = name, value, rule, unit, of
        owner = f"{of}: " if of else ""
        shown = f"{_shown(value)} {unit}".rstrip()
        super().__init__(printable(f"{owner}{name} = {shown}: {rule}"))

    def __reduce__(self) -> tuple[type, tuple[object, ...]]:
        return type(self), (self.name, self.value, self.rule, self.unit, self.of)


class InputError(McdasError, ValueError):
    """A file (or a document) is unusable: names the file, the key, the value and the rule."""

    def __init__(self, file: object, key: str, value: object, rule: str) -> None:
        self.file, self.key, self.value, self.rule = str(file), key, value, rule
        where = f"{self.file}: {key}" if key else self.file
        shown = "" if value is None else f" = {_shown(value)}"
        super().__init__(printable(f"{where}{shown}: {rule}"))

    def __reduce__(self) -> tuple[type, tuple[object, ...]]:
        return type(self), (self.file, self.key, self.value, self.rule)


class SharedPlannerError(McdasError, RuntimeError):
    """One planner is asked from two threads at the same time."""

    def __init__(self) -> None:
        super().__init__("a planner remembers what it did and belongs to one thread: another thread is in it; build a Planner for each")

    def __reduce__(self) -> tuple[type, tuple[object, ...]]:
        return type(self), ()


class PlannerFaultError(McdasError, RuntimeError):
    """A method without a fallback ladder raised what it must not: names the planner, the time and what it raised."""

    def __init__(self, planner: str, time_s: float, fault: str) -> None:
        self.planner, self.time_s, self.fault = planner, time_s, fault
        super().__init__(printable(f"planner {planner!r} at t = {time_s:.2f} s: raised {fault}"))

    def __reduce__(self) -> tuple[type, tuple[object, ...]]:
        return type(self), (self.planner, self.time_s, self.fault)


class PlannerFaultWarning(RuntimeWarning):
    """A method raised what it must not, and the fallback ladder has answered; or what a planner remembered could not be planned with."""


class MeasurementWarning(UserWarning):
    """By what was measured nobody can be tracked: the clock, the host's place or a sensor is wrong. What it watches is not covered.

    Where a radar's range rates alone are wrong, cars are tracked by their places, and it goes on watching.
    """


@contextmanager
def blaming(file: object, under: str = "") -> Iterator[None]:
    """Turns a `ParameterError` into an `InputError` that names the file, and the key below `under`."""
    try:
        yield
    except ParameterError as error:
        raise InputError(file, f"{under}{error.name}", error.value, error.rule) from None


def check_file_name(name: object) -> None:
    """Raises `InputError` for a name that no file can have on this system, which knows how long one may be."""
    text = str(name)
    if "\0" in text:
        rule = "no file has a NUL in its name"
    else:
        try:
            os.lstat(text)
            return
        except UnicodeEncodeError:
            rule = "no file has a name with characters that the system cannot encode"
        except OSError as error:
            if error.errno != errno.ENAMETOOLONG:
                return
            rule = "is longer than a file's name may be"
    raise InputError(text if len(text) <= _LONGEST_SHOWN else f"{text[: _LONGEST_SHOWN - 3]}...", "", None, rule)


@contextmanager
def reading(file: object) -> Iterator[None]:
    """Turns a failure to read the file into an `InputError` that names it."""
    check_file_name(file)
    try:
        yield
    except OSError as error:
        raise InputError(file, "", None, f"cannot be read: {error.strerror}") from None


@contextmanager
def writing(file: object) -> Iterator[None]:
    """Turns a failure to write the file into an `InputError` that names it."""
    check_file_name(file)
    try:
        yield
    except OSError as error:
        raise InputError(file, "", None, f"cannot be written: {error.strerror}") from None


class MissingExtraError(McdasError, ImportError):
    """An optional package is not installed: says which command installs it, and which other one after that if the extra is not enough."""

    def __init__(self, package: str, extra: str, then: str = "") -> None:
        self.package, self.extra, self.then = package, extra, then
        also = f", then {then}" if then else ""
        super().__init__(f"this needs the package {package!r}: pip install 'mcdas-opt[{extra}]'{also}")

    def __reduce__(self) -> tuple[type, tuple[object, ...]]:
        return type(self), (self.package, self.extra, self.then)


@contextmanager
def of_extra(package: str, extra: str, then: str = "") -> Iterator[None]:
    """Turns a failure to import what is imported inside into a `MissingExtraError`."""
    try:
        yield
    except ImportError:
        raise MissingExtraError(package, extra, then) from None


def printable(text: str) -> str:
    """In one line, and nothing in it that a terminal would obey: what cannot be printed is written as Python writes it."""
    return text if text.isprintable() else "".join(one if one.isprintable() else repr(one)[1:-1] for one in text)


def told(error: Exception) -> str:
    """An error's kind and what it says, if it says anything."""
    try:
        return f"{type(error).__name__}: {error}"
    except Exception:
        return type(error).__name__


def _shown(value: object) -> str:
    """The value as Python writes it, cut off where it is long; Python refuses to write an integer of thousands of digits."""
    try:
        text = repr(value)
    except ValueError:
        return f"{type(value).__name__} too large to be written"
    except Exception:  # of somebody else's class, or nested without end
        return f"a {type(value).__name__} that cannot be written"
    return text if len(text) <= _LONGEST_SHOWN else f"{text[: _LONGEST_SHOWN - 3]}..."


def degrees_perhaps(value: object) -> str:
    """What a refused angle is asked; empty where it is less than a full turn."""
    return ": radians, not degrees?" if isinstance(value, (int, float)) and abs(value) > _FULL_TURN_RAD else ""


def nearest(name: str, known: Iterable[str]) -> str:
    """'did you mean' clause for an unknown name, or the list of the known ones when none is near."""
    names = sorted(known)
    near = difflib.get_close_matches(str(name), names, n=1, cutoff=0.5)
    return f"did you mean {near[0]!r}?" if near else "known: " + ", ".join(names)
