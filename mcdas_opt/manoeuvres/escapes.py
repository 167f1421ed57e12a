"""The escape map: for each way out, the last moment at which it still can be started, and what ends it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.escapes import Closer, Escape, Escapes
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.manoeuvres.compiled_escapes import compiled_escapes
from mcdas_opt.manoeuvres.escape_guess import Case, Guess
from mcdas_opt.manoeuvres.escape_library import KINDS, EscapeSettings
from mcdas_opt.manoeuvres.parting import LATTICE_S, Rows

_BEST, _WIDER = 6, 12  # members of each kind that are looked at exactly: at first, and where that does not settle it
_TRIED = np.array((5, 3, 2, 1, 0, -1, -3, -6))  # at which steps of the lattice from their guessed last start
_BEST_EASY, _TRIED_EASY = 2, np.array((2, -1, -5))  # the same for comfortable ones
_DOWN, _UP, _BETWEEN, _CLOSE, _ROUNDS = (7, 14, 35, 90, 220), (4, 10), (0.25, 0.5, 0.75), 2, 6
_GENTLEST = 3


def escapes(situation: Situation, vehicle: Vehicle, prediction: Prediction, settings: EscapeSettings | None = None) -> Escapes:
    """The four ways out, each the best of some dozens of manoeuvres of its kind, for all starts at once.

    Each manoeuvre from a few starts says which gaps it needs, and so until when each gap lasts; the best few are then driven from
    about that moment and parted from everybody exactly, so that a way called open is one.
    """
    chosen = settings or EscapeSettings()
    case = Case(situation, vehicle, prediction, chosen, compiled_escapes())
    end_s, ender = case.end_of_keeping_on()
    guess = case.guess(end_s)
    kinds = case.members.of_kind
    latest = int(np.floor(end_s / LATTICE_S + 1e-9))
    found, now = _last_sound(case, kinds, guess.last_s, _gentlest(guess, kinds), latest)
    answers: dict[str, Escape] = {}
    for kind, name in enumerate(KINDS):
        refusal = _refusal(name, situation)
        start = found[0][kind]
        if refusal is not None or start < 0:
            closer = refusal or (_closer(case, guess, kinds[kind], 0) if kinds[kind].size else Closer.EDGE)
            answers[name] = Escape(closed_by=closer)
            continue
        closed_by = None
        if start < latest:
            after = int(np.searchsorted(guess.starts_s, LATTICE_S * start, side="right"))
            closed_by = _closer(case, guess, kinds[kind], min(after, guess.starts_s.size - 1))
        elif latest * LATTICE_S < chosen.latest_s - 1e-9:
            closed_by = ender
        answers[name] = Escape(
            open=True,
            last_moment_s=round(LATTICE_S * start, 4),
            closed_by=closed_by,
            demand_mps2=now[kind],
            last_comfortable_s=round(LATTICE_S * found[1][kind], 4) if found[1][kind] >= 0 else None,
        )
    return Escapes(**answers, keeping_on_s=round(end_s, 4) if ender is not None else None)


def _last_sound(
    case: Case, kinds: tuple[Rows, ...], guesses: tuple[Array, Array], first: Rows, latest: int
) -> tuple[list[list[int]], list[float | None]]:
    """The last start (on the lattice, -1 without) of each kind that is found sound: of any demand, and of a comfortable one. And what
    each kind asks of the tyres when one of its members of `first` begins now; None where it cannot."""
    tasks = []
    for wanted, guess in enumerate(guesses):
        for kind, mine in enumerate(kinds):
            likely = _latest(mine, guess, _WIDER)
            if likely.size:
                tasks.append(_Search(wanted, kind, likely[: (_BEST, _BEST_EASY)[wanted]], likely, guess, latest))
    now: list[float | None] = [None] * len(KINDS)
    for _ in range(_ROUNDS):
        pending = [task for task in tasks if task.members.size]
        if not pending and not first.size:
            break
        members = np.concatenate([first, *(task.members for task in pending)])
        starts = np.concatenate([np.zeros_like(first), *(task.starts for task in pending)])
        sound, demand = case.sound(members, starts)
        for member, good, asked in zip(first.tolist(), sound[: first.size].tolist(), demand[: first.size].tolist(), strict=True):
            kind = int(case.members.kind[member])
            if good and asked < (now[kind] or np.inf):
                now[kind] = asked
        begin, first = first.size, first[:0]
        for task in pending:
            rows = slice(begin, begin + task.members.size)
            begin = rows.stop
            task.learn(sound[rows] & (demand[rows] <= case.comfort_mps2) if task.wanted else sound[rows])
    answer = [[-1] * len(KINDS) for _ in guesses]
    for task in tasks:
        begun_now = 0 if task.wanted == 0 and now[task.kind] is not None else -1
        answer[task.wanted][task.kind] = max(task.sound, begun_now)
    return answer, now


def _latest(mine: Rows, last_s: Array, count: int) -> Rows:
    """The members whose last start was guessed the latest, of those that have one."""
    moments = last_s[mine]
    best = np.argsort(-moments, kind="stable")[:count]
    return mine[best[moments[best] >= 0.0]]


class _Search:
    """For the last sound start of a few members: the latest found so far, the earliest after it that was not, and what to try next."""

    def __init__(self, wanted: int, kind: int, best: Rows, wider: Rows, guess_s: Array, latest: int) -> None:
        self.wanted, self.kind, self.wider, self.latest = wanted, kind, wider, latest
        self.sound = -1
        tried = (_TRIED, _TRIED_EASY)[wanted]
        near = np.floor(guess_s[best] / LATTICE_S + 1e-9).astype(np.intp)
        self.members = np.repeat(best, tried.size)
        self.starts = np.clip(near[:, None] + tried, 0, latest).reshape(-1)

    def learn(self, good: NDArray[np.bool_]) -> None:
        tried, latest = self.starts.tolist(), self.latest
        self.sound = max((start for start, sound in zip(tried, good.tolist(), strict=True) if sound), default=self.sound)
        limit = min((start for start in tried if start > self.sound), default=latest + 1)
        wanted: set[int] = set()
        if self.sound < 0:
            wanted = {max(limit - step, 0) for step in _DOWN} - {limit}
        elif self.wanted:
            pass
        elif limit > latest:
            wanted = {self.sound + step for step in _UP}
        elif limit - self.sound > _CLOSE:
            wanted = {self.sound + int(share * (limit - self.sound)) for share in _BETWEEN}
        ask = np.array(sorted(start for start in wanted if self.sound < start <= latest), dtype=np.intp)
        self.members, self.starts = np.repeat(self.wider, ask.size), np.tile(ask, self.wider.size)


def _gentlest(guess: Guess, kinds: tuple[Rows, ...]) -> Rows:
    """The members of each kind that ask the least when they begin now, of those that may."""
    ready, ease = guess.open_now_m > 0.0, guess.needs.slack[2, 0]
    chosen = []
    for mine in kinds:
        mine = mine[ready[mine]]
        chosen.append(mine[np.argsort(-ease[mine], kind="stable")[:_GENTLEST]])
    return np.concatenate(chosen)


def _closer(case: Case, guess: Guess, mine: Rows, n: int) -> Closer:
    """What is in the way of a kind at the start `n`: of its members that car and road allow, the one that comes nearest to being clear."""
    edge, ability, _ = guess.slack(n, mine)
    possible = ability >= 0.0
    allowed = possible & (edge >= 0.0)
    if not allowed.any() or not case.company.s_m.shape[0]:
        return Closer.EDGE if possible.any() else Closer.FRICTION
    misses = guess.misses(n, mine)
    best = int(np.where(allowed, misses.min(0), -np.inf).argmax())
    return case.closer(int(misses[:, best].argmin()), 0.0)


def _refusal(name: str, situation: Situation) -> Closer | None:
    """A way into a direction that nobody watches is closed."""
    sector, closer = {
        "brake": (None, None),
        "accelerate": (Sector.FRONT, Closer.FRONT),
        "left": (Sector.LEFT, Closer.SIDE),
        "right": (Sector.RIGHT, Closer.SIDE),
    }[name]
    return closer if sector is not None and not situation.coverage.sees(sector) else None
