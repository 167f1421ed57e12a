"""Old names: still understood, and said once."""

from __future__ import annotations

import warnings
from typing import TypeVar

from mcdas_opt.errors import ParameterError

T = TypeVar("T")


def renamed(of: str, old: str, old_value: T | None, new: str, new_value: T | None) -> T | None:
    """The value of an argument that is now called `new`; its old name still works, with a warning. Raises `ParameterError` for both."""
    if old_value is None:
        return new_value
    if new_value is not None:
        raise ParameterError(old, old_value, f"is the old name of {new}, which is given too")
    warnings.warn(f"{of}({old}=...) is now {of}({new}=...)", DeprecationWarning, stacklevel=3)
    return old_value
