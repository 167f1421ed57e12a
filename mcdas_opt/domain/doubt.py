"""What is doubted in a situation: tracks that cannot all be true, each doubt with its evidence."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import StrEnum

from mcdas_opt.domain.declared_types import require_types
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


_WORDS = {
    DoubtKind.DUPLICATE: "{who} are the same",
    DoubtKind.ONE_PLACE: "{who} are in one place, {measured} deep",
    DoubtKind.WITHIN_HOST: "{who} is where the host is, {measured} deep",
    DoubtKind.TOO_FAST: "{who} moves at {measured}, faster than any car",
    DoubtKind.JUMPED: "{who} jumped by {measured}",
    DoubtKind.SPEED_JUMPED: "the speed of {who} jumped by {measured}",
    DoubtKind.IDS_SWAPPED: "{who} changed ids, {measured} apart",
}


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
        require_types(self)
        who = f"track{'s' if len(self.tracks) > 1 else ''} {' and '.join(self.tracks)}"
        object.__setattr__(self, "words", _WORDS[self.kind].format(who=who, measured=f"{self.value:.3g} {self.unit}"))

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
