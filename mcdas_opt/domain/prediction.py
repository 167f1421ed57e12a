"""Where the neighbours are believed to go: one closed-form motion per body, evaluated at any time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from mcdas_opt.domain.rules import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyMotion:
    """Body centres and headings (relative to the road) of one neighbour over a vector of times; all of one shape."""

    s_m: Array
    d_m: Array
    heading_rad: Array
    speed_s_mps: Array
    speed_d_mps: Array


class PredictedBody(Protocol):
    """A neighbour's predicted motion. `margin_*` is the inflation for the optimiser [m]; the judge takes the bare body."""

    @property
    def id(self) -> str: ...
    @property
    def length_m(self) -> float: ...
    @property
    def width_m(self) -> float: ...
    def at(self, t_s: Any) -> BodyMotion: ...
    def margin_along_m(self, t_s: Any) -> Array: ...
    def margin_across_m(self, t_s: Any) -> Array: ...


@dataclass(frozen=True, slots=True, kw_only=True)
class CruisingBody:
    """Constant speed along the road; lateral speed fades with `lateral_fade_s` (drivers settle in a lane).

    Time zero is the situation's time. Margins: `sigmas` standard deviations of the present estimate, growing with the speed's
    uncertainty over the first `growth_s` only, capped.
    """

    id: str
    length_m: float
    width_m: float
    s_m: float
    d_m: float
    speed_s_mps: float
    speed_d_mps: float
    covariance: Array
    lateral_fade_s: float = 1.0
    sigmas: float = 2.5
    growth_s: float = 1.0
    cap_along_m: float = 3.0
    cap_across_m: float = 0.5

    def at(self, t_s: Any) -> BodyMotion:
        t = np.asarray(t_s, dtype=np.float64)
        fade = np.exp(-t / self.lateral_fade_s)
        speed_d = self.speed_d_mps * fade
        speed_s = np.full_like(t, self.speed_s_mps)
        return BodyMotion(
            s_m=self.s_m + self.speed_s_mps * t,
            d_m=self.d_m + self.speed_d_mps * self.lateral_fade_s * (1.0 - fade),
            heading_rad=np.arctan(speed_d / np.copysign(np.maximum(np.abs(speed_s), 1.0), speed_s)),
            speed_s_mps=speed_s,
            speed_d_mps=speed_d,
        )

    def _margin(self, t_s: Any, position: int, cap: float) -> Array:
        t = np.minimum(np.asarray(t_s, dtype=np.float64), self.growth_s)
        p = self.covariance
        variance = p[position, position] + 2.0 * t * p[position, position + 1] + t**2 * p[position + 1, position + 1]
        return np.asarray(np.minimum(self.sigmas * np.sqrt(np.maximum(variance, 0.0)), cap), dtype=np.float64)

    def margin_along_m(self, t_s: Any) -> Array:
        return self._margin(t_s, 0, self.cap_along_m)

    def margin_across_m(self, t_s: Any) -> Array:
        return self._margin(t_s, 2, self.cap_across_m)


@dataclass(frozen=True, slots=True, kw_only=True)
class KnownBody:
    """A body whose motion is given as a function of time (a scene's script): no margins."""

    id: str
    length_m: float
    width_m: float
    motion: Callable[[Array], BodyMotion]

    def at(self, t_s: Any) -> BodyMotion:
        return self.motion(np.asarray(t_s, dtype=np.float64))

    def margin_along_m(self, t_s: Any) -> Array:
        return np.zeros_like(np.asarray(t_s, dtype=np.float64))

    margin_across_m = margin_along_m


@dataclass(frozen=True, slots=True, kw_only=True)
class Prediction:
    """A named hypothesis about every neighbour. Times are counted from the situation's time."""

    name: str
    bodies: tuple[PredictedBody, ...] = ()
