"""From arrays of measured values to one violation of one rule."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.verdict import Violation


def above(name: str, t_s: Array, value: Array, limit: float, allowed: float, unit: str) -> list[Violation]:
    """The worst value where `value` exceeds `allowed` (the limit with its tolerance); empty where none does."""
    worst = int(value.argmax())
    if value[worst] <= allowed:
        return []
    return [Violation(name=name, t_s=float(t_s[worst]), value=float(value[worst]), limit=float(limit), unit=unit)]


def below(name: str, t_s: Array, value: Array, limit: float, allowed: float, unit: str) -> list[Violation]:
    """The worst value where `value` is less than `allowed`; empty where none is."""
    worst = int(value.argmin())
    if value[worst] >= allowed:
        return []
    return [Violation(name=name, t_s=float(t_s[worst]), value=float(value[worst]), limit=float(limit), unit=unit)]


def wrapped(angle: Array) -> Array:
    """An angle [rad] brought into [-pi, pi)."""
    return np.asarray((angle + np.pi) % (2.0 * np.pi) - np.pi)
