"""A trajectory of the host: samples over time, body centres in the road frame."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np

from mcdas_opt.domain.document import to_document
from mcdas_opt.domain.equality import EqualByValue
from mcdas_opt.domain.rules import Array, all_finite, floats, non_negative, vector
from mcdas_opt.errors import ParameterError


class Command(NamedTuple):
    """What to ask of the car: the rear axle's acceleration, and the angle of the front wheels (left positive)."""

    acceleration_mps2: float
    steering_rad: float


class Vectors(EqualByValue):
    """A dataclass (eq=False) of vectors of one length over the times `t_s`, read-only. Built by anybody: soundness is the judge's."""

    __slots__ = ()
    t_s: Array

    def __post_init__(self) -> None:
        size = -1
        for name, given in self.columns().items():
            value = given if _kept_as_it_is(given) else floats(name, given, "must be a list of numbers")
            size = (len(value) if value.ndim else 1) if size < 0 else size
            if value.shape != (size,):
                raise ParameterError(name, f"shape {value.shape}", f"must be a list of {size} numbers, as t_s")
            value.setflags(write=False)
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        return int(self.t_s.size)

    def to_dict(self) -> dict[str, list[float]]:
        document: dict[str, list[float]] = to_document(self)
        return document

    def columns(self) -> dict[str, Array]:
        """The vectors by their names."""
        names = [field.name for field in fields(self)]  # type: ignore[arg-type]
        return dict(zip(names, attrgetter(*names)(self), strict=True))


class _Tabled:
    """Room for a trajectory's table, once it has been asked for or was there to begin with."""

    __slots__ = ("_kept",)
    _kept: Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trajectory(_Tabled, Vectors):
    """(s, d) body centre, heading relative to the road at s; speed, acceleration, steering of the rear axle.

    `jerk_mps3` and `steering_rate_radps` at k hold over [t_k, t_k+1); the last repeats.
    """

    t_s: Array
    s_m: Array
    d_m: Array
    heading_rad: Array
    speed_mps: Array
    acceleration_mps2: Array
    steering_rad: Array
    steering_rate_radps: Array
    jerk_mps3: Array

    @property
    def table(self) -> Array:
        """(9, n): the vectors as rows, in their order here; not to be written into."""
        try:
            return self._kept
        except AttributeError:
            table = np.array(_columns(self))
            table.setflags(write=False)
            object.__setattr__(self, "_kept", table)
            return table

    @property
    def states(self) -> Array:
        """(n, 6): s, d, psi, v, a, delta."""
        return np.array(self.table[1:7].T, order="C")

    @property
    def inputs(self) -> Array:
        """(n, 2): jerk, steering rate."""
        return np.array(self.table[8:6:-1].T, order="C")

    @classmethod
    def from_states(cls, t_s: Array, x: Array, u: Array) -> Trajectory:
        """From times (n,), states (n, 6) and inputs (n - 1, 2) or (n, 2); a missing last input repeats."""
        t = t_s if _kept_as_it_is(t_s) and t_s.ndim == 1 and all_finite(t_s) else vector("t_s", t_s, "s")
        if t.size != len(x):
            raise ParameterError("s_m", f"shape {(len(x),)}", f"must be a list of {t.size} numbers, as t_s")
        rows = np.empty((len(_NAMES), len(x)))
        rows[0], rows[1:7] = t, np.asarray(x).T
        driven = rows[8:6:-1]
        if len(u) == t.size - 1:
            driven[:, :-1] = np.asarray(u).T
            driven[:, -1] = u[-1] if len(u) else 0.0
        else:
            driven[:] = np.asarray(u).T
        rows.setflags(write=False)
        made = object.__new__(cls)  # the rows are what __post_init__ would make of them
        _keep(made, "_kept", rows)
        _keep(made, "t_s", t)  # itself: who is asked for motions at a grid's times knows them again
        for name, row in zip(_NAMES[1:], rows[1:], strict=True):
            _keep(made, name, row)
        return made

    def command_at(self, t_s: float) -> Command:
        """Acceleration [m/s^2] and steering angle [rad] at `t_s` [s], a time of this trajectory's own clock.

        Both are linear between samples, as jerk and steering rate are constant there. Past the end they are the last sample's.
        Raises `ParameterError` for a time that is negative or not finite.
        """
        asked_s = non_negative("t_s", t_s, "s")
        return Command(*(float(np.interp(asked_s, self.t_s, values)) for values in (self.acceleration_mps2, self.steering_rad)))

    def seen_from(self, s_m: float) -> Trajectory:
        """The same with its s counted from `s_m`."""
        return self if s_m == 0.0 else replace(self, s_m=self.s_m - s_m)

    @classmethod
    def from_columns(cls, columns: dict[str, Any]) -> Trajectory:
        return cls(**{name: columns[name] for name in _NAMES})


_NAMES = tuple(field.name for field in fields(Trajectory))
_columns = attrgetter(*_NAMES)
_keep = object.__setattr__


def _kept_as_it_is(value: Any) -> bool:
    """Whether nobody can write into this array of floats any more."""
    if not isinstance(value, np.ndarray) or value.dtype != np.float64 or value.flags.writeable:
        return False
    return value.base is None or (isinstance(value.base, np.ndarray) and not value.base.flags.writeable)
