"""What was decided over a drive: bands of mode, status and alert, and the moments at which one of them changes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.vocabulary import Alert, Mode, Side, Status
from mcdas_opt.plotting import style

if TYPE_CHECKING:
    from mcdas_opt.interop.replay_record import Cycle

MODES = {
    Mode.HOLD: "#b9bcc2",
    Mode.CRUISE: style.SKY,
    Mode.BRAKE: style.REAR,
    Mode.ACCELERATE: style.GREEN,
    Mode.EVADE: style.PURPLE,
    Mode.PARK: style.YELLOW,
}
STATUSES = {Status.PLANNED: style.GREEN, Status.FALLBACK: style.ORANGE, Status.UNAVOIDABLE: style.VERMILION}
_ALERTS = {Alert.NONE: "", Alert.WARN: style.ORANGE, Alert.ACT: style.VERMILION}


@dataclass(frozen=True, slots=True, kw_only=True)
class Decided:
    """What was decided at a time; `status` and `alert` are None where nothing was planned. `passed`: the judge's word on the plan."""

    t_s: float
    mode: Mode
    side: Side
    status: Status | None
    alert: Alert | None
    reason: str
    passed: bool = True

    @classmethod
    def of(cls, t_s: float, said: Plan | Cycle, *, passed: bool) -> Decided:
        """What a plan says, or a replay's cycle."""
        return cls(t_s=t_s, mode=said.mode, side=said.side, status=said.status, alert=said.alert, reason=said.reason, passed=passed)

    @property
    def action(self) -> str:
        """The mode, and the side where it has one: 'evade left'."""
        return self.mode.value if self.side is Side.NONE else f"{self.mode.value} {self.side.value}"


def bands_document(decided: Sequence[Decided], end_s: float) -> dict[str, Any]:
    """`bands`: rows of spans [from, until, word, colour]; `events`: time, kind and sentence of every change, as the script draws them."""
    rows = {
        "mode": [(one.t_s, one.action, MODES[one.mode]) for one in decided],
        "status": [(one.t_s, *_standing(one.status, one.passed)) for one in decided if one.status is not None],
        "alert": [(one.t_s, one.alert.value, _ALERTS[one.alert]) for one in decided if one.alert is not None],
    }
    return {
        "bands": [{"name": name, "spans": list(_spans(row, end_s))} for name, row in rows.items() if row],
        "events": [event for before, now in pairwise(decided) for event in _events(before, now)],
    }


def _standing(status: Status, passed: bool) -> tuple[str, str]:
    """Word and colour: a plan that the judge fails is shown as that, unless its status says so."""
    if passed or status is Status.UNAVOIDABLE:
        return status.value, STATUSES[status]
    return f"{status.value}, failed by the judge", STATUSES[Status.UNAVOIDABLE]


def _spans(row: Sequence[tuple[float, str, str]], end_s: float) -> Iterator[list[Any]]:
    start = 0
    for k in range(1, len(row) + 1):
        if k == len(row) or row[k][1] != row[start][1]:
            until = end_s if k == len(row) else row[k][0]
            yield [round(row[start][0], 3), round(until, 3), row[start][1], row[start][2]]
            start = k


def _events(before: Decided, now: Decided) -> Iterator[dict[str, Any]]:
    """A status that gets worse, an alert that begins or rises, a mode or side that changes: the gravest of one cycle alone."""
    if now.status is not None and now.status is not before.status and now.status is not Status.PLANNED:
        yield _event(now, "status", now.status.value)
    elif now.alert is not None and now.alert is not before.alert and now.alert is not Alert.NONE:
        yield _event(now, "alert", now.alert.value)
    elif now.action != before.action:
        yield _event(now, "mode", now.action)


def _event(now: Decided, kind: str, word: str) -> dict[str, Any]:
    return {"t": round(now.t_s, 3), "kind": kind, "word": word, "why": now.reason.partition("; before:")[0]}
