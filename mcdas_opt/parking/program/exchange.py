"""The exchange loop: solve, roll the solution out, add collision checks where the clearance dips between nodes, solve again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.rules import Array, non_negative, positive, require, within
from mcdas_opt.errors import ParameterError, nearest
from mcdas_opt.parking.cost import ParkingCosts
from mcdas_opt.parking.program.bounds import end_slack, node_bounds
from mcdas_opt.parking.program.collision_checks import Place, RollOut, checks_at, dips_of, places
from mcdas_opt.parking.program.manoeuvre import Manoeuvre, with_solution
from mcdas_opt.parking.program.nlp import solve_parking
from mcdas_opt.parking.program.records import FORMS, SOLVERS, ParkingPhysics, ParkingProgram, ParkingSolution
from mcdas_opt.parking.program.stages import Stages
from mcdas_opt.parking.soundness import arrived
from mcdas_opt.parking.world import World

MAX_ITERATIONS = 120  # of one program
MARGIN_M = 2e-4  # more clearance than asked, for what lies between roll-out points
_SOUND = 1e-5  # a solution's violation
_LEAST_CLEARANCE_M = 1e-6  # that rounding may take
_NO_SOLUTION = 0.5  # a solution's violation beyond which the loop ends
_NEAR_M = 0.7  # obstacles nearer than this are checked
_GAIN = 0.01  # a round that gains less than this share is no gain
_ASTRAY = 5e-3  # a round that ends with a larger violation is not followed
_LATER_FROM = 5  # round from which `nearly_later_m` is asked for
_SHRINKS_FROM = 2  # round after which the trust region ...
_SHRINKS_BY = 0.5  # ... shrinks, every round, ...
_SETTLES_BY = 0.12  # ... and by this once a round is no more than `_GAIN` from the duration of the one before, ...
_LEAST_SHARE = 0.05  # ... to this


@dataclass(frozen=True, slots=True, kw_only=True)
class ExchangeSettings:
    """Caps are counts. Distances in metres, angles in radians."""

    rounds: int = 9
    rounds_unsound: int = 16  # as long as no round was sound
    work: int = 40_000  # iterations times intervals, after which a loop that has an answer ends ...
    work_unsound: int = 1_000_000  # ... and one that has none
    trust_region_m: float = 0.7
    trust_region_rad: float = 0.4
    tolerance: tuple[float, float] = (1e-5, 1e-5)  # of the solver: in the first round, and in those that begin from its answer
    end_share: float = 0.995  # of the end tolerance that may be used: in narrow slots it saves a tenth of the time
    patience: int = 2  # stop when a round gains nothing on each of so many before it; with 0 the first sound round is the last
    nearly_m: float = 1e-3  # what lacks less than this is asked for as well ...
    nearly_later_m: float = 5e-3  # ... and this, in later rounds
    drift_m: float = 0.0  # a roll-out that ends nearer than this to a fixed end has drifted there, and the next round makes up for it
    restarts: int = 2  # from the best or the first guess, after a round that went astray
    form: str = "half-planes"  # of the collision checks; or "duals"
    solver: str = "ipopt"  # or "fatrop", which IPOPT answers for where it finds nothing sound, and where it cannot be asked

    def __post_init__(self) -> None:
        require_types(self)
        require(self, positive, "rounds", "rounds_unsound")
        require(self, non_negative, "work", "work_unsound")
        require(self, positive, "trust_region_m", "trust_region_rad")
        for tolerance in self.tolerance:
            positive("tolerance", tolerance)
        within("end_share", self.end_share, 0.0, 1.0)
        within("patience", self.patience, 0, 2)
        require(self, non_negative, "nearly_m", "nearly_later_m", "drift_m", "restarts")
        if self.form not in FORMS:
            raise ParameterError("checks", self.form, f"is unknown; {nearest(self.form, FORMS)}")
        if self.solver not in SOLVERS:
            raise ParameterError("solver", self.solver, f"is unknown; {nearest(self.solver, SOLVERS)}")


@dataclass(frozen=True, slots=True)
class Exchanged:
    """The best sound manoeuvre of the loop (None when no round gave one), what the last round lacked, and where it had to check."""

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

    The start is fixed; the goal is met within a share of its tolerance, or exactly, with the steering angle there, where that is given.
    `checked` are places to check from the first round on.
    """
    near = world.near(first.nodes)
    rank = {int(k): place for place, k in enumerate(near)}
    loop = _Loop(case, world.only(near), first, costs, settings, end_steering_rad)
    loop.dips |= {(k, rank[polygon], point) for k, polygon, point in checked if polygon in rank}
    for number in range(1, settings.rounds_unsound + 1):
        if loop.out_of_work(number):
            break
        loop.rounds = number
        if not loop.round(number):
            break
    where = frozenset((k, int(near[polygon]), point) for k, polygon, point in loop.dips)
    return Exchanged(loop.best, loop.current, loop.lacking_m, loop.rounds, loop.iterations, where)


@dataclass(slots=True)
class _TrustRegion:
    """The share of the trust region that a round may use, the round after which it shrinks, and the restarts so far."""

    share: float = 1.0
    shrinks_from: int = _SHRINKS_FROM
    restarts: int = 0

    def restart(self, number: int) -> None:
        self.restarts += 1
        self.share, self.shrinks_from = _SHRINKS_BY**self.restarts, number + _SHRINKS_FROM

    def after(self, number: int, settled: bool) -> None:
        if number >= self.shrinks_from:
            self.share = max(self.share * (_SETTLES_BY if settled else _SHRINKS_BY), _LEAST_SHARE)


class _Loop:
    """One loop: the manoeuvre of the moment and its roll-out, the best sound one, and what the next round has to make up for."""

    def __init__(
        self,
        case: ParkingCase,
        world: World,
        first: Manoeuvre,
        costs: ParkingCosts,
        settings: ExchangeSettings,
        end_steering_rad: float | None,
    ) -> None:
        self.case, self.world, self.first, self.costs, self.settings = case, world, first, costs, settings
        self.end_steering_rad = end_steering_rad
        self.current, self.rolled = first, RollOut.of(case, world, first)
        self.best: Manoeuvre | None = None
        self.dips: set[Place] = set()
        self.missed = np.zeros(3)  # how far from the program the roll-out ends, where that leaves the tolerance or the end is fixed
        self.durations = [0.0, 0.0]
        self.margin_m, self.trust_region = MARGIN_M, _TrustRegion()
        self.rounds, self.iterations, self.lacking_m = 0, 0, np.inf

    def out_of_work(self, number: int) -> bool:
        """Whether the caps on rounds and work end the loop before this round."""
        settings, work = self.settings, self.iterations * len(self.current.steps)
        return work > settings.work_unsound or (self.best is not None and (number > settings.rounds or work > settings.work))

    def round(self, number: int) -> bool:
        """Solve once and measure the solution; whether there is reason to go on."""
        settings, asked = self.settings, self.case.limits.clearance_m
        solution = self._solved(self._program(), warm=number > 1)
        if solution.violation > _ASTRAY and self.trust_region.restarts < settings.restarts:
            self.trust_region.restart(number)
            self._follow(self.best if self.best is not None else self.first)
            return True
        if not solution.violation <= _NO_SOLUTION:
            return False
        self._follow(with_solution(self.current, solution.nodes, solution.steps))
        least = float(self.rolled.apart.min(initial=np.inf))
        self.lacking_m = max(asked - least, solution.violation - _SOUND, 0.0)
        self.dips |= dips_of(self.current, self.rolled, asked + self.margin_m)
        ends_well = self._ends_well()
        if least >= asked - _LEAST_CLEARANCE_M and solution.violation < _SOUND and ends_well:
            if self.best is None or self.current.duration_s < self.best.duration_s:
                self.best = self.current
            self.margin_m = MARGIN_M
            least_before = min(self.durations[2 - settings.patience :], default=np.inf)
            if least_before > (1.0 - _GAIN) * self.best.duration_s:  # what was allowed more was no faster
                return False
        elif self.lacking_m < (settings.nearly_m if number < _LATER_FROM else settings.nearly_later_m):
            self.margin_m += self.lacking_m
        settled = abs(self.current.duration_s - self.durations[-1]) <= _GAIN * self.current.duration_s
        self.durations = [*self.durations, self.current.duration_s][-2:]
        self.trust_region.after(number, settled)
        return True

    def _follow(self, manoeuvre: Manoeuvre) -> None:
        self.current, self.rolled = manoeuvre, RollOut.of(self.case, self.world, manoeuvre)

    def _ends_well(self) -> bool:
        """Whether the roll-out ends where it was asked to; `missed` is brought up to date.

        A long interval's one Runge-Kutta step in the program may end some tenths of a millimetre off.
        """
        off = self.rolled.end - self.current.nodes[-1, :3]
        is_fixed = self.end_steering_rad is not None
        ends_well = is_fixed or arrived(self.case, self.rolled.end)
        if not ends_well or (is_fixed and float(np.abs(off).max()) < self.settings.drift_m):
            self.missed = off
        return ends_well

    def _program(self) -> ParkingProgram:
        """The program around the manoeuvre of the moment."""
        case, manoeuvre, settings, share = self.case, self.current, self.settings, self.trust_region.share
        reach = settings.trust_region_m + settings.trust_region_rad * self.world.body.reach
        where = places(manoeuvre, self.rolled, case.limits.clearance_m, min(_NEAR_M, share * reach), self.dips)
        low, high = node_bounds(case, manoeuvre, self.rolled.node_room, settings.trust_region_m, settings.trust_region_rad, share)
        nodes = np.clip(manoeuvre.nodes, low, high)
        slack: Array = settings.end_share * end_slack(case) if self.end_steering_rad is None else np.zeros(3)
        low[-1, :3] -= slack + self.missed
        high[-1, :3] += slack - self.missed
        if self.end_steering_rad is not None:
            nodes[-1, 4] = low[-1, 4] = high[-1, 4] = self.end_steering_rad
        segments = np.concatenate([[0], np.cumsum(manoeuvre.segments[1:] != manoeuvre.segments[:-1])]).astype(np.int64)
        first = np.flatnonzero(np.concatenate([[True], np.diff(segments) > 0]))
        stands = manoeuvre.gears[first] == 0.0
        return ParkingProgram(
            nodes=nodes,
            nodes_low=low,
            nodes_high=high,
            segments=segments,
            steps=manoeuvre.steps[first],
            steps_low=np.where(stands, 0.0, 2e-3),
            steps_high=np.where(stands, 2.0 * case.vehicle.steering_max_rad / case.vehicle.steering_rate_max_radps, 4.0),
            checks=checks_at(self.world, where, self.rolled),
        )

    def _solved(self, program: ParkingProgram, *, warm: bool) -> ParkingSolution:
        """The solution; the iterations of both solvers are counted."""
        settings, costs = self.settings, self.costs
        body, car = self.world.body, self.case.vehicle
        physics = ParkingPhysics(
            car.wheelbase_m,
            body.rear,
            body.front,
            body.half_width,
            self.case.limits.acceleration_mps2,
            car.steering_rate_max_radps,
            self.case.limits.clearance_m + self.margin_m,
        )
        if settings.solver == "fatrop" and settings.form == "half-planes" and costs.clearance == 0.0:
            by_stages = Stages(program, physics, costs, MAX_ITERATIONS, warm).solve()
            self.iterations += by_stages.iterations
            if by_stages.violation < _SOUND:
                return by_stages
        tolerance = settings.tolerance[int(warm)]
        solution = solve_parking(program, physics, costs, MAX_ITERATIONS, warm=warm, form=settings.form, tolerance=tolerance)
        self.iterations += solution.iterations
        return solution
