"""The facts that a planner is given: host, tracks, coverage, road, time, and what the driver wants."""

from __future__ import annotations

import json
import warnings
from dataclasses import dataclass, field
from typing import Any

from mcdas_opt.domain.destination import Destination
from mcdas_opt.domain.document import SCHEMA_VERSION, from_document, to_document
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.parsing import parsed_json
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import FARTHEST_M, FASTEST_MPS, all_of, finite, non_negative, require_type, within, word
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.domain.vocabulary import Request, Sector, Side
from mcdas_opt.errors import InputError, ParameterError

MOST_TRACKS = 256  # planned around, and kept by a tracker: turned and in one place they take a second or so


def _unsaid() -> Coverage:
    warnings.warn(
        "coverage: which sectors does a working sensor watch? Unsaid, none is taken for watched. Coverage() where all four are, else "
        "Coverage(rear=False, ...)",
        UserWarning,
        stacklevel=3,
    )
    return Coverage(front=False, rear=False, left=False, right=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Situation:
    """Everything a plan may depend on, of at most 256 tracks. `road.friction` is the friction that the planner assumes.

    `coverage` says which sectors a working sensor watches: "nothing there" and "cannot see" are different. Where it is left out nobody
    watches anywhere, and a `UserWarning` says so.
    `vehicle` names the host's car (a shipped vehicle or a path; None: whichever the planner has, the sedan where it has none);
    `desired_speed_mps` defaults to the host's speed: in a loop, to what it is in that cycle, so that who was slowed down stays slow.
    `destination`: where to be, and when, if that matters; times are those of `time_s`.
    `stop_line_s_m` is where the front bumper is to wait now, as at a red light or for who has the right of way: a host that nobody presses
    stops before it as is comfortable. It is no wall: who closes in from behind may be escaped from across it. None: it need not wait.
    """

    time_s: float = 0.0
    host: HostState
    tracks: tuple[Track, ...] = ()
    coverage: Coverage = field(default_factory=_unsaid)
    road: Road = field(default_factory=Road)
    vehicle: str | None = None
    desired_speed_mps: float | None = None
    request: Request = Request.DRIVE
    destination: Destination | None = None
    stop_line_s_m: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "time_s", finite("time_s", self.time_s, "s"))
        require_type("host", self.host, HostState)
        require_type("coverage", self.coverage, Coverage)
        require_type("road", self.road, Road)
        if self.vehicle is not None:
            require_type("vehicle", self.vehicle, str)
        if self.destination is not None:
            require_type("destination", self.destination, Destination)
        if self.stop_line_s_m is not None:
            object.__setattr__(self, "stop_line_s_m", within("stop_line_s_m", self.stop_line_s_m, -2.0 * FARTHEST_M, 2.0 * FARTHEST_M, "m"))
        object.__setattr__(self, "tracks", all_of("tracks", self.tracks, Track))
        if len(self.tracks) > MOST_TRACKS:
            raise ParameterError("tracks", len(self.tracks), f"must be at most {MOST_TRACKS}: a planner's work is bounded")
        if type(self.request) is not Request:
            object.__setattr__(self, "request", word("request", self.request, Request))
        within("host.s_m", self.host.s_m, -FARTHEST_M, FARTHEST_M, "m")
        non_negative("host.speed_mps", self.host.speed_mps, "m/s")
        wanted = self.host.speed_mps if self.desired_speed_mps is None else self.desired_speed_mps
        object.__setattr__(self, "desired_speed_mps", non_negative("desired_speed_mps", wanted, "m/s"))
        if self.wanted_speed_mps > FASTEST_MPS:
            within("desired_speed_mps", self.wanted_speed_mps, 0.0, FASTEST_MPS, "m/s")
        ids = [track.id for track in self.tracks]
        if len(set(ids)) != len(ids):
            twice = next(i for i in ids if ids.count(i) > 1)
            raise ParameterError("tracks.id", twice, "must be unique")

    @property
    def vehicle_name(self) -> str:
        """Of the host's car, where somebody needs one: the sedan where none is said."""
        return self.vehicle or "sedan"

    @property
    def host_lane(self) -> int:
        """The lane that the host's middle is in, counted as `Road.lane_of` does."""
        return self.road.lane_of(self.host.d_m, self.host.s_m)

    def track(self, track_id: str | None) -> Track | None:
        """Who has this id; None where nobody does."""
        return next((track for track in self.tracks if track.id == track_id), None)

    def lane_beside(self, side: Side) -> int:
        """The next lane on a side, as it is counted; whether the road has it is another question."""
        return self.host_lane + side.sign

    def sees_lane(self, side: Side) -> bool:
        """Whether the next lane on a side is watched: beside the host by that sector, and behind it, where somebody may come in it, by the
        rear one. From a lane of oncoming traffic the host comes back though nobody watches behind."""
        beside = self.coverage.sees(Sector(side.value))
        return beside and (self.coverage.rear or self.road.is_for_others(self.host_lane))

    def shares_lane(self, track: Track) -> bool:
        """Whether a track moves along the road, its middle within half a lane of the host's."""
        return track.follows_road and abs(track.d_m - self.host.d_m) < 0.5 * self.road.lane_width_m

    @property
    def wanted_speed_mps(self) -> float:
        assert self.desired_speed_mps is not None
        return self.desired_speed_mps

    def to_dict(self) -> dict[str, Any]:
        return {"schema_version": SCHEMA_VERSION, **to_document(self)}

    def to_json(self) -> str:
        return json.dumps(self.to_dict(), allow_nan=False)

    @classmethod
    def from_json(cls, text: str, file: object = "situation") -> Situation:
        """From a JSON document; raises `InputError` that names `file`, key, value and rule. Which sectors are watched has to be said:
        "nothing there" and "cannot see" are different."""
        require_type("text", text, str)
        document = parsed_json(text, file)
        if isinstance(document, dict):
            said = document.get("coverage")
            for sector in Sector:
                if said is None or (isinstance(said, dict) and sector.value not in said):
                    raise InputError(file, f"coverage.{sector.value}", None, "missing key: whether a working sensor watches it")
        return from_document(cls, document, file)
