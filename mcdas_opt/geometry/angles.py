"""Angles on the circle."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.rules import Array


def wrapped(angle: Array | float) -> Array:
    """The angle [rad] brought into [-pi, pi)."""
    return np.asarray((np.asarray(angle) + np.pi) % (2.0 * np.pi) - np.pi)
