"""What is doubted in a situation: tracks that cannot all be true, each doubt with its evidence."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import StrEnum

from mcdas_opt.domain.track import Track


class DoubtKind(StrEnum):
    """What is wrong with tracks."""

    DUPLICATE = "the same"
    ONE_PLACE = "in one place"  # near duplicates, splits, ghosts beside their origin
    WITHIN_HOST = "where the host is"
    TOO_FAST = "faster than any car"
    JUMPED = "jumped"
    SPEED_JUMPED = "speed jumped"
    IDS_SWAPPED = "ids swapped"


@dataclass(frozen=True, slots=True, kw_only=True)
class Doubt:
    """One doubt, and the tracks that it is about. `value` is the evidence in `unit`: the deepest overlap [m], the jump [m] or [m/s], the
    speed [m/s], how far duplicates are apart [m]. `words` puts it in words."""

    words: str = field(init=False)
    kind: DoubtKind
    tracks: tuple[str, ...]
    value: float
    unit: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "words", self._words())

    def _words(self) -> str:
        who = f"track{'s' if len(self.tracks) > 1 else ''} {' and '.join(self.tracks)}"
        measured = f"{self.value:.3g} {self.unit}"
        match self.kind:
            case DoubtKind.DUPLICATE:
                return f"{who} are the same"
            case DoubtKind.ONE_PLACE:
                return f"{who} are in one place, {measured} deep"
            case DoubtKind.WITHIN_HOST:
                return f"{who} is where the host is, {measured} deep"
            case DoubtKind.TOO_FAST:
                return f"{who} moves at {measured}, faster than any car"
            case DoubtKind.JUMPED:
                return f"{who} jumped by {measured}"
            case DoubtKind.SPEED_JUMPED:
                return f"the speed of {who} jumped by {measured}"
            case DoubtKind.IDS_SWAPPED:
                return f"{who} changed ids, {measured} apart"

    def __str__(self) -> str:
        return self.words


@dataclass(frozen=True, slots=True, kw_only=True)
class SupposedTrack:
    """A body that may still be where it was going before its track jumped: planned around for `left_s` more seconds."""

    track: Track
    left_s: float

    def seen_from(self, s_m: float) -> SupposedTrack:
        """The same with its s counted from `s_m`."""
        return self if s_m == 0.0 else replace(self, track=self.track.seen_from(s_m))
