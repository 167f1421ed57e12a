"""The drive-by-wire loop: a plant with lag and dead time, the speed law as feedforward, feedback designed with `control`.

Design: the error of speed and acceleration, the corrections still in the dead time and the integral of the speed error form
one discrete state; the gain is the discrete linear-quadratic regulator of it (Franklin, Powell and Workman, Digital Control of Dynamic
Systems, 3rd ed. 1998, ch. 9).
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np

from mcdas_opt.actuation.speed_law import SpeedLimits, next_acceleration
from mcdas_opt.domain.rules import Array, non_negative, positive
from mcdas_opt.errors import ParameterError


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveByWire:
    """Acceleration follows its command by a first-order lag after a dead time. The figures are assumed; the paper has none."""

    lag_s: float = 0.25
    delay_s: float = 0.1

    def __post_init__(self) -> None:
        positive("lag_s", self.lag_s, "s")
        non_negative("delay_s", self.delay_s, "s")


@dataclass(frozen=True, slots=True, kw_only=True)
class Margins:
    """Robustness of the loop, broken at the command. `gain` is infinite where the phase never reaches 180 degrees below Nyquist."""

    gain: float
    phase_deg: float
    crossover_radps: float
    delay_s: float  # dead time that may be added
    sensitivity_peak: float  # max |1 / (1 + L)|
    slowest_pole: float  # modulus; below 1 is stable


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedRun:
    """Samples of a run; `jerk` at k is the largest in size within [t_k, t_k+1)."""

    t_s: Array
    speed_mps: Array
    acceleration_mps2: Array
    jerk_mps3: Array
    command_mps2: Array
    reference_mps: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedLoop:
    """Gains on (speed error, acceleration error, corrections in the dead time, oldest first, integral of the speed error)."""

    plant: DriveByWire
    step_s: float
    gains: Array
    margins: Margins
    limits: SpeedLimits
    law_limits: SpeedLimits

    @property
    def waiting(self) -> int:
        """Dead time in whole samples."""
        return round(self.plant.delay_s / self.step_s)

    def run(
        self,
        start_mps: float,
        wanted_mps: Any,
        duration_s: float,
        actual: DriveByWire | None = None,
        disturbance_mps2: float = 0.0,
    ) -> SpeedRun:
        """Closed loop from steady `start_mps`; `wanted_mps` is constant or one value a sample. `actual`: the true plant, default the
        model. `disturbance_mps2`: an acceleration that acts besides (a slope), unknown to the controller."""
        actual = actual or self.plant
        h, steps = self.step_s, round(duration_s / self.step_s)
        wanted = np.broadcast_to(np.asarray(wanted_mps, dtype=np.float64), (steps,))
        late = round(actual.delay_s / h)
        model_decay, true_decay = math.exp(-h / self.plant.lag_s), math.exp(-h / actual.lag_s)
        v, a, integral = start_mps, 0.0, 0.0
        v_law, a_law = start_mps, 0.0
        past = deque([(start_mps, 0.0)] * (self.waiting + 1), maxlen=self.waiting + 1)
        corrections, commands = deque([0.0] * self.waiting), deque([0.0] * self.waiting)
        wire = deque([0.0] * late)
        rows = []
        for k in range(steps):
            past.append((v_law, a_law))
            v_then, a_then = past[0]
            a_next = float(next_acceleration(a_law, wanted[k] - v_law, h, self.law_limits))
            feedforward = a_law + (a_next - a_law) / (1.0 - model_decay)
            error = np.array([v - v_then, a - a_then, *corrections, integral])
            asked = feedforward - float(self.gains @ error)
            command = self._within_limits(asked, _after(a, commands, model_decay), model_decay)
            if command == asked:
                integral += h * (v - v_then)
            for queue, value in ((corrections, command - feedforward), (commands, command), (wire, command)):
                queue.append(value)
            corrections.popleft()
            commands.popleft()
            acting = wire.popleft()
            rows.append((k * h, v, a, (acting - a) / actual.lag_s, command, v_then))
            v += h * (acting + disturbance_mps2) + (a - acting) * actual.lag_s * (1.0 - true_decay)
            a = acting + (a - acting) * true_decay
            v_law, a_law = v_law + 0.5 * h * (a_law + a_next), a_next
        return SpeedRun(**dict(zip(SpeedRun.__slots__, np.array(rows).T, strict=True)))

    def _within_limits(self, command: float, acceleration: float, decay: float) -> float:
        """The command that keeps acceleration and jerk inside the vehicle's limits when it takes effect at `acceleration`."""
        lag, reach = self.plant.lag_s, 1.0 - decay
        low = max(self.limits.jerk_min_mps3 * lag, (self.limits.acceleration_min_mps2 - acceleration) / reach)
        high = min(self.limits.jerk_max_mps3 * lag, (self.limits.acceleration_max_mps2 - acceleration) / reach)
        return acceleration + min(max(command - acceleration, low), high)


def _after(acceleration: float, commands: deque[float], decay: float) -> float:
    """Acceleration once the commands in the dead time have acted, by the model."""
    for command in commands:
        acceleration = command + (acceleration - command) * decay
    return acceleration


def design_speed_loop(
    limits: SpeedLimits,
    plant: DriveByWire | None = None,
    step_s: float = 0.02,
    speed_weight: float = 3.0,
    acceleration_weight: float = 0.1,
    integral_weight: float = 1.5,
    law_jerk_share: float = 0.5,
    law_acceleration_share: float = 0.9,
) -> SpeedLoop:
    """The regulator for a plant, with its margins. Weights are against (m/s^2)^2 of correction; the law gets shares of the limits, so that
    the feedback keeps some room."""
    import control

    plant = plant or DriveByWire()
    waiting = round(plant.delay_s / positive("step_s", step_s, "s"))
    if abs(waiting * step_s - plant.delay_s) > 1e-9:
        raise ParameterError("delay_s", plant.delay_s, f"must be a whole number of samples of {step_s:g} s", "s")
    lagged = control.ss([[0.0, 1.0], [0.0, -1.0 / plant.lag_s]], [[0.0], [1.0 / plant.lag_s]], np.eye(2), np.zeros((2, 1)))
    sampled = control.sample_system(lagged, step_s, method="zoh")
    n = 3 + waiting
    a, b = np.zeros((n, n)), np.zeros((n, 1))
    a[:2, :2] = sampled.A
    if waiting:
        a[:2, 2] = sampled.B[:, 0]
        a[range(2, 1 + waiting), range(3, 2 + waiting)] = 1.0
        b[1 + waiting, 0] = 1.0
    else:
        b[:2] = sampled.B
    a[-1, 0], a[-1, -1] = step_s, 1.0
    weights = np.diag([speed_weight, acceleration_weight, *[0.0] * waiting, integral_weight])
    gains, _, poles = control.dlqr(a, b, weights, np.eye(1))
    loop = control.ss(a, b, gains, np.zeros((1, 1)), step_s)
    factor = step_s / (plant.lag_s * (1.0 - math.exp(-step_s / plant.lag_s)))  # jerk at a sample's start over its mean
    return SpeedLoop(
        plant=plant,
        step_s=step_s,
        gains=np.asarray(gains, dtype=np.float64)[0],
        margins=_margins(loop, step_s, np.asarray(poles)),
        limits=limits,
        law_limits=SpeedLimits(
            acceleration_min_mps2=law_acceleration_share * limits.acceleration_min_mps2,
            acceleration_max_mps2=law_acceleration_share * limits.acceleration_max_mps2,
            jerk_min_mps3=law_jerk_share / factor * limits.jerk_min_mps3,
            jerk_max_mps3=law_jerk_share / factor * limits.jerk_max_mps3,
        ),
    )


def _margins(loop: Any, step_s: float, poles: Array) -> Margins:
    """From the frequency response between 0.2 rad/s and Nyquist (below, the double integrator only brushes the 180 degrees)."""
    import control

    omega = np.geomspace(0.2, 0.999 * math.pi / step_s, 4000)
    response = np.asarray(loop(np.exp(1j * omega * step_s)))
    gain, phase, _, _, crossover, _ = control.stability_margins(control.frd(response, omega))
    return Margins(
        gain=float(gain),
        phase_deg=float(phase),
        crossover_radps=float(crossover),
        delay_s=math.radians(float(phase)) / float(crossover),
        sensitivity_peak=float(np.max(1.0 / np.abs(1.0 + response))),
        slowest_pole=float(np.abs(poles).max()),
    )
