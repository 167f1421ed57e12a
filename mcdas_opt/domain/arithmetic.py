"""What numpy does of an overflow or an underflow, whatever the caller has it do."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

import numpy as np

P = ParamSpec("P")
T = TypeVar("T")


def usual_arithmetic(function: Callable[P, T]) -> Callable[P, T]:
    """The same function, in which numpy does what it does by default. Somebody who looks for a fault of his own sets
    `np.seterr(all="raise")`: a speed that fades to nothing is none."""

    @wraps(function)
    def run(*args: P.args, **kwargs: P.kwargs) -> T:
        with np.errstate(divide="warn", over="warn", under="ignore", invalid="warn"):
            return function(*args, **kwargs)

    return run
