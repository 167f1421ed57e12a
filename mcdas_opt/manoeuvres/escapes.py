"""The escape map: for each way out, the last moment at which it still can be started, and what ends it."""

from __future__ import annotations

from dataclasses import dataclass, field

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

_BEST, _WIDER = 4, 8  # members of each kind that are looked at exactly: at first, and where that does not settle it
_TRIED = (5, 3, 2, 1, 0, -1, -3, -6)  # at which steps of the lattice from their guessed last start
_BEST_EASY, _TRIED_EASY = 2, (2, -1, -5)  # the same for comfortable ones
_DOWN, _UP, _CLOSE, _ROUNDS = (7, 11, 18, 35, 80), (4, 10), 2, 4
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
    kinds = [np.flatnonzero(case.members.kind == kind) for kind in range(len(KINDS))]
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
    case: Case, kinds: list[Rows], guesses: tuple[Array, Array], first: Rows, latest: int
) -> tuple[list[list[int]], list[float | None]]:
    """The last start (on the lattice, -1 without) of each kind that is found sound: of any demand, and of a comfortable one. And what
    each kind asks of the tyres when one of its members of `first` begins now; None where it cannot."""
    tasks = [
        _Search(wanted=g, kind=kind, best=_latest(mine, last, (_BEST, _BEST_EASY)[g]), wider=_latest(mine, last, _WIDER))
        for g, last in enumerate(guesses)
        for kind, mine in enumerate(kinds)
        if mine.size and last[mine].max() >= 0.0
    ]
    for task in tasks:
        near = np.floor(guesses[task.wanted][task.best] / LATTICE_S + 1e-9).astype(np.intp)
        task.ask = np.clip(near[:, None] + np.array((_TRIED, _TRIED_EASY)[task.wanted]), 0, latest)
    now: list[float | None] = [None] * len(KINDS)
    for _ in range(_ROUNDS):
        pending = [task for task in tasks if task.ask.size]
        if not pending and not first.size:
            break
        members = np.concatenate([first, *(np.repeat(task.best, task.ask.shape[1]) for task in pending)])
        starts = np.concatenate([np.zeros_like(first), *(task.ask.reshape(-1) for task in pending)])
        sound, demand = case.sound(members, starts)
        for member, good, asked in zip(first, sound[: first.size], demand[: first.size], strict=True):
            kind = int(case.members.kind[member])
            if good and asked < (now[kind] or np.inf):
                now[kind] = float(asked)
        begin, first = first.size, first[:0]
        for task in pending:
            rows = slice(begin, begin + task.ask.size)
            good = sound[rows] & (demand[rows] <= case.comfort_mps2) if task.wanted else sound[rows]
            task.learn(good, starts[rows], latest)
            begin = rows.stop
    answer = [[-1] * len(KINDS) for _ in guesses]
    for task in tasks:
        begun_now = 0 if task.wanted == 0 and now[task.kind] is not None else -1
        answer[task.wanted][task.kind] = max(task.sound, begun_now)
    return answer, now


def _latest(mine: Rows, last_s: Array, count: int) -> Rows:
    """The members whose last start was guessed the latest."""
    best = mine[np.argsort(-last_s[mine], kind="stable")[:count]]
    return best[last_s[best] >= 0.0]


@dataclass(slots=True)
class _Search:
    """For the last sound start of a few members: the latest found so far, the earliest after it that was not, and what to try next."""

    wanted: int
    kind: int
    best: Rows
    wider: Rows
    sound: int = -1
    ask: Rows = field(default_factory=lambda: np.zeros((0, 0), dtype=np.intp))

    def learn(self, good: NDArray[np.bool_], starts: Rows, latest: int) -> None:
        if good.any():
            self.sound = max(self.sound, int(starts[good].max()))
        beyond = starts[starts > self.sound]
        limit = int(beyond.min()) if beyond.size else latest + 1
        if self.sound < 0:
            wanted = np.maximum(limit - np.array(_DOWN), 0)
            wanted = wanted[wanted < limit]
        elif self.wanted:
            wanted = np.zeros(0, dtype=np.intp)
        elif not beyond.size:
            wanted = self.sound + np.array(_UP)
        elif limit - self.sound > _CLOSE:
            wanted = self.sound + ((limit - self.sound) * np.array([0.25, 0.5, 0.75])).astype(np.intp)
        else:
            wanted = np.zeros(0, dtype=np.intp)
        self.best = self.wider
        wanted = np.unique(wanted[(wanted > self.sound) & (wanted >= 0) & (wanted <= latest)])
        self.ask = np.broadcast_to(wanted, (self.best.size, wanted.size)) if wanted.size else self.ask[:, :0]


def _gentlest(guess: Guess, kinds: list[Rows]) -> Rows:
    """The members of each kind that ask the least when they begin now, of those that may."""
    ready = (guess.free_m[0] > 0.0) & (guess.edge_m[0] > 0.0) & (guess.ability[0] > 0.0)
    chosen = []
    for mine in kinds:
        mine = mine[ready[mine]]
        chosen.append(mine[np.argsort(-guess.ease_mps2[0, mine], kind="stable")[:_GENTLEST]])
    return np.concatenate(chosen)


def _closer(case: Case, guess: Guess, mine: Rows, n: int) -> Closer:
    """What is in the way of a kind at the start `n`: of its members that car and road allow, the one that comes nearest to being clear."""
    possible = guess.ability[n, mine] >= 0.0
    allowed = possible & (guess.edge_m[n, mine] >= 0.0)
    if not allowed.any() or not case.company.s_m.shape[0]:
        return Closer.EDGE if possible.any() else Closer.FRICTION
    best = mine[int(np.where(allowed, guess.free_m[n, mine], -np.inf).argmax())]
    return case.closer(guess.nearest(n, best), 0.0)


def _refusal(name: str, situation: Situation) -> Closer | None:
    """A way into a direction that nobody watches is closed."""
    sector, closer = {
        "brake": (None, None),
        "accelerate": (Sector.FRONT, Closer.FRONT),
        "left": (Sector.LEFT, Closer.SIDE),
        "right": (Sector.RIGHT, Closer.SIDE),
    }[name]
    return closer if sector is not None and not situation.coverage.sees(sector) else None
