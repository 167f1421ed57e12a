"""One planning cycle: what everybody in it needs, made once."""

from __future__ import annotations

import time
from dataclasses import dataclass

from mcdas_opt.domain.assessment import Assessment
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Mode, Side
from mcdas_opt.planning.manoeuvre import Manoeuvre
from mcdas_opt.planning.memory import Memory
from mcdas_opt.situation.assess import assess
from mcdas_opt.tracking.prediction import predict_for

_STRAIGHT_M = 0.1  # a smaller offset of the front vehicle prefers neither side


@dataclass(frozen=True, slots=True, kw_only=True)
class Cycle:
    """The situation with what follows from it. `stop_at_s` (of `time.perf_counter`) is when no further candidate is begun; None: never."""

    situation: Situation
    vehicle: Vehicle
    settings: Settings
    assessment: Assessment
    prediction: Prediction
    memory: Memory
    active: Manoeuvre | None
    stop_at_s: float | None

    @classmethod
    def of(
        cls,
        situation: Situation,
        vehicle: Vehicle,
        settings: Settings | None = None,
        memory: Memory | None = None,
        stop_at_s: float | None = None,
    ) -> Cycle:
        """Assesses and predicts. A manoeuvre that the memory holds is active until it is finished."""
        settings, memory = settings or Settings(), memory or Memory()
        active = memory.active
        return cls(
            situation=situation,
            vehicle=vehicle,
            settings=settings,
            assessment=assess(situation, vehicle, settings.selector, memory.assessment),
            prediction=predict_for(situation, settings.prediction),
            memory=memory,
            active=None if active is None or active.finished(situation) else active,
            stop_at_s=stop_at_s,
        )

    @property
    def is_late(self) -> bool:
        return self.stop_at_s is not None and time.perf_counter() > self.stop_at_s

    @property
    def preferred_side(self) -> Side:
        """The side that asks for less lateral movement past the front vehicle (eq 22-23); none when that is straight ahead."""
        if self.assessment.front_id is None or abs(self.assessment.offset_m) <= _STRAIGHT_M:
            return Side.NONE
        return Side.RIGHT if self.assessment.offset_m > 0.0 else Side.LEFT

    @property
    def needs_no_steering(self) -> bool:
        """The selector finds braking or accelerating enough."""
        return self.assessment.mode in (Mode.BRAKE, Mode.ACCELERATE)
