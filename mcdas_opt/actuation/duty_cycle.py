"""The paper's speed control as published: duty cycles of the drive-by-wire system, eq 10-11. All speeds in one unit."""

from __future__ import annotations

from mcdas_opt.domain.rules import finite, positive

SAMPLE_S = 0.5  # the paper's time frame, section 3.1.3


def duty_of_speed(speed: float, fastest: float) -> float:
    """Eq 10: D = V / V_HM, the fraction of the host's maximum speed (for the rear vehicle: D_(R-1))."""
    return finite("speed", speed) / positive("fastest", fastest)


def next_duty(duty: float, rear_speed: float, fastest: float) -> float:
    """Eq 11: D_H = D_(H-1) + (V_Tr / V_HM - D_(H-1)).

    Deadbeat: D_(H-1) cancels, so the host takes the rear vehicle's speed within one sample, upwards and downwards alike.
    """
    return duty + (duty_of_speed(rear_speed, fastest) - duty)


def implied_acceleration(before: float, after: float) -> float:
    """Acceleration [m/s^2] that a change of speed [m/s] within one sample asks for; 40 to 60 km/h in 0.5 s is 1.13 g."""
    return (after - before) / SAMPLE_S
