"""The last stage of the search for a witness: a nonlinear program, begun from the best of the finer library."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.domain.grid import TimeGrid
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import PredictedBody
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.evaluation.evasive_profiles import DrivenProfiles, drive_profiles, evasive_profiles
from mcdas_opt.evaluation.oracle import lane_kept_until, passed, seen_from
from mcdas_opt.geometry.clearance import Body, separating_lines
from mcdas_opt.geometry.rectangle import corners
from mcdas_opt.manoeuvres.clearance import clearance
from mcdas_opt.ocp.lane_mpc import FAR_M, LaneParameters
from mcdas_opt.ocp.side_constrained_lane import SideConstrainedLaneProblem
from mcdas_opt.ocp.terms import BODY_BEND
from mcdas_opt.planning.lane_problem.roll_out import roll_out
from mcdas_opt.solvers.ipopt_engine import IpoptEngine
from mcdas_opt.solvers.stage_problem import StageGuess

_NODES = 80
_LINES = 4  # neighbours that the host is separated from; the nearest of each start
_STARTS = 2
_ROUNDS = 2  # lines are drawn anew after each
_ITERATIONS = 60
_HOPELESS_M = -0.6  # a start that overlaps by more is not tried
_APART_M = 0.03  # kept from the lines, for what happens between nodes
_DIFFERENT_M = 1.0  # starts differ by so much on average


def optimised_witness_from(scene: Scene, start_s: float, bodies: tuple[PredictedBody, ...]) -> tuple[Trajectory | None, int]:
    """A drive that keeps its lane and speed until `start_s`, then does what the program found, and passes the judge; how many starts were
    tried. Straight roads only: elsewhere there is none."""
    road, vehicle = scene.true_road, scene.vehicle
    left = scene.duration_s - start_s
    if not road.is_straight or left < _NODES * 0.01:
        return None, 0
    begin, later = lane_kept_until(scene, start_s), seen_from(bodies, start_s)
    grid = TimeGrid(steps_s=np.full(_NODES, min(left / _NODES, 0.1)))
    tried = drive_profiles(evasive_profiles(road, vehicle, begin.d_m), grid.times_s, begin, vehicle, road)
    starts = _starts(tried, later, scene)
    for states, inputs in starts:
        drive = _solved(scene, begin, grid, later, states, inputs)
        whole = None if drive is None else passed(scene, drive, start_s, bodies)
        if whole is not None:
            return whole, len(starts)
    return None, len(starts)


def _starts(tried: DrivenProfiles, bodies: tuple[PredictedBody, ...], scene: Scene) -> list[tuple[Array, Array]]:
    """States and inputs of the members with the most room that differ from one another."""
    road, vehicle = scene.true_road, scene.vehicle
    least = clearance(tried.paths(), tried.times_s, bodies, vehicle, road).separation_m.min(-1)
    least = np.where(tried.on_road(vehicle, road), least, -np.inf)
    chosen: list[int] = []
    for member in np.argsort(-least, kind="stable"):
        if least[member] < _HOPELESS_M or len(chosen) == _STARTS:
            break
        place = tried.states[member, :, :2]
        if all(np.abs(place - tried.states[other, :, :2]).mean() > _DIFFERENT_M for other in chosen):
            chosen.append(int(member))
    return [(tried.states[member], tried.inputs[member]) for member in chosen]


def _solved(
    scene: Scene, begin: HostState, grid: TimeGrid, bodies: tuple[PredictedBody, ...], states: Array, inputs: Array
) -> Trajectory | None:
    vehicle, road = scene.vehicle, scene.true_road
    engine = _engine(vehicle)
    problem = engine.problem
    fixed = {
        **dict.fromkeys(BODY_BEND, 0.0),
        "grip": road.grip_mps2,
        "left_edge": road.left_edge_m,
        "right_edge": road.right_edge_m,
        "road_end": FAR_M if road.road_end_s_m is None else road.road_end_s_m,
    }
    for _ in range(_ROUNDS):
        p = LaneParameters(names=problem.parameters).matrix(_NODES, fixed | _lines(vehicle, grid, bodies, states))
        guess = StageGuess(x=states, u=inputs, s=np.zeros((_NODES + 1, problem.ns)))
        outcome = engine.solve(begin.to_vector(), p, grid.steps_s, guess, _ITERATIONS)
        if not outcome.usable:
            return None
        states, inputs = outcome.x, outcome.u
        if float(outcome.s.max()) < 1e-3:
            break
    return roll_out(begin, states[:, 3], inputs, grid, vehicle, road)


def _lines(vehicle: Vehicle, grid: TimeGrid, bodies: tuple[PredictedBody, ...], states: Array) -> dict[str, Array]:
    """For the nearest bodies, the line at each node that separates the host, as it is in `states`, from them best."""
    psi = states[:, 2]
    centre = vehicle.centre_m
    poses = np.column_stack([states[:, 0] - centre * np.cos(psi), states[:, 1] - centre * np.sin(psi), psi])
    shape = Body(rear=-vehicle.rear_overhang_m, front=vehicle.wheelbase_m + vehicle.front_overhang_m, half_width=0.5 * vehicle.width_m)
    found: list[tuple[float, Array, Array]] = []
    for body in bodies:
        motion = body.at(grid.times_s)
        apart = np.hypot(motion.s_m - states[:, 0], motion.d_m - states[:, 1])
        polygons = corners(motion.s_m, motion.d_m, motion.heading_rad, body.length_m, body.width_m)
        parts = [separating_lines(poses[k : k + 1], shape, polygons[k]) for k in range(len(poses))]
        angles, offsets = (np.array([float(part[i][0]) for part in parts]) for i in (0, 1))
        found.append((float(apart.min()), angles, offsets + _APART_M))
    found.sort(key=lambda one: one[0])
    values: dict[str, Array] = {}
    for slot in range(_LINES):
        there = slot < len(found)
        values[f"line{slot}_angle"] = found[slot][1] if there else np.zeros(len(states))
        values[f"line{slot}_offset"] = found[slot][2] if there else np.full(len(states), -FAR_M)
    return values


@lru_cache(maxsize=4)
def _engine(vehicle: Vehicle) -> IpoptEngine:
    return IpoptEngine(SideConstrainedLaneProblem(vehicle=vehicle, neighbours=_LINES).stage_problem(), _NODES, tolerance=1e-5)
