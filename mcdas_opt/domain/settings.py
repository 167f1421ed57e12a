"""Every setting of the planner, in one frozen record, with its unit."""

from __future__ import annotations

from dataclasses import dataclass, field

from mcdas_opt.domain.grid import TimeGrid
from mcdas_opt.domain.vocabulary import Side


@dataclass(frozen=True, slots=True, kw_only=True)
class SelectorSettings:
    """When a neighbour is a threat. Distances of the paper's Table 1 stand beside times to collision."""

    ttc_threat_s: float = 5.0
    ttc_clear_s: float = 6.5  # hysteresis: a threat once seen ends above this
    ttc_warning_s: float = 7.0
    distance_rear_m: float = 25.0  # d_pr
    distance_front_short_m: float = 25.0  # d_spf
    distance_front_long_m: float = 35.0  # d_lpf
    closing_mps: float = 0.5  # slower than this is not closing
    hold_s: float = 0.5  # a mode lives at least this long, a worse threat excepted
    tie_break: Side = Side.LEFT


@dataclass(frozen=True, slots=True, kw_only=True)
class PredictionSettings:
    """How far a track's uncertainty is planned with (not the tracker's process noise: it would close every gap there is)."""

    sigmas: float = 2.5
    growth_s: float = 1.0
    cap_along_m: float = 3.0
    cap_across_m: float = 0.5
    lateral_fade_s: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class SigmoidSettings:
    """The closed form. Literal values are the paper's Table 4; the corrected a follows from speed and `lateral_acceleration_mps2`."""

    a_per_m: float = -0.4
    b: float = 50.0
    y_max_m: float = 3.7
    lateral_acceleration_mps2: float = 4.0
    lateral_friction_share: float = 0.6  # of mu g, where that is less
    speed_floor_mps: float = 3.0  # a*(v) below this speed is that of this speed


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """Groups of settings; a user replaces what differs: `replace(settings, cycle_s=0.05)`."""

    cycle_s: float = 0.1
    grid: TimeGrid = field(default_factory=TimeGrid)
    selector: SelectorSettings = field(default_factory=SelectorSettings)
    prediction: PredictionSettings = field(default_factory=PredictionSettings)
    sigmoid: SigmoidSettings = field(default_factory=SigmoidSettings)
