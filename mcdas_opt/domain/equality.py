"""Records that hold arrays, compared."""

from __future__ import annotations

from dataclasses import fields
from operator import attrgetter
from typing import Any

import numpy as np


class EqualByValue:
    """A dataclass (eq=False) that is equal to another of its kind where every field is, arrays number by number; not to be hashed."""

    __slots__ = ()
    __hash__ = None  # type: ignore[assignment]

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if type(other) is not type(self):
            return NotImplemented
        compared = attrgetter(*(field.name for field in fields(self) if field.compare))  # type: ignore[arg-type]
        return all(map(_equal, compared(self), compared(other)))


def _equal(one: Any, other: Any) -> bool:
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return bool(np.array_equal(one, other))
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(_equal, one, other))
    return bool(one == other)
