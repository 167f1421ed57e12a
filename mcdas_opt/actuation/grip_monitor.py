"""Friction, estimated: from brakes that give less than is asked, and from tyres that give less than their slip should bring.

Source of the second: the slope of force over slip falls long before the force does, so that the limit shows before it is reached (Hsu, Laws
and Gerdes, IEEE Trans. Control Systems Technology 18(4) 2010; Ahn, Peng and Tseng, Vehicle System Dynamics 50(4) 2012). Here axle by axle:
lateral forces from measured lateral and yaw acceleration, slip from measured speeds, and Fiala's curve solved for its limit.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field, replace

from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.host import HostState, SlidingState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import positive
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.dynamics.single_track import axle_loads, axle_pulls, fiala_limit

SLIDING_SHARE = 0.5  # of an axle's contact must slide before it is believed: it then gives 87 % of what it can
SIGNIFICANT = 0.95  # the belief stands while the estimate is at least this share of it
LAG_S = 0.05  # of the estimate behind a single sample
AGREEING = 5  # samples, one after another, that have to agree before the last of them counts
AGREEMENT = 0.15  # what they may differ by, of the largest: where force lags behind slip (suspension, roll) they differ more
USED_S = 1.0  # what tyres have given within that time, they can give
RECOVERY_S = 4.0  # without a sample that counts; from then on the estimate goes back to the belief ...
RECOVERY_PER_S = 0.05  # ... by so much in a second
MISSING_MPS2 = 0.3  # of the braking asked for, and the rest constant over the span: then the road bounds it
LEAST_DEMAND = 0.15  # friction that the slip would ask of tyres that do not slide; less is too small to measure by
SPAN_S = 0.02  # over which accelerations are taken
SLOWEST_MPS = 5.0
_GRIP_SHARE = 0.97  # that a path may be bent by


@dataclass(slots=True, kw_only=True)
class GripMonitor:
    """Takes the measured state every `step_s`. Plans are made with `friction`: the belief, or the estimate where that is less.

    Never above the belief: tyres that do not slide do not tell how much grip there is. There is no new sample while the tyres do little
    work, or below 5 m/s. A state without slip gives one by braking alone. Samples count once AGREEING of them agree. The estimate is never
    less than what the tyres gave within the last second, and goes back to the belief, slowly, where no sample has counted for a while.
    """

    vehicle: Vehicle
    believed: float
    step_s: float = 0.01
    estimate: float | None = None  # friction, once tyres or brakes have worked hard
    _chassis: Chassis = field(init=False)
    _past: deque[HostState] = field(init=False)
    _samples: deque[float] = field(init=False, default_factory=lambda: deque(maxlen=AGREEING))
    _given: deque[float] = field(init=False, default_factory=lambda: deque(maxlen=AGREEING))  # by the tyres, step by step
    _used: deque[float] = field(init=False)  # the least of `_given`, step by step
    _waited_s: float = field(init=False, default=0.0)  # since a sample counted

    def __post_init__(self) -> None:
        positive("believed", self.believed)
        self._chassis = Chassis.of(self.vehicle)
        self._past = deque(maxlen=2 * max(round(0.5 * SPAN_S / positive("step_s", self.step_s, "s")), 1) + 1)
        self._used = deque(maxlen=max(round(USED_S / self.step_s), 1))

    @property
    def friction(self) -> float:
        return self.believed if self.estimate is None or self.estimate >= SIGNIFICANT * self.believed else self.estimate

    def note(self, state: HostState, asked_mps2: float = 0.0) -> None:
        """The state of now, a step after the one before, and the acceleration that the plan asks for."""
        if state.speed_mps < SLOWEST_MPS:
            self._past.clear()
            self._samples.clear()
            self._given.clear()
            return
        self._past.append(state)
        if len(self._past) < (self._past.maxlen or 0):
            return
        first, now, last = self._past[0], self._past[len(self._past) // 2], self._past[-1]
        sample = self._braked(asked_mps2)
        if isinstance(first, SlidingState) and isinstance(now, SlidingState) and isinstance(last, SlidingState):
            sliding, friction = max(self._axles(first, now, last))
            if sliding >= SLIDING_SHARE:
                sample = friction
        self._take(sample)
        self._recover(self._gave(first, now, last))

    def _take(self, sample: float | None) -> None:
        """A sample, or none, of this step."""
        self._waited_s += self.step_s
        if sample is None:
            self._samples.clear()
            return
        self._samples.append(sample)
        if len(self._samples) < AGREEING or min(self._samples) < (1.0 - AGREEMENT) * max(self._samples):
            return
        self._waited_s = 0.0
        if self.estimate is None:
            self.estimate = sample
        self.estimate += (sample - self.estimate) * min(self.step_s / LAG_S, 1.0)

    def _recover(self, given: float) -> None:
        """What the tyres gave bounds the estimate from below; what is old is forgotten."""
        self._given.append(given)
        if len(self._given) == AGREEING:
            self._used.append(min(self._given))
        if self.estimate is None:
            return
        if self._waited_s > RECOVERY_S:
            self.estimate += RECOVERY_PER_S * self.step_s
        self.estimate = max(self.estimate, *self._used)

    def _gave(self, first: HostState, now: HostState, last: HostState) -> float:
        """What the tyres give: acceleration of the centre of gravity in g, in the middle of the span; without slip, along the car alone."""
        span = self.step_s * (len(self._past) - 1)
        along = (last.speed_mps - first.speed_mps) / span
        if not (isinstance(first, SlidingState) and isinstance(now, SlidingState) and isinstance(last, SlidingState)):
            return abs(along) / GRAVITY_MPS2
        aside, behind = now.lateral_speed_mps, self._chassis.cog_to_rear_axle_m
        yaw_rate, turning = now.yaw_rate_radps, (last.yaw_rate_radps - first.yaw_rate_radps) / span
        left = (last.lateral_speed_mps - first.lateral_speed_mps) / span + behind * turning + now.speed_mps * yaw_rate
        return math.hypot(along - yaw_rate * (aside + behind * yaw_rate), left) / GRAVITY_MPS2

    def _braked(self, asked_mps2: float) -> float | None:
        """Friction by braking that is asked for and does not come; None where it comes, or where it is the brakes that end."""
        end = self.vehicle.acceleration_min_mps2
        has = [state.acceleration_mps2 for state in self._past]
        held = max(has) - min(has) < 0.1 * MISSING_MPS2 and max(has) < -MISSING_MPS2
        if held and asked_mps2 < has[-1] - MISSING_MPS2 and has[-1] > end + MISSING_MPS2:
            return -has[-1] / GRAVITY_MPS2
        return None

    def _axles(self, first: SlidingState, now: SlidingState, last: SlidingState) -> list[tuple[float, float]]:
        """(share of the contact that slides, friction) of front and rear axle in the middle of the span; a share of 0 says nothing."""
        c = self._chassis
        a, b, span = c.cog_to_front_axle_m, c.cog_to_rear_axle_m, self.step_s * (len(self._past) - 1)
        v, r, vy, delta, ax = now.speed_mps, now.yaw_rate_radps, now.lateral_speed_mps, now.steering_rad, now.acceleration_mps2
        turning = (last.yaw_rate_radps - first.yaw_rate_radps) / span
        aside = (last.lateral_speed_mps - first.lateral_speed_mps) / span + b * turning + v * r
        loads = axle_loads(c, ax)
        along = axle_pulls(c, ax, loads)
        front = (c.yaw_inertia_kgm2 * turning + b * c.mass_kg * aside) / c.wheelbase_m
        across = (
            (front - along[0] * math.sin(delta)) / math.cos(delta),
            (a * c.mass_kg * aside - c.yaw_inertia_kgm2 * turning) / c.wheelbase_m,
        )
        slips = (delta - math.atan2(vy + c.wheelbase_m * r, v), -math.atan2(vy, v))
        stiffness = (c.cornering_stiffness_front_nprad, c.cornering_stiffness_rear_nprad)
        found = []
        for force, pull, load, slip, stiff in zip(across, along, loads, slips, stiffness, strict=True):
            sliding, limit = fiala_limit(slip, stiff, force) if stiff * abs(slip) > LEAST_DEMAND * load else (0.0, 0.0)
            found.append((sliding, math.hypot(limit, pull) / max(load, 1.0)))
        return found


def within_grip(host: HostState, road: Road, wheelbase_m: float) -> HostState:
    """The host, its path bent no more than friction allows beside its acceleration: a sliding vehicle turns faster than its path bends."""
    grip = _GRIP_SHARE * road.friction * GRAVITY_MPS2
    most = math.sqrt(max(grip**2 - host.acceleration_mps2**2, 0.0))
    v = host.speed_mps
    if v**2 * abs(math.tan(host.steering_rad)) <= most * wheelbase_m:
        return host
    held = math.copysign(math.atan(most * wheelbase_m / v**2), host.steering_rad)
    return replace(host, steering_rad=held)
