"""What a planning method is, and how one is found by name."""

from __future__ import annotations

import inspect
import warnings
from dataclasses import replace
from typing import Literal, Protocol, runtime_checkable

import numpy as np

from mcdas_opt.domain.plan import Plan, Refusal
from mcdas_opt.domain.registry import Registry
from mcdas_opt.domain.rules import require_type
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import McdasError, ParameterError, PlannerFaultError, PlannerFaultWarning, told
from mcdas_opt.planning.candidates.collision_check import judged
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.deadline import Deadline
from mcdas_opt.planning.fallback.ladder import NothingPasses

PlannerName = Literal["mpc", "closed-form", "closed-form-corrected", "closed-form-tuned", "aeb", "un-r157", "idm-mobil"]
"""The shipped planners; others are registered by entry point."""
METHODS = Registry(
    group="mcdas_opt.methods",
    what="planner",
    own={
        "mpc": "mcdas_opt.planning.mpc:MpcMethod",
        "closed-form": "mcdas_opt.baselines.literal:LiteralMethod",
        "closed-form-corrected": "mcdas_opt.baselines.corrected:CorrectedMethod",
        "closed-form-tuned": "mcdas_opt.baselines.corrected:TunedMethod",
        "aeb": "mcdas_opt.baselines.aeb:AebMethod",
        "un-r157": "mcdas_opt.baselines.competent_driver:CompetentDriverMethod",
        "idm-mobil": "mcdas_opt.baselines.idm_mobil:IdmMobilMethod",
    },
)


class Method(Protocol):
    """Built as `Method(vehicle, settings)`. Raises nothing in traffic: a plan or a refusal is a value.

    `has_ladder` true: its plan is judged, whatever verdict that carries; a refusal, or what fails, is answered by the fallback ladder.
    False: it leaves with its own verdict (`verify`). `vehicle` is what it plans with: of a
    dynamic vehicle the planner sets it anew where the zero-sideslip point has moved.
    """

    has_ladder: bool
    vehicle: Vehicle

    def plan(self, situation: Situation, previous: Plan | None) -> Plan | Refusal: ...


@runtime_checkable
class CycleMethod(Protocol):
    """A method of ours, that answers a whole cycle: it shares its assessment, prediction, memory and deadline with the fallback, and its
    plans were judged with them."""

    has_ladder: bool
    vehicle: Vehicle

    def answer(self, cycle: Cycle) -> Plan | NothingPasses: ...


@runtime_checkable
class SolvingMethod(Protocol):
    """A method that asks a solver, and says which and in which form."""

    @property
    def solver(self) -> str: ...


class AskedMethod:
    """A method under its name, asked by the cycle; `previous` is the last plan that left, its own or the fallback's.

    Its answer is due `deadline_s` after a cycle began; None: whenever its work is done.
    """

    def __init__(self, name: str, method: Method, deadline_s: float | None = None) -> None:
        self.name, self.method, self.deadline_s = name, method, deadline_s
        self.previous: Plan | None = None
        self._of_cycles = method if isinstance(method, CycleMethod) else None

    @property
    def has_ladder(self) -> bool:
        """A method that does not say gets the fallback ladder."""
        return getattr(self.method, "has_ladder", True)

    def deadline(self, began_s: float) -> Deadline | None:
        """Of a cycle that began then (`time.perf_counter`)."""
        return None if self.deadline_s is None else Deadline(began_s=began_s, length_s=self.deadline_s)

    @property
    def solver(self) -> str:
        """Which engine it runs, and in which form; empty of a method that has none, or cannot say."""
        try:
            solver = self.method.solver if isinstance(self.method, SolvingMethod) else ""
        except Exception:  # a property of somebody else's
            return ""
        return solver if isinstance(solver, str) else ""

    def answer(self, cycle: Cycle) -> Plan | NothingPasses:
        """What it answers to this cycle. An exception is no answer, and told in a `PlannerFaultWarning`; of a method without a ladder in
        a `PlannerFaultError`. One of ours leaves, unless a method of another kind raised it, which has a ladder."""
        try:
            answer = self._answer(cycle)
        except Exception as error:
            if isinstance(error, McdasError) and (self._of_cycles is not None or not self.has_ladder):
                raise
            said = told(error)
            if not self.has_ladder:
                raise PlannerFaultError(self.name, cycle.given.time_s, said) from error
            fault = f"{self.name} failed: {said}"
            warnings.warn(fault, PlannerFaultWarning, stacklevel=2)
            return NothingPasses(reason=fault, memory=replace(cycle.memory, warm_starts=None))
        if not isinstance(answer, (Plan, NothingPasses)):
            require_type(f"the answer of {self.name}", answer, Plan, Refusal)
        return answer

    def _answer(self, cycle: Cycle) -> Plan | NothingPasses:
        """One that does not know cycles plans in the place and time that were given."""
        if self._of_cycles is not None:
            return self._of_cycles.answer(cycle)
        answer = self.method.plan(cycle.believed, None if cycle.memory.is_empty else self.previous)
        if isinstance(answer, Plan):
            return self._judged(answer, cycle)
        if not isinstance(answer, Refusal):
            return answer
        return NothingPasses(reason=answer.reason, candidates=answer.candidates, iterations=answer.iterations, memory=cycle.memory)

    def _judged(self, plan: Plan, cycle: Cycle) -> Plan | NothingPasses:
        """The plan, if all its numbers are finite; under the ladder with the judge's verdict, whatever it says of itself."""
        drive = plan.trajectory.seen_from(cycle.origin_m)
        bad = [name for name, column in drive.columns().items() if not np.isfinite(column).all()]
        if bad:
            return NothingPasses(reason=f"{self.name} gave a trajectory that is not finite: {', '.join(bad)}", memory=cycle.memory)
        if not self.has_ladder:
            return replace(plan, trajectory=drive)
        return replace(plan, trajectory=drive, verdict=judged(drive, cycle), prediction=cycle.prediction.name)


def known_methods() -> tuple[str, ...]:
    return METHODS.known()


def build_method(name: str, vehicle: Vehicle, settings: Settings) -> Method:
    """The method registered as `name`. Raises `ParameterError` that names the nearest known one, or says why what is registered is none."""
    kind = METHODS.load(name)
    if not callable(kind):
        raise ParameterError("planner", name, f"is registered as {kind!r}, must be a class")
    try:
        method: Method = kind(vehicle, settings)
    except McdasError:
        raise
    except Exception as error:
        rule = f"raised {type(error).__name__} when called with vehicle and settings: {error}"
        raise ParameterError("planner", name, rule) from error
    if not _plans(method):
        raise ParameterError("planner", name, f"gives a {type(method).__name__}, which has no method plan(situation, previous)")
    return method


def check_method(name: str) -> None:
    """That the planner of that name can be had; one of somebody else's is built. Raises as `build_method`."""
    METHODS.load(name)
    if name not in METHODS.own:
        build_method(name, Vehicle(), Settings())


def _plans(method: object) -> bool:
    """Whether it can be asked for a plan of a situation, given the previous plan."""
    plan = getattr(method, "plan", None)
    if not callable(plan):
        return isinstance(method, CycleMethod)
    try:
        inspect.signature(plan).bind(None, None)
    except TypeError:
        return False
    except ValueError:  # of a compiled module, which does not say
        return True
    return True
