"""The paper's sigmoid (eq 20-23), corrected: renormalised, and bent around the front vehicle by its offset. Left positive."""

from __future__ import annotations

import math
from typing import Any

PEAK_OF_FIRST_DERIVATIVE = 0.25  # max |S'| / |a|
PEAK_OF_SECOND_DERIVATIVE = 1.0 / (6.0 * math.sqrt(3.0))  # max |S''| / a^2
PEAK_OF_THIRD_DERIVATIVE = 1.0 / 8.0  # max |S'''| / |a|^3


def sigmoid(x: Any, a: Any, b: Any, m: Any) -> Any:
    """S(x) = 1 / (1 + b exp(a x)), the shape of eq 22 with a < 0; written with tanh so that it cannot overflow."""
    return 0.5 * (1.0 - m.tanh(0.5 * (a * x + m.log(b))))


def renormalised(x: Any, a: Any, b: Any, m: Any) -> Any:
    """(S(x) - S(0)) / (S(X) - S(0)) with X = -2 ln(b) / a, where S(X) = 1 - S(0): exactly 0 at x = 0 and 1 at x = X."""
    return renormalised_shape(sigmoid(x, a, b, m), b)


def renormalised_shape(shape: Any, b: Any) -> Any:
    """The same of S(x)."""
    return (shape - 1.0 / (1.0 + b)) * (b + 1.0) / (b - 1.0)


def hump(x: Any, width: Any, m: Any) -> Any:
    """exp(-(x / width)^2): 1 beside the front vehicle, fading ahead of it and behind."""
    return m.exp(-((x / width) ** 2))
