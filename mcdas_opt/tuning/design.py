"""One design: posed, solved, checked, said in words, and left behind as a TOML that planners take and a picture."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from mcdas_opt.catalogue.toml_text import toml_text
from mcdas_opt.domain.document import to_document
from mcdas_opt.domain.result import Columns, Result
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.sigmoid_design import SigmoidDesign
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.dynamics.sigmoid import renormalised
from mcdas_opt.errors import InputError, ParameterError, writing
from mcdas_opt.ocp.sigmoid_design import OBJECTIVES, SigmoidSolution, solve_sigmoid
from mcdas_opt.tuning.request import DesignRequest

if TYPE_CHECKING:
    from matplotlib.figure import Figure


STEP_M = 0.1
_BINDS = 1e-4  # share of the value that relaxing a limit by its whole self would gain, at first order
_STEPS = {"m/s^2": 1.0, "m/s^3": 1.0, "rad": 0.005, "rad/s": 0.1, "1/m": 0.01, "m": 0.1}  # of "so much more would save"
_FAR_M = 500.0
_SUFFIXES = (".toml", ".png")


@dataclass(frozen=True, slots=True, kw_only=True)
class ConstraintReport:
    """`value` against `limit`; `multiplier` is what `value` of the design gains per unit that the limit is relaxed."""

    name: str
    value: float
    limit: float
    unit: str
    multiplier: float
    sense: str

    @property
    def binds(self) -> bool:
        return self.multiplier > 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class PathSamples:
    """x forward, y left [m], 0.1 m apart from the start of steering; the end, where the target is reached, is included."""

    x_m: Array
    y_m: Array


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Design(Result):
    """The best sigmoid for a request; attributes are the keys of the JSON document. Saved as `.toml` it is what planners take."""

    drawn_by: ClassVar[str] = "mcdas_opt.tuning.design:sheet"

    a_per_m: float
    b: float
    y_max_m: float
    speed_mps: float
    offset_m: float
    side: Side
    length_m: float
    end_m: float
    duration_s: float
    objective: str
    value: float
    unit: str
    constraints: tuple[ConstraintReport, ...]
    active: tuple[str, ...]
    method: str
    evaluations: int
    path: PathSamples
    request: DesignRequest = field(repr=False)

    @property
    def sigmoid(self) -> SigmoidDesign:
        return SigmoidDesign(a_per_m=self.a_per_m, b=self.b, y_max_m=self.y_max_m, offset_m=self.offset_m, side=self.side)

    def to_dict(self) -> dict[str, Any]:
        """The JSON document of the contract."""
        return Result.to_dict(self) | {"request": to_document(self.request)}

    def in_brief(self) -> tuple[str, str, str]:
        bound = ", ".join(row.name for row in self.constraints if row.binds) or "nothing"
        return (
            f"Design ({self.objective}) for {self.speed_mps:.1f} m/s = {3.6 * self.speed_mps:.0f} km/h: {self.value:.4g} {self.unit}",
            f"a = {self.a_per_m:.4g} 1/m, b = {self.b:.4g}, y_max = {self.y_max_m:.3f} m, {self.length_m:.1f} m long",
            f"bound by {bound}; {self.evaluations} evaluations of {self.method}",
        )

    def columns(self) -> Columns:
        """A row for each constraint."""
        names = ("name", "value", "limit", "unit", "multiplier", "sense")
        return {name: [attrgetter(name)(row) for row in self.constraints] for name in names}

    def as_text(self, suffix: str) -> str | None:
        return self.to_toml() if suffix == ".toml" else Result.as_text(self, suffix)

    def to_toml(self) -> str:
        """The TOML: `sigmoid` is what `plan --params` takes, the rest says where it comes from."""
        from importlib.metadata import version

        request = to_document(self.request)
        vehicle = request.pop("vehicle")["name"]
        facts = ("objective", "value", "unit", "length_m", "end_m", "duration_s", "speed_mps", "active")
        document: dict[str, Any] = {
            "sigmoid": {
                "a_per_m": self.a_per_m,
                "b": self.b,
                "y_max_m": self.y_max_m,
                "offset_m": self.offset_m,
                "side": self.side.value,
                "lateral_acceleration_mps2": next(c.limit for c in self.constraints if c.name == "lateral acceleration"),
            },
            "design": {key: to_document(attrgetter(key)(self)) for key in facts},
            "provenance": {
                "made_by": f"mcdas-opt {version('mcdas-opt')} tune",
                "method": self.method,
                "evaluations": self.evaluations,
                "vehicle": vehicle,
                **{f"request_{key}": value for key, value in request.items() if key != "objective"},
            },
            "constraint": [to_document(row) for row in self.constraints],
        }
        return toml_text(document)


def design(request: DesignRequest) -> Design:
    """The optimum of the request. Raises `ParameterError` where there is none, and says what the shortest would be."""
    solution = solve_sigmoid(request.problem())
    if not solution.feasible:
        raise _refused(request)
    return _design(request, solution)


def sampled(sigmoid: SigmoidDesign) -> PathSamples:
    """The path of a design, in the project's frame."""
    end = sigmoid.end_m
    x = np.append(np.arange(0.0, end, STEP_M), end)
    if x[-1] - x[-2] < 1e-6:
        x = np.delete(x, -2)
    y = sigmoid.reach_m * renormalised(x, sigmoid.a_per_m, sigmoid.b, np)
    return PathSamples(x_m=x, y_m=sigmoid.side.sign * y)


def _design(request: DesignRequest, found: SigmoidSolution) -> Design:
    scale = max(abs(found.value), 1e-3)
    reports = tuple(
        ConstraintReport(
            name=term.name,
            value=term.value,
            limit=term.limit,
            unit=term.unit,
            multiplier=term.multiplier if term.multiplier * abs(term.limit) > _BINDS * scale else 0.0,
            sense="at least" if term.at_least else "at most",
        )
        for term in found.terms
        if not (term.at_least and request.objective == "clearance")
    )
    sigmoid = SigmoidDesign(a_per_m=found.a_per_m, b=found.b, y_max_m=found.y_max_m, offset_m=request.offset_m, side=request.side)
    return Design(
        a_per_m=found.a_per_m,
        b=found.b,
        y_max_m=found.y_max_m,
        speed_mps=found.speed_mps,
        offset_m=request.offset_m,
        side=request.side,
        length_m=found.length_m,
        end_m=sigmoid.end_m,
        duration_s=found.length_m / found.speed_mps,
        objective=request.objective,
        value=found.value,
        unit=OBJECTIVES[request.objective],
        constraints=reports,
        active=_words(request.objective, reports, found.at_bounds),
        method="nlp (IPOPT, exact derivatives)",
        evaluations=found.evaluations,
        path=sampled(sigmoid),
        request=request,
    )


def _words(objective: str, reports: tuple[ConstraintReport, ...], at_bounds: tuple[str, ...]) -> tuple[str, ...]:
    """The active set, strongest first: what binds, and what a little more would bring."""
    unit = OBJECTIVES[objective]
    gain = {"shortest": "save", "clearance": "gain", "jerk": "save"}[objective]

    def brings(report: ConstraintReport) -> float:
        return report.multiplier * _step(report)

    said = []
    for report in sorted((r for r in reports if r.binds), key=brings, reverse=True):
        step, more = _step(report), "less" if report.sense == "at least" else "more"
        said.append(f"{report.name} binds; {step:g} {report.unit} {more} would {gain} {brings(report):.2g} {unit}")
    return (*said, *at_bounds)


def _step(report: ConstraintReport) -> float:
    """So much more of a limit that the first order still says something: the unit's usual step, or a tenth of a small limit."""
    usual = _STEPS[report.unit]
    if usual <= 0.5 * abs(report.limit):
        return usual
    return float(f"{0.1 * max(abs(report.limit), 1e-6):.0e}")


def _refused(request: DesignRequest) -> ParameterError:
    """Why nothing satisfies the request, in figures that could be had."""
    km_h = f"{3.6 * request.speed_mps:.0f} km/h"
    under = f"at {km_h} under {_tightest(request):.3g} m/s^2"
    eased = solve_sigmoid(request.eased().problem())
    if not eased.feasible:
        return _contradicted(request, under)
    if request.length_max_m is not None and eased.length_m > request.length_max_m:
        rule = f"no sigmoid settles within {request.length_max_m:g} m {under}: the shortest is {eased.length_m:.3g} m"
        return ParameterError("length_max_m", request.length_max_m, rule, "m")
    for who, other in (("front", request.front), ("rear", request.rear)):
        if other is None or _clearance(request, who, other[0]) >= request.clearance_m:
            continue
        least = _least_gap(request, who)
        clear = f"no sigmoid clears the {who} vehicle by {request.clearance_m:g} m from a gap of {other[0]:.3g} m {under}"
        if least is None:
            across = "right" if request.side is Side.LEFT else "left"
            return ParameterError("offset_m", request.offset_m, f"{clear}, nor from any other gap: it stands in the way; try {across}", "m")
        rule = f"{clear}: the least gap is {least:.3g} m (the shortest sigmoid is {eased.length_m:.3g} m)"
        return ParameterError(f"{who}_gap_m", other[0], rule, "m")
    rule = f"no sigmoid {under} satisfies all limits at once: the shortest with nobody near is {eased.length_m:.3g} m"
    return ParameterError("objective", request.objective, rule)


def _contradicted(request: DesignRequest, under: str) -> ParameterError:
    """Limits that no sigmoid keeps at once, with nobody near: the first one without which there is a design."""
    problem = request.eased().problem()
    for i, term in enumerate(problem.terms):
        freed = (*problem.terms[:i], _freed(term), *problem.terms[i + 1 :])
        found = solve_sigmoid(replace(problem, terms=freed))
        if found.feasible:
            rule = f"no sigmoid {under} keeps this limit and all the others within the bounds: the one that keeps the others reaches"
            return ParameterError(term.name, term.limit, f"{rule} {found.terms[i].value:.3g} {term.unit}", term.unit)
    return ParameterError("limits", "together", f"no sigmoid {under} keeps them within the bounds, nor all but one of them")


def _freed(term: Any) -> Any:
    return replace(term, limit=1e3 * max(abs(term.limit), 1.0))


def _tightest(request: DesignRequest) -> float:
    """The bound on lateral acceleration that counts: the one asked for, or friction's."""
    return min(term.limit for term in request.problem().terms if term.unit == "m/s^2")


def _clearance(request: DesignRequest, who: str, gap_m: float) -> float:
    """The most clearance [m] that any sigmoid has of one vehicle alone, at another gap."""
    alone = replace(request.eased(), objective="clearance")
    if who == "front" and request.front is not None:
        alone = replace(alone, front_gap_m=gap_m, front_speed_mps=request.front[1])
    if who == "rear" and request.rear is not None:
        alone = replace(alone, rear_gap_m=gap_m, rear_speed_mps=request.rear[1])
    return solve_sigmoid(alone.problem()).value


def _least_gap(request: DesignRequest, who: str) -> float | None:
    """By halving, to a centimetre; None where 500 m do not suffice."""
    low, high = 0.0, _FAR_M
    if _clearance(request, who, high) < request.clearance_m:
        return None
    while high - low > 0.01:
        middle = 0.5 * (low + high)
        if _clearance(request, who, middle) < request.clearance_m:
            low = middle
        else:
            high = middle
    return high


def check_out(out: Path) -> Path:
    """Raises `InputError` for a file that is neither a TOML nor a PNG, before anything is computed."""
    if out.suffix.lower() not in _SUFFIXES:
        raise InputError(out, "", None, "must end in .toml or .png: both are written side by side")
    return out


def write_design(design: Design, out: Path) -> tuple[Path, Path]:
    """Writes `out`'s stem as .toml and as .png; returns both."""
    parameters, picture = check_out(out).with_suffix(".toml"), out.with_suffix(".png")
    from mcdas_opt.plotting.style import save_png

    with writing(out):
        parameters.write_text(design.to_toml(), encoding="utf-8")
        save_png(sheet(design), picture, dpi=120)
    return parameters, picture


def sheet(design: Design) -> Figure:
    """The path with its curvature, acceleration and jerk against their limits, and the paper's beside it."""
    from mcdas_opt.plotting.design import design_sheet

    limits = {c.name: c.limit for c in design.constraints}
    return design_sheet(
        design.sigmoid,
        speed_mps=design.speed_mps,
        lane_width_m=design.request.lane_width_m,
        length_m=design.length_m,
        lateral_limit_mps2=min(limits["lateral acceleration"], limits["friction"]),
        jerk_limit_mps3=limits["lateral jerk"],
        vehicle=design.request.vehicle,
        title=f"{design.objective}: {design.length_m:.1f} m at {3.6 * design.speed_mps:.0f} km/h",
    )
