"""The lane problem: kinematic bicycle along the road, the sigmoid offset path as reference, neighbours as moving bodies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.dynamics.bicycle import INPUTS, STATES, road_bicycle
from mcdas_opt.dynamics.integrator import rk4
from mcdas_opt.ocp.terms import (
    BEND,
    AxleFriction,
    CarSizes,
    Comfort,
    Constraint,
    Cost,
    Effort,
    FrictionCircle,
    HeadingDeviation,
    Headway,
    MovingBody,
    PathDeviation,
    RoadEdges,
    RoadEnd,
    SlopingRoadEdges,
    SpeedDeviation,
    Stage,
)
from mcdas_opt.ocp.written_terms import residual_of, rows_of
from mcdas_opt.solvers.barrier_stage import BarrierStage
from mcdas_opt.solvers.stage_problem import Member, ProblemFamily, StageProblem

CENTRE, STEERING_RATE_SHARE = "centre", "steering_rate_share"
HEADWAY_HORIZON_S = 2.5  # of closing speed, kept free
ROAD_MARGIN_M = 0.1  # from the edges to the body


def _costs() -> tuple[Cost, ...]:
    return (
        PathDeviation(weight=2.0, terminal_weight=10.0),
        HeadingDeviation(weight=20.0, terminal_weight=100.0),
        SpeedDeviation(weight=0.2, terminal_weight=1.0),
        Effort(quantity="a", unit="m/s^2", weight=0.1),
        Effort(quantity="jerk", unit="m/s^3", weight=0.01),
        Effort(quantity="delta_rate", unit="rad/s", weight=5.0),
        Effort(quantity="lateral_acceleration", unit="m/s^2", weight=0.02),
    )


def weight_name(cost: Cost) -> str:
    """The parameter that holds a cost's weight where weights are free: 'weight_path_deviation'."""
    return "weight_" + cost.name.split(" [")[0].replace(" ", "_")


def default_weights() -> dict[str, float]:
    """Weight of every cost per node, by `weight_name`; the terminal ones keep their ratio to it."""
    return {weight_name(cost): cost.weight for cost in _costs()}


@dataclass(frozen=True, slots=True, kw_only=True)
class SlackPenalty:
    """Exact penalty of a family of soft rows: linear per unit, and quadratic; `scale` is its order of magnitude."""

    linear: float
    quadratic: float
    scale: float


def _penalties() -> dict[str, SlackPenalty]:
    return {
        "friction": SlackPenalty(linear=1000.0, quadratic=500.0, scale=0.05),
        "road": SlackPenalty(linear=1000.0, quadratic=500.0, scale=0.03),
        "collision": SlackPenalty(linear=400.0, quadratic=200.0, scale=0.05),
        "headway": SlackPenalty(linear=2.0, quadratic=1.0, scale=1.0),
        "comfort": SlackPenalty(linear=20.0, quadratic=10.0, scale=0.1),
    }


@dataclass(frozen=True, slots=True, kw_only=True)
class LaneProblem:
    """What is wanted of the host, and what binds it: read top to bottom. Weights are per node of 0.1 s."""

    vehicle: Vehicle
    neighbours: int
    road_margin_m: float = ROAD_MARGIN_M
    limit_margin: float = 0.995
    costs: tuple[Cost, ...] = field(default_factory=_costs)
    free_weights: bool = False  # the weights are parameters of every node, `weight_<cost>`: one compiled problem for all of them
    sloping_edges: bool = False  # the road's edges change along it
    slips: bool = False  # the car does; parameters are what its axles leave of the friction circle, the share of the steering rate that
    # plans may use, and `centre`, the body centre's lead over the point that moves along the car's axis
    penalties: dict[str, SlackPenalty] = field(default_factory=_penalties)

    @property
    def constraints(self) -> tuple[Constraint, ...]:
        bodies = tuple(MovingBody(slot=i) for i in range(self.neighbours))
        return (
            AxleFriction() if self.slips else FrictionCircle(),
            SlopingRoadEdges(margin=self.road_margin_m) if self.sloping_edges else RoadEdges(margin=self.road_margin_m),
            RoadEnd(),
            Headway(horizon_s=HEADWAY_HORIZON_S),
            Comfort(),
            *bodies,
        )

    def stage_problem(self) -> StageProblem:
        problem = self._posed(self.vehicle)
        return replace(problem, member=self._member(problem)) if self._is_of_family() else problem

    def _posed(self, car: CarSizes | None) -> StageProblem:
        """For a car of these sizes; without one they are its last parameters."""
        vehicle, costs, constraints = self.vehicle, self.costs, self.constraints
        free = [weight_name(cost) for cost in costs] if self.free_weights else []
        asked = [p for cost in costs for p in cost.parameters] + [p for row in constraints for p in row.parameters] + free
        last = [*([STEERING_RATE_SHARE, CENTRE] if self.slips else []), *([] if car else SIZES)]
        parameters = tuple(dict.fromkeys([*BEND, *asked, *last]))
        x, u = ca.SX.sym("x", len(STATES)), ca.SX.sym("u", len(INPUTS))
        p, h = ca.SX.sym("p", len(parameters)), ca.SX.sym("h")
        named = {name: p[i] for i, name in enumerate(parameters)}
        values: dict[str, Any] = {name: x[i] for i, name in enumerate(STATES)}
        values |= {"jerk": u[0], "delta_rate": named[STEERING_RATE_SHARE] * u[1] if self.slips else u[1]}
        sizes: CarSizes = car or _SymbolicSizes(*(named[name] for name in SIZES))
        centre = named.get(CENTRE, vehicle.centre_m)
        stage = Stage(**values, p=named, m=ca, vehicle=sizes, centre=centre)

        def right_side(state: Any) -> list[Any]:
            kappa = named["kappa"] + named["kappa_slope"] * (state[0] - named["kappa_s"])
            return road_bicycle(state, [stage.jerk, stage.delta_rate], kappa, sizes.wheelbase_m, centre, ca)

        step = rk4(right_side, ca.vertsplit(x), h)
        root, terminal_root = self._roots(named, in_symbols=car is None)
        residuals = [(c, residual_of(c, stage)) for c in costs]
        running = [root(c) * residual for c, residual in residuals]
        terminal = [terminal_root(c) * residual for c, residual in residuals if c.terminal_weight > 0.0]
        families = {family: column for column, family in enumerate(self.penalties)}
        rows = [(c.slack, c.name, row) for c in constraints for row in rows_of(c, stage, self.penalties)]
        m = self.limit_margin
        inf = np.inf
        return StageProblem(
            name="lane",
            dynamics=ca.Function("dynamics", [x, u, p, h], [ca.vertcat(*step)]),
            residual=ca.Function("residual", [x, u, p], [ca.vertcat(*running)]),
            terminal_residual=ca.Function("terminal_residual", [x, p], [ca.vertcat(*terminal)]),
            inequality=ca.Function("inequality", [x, u, p], [ca.vertcat(*(row for _, _, row in rows))]),
            slack_of=tuple(families[slack] for slack, _, _ in rows),
            slack_linear=np.array([self.penalties[f].linear for f in families]),
            slack_quadratic=np.array([self.penalties[f].quadratic for f in families]),
            x_lower=np.array([-inf, -inf, -1.2, 0.0, m * vehicle.acceleration_min_mps2, -m * vehicle.steering_max_rad]),
            x_upper=np.array([inf, inf, 1.2, m * vehicle.speed_max_mps, m * vehicle.acceleration_max_mps2, m * vehicle.steering_max_rad]),
            u_lower=np.array([m * vehicle.jerk_min_mps3, -m * vehicle.steering_rate_max_radps]),
            u_upper=np.array([m * vehicle.jerk_max_mps3, m * vehicle.steering_rate_max_radps]),
            x_scale=np.array([1.0, 0.3, 0.05, 0.5, 1.0, 0.02]),
            u_scale=np.array([5.0, 0.2]),
            s_scale=np.array([self.penalties[f].scale for f in families]),
            states=STATES,
            inputs=INPUTS,
            parameters=parameters,
            rows=tuple(name for _, name, _ in rows),
            slacks=tuple(families),
        )

    def _roots(self, named: dict[str, Any], *, in_symbols: bool) -> tuple[Callable[[Cost], Any], Callable[[Cost], Any]]:
        """Of the weights, of a node and of the last one; without a division where speed matters."""
        if in_symbols:
            roots = {cost.name: ca.sqrt(named[weight_name(cost)]) for cost in self.costs}
            return lambda c: roots[c.name], lambda c: np.sqrt(c.terminal_weight / c.weight) * roots[c.name]
        factor = {c.name: named[weight_name(c)] / c.weight if self.free_weights else 1.0 for c in self.costs}
        return lambda c: ca.sqrt(c.weight * factor[c.name]), lambda c: ca.sqrt(c.terminal_weight * factor[c.name])

    def _is_of_family(self) -> bool:
        """Whether it differs from `lane_family` in numbers, numbers of bodies and parameters alone."""
        return self == LaneProblem(
            vehicle=self.vehicle,
            neighbours=self.neighbours,
            free_weights=self.free_weights,
            sloping_edges=self.sloping_edges,
            slips=self.slips,
        )

    def _member(self, problem: StageProblem) -> Member:
        fixed = {**default_weights(), CENTRE: self.vehicle.centre_m, STEERING_RATE_SHARE: 1.0, "brakes_by_load": 1.0, "driving_pull": 1.0}
        names, known = family_parameters(), {name: i for i, name in enumerate(problem.parameters)}
        sizes = [getattr(self.vehicle, name) for name in SIZES]
        limits = [limit for _, _, limit in BarrierStage(problem).bounds]
        return Member(
            numbers=np.array([*sizes, *limits]),
            times=self.neighbours,
            columns=np.array([known.get(name, -1) for name in names], dtype=np.int64),
            fixed=np.array([fixed.get(name, 0.0) for name in names]),
            first_of_row=known[MovingBody(slot=0).parameters[0]] if self.neighbours else 0,
        )


class _SymbolicSizes(NamedTuple):
    wheelbase_m: Any
    length_m: Any
    width_m: Any


SIZES = _SymbolicSizes._fields


def _general() -> LaneProblem:
    return LaneProblem(vehicle=Vehicle(), neighbours=0, free_weights=True, sloping_edges=True, slips=True)


@cache
def family_parameters() -> tuple[str, ...]:
    """Of a node, without those of the bodies and without the sizes."""
    return tuple(name for name in _general()._posed(None).parameters if name not in SIZES)


def lane_family() -> ProblemFamily:
    """Lane problems of all vehicles, for any number of neighbours."""
    problem, body = _general()._posed(None), MovingBody(slot=0)
    x, sizes, own = ca.SX.sym("x", len(STATES)), ca.SX.sym("sizes", len(SIZES)), ca.SX.sym("own", len(body.parameters))
    values = {name: x[i] for i, name in enumerate(STATES)} | dict.fromkeys(INPUTS, 0.0)
    named = {name: own[i] for i, name in enumerate(body.parameters)}
    (row,) = body.rows(Stage(**values, p=named, m=ca, vehicle=_SymbolicSizes(*ca.vertsplit(sizes)), centre=0.0))
    return ProblemFamily(
        problem=problem,
        sizes=len(SIZES),
        row=ca.Function("row", [x, sizes, own], [row]),
        row_parameters=len(body.parameters),
        row_slack=problem.slacks.index(body.slack),
    )


FAR_M = 1.0e4


@dataclass(frozen=True, slots=True, kw_only=True)
class LaneParameters:
    """Names to columns: fills the (N + 1, np) parameter matrix of a lane problem."""

    names: tuple[str, ...]
    columns: dict[str, int] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        require_types(self)
        object.__setattr__(self, "columns", {name: i for i, name in enumerate(self.names)})

    def matrix(self, nodes: int, *groups: dict[str, Any]) -> Array:
        """Each value a number or a vector of N + 1; every name once (KeyError: a programming error)."""
        given = [name for values in groups for name in values]
        if sorted(given) != sorted(self.names):
            raise KeyError(f"parameters {sorted(set(given) ^ set(self.names))} are unknown, missing or given twice")
        matrix = np.empty((nodes + 1, len(self.names)))
        for values in groups:
            self.fill(matrix, values)
        return matrix

    def without_value(self, matrix: Array) -> str:
        """Says which columns were not filled; empty where all were."""
        missing = [name for name, column in self.columns.items() if np.isnan(matrix[:, column]).any()]
        return f"no value for {', '.join(missing)}" if missing else ""

    def fill(self, matrix: Array, values: dict[str, Any]) -> None:
        """Writes some of the columns; a value that no term of the problem asks for goes nowhere."""
        for name, value in values.items():
            column = self.columns.get(name)
            if column is not None:
                matrix[:, column] = value
