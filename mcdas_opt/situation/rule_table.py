"""The total selector's rule table: rows that exclude one another and leave nothing out."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.vocabulary import Mode

Flags = NDArray[np.bool_]


class Conditions(NamedTuple):
    """What the rows ask of a state; vectors over states."""

    front: Flags  # threatens
    rear: Flags  # threatens
    park: Flags  # asked for, and standing still
    blind: Flags  # no sensor covers front or rear
    at_speed: Flags  # the desired one
    unseen_ahead: Flags  # faster is wanted, and no sensor covers the front
    brakes: Flags  # braking for the front is enough
    outruns: Flags  # the front is clear and the acceleration enough
    side: Flags  # one is open, and the car fast enough to steer out
    room: Flags  # ahead, to close up

    @property
    def calm(self) -> Flags:
        return ~self.front & ~self.rear

    @property
    def free(self) -> Flags:
        return self.calm & ~self.park & ~self.blind & ~self.at_speed

    @property
    def only_front(self) -> Flags:
        return self.front & ~self.rear

    @property
    def only_rear(self) -> Flags:
        return self.rear & ~self.front


class Rule(NamedTuple):
    mode: Mode
    reason: str
    applies: Callable[[Conditions], Flags]


RULES = (
    Rule(Mode.PARK, "parking requested at standstill", lambda c: c.calm & c.park),
    Rule(Mode.HOLD, "nobody watches front or rear: safe hold", lambda c: c.calm & ~c.park & c.blind),
    Rule(Mode.HOLD, "nothing threatens", lambda c: c.calm & ~c.park & ~c.blind & c.at_speed),
    Rule(Mode.HOLD, "no acceleration into an unseen front", lambda c: c.free & c.unseen_ahead),
    Rule(Mode.CRUISE, "nothing threatens, to the desired speed", lambda c: c.free & ~c.unseen_ahead),
    Rule(Mode.BRAKE, "front threat, braking is enough", lambda c: c.only_front & c.brakes),
    Rule(Mode.EVADE, "front threat, braking is too hard", lambda c: c.only_front & ~c.brakes & c.side),
    Rule(Mode.BRAKE, "front threat, no side open", lambda c: c.only_front & ~c.brakes & ~c.side),
    Rule(Mode.EVADE, "threats from front and rear", lambda c: c.front & c.rear & c.side),
    Rule(Mode.BRAKE, "threats from front and rear, no side open", lambda c: c.front & c.rear & ~c.side),
    Rule(Mode.ACCELERATE, "rear threat, the front is clear", lambda c: c.only_rear & c.outruns),
    Rule(Mode.EVADE, "rear threat, the gaps leave no room to outrun it", lambda c: c.only_rear & ~c.outruns & c.side),
    Rule(Mode.ACCELERATE, "rear threat, no side open, room ahead", lambda c: c.only_rear & ~c.outruns & ~c.side & c.room),
    Rule(Mode.HOLD, "rear threat, boxed in", lambda c: c.only_rear & ~c.outruns & ~c.side & ~c.room),
)
