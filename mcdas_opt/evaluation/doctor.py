"""What this installation can do: packages, engines, compiler, and a self-test that uses them."""

from __future__ import annotations

import platform
import re
import subprocess
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from importlib import metadata
from statistics import median
from typing import Any

from mcdas_opt.domain.document import SCHEMA_VERSION, to_document

_PACKAGE = "mcdas-opt"
_NAME = re.compile(r"^[A-Za-z0-9._-]+")
_EXTRA = re.compile(r"extra\s*==\s*['\"]([^'\"]+)['\"]")
_PLANS = 5  # of which the median is told
_HIDDEN_EXTRAS = ("dev", "docs")


@dataclass(frozen=True, slots=True, kw_only=True)
class Package:
    """A package that is needed (`extra` empty) or that an extra would bring; `version` is empty where it is not installed."""

    name: str
    version: str
    extra: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Check:
    """One thing that was tried: whether it worked, and what was seen, or what went wrong."""

    name: str
    works: bool
    detail: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Form:
    """Which form of the planner runs, in words why, and what a plan takes in it: the median of some plans, nothing remembered."""

    name: str
    why: str
    plan_ms: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Diagnosis:
    """What `doctor` found. `well` is about what is needed; extras may be missing."""

    version: str
    python: str
    packages: tuple[Package, ...]
    solvers: tuple[Check, ...]
    compiler: Check
    self_test: tuple[Check, ...]
    form: Form | None = None

    @property
    def well(self) -> bool:
        needed = all(package.version for package in self.packages if not package.extra)
        return needed and all(check.works for check in (*self.solvers, *self.self_test))

    def to_dict(self) -> dict[str, Any]:
        return {"schema_version": SCHEMA_VERSION, **to_document(self), "well": self.well}


def diagnose() -> Diagnosis:
    """Tries everything; raises nothing."""
    return Diagnosis(
        version=metadata.version(_PACKAGE),
        python=f"{platform.python_version()} ({platform.python_implementation()}, {platform.system()} {platform.machine()})",
        packages=tuple(packages()),
        solvers=tuple(_tried(name, trial) for name, trial in _engines()),
        compiler=_tried("C compiler", _compiler),
        form=_form(),
        self_test=tuple(_tried(name, trial) for name, trial in _SELF_TEST),
    )


def packages() -> Iterator[Package]:
    """What this distribution requires, and what its extras would; a package of several extras is listed with the first."""
    seen: set[str] = set()
    for requirement in metadata.requires(_PACKAGE) or ():
        name, extra = _NAME.match(requirement), _EXTRA.search(requirement)
        kind = extra.group(1) if extra else ""
        if name is None or name.group() in seen or name.group() == _PACKAGE or kind in _HIDDEN_EXTRAS:
            continue
        seen.add(name.group())
        try:
            version = metadata.version(name.group())
        except metadata.PackageNotFoundError:
            version = ""
        yield Package(name=name.group(), version=version, extra=kind)


def _tried(name: str, trial: Callable[[], str]) -> Check:
    try:
        return Check(name=name, works=True, detail=trial())
    except Exception as error:  # whatever it is, it is the finding
        return Check(name=name, works=False, detail=f"{type(error).__name__}: {error}")


def _compiler() -> str:
    from mcdas_opt.native.build import compiler

    path = compiler()
    said = subprocess.run([path, "--version"], capture_output=True, text=True, timeout=20.0, check=True).stdout
    return f"{path}: {said.splitlines()[0] if said else 'of unknown version'}"


def _form() -> Form | None:
    """None where there is no plan to time: the self-test says why."""
    from mcdas_opt.native.form import interpreted
    from mcdas_opt.native.library import interpreted_because
    from mcdas_opt.planning.planner import Planner
    from mcdas_opt.simulation.first_situation import situation_of

    try:
        situation, vehicle = situation_of("sandwich-60-40")
        planner = Planner(vehicle)
        took = []
        for _ in range(_PLANS):
            planner.reset()
            plan = planner.plan(situation)
            took.append(plan.timing_ms.total)
    except Exception:
        return None
    reason = interpreted_because()
    return Form(name="interpreted" if reason else "compiled", why=interpreted(reason) if reason else "", plan_ms=median(took))


def _engines() -> Iterator[tuple[str, Callable[[], str]]]:
    """The same sandwich solved by each engine."""
    from mcdas_opt.planning.solver_settings import SolverSettings

    for name, settings in (
        ("interior-point", SolverSettings()),
        ("osqp", SolverSettings(solver="osqp")),
        ("ipopt", SolverSettings(cold_start="ipopt")),
    ):
        yield name, partial(_solved, settings)


def _solved(settings: Any) -> str:
    from mcdas_opt.domain.plan import Refusal
    from mcdas_opt.planning.mpc import MpcMethod
    from mcdas_opt.simulation.first_situation import situation_of

    situation, vehicle = situation_of("sandwich-60-40")
    method = MpcMethod(vehicle, solver=settings)
    plan = method.plan(situation, None)
    if isinstance(plan, Refusal):
        raise RuntimeError(plan.reason)
    compiled = "" if settings.solver == "osqp" or settings.cold_start == "ipopt" else f"; {method.solver}"
    return f"{plan.chosen} of {len(plan.candidates)} candidates{compiled}"


def _planned() -> Any:
    """The sandwich's plan, its situation and its vehicle."""
    from mcdas_opt.planning.planner import Planner
    from mcdas_opt.simulation.first_situation import situation_of

    situation, vehicle = situation_of("sandwich-60-40")
    return Planner(vehicle).plan(situation), situation, vehicle


def _plans() -> str:
    plan, _, _ = _planned()
    if not plan.verdict.passed or plan.status.value != "planned":
        raise RuntimeError(f"the plan is {plan.status.value}: {plan.reason}")
    return f"{plan.mode.value} {plan.side.value}, judged: {plan.verdict.reason}"


def _judges() -> str:
    from dataclasses import replace

    from mcdas_opt.domain.host import HostState
    from mcdas_opt.domain.prediction import Prediction
    from mcdas_opt.verification.judge import judge

    plan, situation, vehicle = _planned()
    drive = plan.trajectory
    wrong = replace(drive, speed_mps=drive.speed_mps * 1.2)
    start = HostState.from_vector(wrong.states[0])
    verdict = judge(wrong, start, vehicle, situation.road, Prediction(name="nobody"))
    if verdict.passed:
        raise RuntimeError("a drive whose speed does not fit its path passed")
    return f"convicts a forged drive of {', '.join(sorted({v.name for v in verdict.violations}))}"


def _tracks() -> str:
    from mcdas_opt.catalogue.scenes import load_scene
    from mcdas_opt.simulation.loop import simulate

    scene = load_scene("sandwich-60-40")
    drive = simulate(scene.model_copy(update={"duration_s": 1.0}))
    if drive.unverified_plans:
        raise RuntimeError(f"{drive.unverified_plans} unverified plans")
    return f"{drive.outcome.value} after {drive.duration_s:.1f} s through noisy radar, {drive.plans} plans, 0 unverified"


def _parks() -> str:
    from mcdas_opt.parking.case_file import slot_case
    from mcdas_opt.parking.park import park

    plan = park(slot_case(9.0), "two-arc")
    if not plan.verdict.passed:
        raise RuntimeError(plan.reason)
    return f"two arcs into 9 m in {plan.duration_s:.1f} s, judged"


_SELF_TEST: tuple[tuple[str, Callable[[], str]], ...] = (
    ("a plan", _plans),
    ("the judge", _judges),
    ("the closed loop", _tracks),
    ("parking", _parks),
)
