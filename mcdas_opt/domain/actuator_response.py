"""How steering, brakes and engine answer to commands."""

from __future__ import annotations

from dataclasses import dataclass

from mcdas_opt.domain.rules import unit_of, within

SLOWEST_S = 1.0  # beyond is no actuator of a car


@dataclass(frozen=True, slots=True, kw_only=True)
class ActuatorResponse:
    """Dead time of the commands, and time constants of first-order lags; zeros answer at once.

    `steering_delay_s` counts for acceleration commands too: they wait for the steering, so that what is planned together takes effect
    together. Deceleration grows with `brake_build_up_s` and falls with `brake_release_s`; positive acceleration has `engine_lag_s`.
    """

    steering_delay_s: float = 0.0
    steering_lag_s: float = 0.0
    brake_build_up_s: float = 0.0
    brake_release_s: float = 0.0
    engine_lag_s: float = 0.0

    def __post_init__(self) -> None:
        for name, value in (
            ("steering_delay_s", self.steering_delay_s),
            ("steering_lag_s", self.steering_lag_s),
            ("brake_build_up_s", self.brake_build_up_s),
            ("brake_release_s", self.brake_release_s),
            ("engine_lag_s", self.engine_lag_s),
        ):
            within(name, value, 0.0, SLOWEST_S, unit_of(name))

    @property
    def is_immediate(self) -> bool:
        return self == ActuatorResponse()
