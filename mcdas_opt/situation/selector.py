"""The total selector: every state has exactly one mode. One rule table for one state and for a million."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import lru_cache
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.settings import SelectorSettings
from mcdas_opt.domain.vocabulary import Mode, Side
from mcdas_opt.situation import one_state
from mcdas_opt.situation.rule_table import RULES, Conditions, Flags

Codes = NDArray[np.int8]

MODES = (Mode.HOLD, Mode.CRUISE, Mode.BRAKE, Mode.ACCELERATE, Mode.EVADE, Mode.PARK)
SIDES = (Side.NONE, Side.LEFT, Side.RIGHT)
NO_MODE = -1
_NO_RULE = -1
_CODE = {mode: code for code, mode in enumerate(MODES)}
_SIDE = {side: code for code, side in enumerate(SIDES)}
_HOLD, _CRUISE, _BRAKE, _ACCELERATE, _EVADE, _PARK = (_CODE[mode] for mode in MODES)
_NONE, _LEFT, _RIGHT = (_SIDE[side] for side in SIDES)
_URGENCY = np.array([0, 0, 1, 1, 2, 0], dtype=np.int8)  # by mode code
_MODE_OF_RULE = np.array([_CODE[rule.mode] for rule in RULES], dtype=np.int8)
_SLOWEST_MPS = 1e-6  # slower than this is not closing at all
_NEAREST_M = 0.1  # a gap counts as at least this, so that the demand stays finite
_ACCELERATION_DELAY_S = 0.15  # until the acceleration has built up


def mode_code(mode: Mode | None) -> int:
    return NO_MODE if mode is None else _CODE[mode]


def side_code(side: Side) -> int:
    return _SIDE[side]


@dataclass(frozen=True, slots=True, kw_only=True)
class Facts:
    """What modes are chosen from: vectors over states, or scalars. Gaps [m] are infinite where nobody is, speeds [m/s] then unused.

    `front_seen`, `rear_seen`: a sensor covers that sector. `preferred_side`: +1 left, -1 right, 0 leaves it to the tie-break.
    The `previous_*` are of the cycle before (`NO_MODE` when there was none), `previous_age_s` since its mode began.
    """

    host_speed: Any
    desired_speed: Any
    front_seen: Any = True
    front_gap: Any = np.inf
    front_speed: Any = 0.0
    rear_seen: Any = True
    rear_gap: Any = np.inf
    rear_speed: Any = 0.0
    left_open: Any = False
    right_open: Any = False
    preferred_side: Any = 0
    park_requested: Any = False
    acceleration_mps2: Any = 3.0
    previous_mode: Any = NO_MODE
    previous_side: Any = 0
    previous_front_threat: Any = False
    previous_rear_threat: Any = False
    previous_warning: Any = False
    previous_age_s: Any = np.inf

    def broadcast(self) -> Facts:
        values = np.broadcast_arrays(*(np.atleast_1d(value) for value in _values(self)))
        return Facts(**dict(zip(_FACTS, values, strict=True)))


_FACTS = tuple(f.name for f in fields(Facts))
_values = attrgetter(*_FACTS)


class Selection(NamedTuple):
    """Vectors over states; codes index `MODES` and `SIDES`; `rule` indexes `RULES`, -1 where the mode before is kept."""

    mode: Codes
    side: Codes
    warning: Flags
    front_threat: Flags
    rear_threat: Flags
    rule: Codes


class Threat(NamedTuple):
    """One direction: threat, warning, the change of speed [m/s^2] that ends the closing within the gap, closing speed [m/s]."""

    threat: Flags
    warning: Flags
    demand: Array
    closing: Array


def closing_time(gap: Any, closing: Any, m: Any = np) -> Any:
    """Time to collision [s]: gap / closing speed, infinite where not closing or nobody is there, 0 where already touching."""
    positive = closing > _SLOWEST_MPS
    return m.where(positive, m.maximum(gap, 0.0) / m.where(positive, closing, 1.0), np.inf)


def conditions(f: Facts, front: Threat, rear: Threat, settings: SelectorSettings, m: Any = np) -> Conditions:
    """The rule table's conditions, of broadcast facts. A choice once made changes only past a margin (hysteresis)."""
    error = f.desired_speed - f.host_speed
    band = settings.speed_band_mps * m.where(f.previous_mode == _CRUISE, 0.5, 1.0)
    stay = m.where(f.previous_mode == _EVADE, settings.ttc_clear_s / settings.ttc_threat_s, 1.0)
    followed = m.logical_not(f.rear_seen) | (f.rear_gap <= settings.distance_rear_m * stay)
    needed = rear.closing * rear.closing / (2.0 * f.acceleration_mps2) + rear.closing * _ACCELERATION_DELAY_S
    clear_ahead = f.front_seen & (f.front_gap > settings.distance_front_long_m * stay)
    return Conditions(
        front=front.threat,
        rear=rear.threat,
        park=f.park_requested & _standing(f, settings, m),
        blind=m.logical_not(f.front_seen) & m.logical_not(f.rear_seen),
        at_speed=m.abs(error) <= band,
        unseen_ahead=(error > 0.0) & m.logical_not(f.front_seen),
        brakes=front.demand * stay <= m.where(followed, settings.braking_followed_mps2, settings.braking_enough_mps2),
        outruns=clear_ahead & (needed * stay <= f.rear_gap - settings.occupancy_gap_m),
        side=(f.left_open | f.right_open) & (f.host_speed * stay >= settings.evading_speed_mps),
        room=_room(f, settings, m),
    )


def select(facts: Facts, settings: SelectorSettings) -> Selection:
    """Exactly one mode for every state. Hysteresis: relaxed thresholds while threatened, and a mode lives `hold_s` unless things worsen."""
    f = facts.broadcast()
    front, rear, state = _seen(f, settings, np)
    rule = np.full(f.host_speed.shape, -1, dtype=np.int8)
    for number, row in enumerate(RULES):
        rule[row.applies(state)] = number
    chosen = _selected(f, front, rear, rule, settings, np)
    return chosen._replace(mode=chosen.mode.astype(np.int8), side=chosen.side.astype(np.int8), rule=chosen.rule.astype(np.int8))


def select_one(facts: Facts, settings: SelectorSettings) -> Selection:
    """`select` of a single state, its facts numbers: scalars out. The same rules, a hundredth of the time."""
    front, rear, state = _seen(facts, settings, one_state)
    return _selected(facts, front, rear, _rule_of(tuple(map(bool, state))), settings, one_state)


@lru_cache(maxsize=1 << len(Conditions._fields))
def _rule_of(state: tuple[bool, ...]) -> int:
    """The number of the rule that applies."""
    one = Conditions(*(np.array(holds) for holds in state))
    return next(number for number, row in enumerate(RULES) if row.applies(one))


def _seen(f: Facts, settings: SelectorSettings, m: Any) -> tuple[Threat, Threat, Conditions]:
    front = _threat(f.front_gap, f.host_speed - f.front_speed, settings.distance_front_short_m, f.previous_front_threat, f, settings, m)
    rear = _threat(f.rear_gap, f.rear_speed - f.host_speed, settings.distance_rear_m, f.previous_rear_threat, f, settings, m)
    return front, rear, conditions(f, front, rear, settings, m)


def _selected(f: Facts, front: Threat, rear: Threat, rule: Any, settings: SelectorSettings, m: Any) -> Selection:
    """The rules' choice, unless the mode before is kept."""
    mode = m.take(_MODE_OF_RULE, rule)
    kept = (mode != f.previous_mode) & _is_kept(f, front.threat, rear.threat, mode, settings, m)
    mode, rule = m.where(kept, f.previous_mode, mode), m.where(kept, _NO_RULE, rule)
    sandwiched = (f.front_gap <= settings.distance_front_long_m) & (f.rear_gap <= settings.distance_rear_m)
    warning = front.threat | rear.threat | front.warning | rear.warning | sandwiched
    return Selection(mode, _side(f, mode, settings, m), warning, front.threat, rear.threat, rule)


def _threat(gap: Any, closing: Any, distance: float, before: Any, f: Facts, settings: SelectorSettings, m: Any) -> Threat:
    """A threat closes in, and is soon there, or within Table 1's distance and near in time, or only a hard change of speed helps."""
    ratio = settings.ttc_clear_s / settings.ttc_threat_s
    relax = m.where(before, ratio, 1.0)
    closing = m.where(m.isfinite(gap), m.maximum(closing, 0.0), 0.0)
    time = closing_time(gap, closing, m)
    demand = closing * closing / (2.0 * m.maximum(gap, _NEAREST_M))
    near = (gap <= distance * relax) & (time < settings.ttc_warning_s * relax)
    soon = (time < settings.ttc_threat_s * relax) | near | (demand > settings.demand_threat_mps2 / relax)
    is_closing = closing > settings.closing_mps / relax
    warned = time < settings.ttc_warning_s * m.where(f.previous_warning, ratio, 1.0)
    return Threat(is_closing & soon, is_closing & warned, demand, closing)


def _is_kept(f: Facts, front: Any, rear: Any, mode: Any, settings: SelectorSettings, m: Any) -> Any:
    """Whether the mode before is kept: young, still admissible, and neither a new threat nor a more urgent mode."""
    before = f.previous_mode
    young = (before >= 0) & (f.previous_age_s < settings.hold_s)
    new = (front & m.logical_not(f.previous_front_threat)) | (rear & m.logical_not(f.previous_rear_threat))
    worse = new | (m.take(_URGENCY, mode) > m.take(_URGENCY, before))
    side_open = m.where(f.previous_side == _LEFT, f.left_open, m.where(f.previous_side == _RIGHT, f.right_open, False))
    admissible = m.select(
        [before == code for code in (_HOLD, _CRUISE, _BRAKE, _ACCELERATE, _EVADE, _PARK)],
        [
            m.logical_not(front) & m.logical_not(rear),
            m.logical_not(front) & m.logical_not(rear) & (f.front_seen | (f.desired_speed < f.host_speed)),
            front | True,
            m.logical_not(front) & _room(f, settings, m),
            side_open & (f.host_speed >= settings.evading_speed_mps),
            f.park_requested & _standing(f, settings, m) & m.logical_not(front) & m.logical_not(rear),
        ],
        False,
    )
    return young & m.logical_not(worse) & admissible


def _side(f: Facts, mode: Any, settings: SelectorSettings, m: Any) -> Any:
    """The open side of an evasion; with both open the side before, else the preferred one, else the tie-break."""
    tie = _RIGHT if settings.tie_break is Side.RIGHT else _LEFT
    preferred = m.where(f.preferred_side > 0, _LEFT, m.where(f.preferred_side < 0, _RIGHT, tie))
    evading = (f.previous_mode == _EVADE) & (f.previous_side != _NONE)
    preferred = m.where(evading, f.previous_side, preferred)
    side = m.where(f.left_open & f.right_open, preferred, m.where(f.left_open, _LEFT, _RIGHT))
    return m.where(mode == _EVADE, side, _NONE)


def _standing(f: Facts, settings: SelectorSettings, m: Any) -> Any:
    return m.abs(f.host_speed) <= settings.standstill_mps


def _room(f: Facts, settings: SelectorSettings, m: Any) -> Any:
    stay = m.where(f.previous_mode == _ACCELERATE, settings.ttc_clear_s / settings.ttc_threat_s, 1.0)
    return f.front_seen & (f.front_gap * stay > settings.accelerating_room_m)
