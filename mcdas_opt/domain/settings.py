"""Every setting of the planner, in one frozen record, with its unit."""

from __future__ import annotations

from dataclasses import dataclass, field

from mcdas_opt.domain.comfort import ComfortSettings
from mcdas_opt.domain.grid import TimeGrid
from mcdas_opt.domain.manners import MannersSettings
from mcdas_opt.domain.rules import at_most, bounded, finite, measurable, negative, require, require_type, true_or_false, within, word
from mcdas_opt.domain.safe_end import SafeEndSettings
from mcdas_opt.domain.sigmoid_design import SigmoidDesign
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.errors import ParameterError


@dataclass(frozen=True, slots=True, kw_only=True)
class SelectorSettings:
    """When a neighbour is a threat. Distances of the paper's Table 1 stand beside times to collision.

    While something is a threat, every threshold of its threat rule is relaxed by ttc_clear_s / ttc_threat_s.
    """

    ttc_threat_s: float = 5.0
    ttc_clear_s: float = 6.5  # hysteresis: a threat once seen ends above this
    ttc_warning_s: float = 7.0
    distance_rear_m: float = 25.0  # d_pr
    distance_front_short_m: float = 25.0  # d_spf
    distance_front_long_m: float = 35.0  # d_lpf
    closing_mps: float = 0.5  # slower than this is not closing
    hold_s: float = 0.5  # a mode lives at least this long, a worse threat excepted
    tie_break: Side = Side.LEFT
    demand_threat_mps2: float = 2.0  # v_rel^2 / (2 gap) above this is a threat at any time to collision
    braking_enough_mps2: float = 5.0  # a front threat that asks for more is evaded, if a side is open
    braking_followed_mps2: float = 3.0  # the same with somebody close behind, or with nobody watching there
    accelerating_room_m: float = 10.0  # boxed in, the host still closes up to this gap
    speed_band_mps: float = 0.5  # nearer to the desired speed than this is holding it
    evading_speed_mps: float = 2.0  # slower than this a car cannot swerve
    standstill_mps: float = 0.1
    lane_intrusion_m: float = 0.3  # a body this far inside a lane is in it
    swept_margin_m: float = 0.2  # so is one this close to the width that the host's body sweeps
    beside_m: float = 60.0  # in a next lane within this distance: role left or right
    occupancy_s: float = 1.0  # a car in the target lane that gets within occupancy_gap_m in this time blocks the side
    occupancy_gap_m: float = 1.0

    def __post_init__(self) -> None:
        require(self, measurable, "ttc_threat_s", "ttc_clear_s", "ttc_warning_s")
        require(self, measurable, "demand_threat_mps2", "braking_enough_mps2", "braking_followed_mps2")
        require(self, bounded, "distance_rear_m", "distance_front_short_m", "distance_front_long_m", "closing_mps", "hold_s")
        require(self, bounded, "accelerating_room_m", "speed_band_mps", "evading_speed_mps", "standstill_mps", "lane_intrusion_m")
        require(self, bounded, "swept_margin_m", "beside_m", "occupancy_s", "occupancy_gap_m")
        if type(self.tie_break) is not Side:
            object.__setattr__(self, "tie_break", word("tie_break", self.tie_break, Side))
        at_most("ttc_threat_s", self.ttc_threat_s, "ttc_clear_s", self.ttc_clear_s)
        at_most("distance_front_short_m", self.distance_front_short_m, "distance_front_long_m", self.distance_front_long_m)


@dataclass(frozen=True, slots=True, kw_only=True)
class PredictionSettings:
    """How far a track's uncertainty is planned with (not the tracker's process noise: it would close every gap there is).

    A body grows by `sigmas` standard deviations of its place, as it is now and within the first `growth_s`, by no more than `cap_along_m`
    along the road and `cap_across_m` across. Its speed across fades with the time constant `lateral_fade_s`.
    """

    sigmas: float = 2.5
    growth_s: float = 1.0
    cap_along_m: float = 3.0
    cap_across_m: float = 0.5
    lateral_fade_s: float = 1.0

    def __post_init__(self) -> None:
        require(self, bounded, "sigmas", "growth_s", "cap_along_m", "cap_across_m")
        measurable("lateral_fade_s", self.lateral_fade_s, "s")


@dataclass(frozen=True, slots=True, kw_only=True)
class SigmoidSettings:
    """The closed form. Literal values are the paper's Table 4; the corrected a follows from speed and `lateral_acceleration_mps2`.

    A `given` design takes the place of the corrected path that would follow from the speed: its a, b and reach stand as they are.
    """

    a_per_m: float = -0.4
    b: float = 50.0
    y_max_m: float = 3.7
    lateral_acceleration_mps2: float = 4.0
    lateral_friction_share: float = 0.6  # of mu g, where that is less
    speed_floor_mps: float = 3.0  # a*(v) below this speed is that of this speed
    given: SigmoidDesign | None = None

    def __post_init__(self) -> None:
        negative("a_per_m", self.a_per_m, "1/m")
        if not finite("b", self.b) > 1.0:
            raise ParameterError("b", self.b, "must be greater than 1")
        require(self, measurable, "y_max_m", "lateral_acceleration_mps2", "speed_floor_mps")
        within("lateral_friction_share", self.lateral_friction_share, 0.05, 1.0)
        if self.given is not None:
            require_type("given", self.given, SigmoidDesign)


@dataclass(frozen=True, slots=True, kw_only=True)
class WarningSettings:
    """When the driver is warned and when the car acts by itself: a carmaker's to choose. Both come from the escape map (times to react).

    A candidate is comfortable if it asks no more of the tyres than `comfort_mps2` and `comfort_share` of the grip. Nobody is acted for
    unwarned: an alert grows by one step a cycle. Without `escapes` there is no map, and no alert.
    """

    escapes: bool = True
    comfort_mps2: float = 3.0
    comfort_share: float = 0.7
    warn_lead_s: float = 0.0  # warn when the last comfortable moment is no farther away than this
    act_lead_s: float = 0.2  # act when the last possible moment is no farther away than this
    within_s: float = 4.0  # neither where constant inputs meet nobody so soon

    def __post_init__(self) -> None:
        true_or_false("warning.escapes", self.escapes)
        measurable("warning.comfort_mps2", self.comfort_mps2, "m/s^2")
        within("warning.comfort_share", self.comfort_share, 0.05, 1.0)
        require(self, bounded, "warn_lead_s", "act_lead_s", "within_s", of="warning")


LEAST_SHARE = 0.65  # of the time gap that is asked for; then 0.8 s where that is 1.2 s


@dataclass(frozen=True, slots=True, kw_only=True)
class HeadwaySettings:
    """The gap to the front car that is driven: `standstill_m` and `time_gap_s` times the own speed (ISO 15622 asks for at least 0.8 s).

    A smaller gap that was found opens: the time gap asked for grows by `opening` seconds a second, from what braking by `braking_mps2`
    leaves of it; both sooner where the host itself took the gap. While somebody closes in from behind no more than `pressed_s` is asked
    for: headway gives way first.
    """

    time_gap_s: float = 1.2
    standstill_m: float = 2.0
    opening: float = 0.1
    braking_mps2: float = 1.2
    pressed_s: float = 0.05

    def __post_init__(self) -> None:
        require(self, measurable, "time_gap_s", "standstill_m", "opening", "braking_mps2", "pressed_s", of="headway")
        at_most("headway.pressed_s", self.pressed_s, "headway.time_gap_s", self.time_gap_s)

    def gap_m(self, speed_mps: float, share: float = 1.0) -> float:
        """The gap at that own speed, with that share of the time gap."""
        return self.standstill_m + share * self.time_gap_s * max(speed_mps, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """Groups of settings; a user replaces what differs: `replace(settings, cycle_s=0.05)`."""

    cycle_s: float = 0.1
    steering_rate_share: float = 1.0  # of the limit that the MPC plans with; the judge allows the whole
    lateral_jerk_mps3: float = 30.0  # up to which it steers a car that slips faster than that share: slow cars ask little of their tyres
    friction_share: float = 1.0  # of what it takes of the friction circle: the judge allows the whole of that too
    speed_limit_excess: float = 0.0  # share (0.05: 5 %) by which ordinary driving may exceed the speed limit; escaping from behind may more
    edge_reserve_m: float = 0.0  # kept from the road's edges by the MPC where it can, beyond its margin: the judge allows all of the road
    grid: TimeGrid = field(default_factory=TimeGrid)
    selector: SelectorSettings = field(default_factory=SelectorSettings)
    prediction: PredictionSettings = field(default_factory=PredictionSettings)
    sigmoid: SigmoidSettings = field(default_factory=SigmoidSettings)
    headway: HeadwaySettings = field(default_factory=HeadwaySettings)
    comfort: ComfortSettings = field(default_factory=ComfortSettings)
    manners: MannersSettings = field(default_factory=MannersSettings)
    safe_end: SafeEndSettings = field(default_factory=SafeEndSettings)
    warning: WarningSettings = field(default_factory=WarningSettings)

    def __post_init__(self) -> None:
        within("cycle_s", self.cycle_s, 1e-3, 10.0, "s")
        require_type("grid", self.grid, TimeGrid)
        require_type("selector", self.selector, SelectorSettings)
        require_type("prediction", self.prediction, PredictionSettings)
        require_type("sigmoid", self.sigmoid, SigmoidSettings)
        require_type("headway", self.headway, HeadwaySettings)
        require_type("comfort", self.comfort, ComfortSettings)
        require_type("manners", self.manners, MannersSettings)
        require_type("safe_end", self.safe_end, SafeEndSettings)
        require_type("warning", self.warning, WarningSettings)
        within("steering_rate_share", self.steering_rate_share, 0.05, 1.0)
        within("friction_share", self.friction_share, 0.1, 1.0)
        require(self, bounded, "lateral_jerk_mps3", "edge_reserve_m")
        if not 0.0 <= finite("speed_limit_excess", self.speed_limit_excess) <= 1.0:
            raise ParameterError("speed_limit_excess", self.speed_limit_excess, "must lie in [0, 1], a share: 0.05 is 5 %?")
