"""One scene of a suite, with what the statistics must know about it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from mcdas_opt.catalogue.scenes import Scene


class Traffic(StrEnum):
    """What drives around the host: a script whatever it does, drivers who react to it, or what was recorded. Never mixed in one rate."""

    SCRIPTED = "scripted"
    REACTING = "reacting"
    RECORDED = "recorded"


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """`index` counts within the suite. `nominal`: nothing here needs an intervention. `labelled`: the oracle is asked about it."""

    index: int
    family: str
    traffic: Traffic
    nominal: bool = False
    labelled: bool = True
    scene: Scene
