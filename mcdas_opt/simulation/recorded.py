"""Recorded neighbours: a file's samples, played back."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mcdas_opt.domain.prediction import BodyMotion
from mcdas_opt.domain.rules import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordedMotion:
    """Plays samples (n, 5) of t, s, d, heading, speed: linear in time in between.

    As in a script, speed is speed in the road's frame: ds/dt = speed cos(heading). After the last sample the body goes on along the
    road at the last speed, heading 0. Before t = 0 (and before a first sample that is later) it has come along the road at the speed
    of that moment, as everybody has before a scene begins.
    """

    samples: Array

    def __call__(self, t_s: Any) -> BodyMotion:
        t = np.asarray(t_s, dtype=np.float64)
        first, last = max(0.0, float(self.samples[0, 0])), float(self.samples[-1, 0])
        inside = np.clip(t, first, max(last, first))
        s, d, heading, speed = (np.interp(inside, self.samples[:, 0], self.samples[:, k]) for k in (1, 2, 3, 4))
        beyond = t > last
        heading = np.where(beyond, 0.0, heading)
        along = speed * np.cos(heading)
        return BodyMotion(
            s_m=s + (t - inside) * np.where(beyond, speed, along),
            d_m=d,
            heading_rad=heading,
            speed_s_mps=along,
            speed_d_mps=np.where(t < first, 0.0, speed * np.sin(heading)),
        )
