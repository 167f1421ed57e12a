"""The exchange loop: solve, roll the solution out, add collision checks where the clearance dips between nodes, solve again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.rules import Array
from mcdas_opt.errors import ParameterError, nearest
from mcdas_opt.geometry.clearance import separating_lines
from mcdas_opt.parking.obstacle_separations import separation
from mcdas_opt.parking.program.manoeuvre import Manoeuvre, node_poses, with_solution
from mcdas_opt.parking.program.nlp import solve_parking
from mcdas_opt.parking.program.records import CORNERS, FORMS, SOLVERS, Checks, ParkingCosts, ParkingPhysics, ParkingProgram, ParkingSolution
from mcdas_opt.parking.program.stages import Stages
from mcdas_opt.parking.world import World

Place = tuple[int, int, int]  # of a check: interval, polygon of the world, roll-out point of the interval
_SOUND = 1e-5  # a solution's violation


@dataclass(frozen=True, slots=True, kw_only=True)
class ExchangeSettings:
    """Caps are counts. Distances in metres, angles in radians."""

    rounds: int = 9
    rounds_unsound: int = 16  # as long as no round was sound
    work: int = 40_000  # iterations times intervals, after which a loop that has an answer ends ...
    work_unsound: int = 1_000_000  # ... and one that has none
    checks: int = 24  # per interval
    close_m: float = 0.06  # passing nearer than this beyond the clearance asks for checks inside the interval ...
    spacing_m: float = 0.1  # ... that the car passes at most so far apart
    near_m: float = 0.7  # obstacles nearer than this are checked
    trust_m: float = 0.7
    trust_rad: float = 0.4
    trust_room: float = 0.7  # share of a pose's clearance that it may move, where that is more
    per_interval: int = 96  # roll-out points per interval
    margin_m: float = 2e-4  # more clearance than asked, for what lies between roll-out points
    max_iterations: int = 120
    tolerance: tuple[float, float] = (1e-5, 1e-5)  # of the solver: in the first round, and in those that begin from its answer
    end_share: float = 0.995  # of the end tolerance that may be used: in narrow slots it is worth a tenth of the time
    gain: float = 0.01  # stop when a round gains less than this share ...
    patience: int = 2  # ... on each of so many rounds before it; with 0 the first sound round is the last
    around_m: tuple[float, ...] = (0.0, 0.025, 0.06)  # where else to check where the clearance dips
    nearly_m: float = 1e-3  # what lacks less than this is asked for as well ...
    nearly_later_m: float = 5e-3  # ... and this, once so many rounds have not been sound:
    later_from: int = 5
    drift_m: float = 0.0  # a roll-out that ends nearer than this to a held end has drifted there, and the next round makes up for it
    astray: float = 5e-3  # a round that ends with a larger violation is not followed: back to the best or the first guess, ...
    restarts: int = 2  # ... at most so often, with the checks found so far and less trust
    trust_from: int = 2  # round after which the box of trust ...
    trust_shrinks: float = 0.5  # ... shrinks, every round, ...
    trust_settles: float = 0.12  # ... and by this once a round is no more than `gain` from the duration of the one before
    form: str = "half-planes"  # of the collision checks; or "duals"
    solver: str = "ipopt"  # or "fatrop", which IPOPT answers for where it finds nothing sound, and where it cannot be asked

    def __post_init__(self) -> None:
        if self.form not in FORMS:
            raise ParameterError("checks", self.form, f"is unknown; {nearest(self.form, FORMS)}")
        if self.solver not in SOLVERS:
            raise ParameterError("solver", self.solver, f"is unknown; {nearest(self.solver, SOLVERS)}")


@dataclass(frozen=True, slots=True)
class Exchanged:
    """The best sound manoeuvre of the loop (None when no round gave one), what the last round lacked, and where it had to look."""

    best: Manoeuvre | None
    last: Manoeuvre
    lacking_m: float
    rounds: int
    iterations: int
    checked: frozenset[Place] = frozenset()


def exchange(
    case: ParkingCase,
    world: World,
    first: Manoeuvre,
    costs: ParkingCosts,
    settings: ExchangeSettings,
    end_steering_rad: float | None = None,
    checked: frozenset[Place] = frozenset(),
) -> Exchanged:
    """Improve a manoeuvre: every round's solution is rolled out and measured between its nodes.

    The start is held; the goal within a share of its tolerance, or exactly, with the steering angle there, where that is given.
    `checked` are places to look at from the first round on.
    """
    asked = case.limits.clearance_m
    car = case.vehicle
    physics = ParkingPhysics(
        car.wheelbase_m,
        world.body.rear,
        world.body.front,
        world.body.half_width,
        case.limits.acceleration_mps2,
        car.steering_rate_max_radps,
        asked + settings.margin_m,
    )
    whole = world.whole
    centre = 0.5 * (first.nodes[:, :2].max(0) + first.nodes[:, :2].min(0))
    spread = float(np.hypot(*(first.nodes[:, :2] - centre).T).max())
    near = whole.near(float(centre[0]), float(centre[1]), spread + world.body.reach + 2.0)
    rank = {int(k): place for place, k in enumerate(near)}
    if near.size < len(whole.polygons):
        world = World(world.body, whole.only(near), [world.owner[int(k)] for k in near])
    current, best = first, None
    missed = np.zeros(3)  # by how much the roll-out ends elsewhere than the program, where that leaves the tolerance or the end is held
    kept = {(k, rank[polygon], point) for k, polygon, point in checked if polygon in rank}
    durations = [0.0, 0.0]
    iterations, lacking, margin, trust = 0, np.inf, settings.margin_m, 1.0
    rounds, restarts, shrinks_from = 0, 0, settings.trust_from
    poses, fractions = node_poses(case, current, settings.per_interval)
    apart = _apart(world, poses)
    for rounds in range(1, settings.rounds_unsound + 1):
        work = iterations * len(current.steps)
        if work > settings.work_unsound or (best is not None and (rounds > settings.rounds or work > settings.work)):
            break
        program = _program(case, world, current, poses, fractions, apart, kept, settings, trust)
        slack = settings.end_share * _end_slack(case) if end_steering_rad is None else np.zeros(3)
        program.nodes_low[-1, :3] -= slack + missed
        program.nodes_high[-1, :3] += slack - missed
        if end_steering_rad is not None:
            program.nodes[-1, 4] = program.nodes_low[-1, 4] = program.nodes_high[-1, 4] = end_steering_rad
        tried, solution = _solved(program, physics._replace(clearance_m=asked + margin), costs, settings, warm=rounds > 1)
        iterations += tried
        if solution.violation > settings.astray and restarts < settings.restarts:
            restarts += 1
            current = best if best is not None else first
            trust, shrinks_from = settings.trust_shrinks**restarts, rounds + settings.trust_from
            poses, fractions = node_poses(case, current, settings.per_interval)
            apart = _apart(world, poses)
            continue
        if not solution.violation <= 0.5:
            break
        current = with_solution(current, solution.nodes, solution.steps)
        poses, fractions = node_poses(case, current, settings.per_interval)
        apart = _apart(world, poses)
        least = float(apart.min(initial=np.inf))
        lacking = max(asked - least, solution.violation - 1e-5, 0.0)
        kept |= _dips(apart, asked + margin, _ways(current), settings.around_m)
        off = poses[-1, -1] - current.nodes[-1, :3]
        ends_well = end_steering_rad is not None or _arrived(case, poses[-1, -1])
        if not ends_well or (end_steering_rad is not None and float(np.abs(off).max()) < settings.drift_m):
            missed = off
        if least >= asked - 1e-6 and solution.violation < _SOUND and ends_well:
            if best is None or current.duration_s < best.duration_s:
                best = current
            margin = settings.margin_m
            least_before = min(durations[2 - settings.patience :], default=np.inf)
            if least_before > (1.0 - settings.gain) * best.duration_s:  # what was allowed more was no faster
                break
        elif lacking < (settings.nearly_m if rounds < settings.later_from else settings.nearly_later_m):
            margin += lacking
        settled = abs(current.duration_s - durations[-1]) <= settings.gain * current.duration_s
        durations = [*durations, current.duration_s][-2:]
        if rounds >= shrinks_from:
            trust = max(trust * (settings.trust_settles if settled else settings.trust_shrinks), 0.05)
    places = frozenset((k, int(near[polygon]), point) for k, polygon, point in kept)
    return Exchanged(best, current, lacking, rounds, iterations, places)


def _solved(
    program: ParkingProgram, physics: ParkingPhysics, costs: ParkingCosts, settings: ExchangeSettings, *, warm: bool
) -> tuple[int, ParkingSolution]:
    """(iterations of both solvers, solution)."""
    tried = 0
    if settings.solver == "fatrop" and settings.form == "half-planes" and costs.clearance == 0.0:
        first = Stages(program, physics, costs, settings.max_iterations, warm).solve()
        if first.violation < _SOUND:
            return first.iterations, first
        tried = first.iterations
    second = solve_parking(
        program, physics, costs, settings.max_iterations, warm=warm, form=settings.form, tolerance=settings.tolerance[int(warm)]
    )
    return tried + second.iterations, second


def _ways(manoeuvre: Manoeuvre) -> Array:
    """(n,) metres driven in each interval."""
    speed = np.abs(manoeuvre.nodes[:, 3])
    return np.asarray(0.5 * (speed[1:] + speed[:-1]) * manoeuvre.steps)


def _apart(world: World, poses: Array) -> Array:
    """(n, m, polygons): distances along the roll-out."""
    n, m = poses.shape[:2]
    return separation(world.whole, poses.reshape(-1, 3), world.body).reshape(n, m, len(world.whole.polygons))


def _dips(apart: Array, asked: float, way: Array, around_m: tuple[float, ...]) -> set[Place]:
    """(interval, polygon, point) where the clearance falls short, and places around it: the next solution dips a little farther on.

    `way` (n,) is how far the car goes in each interval [m].
    """
    found = set()
    per = apart.shape[1] - 1
    worst = apart.argmin(axis=1)
    least = apart.min(axis=1)
    for k, polygon in zip(*np.nonzero(least < asked - 5e-5), strict=True):
        at = int(k) * per + int(worst[k, polygon])
        each = max(float(way[k]) / per, 1e-4)
        for offset in around_m:
            steps = max(1, round(offset / each)) if offset else 0
            for there in (at - steps, at + steps):
                if 0 < there < per * len(apart):
                    found.add((there // per, int(polygon), there % per))
    return found


def _program(
    case: ParkingCase,
    world: World,
    manoeuvre: Manoeuvre,
    poses: Array,
    fractions: Array,
    apart: Array,
    kept: set[Place],
    settings: ExchangeSettings,
    trust: float,
) -> ParkingProgram:
    wanted: list[list[tuple[float, int, int]]] = [[] for _ in manoeuvre.steps]
    reach = settings.trust_m + settings.trust_rad * world.body.reach
    near = case.limits.clearance_m + settings.close_m + min(settings.near_m, trust * reach)
    for k, polygon in zip(*np.nonzero(apart[:, 0] < near), strict=True):
        if manoeuvre.gears[k] != 0.0:
            wanted[k].append((float(apart[k, 0, polygon]), int(polygon), 0))
    least = apart.min(axis=1)
    for k, polygon in zip(*np.nonzero(least < case.limits.clearance_m + settings.close_m), strict=True):
        pieces = int(np.ceil(abs(manoeuvre.nodes[k : k + 2, 3]).mean() * manoeuvre.steps[k] / settings.spacing_m))
        for piece in range(1, pieces):
            point = round(piece * settings.per_interval / pieces)
            kept.add((int(k), int(polygon), point))
    for k, polygon, point in sorted(kept):
        wanted[k].append((float(apart[k, point, polygon]), polygon, point))
    places = [(k, polygon, point) for k, entries in enumerate(wanted) for _, polygon, point in sorted(set(entries))[: settings.checks]]
    checks = _checks(world, np.array(places, dtype=np.int64).reshape(-1, 3), poses, fractions)
    low, high = _node_bounds(case, manoeuvre, apart[:, 0].min(axis=1, initial=np.inf), settings, trust)
    segments = np.concatenate([[0], np.cumsum(manoeuvre.segments[1:] != manoeuvre.segments[:-1])]).astype(np.int64)
    first = np.flatnonzero(np.concatenate([[True], np.diff(segments) > 0]))
    stands = manoeuvre.gears[first] == 0.0
    return ParkingProgram(
        nodes=np.clip(manoeuvre.nodes, low, high),
        nodes_low=low,
        nodes_high=high,
        segments=segments,
        steps=manoeuvre.steps[first],
        steps_low=np.where(stands, 0.0, 2e-3),
        steps_high=np.where(stands, 2.0 * case.vehicle.steering_max_rad / case.vehicle.steering_rate_max_radps, 4.0),
        checks=checks,
    )


def _checks(world: World, places: NDArray[np.int64], poses: Array, fractions: Array) -> Checks:
    """Lines and vertices for checks at (interval, polygon, point) rows."""
    m = len(places)
    angles, offsets, vertices = np.zeros(m), np.zeros(m), np.zeros((m, CORNERS, 2))
    for polygon in np.unique(places[:, 1]):
        rows = np.flatnonzero(places[:, 1] == polygon)
        shape = world.whole.polygons[int(polygon)]
        at = poses[places[rows, 0], places[rows, 2]]
        angles[rows], offsets[rows] = separating_lines(at, world.body, shape)
        depth = np.column_stack([np.cos(angles[rows]), np.sin(angles[rows])]) @ shape.T
        order = np.argsort(-depth, axis=1, kind="stable")[:, np.arange(CORNERS) % min(CORNERS, len(shape))]
        vertices[rows] = shape[order]
    return Checks(intervals=places[:, 0], fractions=fractions[places[:, 2]], vertices=vertices, angles=angles, offsets=offsets)


def _node_bounds(case: ParkingCase, manoeuvre: Manoeuvre, room: Array, settings: ExchangeSettings, share: float) -> tuple[Array, Array]:
    """A box of trust around every pose, the gear's speeds, rest where the gear changes, and both ends held."""
    limits, top = case.limits, case.vehicle.steering_max_rad
    reach = share * np.append(np.clip(settings.trust_room * room, settings.trust_m, 4.0 * settings.trust_m), settings.trust_m)[:, None]
    trust = reach * np.array([1.0, 1.0, settings.trust_rad / settings.trust_m])
    low, high = manoeuvre.nodes.copy(), manoeuvre.nodes.copy()
    low[:, :3] -= trust
    high[:, :3] += trust
    gears = _gear_at_nodes(manoeuvre.gears)
    low[:, 3] = np.where(gears < 0.0, -limits.reverse_mps, 0.0)
    high[:, 3] = np.where(gears > 0.0, limits.forward_mps, 0.0)
    low[:, 4], high[:, 4] = -top, top
    low[0], high[0] = [*case.start, 0.0, case.start_steering_rad], [*case.start, 0.0, case.start_steering_rad]
    turns = np.round((manoeuvre.nodes[-1, 2] - case.goal[2]) / (2.0 * np.pi)) * 2.0 * np.pi
    low[-1, :4] = high[-1, :4] = [case.goal[0], case.goal[1], case.goal[2] + turns, 0.0]
    return low, high


def _end_slack(case: ParkingCase) -> Array:
    """(x, y, heading): a box inside the circle of the end tolerance, longer across the goal's heading where that lies along an axis."""
    across, along = 0.95, 0.3
    c, s = abs(float(np.cos(case.goal[2]))), abs(float(np.sin(case.goal[2])))
    shape = (along, across) if s < 0.05 else (across, along) if c < 0.05 else (0.7, 0.7)
    return np.array([*(case.tolerance.position_m * q for q in shape), case.tolerance.heading_rad])


def _arrived(case: ParkingCase, pose: Array) -> bool:
    """Within the end tolerance; a long interval's one Runge-Kutta step in the program may end some tenths of a millimetre off."""
    off = pose - case.goal
    turn = abs(float((off[2] + np.pi) % (2.0 * np.pi) - np.pi))
    return float(np.hypot(off[0], off[1])) <= case.tolerance.position_m and turn <= case.tolerance.heading_rad


def _gear_at_nodes(gears: Array) -> Array:
    """+1 or -1 where the intervals before and after a node go the same way (standstill looked through), else 0."""
    n = len(gears)
    before, after = np.zeros(n + 1), np.zeros(n + 1)
    for k in range(n):
        before[k + 1] = gears[k] if gears[k] != 0.0 else before[k]
        after[n - 1 - k] = gears[n - 1 - k] if gears[n - 1 - k] != 0.0 else after[n - k]
    return np.where(before == after, before, 0.0)
