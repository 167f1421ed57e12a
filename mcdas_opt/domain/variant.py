"""What somebody may do besides going on as he does. Each is a body of its own in a prediction, named after the track."""

from __future__ import annotations

from enum import StrEnum
from functools import lru_cache


class Variant(StrEnum):
    """The value is what a person reads behind the track's name."""

    CHANGING = "changing lanes"
    BRAKING = "braking"
    ACCELERATING = "accelerating"
    STRAIGHT_ON = "straight on"

    def of(self, track_id: str) -> str:
        """The name of the body of this track that does so."""
        return f"{track_id} {self}"


@lru_cache(maxsize=1024)
def names_of(track_id: str) -> tuple[str, ...]:
    """Every name that a track may have in a prediction."""
    return (track_id, *(variant.of(track_id) for variant in Variant))
