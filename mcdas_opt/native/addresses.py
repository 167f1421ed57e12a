"""Where an array lies, for a call of a compiled library."""

from __future__ import annotations

from ctypes import addressof, c_char
from typing import Any

_first_byte: Any = c_char.from_buffer


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
