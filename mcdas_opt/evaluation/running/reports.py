"""What a task tells its parent process while it is worked on, and hears from it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

_parent: Callable[[Any], Any] | None = None


def tell_by(told: Callable[[Any], Any]) -> None:
    """For the child process: `told` carries a report to the parent and gives what that says."""
    global _parent
    _parent = told


def report(value: Any) -> Any:
    """What the parent says to `value`; None where there is none, or it does not listen."""
    return None if _parent is None else _parent(value)
