"""The problems that the planner poses to its solver in a drive, and the answers: the sequence that the C code has to repeat."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.settings import Settings
from mcdas_opt.errors import ParameterError
from mcdas_opt.planning.lane_problem.transcribed_problem import TranscribedProblem
from mcdas_opt.planning.mpc import MpcMethod
from mcdas_opt.planning.planner import Planner
from mcdas_opt.planning.solver_settings import SolverSettings
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.solvers.interior_point import ITERATIONS, InteriorPointEngine
from mcdas_opt.solvers.outcome import Ending, Outcome
from mcdas_opt.solvers.stage_problem import StageGuess

SLOTS = 64  # answers kept for warm starts: more than the planner has candidates
ENDINGS = (Ending.CONVERGED, Ending.LIMIT, Ending.INFEASIBLE, Ending.NOT_FINITE)  # in the order of the header's enum
_MOST_DRIVES = 200

Arithmetic = Literal["portable", "native"]
"""Of the Python side. "portable": no instruction of one processor's and scalar mathematics, as any C99 compiler builds it; "native": as the
planner flies with it here, its sines from the vector library where there is one."""
ARITHMETICS: tuple[Arithmetic, ...] = ("portable", "native")


def one_arithmetic(name: str) -> Arithmetic:
    """Raises `ParameterError` for a name that is none of them."""
    for known in ARITHMETICS:
        if name == known:
            return known
    raise ParameterError("arithmetic", name, f"must be one of {', '.join(ARITHMETICS)}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """One solve: from the answer in `slot`, moved on (`warm`), or from states and inputs of its own; its answer goes to `slot`."""

    slot: int
    warm: bool
    cap: int
    x0: Array
    p: Array
    guess_x: Array
    guess_u: Array
    outcome: Outcome
    took_us: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Recording:
    """The solves of one or more drives, in order, and the problem that they are of."""

    transcribed: TranscribedProblem
    steps_s: Array
    steps: tuple[Step, ...]
    solver: str

    @property
    def took_us(self) -> Array:
        return np.array([step.took_us for step in self.steps])


@dataclass(slots=True)
class _Slots:
    """Which answers are kept, and the guesses made of them. The one used longest ago is replaced."""

    outcomes: list[Outcome | None] = field(default_factory=lambda: [None] * SLOTS)
    used: list[int] = field(default_factory=lambda: [-1] * SLOTS)
    shifted: list[tuple[StageGuess, int]] = field(default_factory=list)

    def of_guess(self, guess: StageGuess) -> int | None:
        slot = next((slot for made, slot in self.shifted if made is guess), None)
        self.shifted = [entry for entry in self.shifted if entry[0] is not guess]
        return slot

    def of_outcome(self, outcome: Outcome) -> int | None:
        return next((slot for slot, kept in enumerate(self.outcomes) if kept is outcome), None)

    def free(self) -> int:
        return min(range(SLOTS), key=lambda slot: self.used[slot])


class RecordingEngine(InteriorPointEngine):
    """The interior point, which also writes down its first `most` solves."""

    def __init__(self, transcribed: TranscribedProblem, most: int, arithmetic: Arithmetic) -> None:
        super().__init__(transcribed.problem, transcribed.nodes, portable=arithmetic == "portable")
        self.steps: list[Step] = []
        self._most, self._slots = most, _Slots()

    def solve(self, x0: Array, p: Array, steps: Array, guess: StageGuess, iterations: int = ITERATIONS) -> Outcome:
        started = time.perf_counter()
        outcome = super().solve(x0, p, steps, guess, iterations)
        took_us = 1e6 * (time.perf_counter() - started)
        if len(self.steps) >= self._most:
            return outcome
        known = self._slots.of_guess(guess)
        slot = self._slots.free() if known is None else known
        self.steps.append(
            Step(
                slot=slot,
                warm=known is not None,
                cap=iterations,
                x0=np.array(x0),
                p=np.array(p),
                guess_x=guess.x,
                guess_u=guess.u,
                outcome=outcome,
                took_us=took_us,
            )
        )
        self._slots.outcomes[slot], self._slots.used[slot] = outcome, len(self.steps)
        return outcome

    def shifted(self, outcome: Outcome, nodes: int = 1) -> StageGuess:
        guess = super().shifted(outcome, nodes)
        slot = self._slots.of_outcome(outcome)
        if slot is not None:
            self._slots.shifted.append((guess, slot))
        return guess


def record(scene: Scene, steps: int, neighbours: int, arithmetic: Arithmetic = "portable") -> Recording:
    """The first `steps` solves of the MPC planner driving through `scene`, again with the next seed of the noise where one drive has fewer.

    The problem is posed for `neighbours` at a time; the planner takes the nearest. Of a scene in which fewer solves are asked for, all.
    """
    settings = Settings()
    method = MpcMethod(scene.vehicle, settings, SolverSettings(slots=(neighbours,)))
    transcribed = method.solvers.usual.problems.holding(neighbours, scene.vehicle, sloping_edges=scene.assumed_road.edges is not None)
    engine = transcribed.interior_point = RecordingEngine(transcribed, steps, arithmetic)
    for seed in range(scene.seed, scene.seed + _MOST_DRIVES):
        before = len(engine.steps)
        simulate(scene, Planner(scene.vehicle, method, settings=settings, road=scene.assumed_road), seed=seed, settings=settings)
        if not before < len(engine.steps) < steps:
            break
    kind = f"{engine.kind}, {arithmetic}" if engine.kind == "compiled" else engine.kind
    return Recording(transcribed=transcribed, steps_s=settings.grid.steps_s, steps=tuple(engine.steps), solver=f"interior-point ({kind})")
