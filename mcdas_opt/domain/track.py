"""A tracked neighbour, and which directions the sensors can vouch for."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from mcdas_opt.domain.equality import EqualByValue
from mcdas_opt.domain.rules import (
    FARTHEST_M,
    FASTEST_MPS,
    Array,
    angle,
    as_floats,
    covariance,
    floats,
    is_text,
    non_negative,
    positive,
    require_type,
    true_or_false,
    within,
    word,
)
from mcdas_opt.domain.vocabulary import BodyKind, Sector
from mcdas_opt.errors import ParameterError

HARDEST_MPS2 = 1e4  # beyond is no number of traffic
FASTEST_TURN_RADPS = 1e3  # nor this
ALIGNED_RAD = math.radians(20.0)  # who is turned no farther from the road's direction, or the opposite one, follows the road
CROSSING_MPS = 1.0
_CREEPING_MPS, _ASLANT_M = 1.5, 0.25  # who is slower stays as he is turned; what his body then takes to either side counts from so much on
_SEEN_MPS2, _SEEN_SIGMAS = 1.0, 2.0  # braking that is seen, and in standard deviations
_AT_ONCE_M = 0.5  # who brakes to a standstill within so much is about to stand
Places = tuple[tuple[float, float], ...]  # (s, d) each [m]
_MOST_PLACES = 1000
LONGEST_M = 1000.0  # of a body: a long train, or a wall
_AS_A_CAR_M = (4.5, 1.8)
USUAL_SIZE_M = {
    BodyKind.PEDESTRIAN: (0.5, 0.5),
    BodyKind.BICYCLE: (1.8, 0.6),
    BodyKind.MOTORCYCLE: (2.2, 0.8),
    BodyKind.LORRY: (12.0, 2.5),  # the longest without a trailer that European directive 96/53/EC allows; the others are assumed
}
_SINE_ALIGNED = math.sin(ALIGNED_RAD)
_NUMBERS = ("s_m", "d_m", "speed_s_mps", "speed_d_mps", "age_s", "acceleration_s_mps2", "acceleration_d_mps2", "turn_rate_radps")
_ACCELERATIONS = ("acceleration_s_mps2", "acceleration_d_mps2"), ("acceleration_s_sd_mps2", "acceleration_d_sd_mps2")


class AlongHeading(NamedTuple):
    """In the direction of a heading: the acceleration, its standard deviation, and the speed."""

    acceleration_mps2: float
    sd_mps2: float
    speed_mps: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Track(EqualByValue):
    """Body centre and velocity of a neighbour along (s) and across (d) the road, with their covariance.

    `covariance` is 4 x 4 in the order (s, s speed, d, d speed), units m and m/s; left out it is zero: known exactly. Plans take it so:
    bodies are grown by 2.5 standard deviations of the place as it is now and in the first second to come, but never by more than 3 m along
    and 0.5 m across (`PredictionSettings`; a larger gap would close every lane); a speed across the road that it does not make clear is no
    lane change, and counts less; jumps and overlaps within 3 standard deviations are no doubts. Beyond 1.2 m of standard deviation
    along, and 0.2 m across, nothing grows any more, and no doubt says so: leave out a track that is known no better.
    `age_s` [s] and `coasting` (no sensor has shown it of late) are for pictures and logs: no plan depends on them.

    `acceleration_s_mps2` is its acceleration along the road with a standard deviation, `acceleration_d_mps2` that across it, to the left;
    without one (None) it is not known, and the number says nothing. That across counts of who does not follow the road alone.

    `heading_rad` is where it points, relative to the road there (0 along it, pi towards the host, pi / 2 across it to the left). Who is
    turned by more than `ALIGNED_RAD` does not follow the road; nor does a pedestrian. Who stands, or creeps, with less is taken as it is
    turned: a lorry across the line does not straighten there. None: not known, it counts as aligned with the road.
    At most a full turn; beyond half a turn it is counted the other way round.
    `turn_rate_radps` is how fast it turns in the plane, to the left, with a standard deviation; without one (None) it is not known, and
    the number says nothing.
    `lane_path_m`, two to a thousand places (s, d), is the middle of the lane that it is in, from where it is, or before, to where it
    is not known any more which lane it takes; a map tells. Who does not follow the road is then predicted to follow its lane; so is, in a
    lane that leads elsewhere, slowly enough for its bends, who comes towards the host, or keeps to it where the road turns as tightly as
    at a crossing; and nobody is predicted to leave it where the road turns. None: not known.
    `length_m` and `width_m` [m], where they are not said, are those of its `kind`: pedestrian 0.5 x 0.5, bicycle 1.8 x 0.6, motorcycle
    2.2 x 0.8, lorry 12 x 2.5 (the longest without a trailer that directive 96/53/EC allows), every other 4.5 x 1.8. But for the lorry's
    length they are assumed; what is said counts.

    Raises `ParameterError` that names the track, the field and its rule.
    """

    id: str
    s_m: float
    d_m: float
    speed_s_mps: float
    speed_d_mps: float = 0.0
    covariance: Array = field(default_factory=lambda: np.zeros((4, 4)))
    length_m: float = None  # type: ignore[assignment]  # as its kind is long; a number in every track that there is
    width_m: float = None  # type: ignore[assignment]
    age_s: float = 0.0
    coasting: bool = False
    acceleration_s_mps2: float = 0.0
    acceleration_s_sd_mps2: float | None = None
    heading_rad: float | None = None
    kind: BodyKind | None = None
    turn_rate_radps: float = 0.0
    turn_rate_sd_radps: float | None = None
    acceleration_d_mps2: float = 0.0
    acceleration_d_sd_mps2: float | None = None
    lane_path_m: Places | None = None

    def __hash__(self) -> int:  # type: ignore[override]  # unlike others of its kind it can be hashed
        return hash((self.id, self.s_m, self.d_m, self.speed_s_mps, self.speed_d_mps))

    def __post_init__(self) -> None:
        require_type("id", self.id, str)
        if not is_text(self.id):
            raise ParameterError("id", self.id, "must be text: it holds half of a surrogate pair")
        self._or_by_name(self._checked)

    def _or_by_name(self, check: Callable[[], None]) -> None:
        try:
            check()
        except ParameterError as error:
            raise ParameterError(error.name, error.value, error.rule, error.unit, of=f"track {self.id!r}") from None

    def _checked(self) -> None:
        as_floats(self, _NUMBERS)
        self._check_place()
        if max(abs(self.speed_s_mps), abs(self.speed_d_mps)) > FASTEST_MPS:
            for name in ("speed_s_mps", "speed_d_mps"):
                within(name, attrgetter(name)(self), -FASTEST_MPS, FASTEST_MPS, "m/s")
        for name, sd_name in zip(*_ACCELERATIONS, strict=True):
            within(name, attrgetter(name)(self), -HARDEST_MPS2, HARDEST_MPS2, "m/s^2")
            if attrgetter(sd_name)(self) is not None:
                within(sd_name, attrgetter(sd_name)(self), 0.0, HARDEST_MPS2, "m/s^2")
        within("turn_rate_radps", self.turn_rate_radps, -FASTEST_TURN_RADPS, FASTEST_TURN_RADPS, "rad/s")
        if self.turn_rate_sd_radps is not None:
            within("turn_rate_sd_radps", self.turn_rate_sd_radps, 0.0, FASTEST_TURN_RADPS, "rad/s")
        non_negative("age_s", self.age_s, "s")
        true_or_false("coasting", self.coasting)
        if self.heading_rad is not None:
            heading = angle("heading_rad", self.heading_rad)
            object.__setattr__(self, "heading_rad", heading if abs(heading) <= math.pi else math.remainder(heading, 2.0 * math.pi))
        if self.kind is not None and type(self.kind) is not BodyKind:
            object.__setattr__(self, "kind", word("kind", self.kind, BodyKind))
        if self.length_m is None or self.width_m is None:
            self._sized_as_usual()
        positive("length_m", self.length_m, "m")
        positive("width_m", self.width_m, "m")
        if max(self.length_m, self.width_m) > LONGEST_M:
            within("length_m", self.length_m, 0.0, LONGEST_M, "m")
            within("width_m", self.width_m, 0.0, LONGEST_M, "m")
        object.__setattr__(self, "covariance", covariance("covariance", self.covariance, 4))
        if self.lane_path_m is not None:
            object.__setattr__(self, "lane_path_m", _path("lane_path_m", self.lane_path_m))

    def _check_place(self) -> None:
        if not (abs(self.s_m) <= 2.0 * FARTHEST_M and abs(self.d_m) <= 2.0 * FARTHEST_M):
            for name in ("s_m", "d_m"):
                within(name, attrgetter(name)(self), -2.0 * FARTHEST_M, 2.0 * FARTHEST_M, "m")  # a host at the farthest place sees ahead

    def _sized_as_usual(self) -> None:
        usual = _AS_A_CAR_M if self.kind is None else USUAL_SIZE_M.get(self.kind, _AS_A_CAR_M)
        for name, usual_m in zip(("length_m", "width_m"), usual, strict=True):
            if attrgetter(name)(self) is None:
                object.__setattr__(self, name, usual_m)

    @property
    def is_turned(self) -> bool:
        """Whether it points so far off the road's direction that it does not follow the road."""
        return self.heading_rad is not None and abs(math.sin(self.heading_rad)) > _SINE_ALIGNED

    @property
    def braking_seen_mps2(self) -> float:
        """What it is clearly seen to brake with, else 0."""
        sd, braking = self.acceleration_s_sd_mps2, -self.acceleration_s_mps2
        return braking if sd is not None and braking > max(_SEEN_MPS2, _SEEN_SIGMAS * sd) else 0.0

    @property
    def along_heading(self) -> AlongHeading | None:
        """How a vehicle moves in the direction of its heading; None where that or its acceleration is not known, and of people on foot."""
        along, across, heading = self.acceleration_s_sd_mps2, self.acceleration_d_sd_mps2, self.heading_rad
        if along is None or across is None or heading is None or self.kind is BodyKind.PEDESTRIAN:
            return None
        c, s = math.cos(heading), math.sin(heading)
        return AlongHeading(
            acceleration_mps2=c * self.acceleration_s_mps2 + s * self.acceleration_d_mps2,
            sd_mps2=math.hypot(c * along, s * across),
            speed_mps=c * self.speed_s_mps + s * self.speed_d_mps,
        )

    @property
    def slowing_mps2(self) -> float:
        """What a vehicle that drives forwards is clearly seen to brake with, wherever it goes, else 0."""
        ahead = self.along_heading
        if ahead is None or ahead.speed_mps <= 0.0:
            return 0.0
        braking = -ahead.acceleration_mps2
        return braking if braking > max(_SEEN_MPS2, _SEEN_SIGMAS * ahead.sd_mps2) else 0.0

    @property
    def stopping_s(self) -> float:
        """How long a vehicle that clearly slows down takes until it stands; 0 of any other."""
        rate = self.slowing_mps2
        return math.hypot(self.speed_s_mps, self.speed_d_mps) / rate if rate > 0.0 else 0.0

    @property
    def is_about_to_stand(self) -> bool:
        """Whether it clearly slows down, and stands at once."""
        return 0.0 < 0.5 * math.hypot(self.speed_s_mps, self.speed_d_mps) * self.stopping_s <= _AT_ONCE_M

    @property
    def follows_road(self) -> bool:
        """Whether it is believed to go on along the road."""
        return not self.is_turned and self.kind is not BodyKind.PEDESTRIAN

    @property
    def crosses(self) -> bool:
        """Whether it goes across the road, out of every lane that it is in: nobody drives behind it, or before it."""
        return self.is_turned and abs(self.speed_d_mps) > CROSSING_MPS

    @property
    def lies_aslant(self) -> bool:
        """Whether its body has to be taken as it is turned: it does not follow the road, or it hardly moves and reaches clearly farther
        across the road than it is wide."""
        if self.heading_rad is None:
            return False
        sine = abs(math.sin(self.heading_rad))
        if sine > _SINE_ALIGNED:
            return True
        if self.length_m * sine - self.width_m * (1.0 - math.sqrt(1.0 - sine * sine)) <= 2.0 * _ASLANT_M:
            return False
        return math.hypot(self.speed_s_mps, self.speed_d_mps) < _CREEPING_MPS or self.is_about_to_stand

    @property
    def along_m(self) -> float:
        """How much of the road's length its body takes, as it is turned."""
        if self.heading_rad is None or not self.lies_aslant:
            return self.length_m
        return self.length_m * abs(math.cos(self.heading_rad)) + self.width_m * abs(math.sin(self.heading_rad))

    @property
    def across_m(self) -> float:
        """How much of the road's width its body takes, as it is turned."""
        if self.heading_rad is None or not self.lies_aslant:
            return self.width_m
        return self.length_m * abs(math.sin(self.heading_rad)) + self.width_m * abs(math.cos(self.heading_rad))

    def seen_from(self, s_m: float) -> Track:
        """The same with its s counted from `s_m`."""
        if s_m == 0.0:
            return self
        there = self.moved_to(self.s_m - s_m, self.d_m)
        if self.lane_path_m is not None:
            object.__setattr__(there, "lane_path_m", tuple((s - s_m, d) for s, d in self.lane_path_m))
        return there

    def later(self, by_s: float) -> Track:
        """The same where it is so long after, at its speed."""
        return self.moved_to(self.s_m + by_s * self.speed_s_mps, self.d_m + by_s * self.speed_d_mps)

    def moved_to(self, s_m: float, d_m: float) -> Track:
        """The same in another place: only that is checked anew."""
        there = object.__new__(Track)
        for name in Track.__slots__:
            object.__setattr__(there, name, getattr(self, name))
        object.__setattr__(there, "s_m", s_m)
        object.__setattr__(there, "d_m", d_m)
        there._or_by_name(there._check_place)
        return there


def _path(name: str, value: object) -> Places:
    """`value` as places, one after the other."""
    rule = f"must be two to {_MOST_PLACES} places (s, d), none twice in a row"
    path = floats(name, value, rule)
    if path.ndim != 2 or not 2 <= path.shape[0] <= _MOST_PLACES or path.shape[1] != 2:
        raise ParameterError(name, f"shape {path.shape}", rule)
    for s, d in path[~(np.abs(path) <= 2.0 * FARTHEST_M).all(axis=1)].tolist():  # NaN is no number within
        raise ParameterError(name, f"({s:g}, {d:g})", f"must be places of numbers within {2.0 * FARTHEST_M:g}", "m")
    for s, d in path[1:][~np.any(np.diff(path, axis=0), axis=1)].tolist():
        raise ParameterError(name, f"({s:g}, {d:g})", rule)
    return tuple((s, d) for s, d in path.tolist())


@dataclass(frozen=True, slots=True, kw_only=True)
class Coverage:
    """Which sectors a working sensor watches. A sector that nobody watches counts as occupied, never as empty.

    `front`: everybody ahead of the front bumper, `rear`: everybody behind the rear bumper, both in every lane, as far as a radar sees.
    `left`, `right`: whoever is beside the host's body there. Who comes from behind in the next lane is in `rear`, so a change to the left
    needs `left` and `rear`.
    """

    front: bool = True
    rear: bool = True
    left: bool = True
    right: bool = True

    def __post_init__(self) -> None:
        for name in ("front", "rear", "left", "right"):
            value = attrgetter(name)(self)
            if type(value) is not bool:
                object.__setattr__(self, name, true_or_false(name, value))

    def sees(self, sector: Sector) -> bool:
        match sector:
            case Sector.FRONT:
                return self.front
            case Sector.REAR:
                return self.rear
            case Sector.LEFT:
                return self.left
            case Sector.RIGHT:
                return self.right
