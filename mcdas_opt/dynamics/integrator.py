"""One explicit integrator for every number system."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any


def rk4(f: Callable[[Sequence[Any]], list[Any]], x: Sequence[Any], h: Any) -> list[Any]:
    """One step of length h of the classical Runge-Kutta method (Kutta 1901) for dx/dt = f(x); entries may be arrays."""
    k1 = f(x)
    k2 = f([xi + 0.5 * h * ki for xi, ki in zip(x, k1, strict=True)])
    k3 = f([xi + 0.5 * h * ki for xi, ki in zip(x, k2, strict=True)])
    k4 = f([xi + h * ki for xi, ki in zip(x, k3, strict=True)])
    return [xi + h / 6.0 * (a + 2.0 * b + 2.0 * c + d) for xi, a, b, c, d in zip(x, k1, k2, k3, k4, strict=True)]
