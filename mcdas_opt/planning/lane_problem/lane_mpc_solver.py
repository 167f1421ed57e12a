"""A proposed manoeuvre, transcribed as the lane problem and solved: warm start or guess, solve, roll-out."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import chain, product

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.ocp.lane_mpc import CENTRE, HEADWAY_HORIZON_S, ROAD_MARGIN_M, STEERING_RATE_SHARE
from mcdas_opt.planning.candidate import Driven, Proposed, Refused
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.lane_problem.bends import given_up_m
from mcdas_opt.planning.lane_problem.lane_parameters import (
    ObstacleSlots,
    guessed_states,
    nearest_values,
    obstacle_slots,
    proposal_values,
    shared_values,
    slip_values,
)
from mcdas_opt.planning.lane_problem.mirror import is_mirrored, mirrored_guess, mirrored_inputs, mirrored_states
from mcdas_opt.planning.lane_problem.roll_out import roll_out, within_reach
from mcdas_opt.planning.lane_problem.transcribed_problem import TranscribedProblem, TranscribedProblems
from mcdas_opt.planning.solver_settings import SolverSettings
from mcdas_opt.planning.traffic.reach import Room, in_reach
from mcdas_opt.solvers.interior_point import InteriorPointEngine
from mcdas_opt.solvers.ipopt_engine import IpoptEngine
from mcdas_opt.solvers.osqp_engine import OsqpEngine
from mcdas_opt.solvers.outcome import Ending, Outcome, ask
from mcdas_opt.solvers.stage_problem import StageGuess

_IPOPT_ITERATIONS = 200
_OSQP_WARM, _OSQP_COLD, _OSQP_BACKUP = 3, 8, 2  # iterations: from a warm start, from none, where the interior point has no answer
_SLOWS_MPS = 2.0  # by so much slower somewhere on the way is another drive
_MOST_SHIFTS = 5  # nodes that a warm start is moved on by
_MARGINS_M = 5.0  # a body's clearance and uncertainty, at most, and some rounding
Engine = InteriorPointEngine | OsqpEngine | IpoptEngine
Asked = tuple[Engine, Callable[[], StageGuess], int]  # who, from which guess, with which cap on iterations


@dataclass(frozen=True, slots=True)
class _WarmStart:
    """What a candidate's solve leaves for the next cycle: thrown away at an event."""

    proposed: Proposed
    outcome: Outcome
    engine: Engine
    mirrored: bool
    others: ObstacleSlots


@dataclass(slots=True)
class _Scene:
    """What the candidates of one cycle share: the neighbours on the grid and who of them is not where the cycle before predicted, the
    parameters that are the same for all, the state to begin in (a measured one a hair outside a hard bound, by rounding or a limit just
    touched, is brought to it), by how many nodes a warm start is moved on, and the Newton steps taken."""

    cycle: Cycle
    others: ObstacleSlots
    surprising: frozenset[str]
    transcribed: TranscribedProblem
    matrix: Array
    start: Array
    shifts: int
    newton_steps: int = 0


class LaneMpcSolver:
    """Owns the engines and the warm starts, one per candidate's name. Not shared between threads."""

    def __init__(self, vehicle: Vehicle, settings: Settings, own: SolverSettings | None = None) -> None:
        self.settings, self.own = settings, own or SolverSettings()
        self.problems = TranscribedProblems(vehicle, settings, self.own)
        self._warm_starts: dict[str, _WarmStart] = {}  # that the cycle before left
        self._left: dict[str, _WarmStart] = {}  # for the cycle after
        self._scene: _Scene | None = None

    def warm_up(self, vehicle: Vehicle) -> None:
        """Poses every problem now that a drive may ask for, and loads the backup: some tenths of a second once a process, else nothing."""
        OsqpEngine.load()
        for slots, sloping in product(self.own.slots, (False, True)):
            self.problems.holding(slots, vehicle, sloping_edges=sloping)

    def with_less_clearance(self, vehicle: Vehicle) -> LaneMpcSolver:
        """The same, with less clearance asked for."""
        least = self.own.closer_m
        return LaneMpcSolver(
            vehicle, self.settings, replace(self.own, clearance_along_m=least, clearance_across_m=least, clearance_on_foot_m=least)
        )

    @property
    def name(self) -> str:
        """Which engine answers first, and in which form; known once it has solved."""
        if self.own.solver == "osqp":
            return "osqp"
        return f"interior-point ({self.problems.kinds})"

    def begin(self) -> None:
        """A new cycle: what the last one left is there to begin from."""
        self._warm_starts, self._left = self._left, {}

    def forget(self) -> None:
        """Throws every warm start away."""
        self._warm_starts, self._left = {}, {}
        for transcribed in self.problems:
            transcribed.forget()

    def solve(self, cycle: Cycle, proposed: Proposed) -> Driven | Refused:
        """From the candidate's last solve when that says something of this one, else from its own path."""
        scene = self._shared(cycle)
        transcribed, others = scene.transcribed, scene.others
        mirrored = is_mirrored(cycle.situation, others, proposed)

        def cold() -> StageGuess:
            guess = self.guess(cycle, proposed, transcribed)
            return mirrored_guess(guess) if mirrored else guess

        warm = self._warm_starts.pop(proposed.name, None)
        best: Outcome | None = None
        attempts: Iterator[Asked] = self._attempts(scene, cold, lambda: best is not None)
        engine = transcribed.interior_point if self.own.solver == "interior-point" else transcribed.osqp
        fits = warm is not None and warm.engine is engine and warm.mirrored == mirrored
        if warm is not None and fits and not self._event(warm, proposed, scene):
            last = warm.outcome
            steps = self._newton_cap(scene) if engine is transcribed.interior_point else _OSQP_WARM
            attempts = chain([(engine, lambda: engine.shifted(last, scene.shifts), steps)], attempts)
        x0 = mirrored_states(scene.start) if mirrored else scene.start
        by: Engine = engine
        iterations, reason = 0, ""
        for trial, guessed, cap in attempts:
            guess = guessed()
            p = self._filled(scene, proposed, guess.x[:, 0])
            p = transcribed.mirrored(p) if mirrored else p
            outcome = ask(trial, x0, p, self.settings.grid.steps_s, guess, cap)
            iterations += outcome.inner_iterations
            scene.newton_steps += outcome.inner_iterations if trial is transcribed.interior_point else 0
            if outcome.usable and (best is None or outcome.ending is Ending.CONVERGED or outcome.objective < best.objective):
                best, by = outcome, trial
            if outcome.ending is Ending.CONVERGED:
                break
            reason = outcome.message or outcome.ending.value
        if best is None:
            reason = transcribed.parameters.without_value(p) or reason
            return Refused(proposed=proposed, reason=f"not solved: {reason}", iterations=iterations)
        self._left[proposed.name] = _WarmStart(proposed, best, by, mirrored, others)
        u = mirrored_inputs(best.u) if mirrored else best.u
        trajectory = self._rolled_out(cycle, transcribed, best.x[:, 3], u, p)
        return Driven(proposed=proposed, trajectory=trajectory, iterations=iterations, converged=best.ending is Ending.CONVERGED)

    def guess(self, cycle: Cycle, proposed: Proposed, transcribed: TranscribedProblem) -> StageGuess:
        """The cold start: the candidate's own path."""
        n, problem = self.settings.grid.nodes, transcribed.problem
        x = proposed.guess
        if x is None:
            x = guessed_states(cycle.situation, proposed, cycle.vehicle, self.settings.grid.times_s)
        return StageGuess(x=x, u=np.zeros((n, problem.nu)), s=np.zeros((n + 1, problem.ns)))

    def parameters(self, cycle: Cycle, proposed: Proposed, guess_s: Array) -> Array:
        """(N + 1, np): what the problem of a candidate is posed with, its road linearised around `guess_s` (N + 1)."""
        return self._filled(self._shared(cycle), proposed, guess_s)

    def who_matters(self, cycle: Cycle) -> ObstacleSlots:
        """The bodies that can come near, or into the headway, within the horizon; in the cycle's order."""
        times, situation, headway = self.settings.grid.times_s, cycle.situation, cycle.front_gap.headway
        bodies, motion = cycle.prediction.bodies, cycle.prediction.rows_on(times)
        if bodies:
            lengths = np.array([body.length_m for body in bodies])
            room = Room(standstill_m=headway.standstill_m + _MARGINS_M, time_gap_s=headway.time_gap_s, closing_s=HEADWAY_HORIZON_S)
            near = in_reach(motion, lengths, times, situation.host, cycle.vehicle, situation.road, room)
            if not near.all():
                chosen = np.flatnonzero(near).tolist()
                bodies, motion = tuple(bodies[i] for i in chosen), motion.part(chosen)
        own = self.own
        clearance = {"along_m": own.clearance_along_m, "across_m": own.clearance_across_m, "on_foot_m": own.clearance_on_foot_m}
        return obstacle_slots(bodies, times, motion=motion, passed=cycle.passed_in_lane.bodies, **clearance)

    def _attempts(self, scene: _Scene, cold: Callable[[], StageGuess], answered: Callable[[], bool]) -> Iterator[Asked]:
        """Engines in the order in which they are asked, from a cold start, with their iteration caps: the first that converges answers.

        OSQP is the backup where the first engine has not `answered` at all.
        """
        if self.own.cold_start == "ipopt":
            yield scene.transcribed.ipopt, cold, _IPOPT_ITERATIONS
        elif self.own.solver == "osqp":
            yield scene.transcribed.osqp, cold, _OSQP_COLD
            return
        else:
            yield scene.transcribed.interior_point, cold, self._newton_cap(scene)
        if not answered():
            yield scene.transcribed.osqp, cold, _OSQP_BACKUP  # built when it is first asked

    def _newton_cap(self, scene: _Scene) -> int:
        """What is left of the cycle's for one solve."""
        left = self.own.newton_steps_cycle - scene.newton_steps
        return min(self.own.newton_steps, max(left, self.own.newton_steps_late))

    def _rolled_out(self, cycle: Cycle, transcribed: TranscribedProblem, speed_mps: Array, u: Array, p: Array) -> Trajectory:
        """The inputs, kept inside their limits, driven through the equations of motion from the measured state; `p` (N + 1, np) says which
        share of the steering rate they are of."""
        u = np.minimum(np.maximum(u, transcribed.problem.u_lower), transcribed.problem.u_upper)
        share = transcribed.parameters.columns.get(STEERING_RATE_SHARE)
        u = u if share is None else u * (1.0, p[0, share])
        return roll_out(cycle.situation.host, speed_mps, u, self.settings.grid, cycle.vehicle, cycle.situation.road)

    def _shared(self, cycle: Cycle) -> _Scene:
        """Made for a cycle's first candidate, and kept for the others."""
        last = self._scene
        if last is None or last.cycle is not cycle:
            others = self.who_matters(cycle)
            sloping = cycle.situation.road.edges is not None
            transcribed = self.problems.holding(len(others), cycle.vehicle, sloping_edges=sloping)
            matrix = self.problems.constant(transcribed).copy()
            share = self.own.friction_share * self.settings.friction_share
            values = shared_values(cycle.situation, others, slots=min(len(others), transcribed.slots), friction_share=share)
            if CENTRE in transcribed.parameters.columns:
                values |= slip_values(cycle.vehicle, cycle.situation.host.speed_mps, cycle.situation.road.friction, self.settings)
            transcribed.parameters.fill(matrix, values)
            low, high = transcribed.problem.x_lower, transcribed.problem.x_upper
            start = np.minimum(np.maximum(within_reach(cycle.situation.host, cycle.vehicle), low), high)
            surprising = self._surprising(last.cycle, cycle, others) if last is not None and self._warm_starts else frozenset[str]()
            shifts = round(cycle.memory.elapsed_s / float(self.settings.grid.steps_s[0]))
            last = self._scene = _Scene(cycle, others, surprising, transcribed, matrix, start, shifts)
        return last

    def _surprising(self, before: Cycle, cycle: Cycle, others: ObstacleSlots) -> frozenset[str]:
        """Who of them is not where the cycle before predicted, or was not there."""
        times_s, elapsed_s = self.settings.grid.times_s, cycle.memory.elapsed_s
        k = min(max(int(np.searchsorted(times_s, elapsed_s)), 1), times_s.size - 1)
        share = (elapsed_s - times_s[k - 1]) / (times_s[k] - times_s[k - 1])
        then = before.prediction.rows_on(times_s)  # known: the problem of the cycle before was posed with them
        columns = ((row[:, k - 1] + share * (row[:, k] - row[:, k - 1])).tolist() for row in (then.s_m, then.d_m, then.speed_s_mps))
        expected = {body.id: place for body, place in zip(before.prediction.bodies, zip(*columns, strict=True), strict=True)}
        most = self.own.event_position_m, self.own.event_position_m, self.own.event_speed_mps
        return frozenset(
            body.id
            for body, now in zip(others.bodies, others.first, strict=True)
            if body.id not in expected or any(abs(a - b) > far for a, b, far in zip(expected[body.id], now, most, strict=True))
        )

    def _filled(self, scene: _Scene, proposed: Proposed, guess_s: Array) -> Array:
        """(N + 1, np): the parameters of every node."""
        p, cycle = scene.matrix.copy(), scene.cycle
        situation, times_s, comfort = cycle.situation, self.settings.grid.times_s, self.settings.comfort
        values = proposal_values(situation, cycle.vehicle, scene.others, proposed, times_s, guess_s, cycle.front_gap.headway, comfort)
        if len(scene.others) > scene.transcribed.slots:
            values |= nearest_values(scene.others, scene.transcribed.slots, proposed, guess_s)
        reserve_m = self.settings.edge_reserve_m
        given_m: Array | float = 0.0
        if not situation.road.is_straight:
            width_m = values["left_edge"] - values["right_edge"]
            given_m = given_up_m(situation.road, guess_s, width_m, reserve_m + ROAD_MARGIN_M, cycle.vehicle)
        values["left_edge"] = values["left_edge"] - reserve_m + given_m
        values["right_edge"] = values["right_edge"] + reserve_m - given_m
        scene.transcribed.parameters.fill(p, values)
        return p

    def _event(self, warm: _WarmStart, proposed: Proposed, scene: _Scene) -> bool:
        """Whether the last solve says little of this one: time jumped, another path or goal, somebody new or not where predicted."""
        if scene.shifts > _MOST_SHIFTS or warm.outcome.ending is not Ending.CONVERGED:
            return True
        if proposed.manoeuvre != warm.proposed.manoeuvre or abs(proposed.speed_mps - warm.proposed.speed_mps) > 1.0:
            return True
        if _slows_newly(warm.proposed, proposed):
            return True
        there = {body.id for body in scene.cycle.prediction.bodies}
        return any(body.id not in there for body in warm.others.bodies) or any(body.id in scene.surprising for body in scene.others.bodies)


def _slows_newly(before: Proposed, now: Proposed) -> bool:
    """Whether it is to drive clearly slower somewhere on the way: what it did before may pass ahead of whom it is to let ahead now."""
    if before.speeds_mps is None or now.speeds_mps is None:
        return False
    return bool(np.any(now.speeds_mps < before.speeds_mps - _SLOWS_MPS))
