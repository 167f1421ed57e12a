"""Friction that plans are made with: a belief, until brakes give less than is asked or tyres less than their slip should bring.

Of the second an observer has an estimate with its uncertainty (`tracking.sideslip_observer`): the slope of force over slip falls long
before the force does, so that the limit shows before it is reached (Hsu, Laws and Gerdes, IEEE Trans. Control Systems Technology 18(4)
2010).
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field, replace

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.host_motion import MotionMeasurement, SlipEstimate
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import positive, within
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.tracking.sideslip_observer import LEAST_FRICTION, UNKNOWN_SD

INFORMED_SD = UNKNOWN_SD / math.sqrt(2.0)  # of the observer's friction: by then tyres have said as much as was known without them
SIGNIFICANT = 0.95  # the belief stands while the estimate is at least this share of it
LAG_S = 0.05  # of the estimate behind a single sample
AGREEING = 5  # samples, one after another, that have to agree before the last of them counts
AGREEMENT = 0.15  # what they may differ by, of the largest: where force lags behind slip (suspension, roll) they differ more
USED_S = 1.0  # what tyres have given within that time, they can give
RECOVERY_S = 4.0  # without a sample that counts; from then on the estimate goes back to the belief ...
RECOVERY_PER_S = 0.05  # ... by so much in a second
MISSING_MPS2 = 0.3  # of the braking asked for, and the rest constant over the span: then the road bounds it
SPAN_S = 0.02  # over which accelerations are taken
SLOWEST_MPS = 5.0
_GRIP_SHARE = 0.97  # that a path may be bent by


@dataclass(slots=True, kw_only=True)
class GripMonitor:
    """Takes the measured state every `step_s`. Plans are made with `friction`: the belief, or the estimate where that is less.

    Never above the belief: tyres that do not slide do not tell how much grip there is. There is no new sample while the tyres do little
    work, or below 5 m/s. Without an observer, braking alone gives one. A belief within one standard deviation of what the observer has
    stands; where it is above, the sample is a bound: a standard deviation below. Samples count once AGREEING of them agree. The estimate
    is never less than what the tyres gave within the last second, and goes back to the belief, slowly, where no sample has counted for a
    while.
    """

    vehicle: Vehicle
    believed: float
    step_s: float = 0.01
    estimate: float | None = None  # friction, once tyres or brakes have worked hard
    _past: deque[HostState] = field(init=False)
    _samples: deque[float] = field(init=False, default_factory=lambda: deque(maxlen=AGREEING))
    _given: deque[float] = field(init=False, default_factory=lambda: deque(maxlen=AGREEING))  # by the tyres, step by step
    _used: deque[float] = field(init=False)  # the least of `_given`, step by step
    _waited_s: float = field(init=False, default=0.0)  # since a sample counted

    def __post_init__(self) -> None:
        require_types(self)
        positive("believed", self.believed)
        self._past = deque(maxlen=2 * max(round(0.5 * SPAN_S / within("step_s", self.step_s, 1e-4, 1.0, "s")), 1) + 1)
        self._used = deque(maxlen=max(round(USED_S / self.step_s), 1))

    @property
    def friction(self) -> float:
        return self.believed if self.estimate is None or self.estimate >= SIGNIFICANT * self.believed else self.estimate

    def note(
        self,
        state: HostState,
        asked_mps2: float = 0.0,
        slip: SlipEstimate | None = None,
        measured: MotionMeasurement | None = None,
    ) -> None:
        """The state of now, a step after the one before, and the acceleration that the plan asks for; what the observer has of a car whose
        tyres slip, and from what."""
        if state.speed_mps < SLOWEST_MPS:
            self._past.clear()
            self._samples.clear()
            self._given.clear()
            return
        self._past.append(state)
        if len(self._past) < (self._past.maxlen or 0):
            return
        sample = self._braked(asked_mps2)
        if slip is not None and slip.friction_sd <= INFORMED_SD:
            above = slip.friction + slip.friction_sd >= self.believed
            sample = self.believed if above else max(slip.friction - slip.friction_sd, LEAST_FRICTION)
        self._take(sample)
        self._recover(self._gave(measured))

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

    def _gave(self, measured: MotionMeasurement | None) -> float:
        """What the tyres give: acceleration of the centre of gravity in g; without its measurement, along the car alone."""
        if measured is None:
            span = self.step_s * (len(self._past) - 1)
            return abs((self._past[-1].speed_mps - self._past[0].speed_mps) / span) / GRAVITY_MPS2
        return math.hypot(measured.forward_mps2, measured.lateral_mps2) / GRAVITY_MPS2

    def _braked(self, asked_mps2: float) -> float | None:
        """Friction by braking that is asked for and does not come; None where it comes, or where it is the brakes that end."""
        end = self.vehicle.acceleration_min_mps2
        has = [state.acceleration_mps2 for state in self._past]
        held = max(has) - min(has) < 0.1 * MISSING_MPS2 and max(has) < -MISSING_MPS2
        if held and asked_mps2 < has[-1] - MISSING_MPS2 and has[-1] > end + MISSING_MPS2:
            return -has[-1] / GRAVITY_MPS2
        return None


def within_grip(host: HostState, road: Road, wheelbase_m: float) -> HostState:
    """The host, its path bent no more than friction allows beside its acceleration: a sliding vehicle turns faster than its path bends."""
    grip = _GRIP_SHARE * road.friction * GRAVITY_MPS2
    most = math.sqrt(max(grip**2 - host.acceleration_mps2**2, 0.0))
    v = host.speed_mps
    if v**2 * abs(math.tan(host.steering_rad)) <= most * wheelbase_m:
        return host
    held = math.copysign(math.atan(most * wheelbase_m / v**2), host.steering_rad)
    return replace(host, steering_rad=held)
