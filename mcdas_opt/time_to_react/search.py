"""The search for the last sound start of each kind of candidate: in C where there is a compiler (`compiled_map`), else here."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mcdas_opt.domain.escapes import Closer
from mcdas_opt.domain.rules import Array
from mcdas_opt.time_to_react.effort import (
    BEST,
    BEST_EASY,
    BETWEEN,
    CLOSE,
    DOWN,
    FARTHER,
    GENTLEST,
    IN_LANE,
    LEAST,
    MOST,
    REFINED,
    SEARCH_ROUNDS,
    STEADY,
    STEERED,
    TRIED,
    TRIED_EASY,
    UP,
    WIDER,
)
from mcdas_opt.time_to_react.guess import Case, Guess
from mcdas_opt.time_to_react.library import KINDS, SIDEWAYS
from mcdas_opt.time_to_react.predicted_traffic import LATTICE_S, Rows

_AT_ONCE = 24  # rows of a search that are driven together


class Found(NamedTuple):
    """When the constant-input prediction ends [s] and by what; for each kind the last sound step of the lattice, of any demand and of a
    comfortable one, -1 without; what it asks that begins now [m/s^2], None without; and what closes it after its last step, None where
    nothing does."""

    end_s: float
    ender: Closer | None
    start: tuple[list[int], list[int]]
    now: list[float | None]
    closer: list[Closer | None]


def found(case: Case) -> Found:
    """What the map says, kind by kind."""
    end_s, ender = case.end_of_constant_input()
    guess = case.guess(end_s)
    kinds = case.members.of_kind
    latest = int(np.floor(end_s / LATTICE_S + 1e-9))
    now = _now(case, _gentlest(guess, kinds))
    start = _last_sound(case, kinds, guess.last_s, latest)
    closers: list[Closer | None] = []
    for kind, mine in enumerate(kinds):
        if start[0][kind] < 0 and now[kind] is not None:
            start[0][kind] = 0
        asked = now[kind]
        if start[1][kind] < 0 and asked is not None and asked <= case.comfort_mps2:
            start[1][kind] = 0
        last = start[0][kind] = max(start[0][kind], start[1][kind])  # what is comfortable is sound
        after = 0 if last < 0 else int(np.searchsorted(guess.starts_s, LATTICE_S * last, side="right"))
        closers.append(_closer(case, guess, mine, min(after, guess.starts_s.size - 1)) if last < latest else None)
    return Found(end_s, ender, start, now, closers)


def _last_sound(case: Case, kinds: tuple[Rows, ...], guesses: tuple[Array, Array], latest: int) -> tuple[list[int], list[int]]:
    """The last start (on the lattice, -1 without) of each kind that is found sound: of any demand, and of a comfortable one."""
    tasks = [_Search(easy, kind, mine, guess, latest) for easy, guess in enumerate(guesses) for kind, mine in enumerate(kinds)]
    while pending := [task for task in tasks if task.members.size]:
        asked = [task.next() for task in pending]
        members, starts = (np.concatenate([rows[i] for rows in asked]) for i in range(2))
        sound, demand = case.sound(members, starts)
        begin = 0
        for task, (mine, _) in zip(pending, asked, strict=True):
            rows = slice(begin, begin + mine.size)
            begin = rows.stop
            good = sound[rows] & (demand[rows] <= case.comfort_mps2) if task.easy else sound[rows]
            task.learn(mine[good], starts[rows][good])
    answer: tuple[list[int], list[int]] = ([], [])
    for task in tasks:
        last = task.sound if task.easy or task.sound < 0 else _refined(case, task.who, task.sound, latest)
        answer[task.easy].append(last)
    return answer


class _Search:
    """For the last sound start of a few members: the latest found so far, the earliest after it that was not, and what to try next.

    Rows are looked at from the latest start on, until one is sound: earlier ones can no longer matter.
    """

    def __init__(self, easy: int, kind: int, mine: Rows, guess_s: Array, latest: int) -> None:
        self.easy, self.kind, self.latest = easy, kind, latest
        self.sound, self.who, self.limit, self.rounds = -1, -1, latest + 1, SEARCH_ROUNDS
        likely = _latest(mine, guess_s, max(BEST, WIDER))
        best, tried = likely[: (BEST, BEST_EASY)[easy]], np.array((TRIED, TRIED_EASY)[easy])
        self.wider = likely[:WIDER]
        near = np.floor(guess_s[best] / LATTICE_S + 1e-9).astype(np.intp)
        self._ask(np.repeat(best, tried.size), np.clip(near[:, None] + tried, 0, latest).reshape(-1))

    def _ask(self, members: Rows, starts: Rows) -> None:
        order = np.argsort(-starts, kind="stable")
        self.members, self.starts, self.asked = members[order], starts[order], starts

    def next(self) -> tuple[Rows, Rows]:
        """The rows to look at next."""
        return self.members[:_AT_ONCE], self.starts[:_AT_ONCE]

    def learn(self, members: Rows, sound: Rows) -> None:
        """Of those rows the members and the starts that are sound, the latest first."""
        self.members, self.starts = self.members[_AT_ONCE:], self.starts[_AT_ONCE:]
        if not sound.size and self.members.size:
            return
        if sound.size and sound[0] > self.sound:
            self.who, self.sound = int(members[0]), int(sound[0])
        if self.limit <= self.sound:
            self.limit = self.latest + 1
        self.limit = int(self.asked[self.asked > self.sound].min(initial=self.limit))
        self.rounds -= 1
        wanted = self._wanted() if self.rounds else []
        starts = np.array([start for start in wanted if self.sound < start <= self.latest and start != self.limit], dtype=np.intp)
        self._ask(np.tile(self.wider, starts.size), np.repeat(starts, self.wider.size))

    def _wanted(self) -> list[int]:
        if self.sound < 0:
            return [max(self.limit - step, 0) for step in DOWN]
        if self.easy:
            return []
        if self.limit > self.latest:
            return [self.sound + step for step in UP]
        if self.limit - self.sound > CLOSE:
            return [self.sound + int(share * (self.limit - self.sound)) for share in BETWEEN]
        return []


def _refined(case: Case, member: int, sound: int, latest: int) -> int:
    """A later start than this one that a member is still sound from when it is varied a little."""
    steers = case.members.kind[member] >= SIDEWAYS
    varied = np.array(STEERED if steers else IN_LANE)
    if steers and case.members.level_mps2[member] == 0.0:
        varied = varied[:STEADY]
    so_far = np.ones(3)
    for _ in range(REFINED):
        later = np.array([sound + step for step in FARTHER if sound + step <= latest], dtype=np.intp)
        among, rows = case.members.varied(member, so_far * varied), np.arange(len(varied))
        good = case.sound_among(among, np.tile(rows, later.size), np.repeat(later, rows.size))[0].reshape(later.size, rows.size)
        share = np.where(among.level_mps2 < 0.0, -among.level_mps2 / case.brake_mps2, among.level_mps2 / case.accelerate_mps2)
        brief = np.isnan(among.until_mps) & (among.until_s < among.shortest_s)
        good &= (share <= MOST) & (steers | ((share >= LEAST) & ~brief))
        moved = np.flatnonzero(good.any(-1))
        if not moved.size:
            break
        so_far, sound = so_far * varied[good[moved[0]].argmax()], int(later[moved[0]])
    return sound


def _latest(mine: Rows, last_s: Array, count: int) -> Rows:
    """The members whose last start was guessed the latest, of those that have one."""
    moments = last_s[mine]
    best = np.argsort(-moments, kind="stable")[:count]
    return mine[best[moments[best] >= 0.0]]


def _now(case: Case, gentlest: Rows) -> list[float | None]:
    """What each kind asks of the tyres that begins now with one of these members; None where none can."""
    now: list[float | None] = [None] * len(KINDS)
    if gentlest.size:
        sound, demand = case.sound(gentlest, np.zeros_like(gentlest))
        for member, good, asked in zip(gentlest.tolist(), sound.tolist(), demand.tolist(), strict=True):
            kind = int(case.members.kind[member])
            if good and asked < (now[kind] or np.inf):
                now[kind] = asked
    return now


def _gentlest(guess: Guess, kinds: tuple[Rows, ...]) -> Rows:
    """The members of each kind that ask the least when they begin now, of those that may."""
    ready, ease = guess.open_now_m > 0.0, guess.needs.slack[2, 0]
    chosen = []
    for mine in kinds:
        mine = mine[ready[mine]]
        chosen.append(mine[np.argsort(-ease[mine], kind="stable")[:GENTLEST]])
    return np.concatenate(chosen)


def _closer(case: Case, guess: Guess, mine: Rows, n: int) -> Closer:
    """What is in the way of a kind at the start `n`: of its members that car and road allow, the one that comes nearest to being clear."""
    edge, ability, _ = guess.slack(n, mine)
    possible = ability >= 0.0
    allowed = possible & (edge >= 0.0)
    if not allowed.any() or not case.traffic.s_m.shape[0]:
        return Closer.EDGE if possible.any() or not mine.size else Closer.FRICTION
    misses = guess.misses(n, mine)
    best = int(np.where(allowed, misses.min(0), -np.inf).argmax())
    return case.closer(int(misses[:, best].argmin()), 0.0)
