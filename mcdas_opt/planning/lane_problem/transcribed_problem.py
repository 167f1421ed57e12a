"""The lane problem transcribed for a number of obstacle slots, with its engines; built once a process, twins for every planner."""

from __future__ import annotations

import copy
import os
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property, lru_cache

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.native.form import SWITCH
from mcdas_opt.ocp.lane_mpc import LaneParameters, LaneProblem
from mcdas_opt.planning.lane_problem.lane_parameters import vacant_values
from mcdas_opt.planning.lane_problem.mirror import MirroredParameters
from mcdas_opt.planning.solver_settings import SolverSettings
from mcdas_opt.solvers.held_interrupts import held_interrupts
from mcdas_opt.solvers.interior_point import InteriorPointEngine
from mcdas_opt.solvers.ipopt_engine import IpoptEngine
from mcdas_opt.solvers.osqp_engine import OsqpEngine, OsqpSettings

_BACKUP_QP_ITERATIONS = 100  # of OSQP in each of its steps, where the interior point has no answer


class TranscribedProblem:
    """The lane problem for a number of neighbours, with its engines, each built when first asked for."""

    def __init__(self, lane: LaneProblem, nodes: int) -> None:
        self.slots, self.nodes = lane.neighbours, nodes
        self.osqp_settings = OsqpSettings()
        self.problem = lane.stage_problem()
        self.parameters = LaneParameters(names=self.problem.parameters)
        self.mirrored = MirroredParameters(self.problem.parameters)

    def twin(self, osqp_settings: OsqpSettings | None = None) -> TranscribedProblem:
        """The same problem with engines of its own."""
        twin = copy.copy(self)
        twin.osqp_settings = osqp_settings or self.osqp_settings
        for name in ("interior_point", "osqp", "ipopt"):
            twin.__dict__.pop(name, None)
        twin.__dict__["interior_point"] = self.interior_point.twin()
        return twin

    def forget(self) -> None:
        """What the engines learnt: of these, OSQP its step size."""
        if "osqp" in self.__dict__:
            self.osqp.reset()

    @cached_property
    @held_interrupts()
    def interior_point(self) -> InteriorPointEngine:
        """The engine of choice."""
        return InteriorPointEngine(self.problem, self.nodes)

    @cached_property
    @held_interrupts()
    def osqp(self) -> OsqpEngine:
        """The backup, and the engine of choice where the settings say so."""
        return OsqpEngine(self.problem, self.nodes, self.osqp_settings)

    @cached_property
    @held_interrupts()
    def ipopt(self) -> IpoptEngine:
        """The reference."""
        return IpoptEngine(self.problem, self.nodes)


class TranscribedProblems:
    """One planner's problems, one per number of slots; `kinds` says in which form they are solved. A vehicle that once had its
    zero-sideslip point ahead of the rear axle keeps the problems in which that point, and its share of the steering rate, are parameters,
    at rest too."""

    def __init__(self, vehicle: Vehicle, settings: Settings, solver: SolverSettings) -> None:
        self._vehicle = replace(vehicle, zero_sideslip_point_m=0.0)
        self._settings, self._solver = settings, solver
        self.kinds = ""
        self._built: dict[tuple[int, bool, bool], TranscribedProblem] = {}
        self._constant: dict[tuple[str, ...], Array] = {}

    def __iter__(self) -> Iterator[TranscribedProblem]:
        return iter(self._built.values())

    def holding(self, neighbours: int, vehicle: Vehicle, *, sloping_edges: bool = False) -> TranscribedProblem:
        """The one with the fewest slots that hold so many neighbours (at most the last), built when first asked for; another one where
        the road's edges change along it."""
        slots = next((n for n in self._solver.slots if n >= neighbours), self._solver.slots[-1])
        slips = vehicle.zero_sideslip_point_m > 0.0 or any(slips for _, slips, _ in self._built)
        asked = slots, slips, sloping_edges
        if asked not in self._built:
            weights, nodes = self._solver.weights is not None, self._settings.grid.nodes
            original = _original(self._steered_within_limits(slips), slots, weights, asked[1:], nodes, _circumstances())
            backup = OsqpSettings(qp_iterations=_BACKUP_QP_ITERATIONS)
            self._built[asked] = original.twin(OsqpSettings() if self._solver.solver == "osqp" else backup)
            self.kinds = ", ".join(sorted({built.interior_point.kind for built in self}))
        return self._built[asked]

    def _steered_within_limits(self, slips: bool) -> Vehicle:
        """The vehicle with its share of the steering rate; one that slips has that as a parameter."""
        rate = self._vehicle.steering_rate_max_radps
        return self._vehicle if slips else replace(self._vehicle, steering_rate_max_radps=self._settings.steering_rate_share * rate)

    def constant(self, of: TranscribedProblem) -> Array:
        """(N + 1, np): what stays from cycle to cycle, the weights and nobody in any slot; the rest is to be filled in."""
        names = of.parameters.names
        if names not in self._constant:
            matrix = self._constant[names] = np.full((self._settings.grid.nodes + 1, len(names)), np.nan)
            of.parameters.fill(matrix, vacant_values(range(of.slots)) | dict(self._solver.weights or ()))
        return self._constant[names]


def _circumstances() -> str:
    """What decides which form an engine has."""
    return os.environ.get(SWITCH, "1")


@lru_cache(maxsize=24)
@held_interrupts()
def _original(
    vehicle: Vehicle, slots: int, free_weights: bool, kind: tuple[bool, bool], nodes: int, circumstances: str
) -> TranscribedProblem:
    slips, sloping = kind
    lane = LaneProblem(vehicle=vehicle, neighbours=slots, free_weights=free_weights, slips=slips, sloping_edges=sloping)
    return TranscribedProblem(lane, nodes)
