"""Where the neighbours are believed to go: one closed-form motion per body, evaluated at any time."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
from operator import attrgetter
from typing import Any, Protocol, TypeGuard

import numpy as np

from mcdas_opt.domain.equality import EqualByValue
from mcdas_opt.domain.rules import Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BodyMotion(EqualByValue):
    """Body centres and headings (relative to the road) of one neighbour over a vector of times; all of one shape."""

    s_m: Array
    d_m: Array
    heading_rad: Array
    speed_s_mps: Array
    speed_d_mps: Array

    def part(self, which: int | slice | Sequence[int]) -> BodyMotion:
        """The motion at one of its times or over some of them; of a motion of several bodies, as rows, these bodies."""
        return BodyMotion(**{name: column[which] for name, column in zip(_MOTION, _columns(self), strict=True)})


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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CruisingBody(EqualByValue):
    """Constant speed along the road, but for an `acceleration_mps2` held until `changing_s`; lateral speed fades with `lateral_fade_s`
    (drivers settle in a lane).

    With a `lateral_swell` q > 0 it swells before it fades, as in a lane change (a logistic curve): the way still to go to the asymptote
    is q times the way already gone, and of the form r(t) = (1 + q) r(0) e / (1 + q e), e = exp(-t / fade). q = 0 is fading alone.

    A driver who looks ahead responds: from `response_s` on it brakes with `braking_mps2` to a standstill, whatever it did until then.

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
    lateral_swell: float = 0.0
    acceleration_mps2: float = 0.0
    changing_s: float = 0.0
    response_s: float = math.inf
    braking_mps2: float = 1.0
    sigmas: float = 2.5
    growth_s: float = 1.0
    cap_along_m: float = 3.0
    cap_across_m: float = 0.5

    def at(self, t_s: Any) -> BodyMotion:
        t = np.asarray(t_s, dtype=np.float64)
        return _cruise(*_beginning(self), t=t, shape=t.shape)

    def _margin(self, t_s: Any, position: int, cap: float) -> Array:
        return grown_by(self.covariance, position, t_s, self.sigmas, self.growth_s, cap)

    def margin_along_m(self, t_s: Any) -> Array:
        return self._margin(t_s, 0, self.cap_along_m)

    def margin_across_m(self, t_s: Any) -> Array:
        return self._margin(t_s, 2, self.cap_across_m)


@dataclass(frozen=True, slots=True, kw_only=True)
class FreeBody:
    """A body that does not follow the road: its motion is that of a line in the plane, its body turned as the motion says.

    Margins as of a `CruisingBody`; `cap_along_m` holds in its own direction at time zero, `cap_across_m` across that, and it may come by
    `unsure_mps` times the growing time nearer than it is seen to, whatever the estimate says. To who is `on_foot` plans keep a distance of
    their own.
    """

    id: str
    length_m: float
    width_m: float
    motion: Callable[[Array], BodyMotion]
    heading_rad: float
    covariance: Array
    unsure_mps: float = 0.0
    on_foot: bool = False
    sigmas: float = 2.5
    growth_s: float = 1.0
    cap_along_m: float = 3.0
    cap_across_m: float = 0.5

    def at(self, t_s: Any) -> BodyMotion:
        return self.motion(np.asarray(t_s, dtype=np.float64))

    def _margin(self, t_s: Any, position: int, along: float, across: float) -> Array:
        cap = self.cap_along_m * abs(along) + self.cap_across_m * abs(across)
        unsure = self.unsure_mps * np.minimum(np.asarray(t_s, dtype=np.float64), self.growth_s)
        return grown_by(self.covariance, position, t_s, self.sigmas, self.growth_s, cap) + unsure

    def margin_along_m(self, t_s: Any) -> Array:
        return self._margin(t_s, 0, math.cos(self.heading_rad), math.sin(self.heading_rad))

    def margin_across_m(self, t_s: Any) -> Array:
        return self._margin(t_s, 2, math.sin(self.heading_rad), math.cos(self.heading_rad))


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
class _OtherMotion:
    """A body of another's name, size and margins."""

    body: PredictedBody

    @property
    def id(self) -> str:
        return self.body.id

    @property
    def length_m(self) -> float:
        return self.body.length_m

    @property
    def width_m(self) -> float:
        return self.body.width_m

    def margin_along_m(self, t_s: Any) -> Array:
        return self.body.margin_along_m(t_s)

    def margin_across_m(self, t_s: Any) -> Array:
        return self.body.margin_across_m(t_s)


@dataclass(frozen=True, slots=True, kw_only=True)
class _MovedBody(_OtherMotion):
    """Another body with its s counted from `origin_s_m`."""

    origin_s_m: float

    def at(self, t_s: Any) -> BodyMotion:
        motion = self.body.at(t_s)
        return replace(motion, s_m=motion.s_m - self.origin_s_m)


@dataclass(frozen=True, slots=True, kw_only=True)
class _RespondingBody(_OtherMotion):
    """A body that goes on as it does until `response_s`, then brakes with `braking_mps2` to a standstill."""

    response_s: float
    braking_mps2: float

    def at(self, t_s: Any) -> BodyMotion:
        t = np.asarray(t_s, dtype=np.float64)
        free, now = self.body.at(t), self.body.at(np.full(t.shape, self.response_s))
        v = np.maximum(now.speed_s_mps, 0.0)
        braked = np.clip(t - self.response_s, 0.0, v / self.braking_mps2)
        late = t > self.response_s
        return BodyMotion(
            s_m=np.where(late, now.s_m + v * braked - 0.5 * self.braking_mps2 * braked**2, free.s_m),
            d_m=free.d_m,
            heading_rad=free.heading_rad,
            speed_s_mps=np.where(late, v - self.braking_mps2 * braked, free.speed_s_mps),
            speed_d_mps=free.speed_d_mps,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Prediction:
    """A named hypothesis about every neighbour. Times are counted from the situation's time."""

    name: str
    bodies: tuple[PredictedBody, ...] = ()
    _on: dict[bytes, BodyMotion] = field(default_factory=dict, init=False, repr=False, compare=False)

    def seen_from(self, s_m: float) -> Prediction:
        """The same with every s counted from `s_m`."""
        if s_m == 0.0:
            return self
        return Prediction(name=self.name, bodies=tuple(_moved(body, s_m) for body in self.bodies))

    def rows_on(self, t_s: Array) -> BodyMotion:
        """Every body's motion at these times (n,), as rows (J, n) of one motion: worked out once for the same times, and read-only."""
        key = t_s.tobytes()
        known = self._on.get(key)
        if known is None:
            if len(self._on) >= _KEPT:
                self._on.clear()
            known = together(self.bodies, t_s)
            for row in _columns(known):
                row.setflags(write=False)
            self._on[key] = known
        return known


def grown_by(covariance: Array, position: int, t_s: Any, sigmas: float, growth_s: float, cap_m: float) -> Array:
    """So many standard deviations of the place at `position` in the covariance [m], growing with its speed's at first, capped."""
    t = np.minimum(np.asarray(t_s, dtype=np.float64), growth_s)
    p = covariance
    variance = p[position, position] + 2.0 * t * p[position, position + 1] + t**2 * p[position + 1, position + 1]
    return np.asarray(np.minimum(sigmas * np.sqrt(np.maximum(variance, 0.0)), cap_m), dtype=np.float64)


def responding(body: PredictedBody, *, response_s: float, braking_mps2: float) -> PredictedBody:
    """The same body with a driver who looks ahead: it goes on as it does until `response_s`, then brakes with `braking_mps2` to a
    standstill."""
    if isinstance(body, CruisingBody) and not responds(body):
        return replace(body, response_s=response_s, braking_mps2=braking_mps2)
    return _RespondingBody(body=body, response_s=response_s, braking_mps2=braking_mps2)


def responds(body: PredictedBody) -> bool:
    """Whether it brakes after a while, as a driver who looks ahead."""
    return isinstance(body, _RespondingBody) or (isinstance(body, CruisingBody) and body.response_s < math.inf)


def is_free(body: PredictedBody) -> bool:
    """Whether it does not follow the road, but moves, and is turned, as it likes."""
    return isinstance(body, FreeBody) or (isinstance(body, _OtherMotion) and is_free(body.body))


def is_on_foot(body: PredictedBody) -> bool:
    """Whether it is a person."""
    return is_on_foot(body.body) if isinstance(body, _OtherMotion) else isinstance(body, FreeBody) and body.on_foot


def sizes_on_road(bodies: Sequence[PredictedBody], heading_rad: Array) -> tuple[Array, Array]:
    """How much of the road's length and width bodies take [m], headed like this (J, n): (J, n) each, or (J, 1) where nobody is free. Who
    follows the road takes its own length and width."""
    sizes = np.array([(body.length_m, body.width_m) for body in bodies], dtype=np.float64).reshape(-1, 2)
    length, width = sizes[:, :1], sizes[:, 1:]
    free = [j for j, body in enumerate(bodies) if is_free(body)]
    if not free:
        return length, width
    c, s = np.abs(np.cos(heading_rad[free])), np.abs(np.sin(heading_rad[free]))
    along, across = (np.repeat(size, heading_rad.shape[1], axis=1) for size in (length, width))
    along[free], across[free] = length[free] * c + width[free] * s, length[free] * s + width[free] * c
    return along, across


def _moved(body: PredictedBody, s_m: float) -> PredictedBody:
    return replace(body, s_m=body.s_m - s_m) if isinstance(body, CruisingBody) else _MovedBody(body=body, origin_s_m=s_m)


def together(bodies: Sequence[PredictedBody], t_s: Array) -> BodyMotion:
    """Every body's motion at these times (n,), as rows (J, n) of one motion; of those who cruise in one go."""
    if bodies and all_cruise(bodies):
        return _cruising(bodies, t_s)
    rows = np.empty((5, len(bodies), t_s.size))
    which, cruise = _who_cruise(bodies)
    if cruise:
        rows[:, which] = _columns(_cruising(cruise, t_s))
    for j, body in enumerate(bodies):
        if not isinstance(body, CruisingBody):
            rows[:, j] = _columns(body.at(t_s))
    s_m, d_m, heading, speed_s, speed_d = rows
    return BodyMotion(s_m=s_m, d_m=d_m, heading_rad=heading, speed_s_mps=speed_s, speed_d_mps=speed_d)


def _who_cruise(bodies: Sequence[PredictedBody]) -> tuple[list[int], list[CruisingBody]]:
    found = [(j, body) for j, body in enumerate(bodies) if isinstance(body, CruisingBody)]
    return [j for j, _ in found], [body for _, body in found]


def _cruising(bodies: Sequence[CruisingBody], t_s: Array) -> BodyMotion:
    """The same of bodies, at least one, that move in the one closed form."""
    beginnings = [_beginning(body) for body in bodies]
    s, d, along, across, fade, swell, rate, until, response, braking = np.array(beginnings, dtype=np.float64).T[:, :, None]
    nobody_swells, nobody_changes = (not any(one[i] for one in beginnings) for i in (_SWELL, _RATE))
    kinds = 0.0 if nobody_swells else swell, 0.0 if nobody_changes else rate
    late = math.inf if all(one[_RESPONSE] == math.inf for one in beginnings) else response
    return _cruise(s, d, along, across, fade, *kinds, until, late, braking, t=t_s, shape=(len(bodies), t_s.size))


def margins_together(bodies: Sequence[PredictedBody], t_s: Array) -> tuple[Array, Array]:
    """Every body's inflation along and across [m] at these times (n,), as rows (J, n)."""
    margins = np.empty((2, len(bodies), t_s.size))
    which, cruise = _who_cruise(bodies)
    if cruise:
        margins[:, which] = _margins_of_cruising(cruise, t_s)
    for j, body in enumerate(bodies):
        if not isinstance(body, CruisingBody):
            margins[:, j] = body.margin_along_m(t_s), body.margin_across_m(t_s)
    return margins[0], margins[1]


def _margins_of_cruising(bodies: Sequence[CruisingBody], t_s: Array) -> Array:
    settings = np.array([_margin_settings(body) for body in bodies]).T[:, :, None]
    sigmas, growth, caps = settings[0], settings[1], settings[2:]
    places, both, speeds = np.array([body.covariance for body in bodies])[:, _ROWS, _COLUMNS].T.reshape(3, 2, -1, 1)
    t = np.minimum(t_s, growth)
    return np.asarray(np.minimum(sigmas * np.sqrt(np.maximum(places + 2.0 * t * both + t**2 * speeds, 0.0)), caps))


def all_cruise(bodies: Sequence[PredictedBody]) -> TypeGuard[Sequence[CruisingBody]]:
    """Whether all of them move in the one closed form: then they are worked out together."""
    return all(isinstance(body, CruisingBody) for body in bodies)


def _cruise(
    s: Any,
    d: Any,
    speed_s: Any,
    speed_d: Any,
    fade_s: Any,
    swell: Any,
    acceleration: Any,
    until_s: Any,
    response_s: Any,
    braking: Any,
    *,
    t: Array,
    shape: tuple[int, ...],
) -> BodyMotion:
    """At t, of this shape: constant speed along the road but for an acceleration until then, and for who responds braking after that;
    lateral speed swelling and fading.

    The heading is that of the speed along the road now: who brakes does not turn.
    """
    fade = np.exp(-t / fade_s)
    slowest = np.copysign(np.maximum(np.abs(speed_s), 1.0), speed_s)
    if isinstance(swell, float) and swell == 0.0:  # nobody changes lanes: what follows with a swell of nothing, worked out sooner
        across, gone = speed_d * fade, speed_d * fade_s * (1.0 - fade)
    else:
        risen = (1.0 + swell) / (1.0 + swell * fade)
        across, gone = speed_d * risen * risen * fade, speed_d * fade_s * risen * (1.0 - fade)
    nobody_responds = isinstance(response_s, float) and response_s == math.inf
    free = t if nobody_responds else np.minimum(t, response_s)
    place, along = s + speed_s * free, np.empty(shape)
    if isinstance(acceleration, float) and acceleration == 0.0:
        along[...] = speed_s
    else:
        accelerated = np.minimum(free, until_s)
        changed = acceleration * accelerated
        along[...] = speed_s + changed
        place = place + changed * (free - 0.5 * accelerated)
    if not nobody_responds:
        v = np.where(t > response_s, np.maximum(along, 0.0), along)
        braked = np.minimum(np.maximum(t - response_s, 0.0), np.maximum(v, 0.0) / braking)
        place = place + v * braked - 0.5 * braking * braked**2
        along = v - braking * braked
    return BodyMotion(s_m=place, d_m=d + gone, heading_rad=np.arctan(across / slowest), speed_s_mps=along, speed_d_mps=across)


_MOTION = tuple(field.name for field in fields(BodyMotion))
_columns = attrgetter(*_MOTION)
_KEPT = 16  # vectors of times whose motions a prediction remembers
# what moves a `CruisingBody`, in the order in which `_cruise` and the C texts take it
_ACROSS = "lateral_fade_s", "lateral_swell"
MOVING = ("s_m", "d_m", "speed_s_mps", "speed_d_mps", *_ACROSS, "acceleration_mps2", "changing_s", "response_s", "braking_mps2")
_SWELL, _RATE, _RESPONSE = (MOVING.index(name) for name in ("lateral_swell", "acceleration_mps2", "response_s"))
_beginning = attrgetter(*MOVING)
_margin_settings = attrgetter("sigmas", "growth_s", "cap_along_m", "cap_across_m")
# of a covariance: the places along and across, what they share with their speeds, the speeds
_ROWS, _COLUMNS = np.array([0, 2, 0, 2, 1, 3]), np.array([0, 2, 1, 3, 1, 3])
