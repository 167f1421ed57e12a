"""What the situation means: roles, times to collision, threats, the mode that they call for."""

from __future__ import annotations

from dataclasses import dataclass, field

from mcdas_opt.domain.vocabulary import Mode, Role, Sector, Side


@dataclass(frozen=True, slots=True, kw_only=True)
class Assessment:
    """Facts about a situation, each from geometry and the tracks alone.

    Gaps are bumper to bumper [m], infinite when nobody is there; times to collision are infinite when not closing.
    `occupied` holds the sectors where a steering manoeuvre is blocked (a car there, no lane, or nobody watches).
    Ahead of a host with no `front_id` and a gap is the end of the road, or with `lane_ends` that of its lane.
    `literal_mode` is the row of the paper's Table 1 that matches, None when none does. `lane` is the lane that left and right are
    counted from (held while an evasion lasts), `since_s` the time at which the mode began.
    """

    roles: dict[str, Role] = field(default_factory=dict)
    front_id: str | None = None
    rear_id: str | None = None
    front_gap_m: float = float("inf")
    rear_gap_m: float = float("inf")
    front_speed_mps: float | None = None
    lane_ends: bool = False
    rear_speed_mps: float | None = None
    ttc_front_s: float = float("inf")
    ttc_rear_s: float = float("inf")
    offset_m: float = 0.0
    occupied: frozenset[Sector] = frozenset()
    threats: frozenset[Sector] = frozenset()
    mode: Mode = Mode.HOLD
    side: Side = Side.NONE
    warning: bool = False
    literal_mode: str | None = None
    reason: str = ""
    lane: int = 0
    since_s: float = 0.0

    @property
    def threatened(self) -> bool:
        return bool(self.threats)
