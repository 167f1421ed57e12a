"""Where a number of a family of scenes comes from."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import AfterValidator, Field, ValidationInfo, ValidatorFunctionWrapHandler, WrapValidator, model_validator

from mcdas_opt.catalogue.part import Pair, Part

_MOST_VALUES = 10_000
_HARDEST_MPS2 = 15.0  # a car on the best of tyres brakes by no more
_UNITS = {"km/h": 1.0 / 3.6, "mph": 0.44704}


class Spread(Part):
    """Evenly between `low` and `high`; one of a list; one of `first`, `first + step` ... `last`; or read at the host's speed [m/s] from
    `by_speed`, linear in between and held at both ends. `unit` is what the numbers of a speed are written in, where that is not SI."""

    low: Annotated[float | None, Field(description="evenly between low and high")] = None
    high: Annotated[float | None, Field(description="evenly between low and high")] = None
    one_of: Annotated[Annotated[list[float], Field(min_length=1)] | None, Field(description="one of these")] = None
    first: Annotated[float | None, Field(description="one of first, first + step ... last")] = None
    last: Annotated[float | None, Field(description="as first says")] = None
    step: Annotated[Annotated[float, Field(gt=0.0)] | None, Field(description="as first says")] = None
    by_speed: Annotated[
        Annotated[list[Pair], Field(min_length=1)] | None, Field(description="[host's speed in m/s, value], linear in between")
    ] = None
    unit: Annotated[Literal["km/h", "mph"] | None, Field(description="of a speed, where not SI; other keys take none")] = None

    @model_validator(mode="after")
    def _one_kind(self) -> Self:
        kinds = (("low", "high"), ("one_of",), ("first", "last", "step"), ("by_speed",))
        given = dict(self)
        begun = [kind for kind in kinds if any(given[name] is not None for name in kind)]
        if len(begun) != 1 or any(given[name] is None for name in begun[0]):
            raise ValueError("needs low and high, or one_of, or first, last and step, or by_speed")
        for low, high in (("low", "high"), ("first", "last")):
            if given[low] is not None and given[high] < given[low]:
                raise ValueError(f"{high} = {given[high]:g} must be at least {low} = {given[low]:g}")
        if self.low is not None and self.high is not None and not math.isfinite(self.high - self.low):
            raise ValueError("high - low must be a finite number")
        if (
            self.first is not None
            and self.last is not None
            and self.step is not None
            and (self.last - self.first) / self.step > _MOST_VALUES
        ):
            raise ValueError(f"step must be large enough for at most {_MOST_VALUES:g} values from first to last")
        if self.by_speed is not None and any(b[0] <= a[0] for a, b in zip(self.by_speed, self.by_speed[1:], strict=False)):
            raise ValueError("the speeds of by_speed must increase")
        return self

    @property
    def values(self) -> tuple[float, ...] | None:
        """The numbers that it may take, in SI; None where they lie on a line or follow from the speed."""
        if self.one_of is not None:
            listed = self.one_of
        elif self.first is not None and self.last is not None and self.step is not None:
            listed = [self.first + k * self.step for k in range(int((self.last - self.first) / self.step + 1e-9) + 1)]
        else:
            return None
        return tuple(self._scale * value for value in listed)

    @property
    def bounds(self) -> tuple[float, float]:
        """The least and the most that may be drawn, in SI."""
        values = self.values
        if values is None and self.by_speed is not None:
            values = tuple(self._scale * value for _, value in self.by_speed)
        if values is None:
            values = (self._scale * (self.low or 0.0), self._scale * (self.high or 0.0))
        return min(values), max(values)

    def draw(self, rng: np.random.Generator, host_mps: float) -> float:
        values = self.values
        if values is not None:
            return values[int(rng.integers(len(values)))]
        if self.by_speed is not None:
            speeds, wanted = np.array(self.by_speed).T
            return self._scale * float(np.interp(host_mps, speeds, wanted))
        assert self.low is not None
        assert self.high is not None
        return float(rng.uniform(self._scale * self.low, self._scale * self.high + 0.0))  # numpy refuses 0.0 to -0.0

    @property
    def _scale(self) -> float:
        return _UNITS[self.unit] if self.unit is not None else 1.0


def _number_or_range(value: object, checked: ValidatorFunctionWrapHandler, info: ValidationInfo) -> object:
    """The rules of what was meant: a table's are those of `Spread`; only a speed has a unit, and is a key that ends in _mps."""
    if isinstance(value, dict):
        spread = Spread.model_validate(value)
        if spread.unit is not None and not (info.field_name or "").endswith("_mps"):
            raise ValueError(f"unit = {spread.unit!r} is a speed's: only keys that end in _mps take one")
        return spread
    if isinstance(value, bool) or not isinstance(value, (float, int, Spread)):
        raise ValueError("must be a number, or a table with a range, as { low = 1.0, high = 2.0 }")
    if not isinstance(value, Spread) and not math.isfinite(value):
        raise ValueError("must be a finite number")
    return checked(value)


Number = Annotated[float | int | Spread, WrapValidator(_number_or_range)]


def largest(number: Number) -> float:
    """The largest that may be drawn."""
    return number.bounds[1] if isinstance(number, Spread) else float(number)


def _as_a_car_brakes(number: Number) -> Number:
    least, most = number.bounds if isinstance(number, Spread) else (number, number)
    if not 0.0 <= least <= most <= _HARDEST_MPS2:
        raise ValueError(f"must lie in [0, {_HARDEST_MPS2:g}] m/s^2: braking is positive")
    return number


Braking = Annotated[Number, AfterValidator(_as_a_car_brakes)]


def draw(number: Number, rng: np.random.Generator, host_mps: float = 0.0) -> float:
    """One number; a fixed one takes nothing from the generator."""
    return number.draw(rng, host_mps) if isinstance(number, Spread) else float(number)
