"""What a cycle has seen of the others that the next one has to know, whatever was planned."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from mcdas_opt.domain.doubt import SupposedTrack
from mcdas_opt.domain.track import Track
from mcdas_opt.planning.front.blind_ahead import BlindAhead
from mcdas_opt.planning.front.front_deficit import FrontDeficit
from mcdas_opt.planning.front.front_gap import CutIn
from mcdas_opt.planning.lanes.lane_choice import LaneChoice
from mcdas_opt.situation.passed_in_lane import PassedInLane


@dataclass(frozen=True, slots=True, kw_only=True)
class Observed:
    """`tracks`: what was told, before any doubt. `supposed`: whose track has jumped away. `deficits`: who is ahead, and what front distance
    is owed to whom. `cut_in`: who came in between lately. `lane_choice`: what lane is wanted. `attentive`: who keeps his distance behind.
    `passed`: who stands at the lane's side and is passed within it, and how far aside. `blind_ahead`: nobody watches ahead; None:
    somebody does.
    """

    tracks: tuple[Track, ...] = ()
    supposed: tuple[SupposedTrack, ...] = ()
    deficits: tuple[FrontDeficit, ...] = ()
    cut_in: CutIn | None = None
    lane_choice: LaneChoice = field(default_factory=LaneChoice)
    attentive: frozenset[str] = frozenset()
    passed_in_lane: PassedInLane | None = None
    blind_ahead: BlindAhead | None = None

    def seen_from(self, s_m: float) -> Observed:
        """The same with every s counted from `s_m`."""
        if s_m == 0.0:
            return self
        tracks = tuple(track.seen_from(s_m) for track in self.tracks)
        blind = None if self.blind_ahead is None else self.blind_ahead.seen_from(s_m)
        return replace(self, tracks=tracks, supposed=tuple(one.seen_from(s_m) for one in self.supposed), blind_ahead=blind)
