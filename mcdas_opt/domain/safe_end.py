"""How a plan ends: what the car may still do when the plan is over."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from enum import StrEnum

from mcdas_opt.domain.rules import measurable, require, within


class EndKind(StrEnum):
    """`clear`: nobody in its way; `held`: at a distance that can be held; `stopped`: at rest in its lane; `open`: none of these."""

    CLEAR = "clear"
    HELD = "held"
    STOPPED = "stopped"
    OPEN = "open"


@dataclass(frozen=True, slots=True, kw_only=True)
class SafeEndSettings:
    """What an end must survive: the front car braking fully, and the follower not braking for a while.

    The distance to the front car is the longitudinal one of Responsibility-Sensitive Safety (Shalev-Shwartz, Shammah and Shashua, 2017,
    lemma 2), with the host holding its speed during `response_s`, then braking with `braking_share` of what tyres and brakes give.
    """

    response_s: float = 0.2
    braking_share: float = 0.97
    front_braking_mps2: float = 8.0  # of the front car, never beyond the road's grip
    follower_demand_mps2: float = 4.0  # what may be asked of who is behind ...
    follower_response_s: float = 1.0  # ... after so long
    attentive_braking_mps2: float = 3.0  # what an attentive follower does in a queue; relied on only where nothing else is left ...
    attentive_response_s: float = 0.5  # ... after so long
    queue_mps: float = 10.0  # whoever is behind and no faster than this is in a queue
    payback_s: float = 4.0  # front distance that others took is won back with this time constant ...
    payback_mps2: float = 2.0  # ... but no faster than braking by this does it
    settled_rad: float = 0.05  # a heading at the end within this is along the road
    longest_s: float = 12.0  # that a plan is continued by, to reach a safe end

    def __post_init__(self) -> None:
        require(self, measurable, "response_s", "follower_response_s", "attentive_response_s", "longest_s", "queue_mps", "settled_rad")
        require(self, measurable, "front_braking_mps2", "follower_demand_mps2", "attentive_braking_mps2", "payback_s", "payback_mps2")
        within("braking_share", self.braking_share, 0.1, 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class SafeEnd:
    """`front_margin_m`: the gap to whoever is ahead less the distance that can be held (None: nobody); `follower_demand_mps2`: what whoever
    is behind must brake with (None: nobody). What others made it short of that, and is not yet paid back, it may still be short of at the
    end. `relies_on` is who follows and has braked by then, as an attentive driver does ("a and b" where there are two); None: the end is
    safe though nobody brakes until then.
    """

    kind: EndKind
    t_s: float
    front_margin_m: float | None = None
    follower_demand_mps2: float | None = None
    relies_on: str | None = None

    @property
    def safe(self) -> bool:
        return self.kind is not EndKind.OPEN


_AND = " and "


def in_one_text(ids: Collection[str]) -> str:
    """Several ids as `SafeEnd.relies_on` tells them."""
    return _AND.join(ids)


def named_in(told: str, ids: Collection[str]) -> list[str]:
    """Which of these ids `SafeEnd.relies_on` names: ids may hold the word between them, and the longest that fits is meant."""
    found, rest = [], told
    while rest:
        fitting = [one for one in ids if rest == one or rest.startswith(one + _AND)]
        if fitting:
            found.append(max(fitting, key=len))
            rest = rest[len(found[-1]) :].removeprefix(_AND)
        else:
            rest = rest.partition(_AND)[2]
    return found
