"""The interior point's iteration in the native library: the same steps as the interpreted kernel, ten to twenty times faster."""

from __future__ import annotations

import ctypes
import re
from functools import cache

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.native.build import text_of
from mcdas_opt.solvers.barrier_stage import BarrierStage
from mcdas_opt.solvers.iterate import Iterate
from mcdas_opt.solvers.newton_loop import LoopEnd, LoopEnding, LoopRule, Progress
from mcdas_opt.solvers.stage_problem import Member

_ALIGNMENT = 64


class CompiledKernel:
    """Owns the library's working memory; what its methods do stands in `InterpretedKernel`. `measure` brings the iterate up to date."""

    kind = "compiled"

    def __init__(self, library: ctypes.CDLL, stage: BarrierStage, member: Member, nodes: int) -> None:
        self.iterate = it = Iterate(stage, nodes)
        self._memory = np.zeros(library.mcdas_size(nodes, member.times) + _ALIGNMENT, dtype=np.uint8)
        self._work = ctypes.c_void_p(-(-self._memory.ctypes.data // _ALIGNMENT) * _ALIGNMENT)
        self._numbers = np.zeros(len(Progress._fields) + 3)  # and objective, gap, steps done
        self._to = _pointer(self._numbers)
        self._ruled: LoopRule | None = None  # whose numbers `_rule` holds
        self._rule = np.zeros(len(LoopRule._fields))
        self._rule_at = _pointer(self._rule)
        z, p, steps, s, t, multiplier, least = map(_pointer, (it.z, it.p, it.steps, it.s, it.t, it.multiplier, it.least))
        self._problem, self._start, self._all = (z, p, steps), (s, t, multiplier), (z, s, t, multiplier, least)
        self._library = library
        given = nodes, member.times, member.numbers, stage.np, member.columns, member.fixed, member.first_of_row
        library.mcdas_prepare(self._work, *given)

    def cold(self, mu: float, least: float) -> bool:
        finite: int = self._library.mcdas_cold(self._work, *self._problem, mu, least)
        return finite == 1

    def warm(self, mu: float, least: float) -> bool:
        finite: int = self._library.mcdas_warm(self._work, *self._problem, *self._start, mu, least)
        return finite == 1

    def loop(self, *, warm: bool, iterations: int, rule: LoopRule) -> LoopEnd:
        """`newton_loop.looped`."""
        if rule is not self._ruled:
            self._ruled, self._rule[:] = rule, rule
        ending = LoopEnding(self._library.mcdas_loop(self._work, warm, iterations, self._rule_at, self._to, *self._all))
        *progress, objective, gap, done = self._numbers.tolist()
        return LoopEnd(ending, int(done), Progress(*progress), objective, gap)

    def newton(self, *, corrected: bool, mu: float, boundary: float, longest: float) -> Progress:
        self._library.mcdas_newton(self._work, corrected, mu, boundary, longest, self._to)
        return Progress(*self._numbers[: len(Progress._fields)].tolist())

    def measure(self) -> tuple[float, float]:
        self._library.mcdas_measure(self._work, self._to, *self._all)
        return float(self._numbers[0]), float(self._numbers[1])


def fits(stage: BarrierStage, member: Member) -> bool:
    """Whether the library's stage functions are of the problem's sizes: of another size they would read and write beside its arrays."""
    size, times = _sizes(f"generated/{stage.problem.name}_stage.h"), member.times
    its_own = (stage.nx, stage.nu, stage.ns, stage.ng, stage.inner, stage.nc, member.columns.size, member.fixed.size, member.numbers.size)
    rows = (size["NROWS"] + times, size["NINNER"] + times, size["NC"] + times)
    compiled = (size["NX"], size["NU"], size["NS"], *rows, size["NP"], size["NP"], size["NNUMBERS"])
    return its_own == compiled and member.first_of_row + times * size["NROWP"] <= stage.np


@cache
def _sizes(text: str) -> dict[str, int]:
    """The whole numbers that a C text defines, by name; the library says by its digest that it is of this text."""
    return {name: int(value) for name, value in re.findall(r"^#define (\w+) (\d+)$", text_of(text), re.MULTILINE)}


def _pointer(array: Array) -> ctypes.c_void_p:
    """Valid as long as the array lives: the iterate and the numbers live as long as the kernel."""
    assert array.flags.c_contiguous
    return ctypes.c_void_p(array.ctypes.data)
