"""The MPC method: every way out is posed, solved and judged; the cheapest that the judge passes wins."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace

from mcdas_opt.domain.assessment import Assessment
from mcdas_opt.domain.plan import Attempt, Candidate, Plan, Refusal, Timing
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.verdict import Verdict
from mcdas_opt.domain.vocabulary import Mode, Sector, Side
from mcdas_opt.manoeuvres.kinds import build_family
from mcdas_opt.native.kernels import CONSERVATIVE_ACCEPT
from mcdas_opt.planning.answer import Answer
from mcdas_opt.planning.closed_form import drive
from mcdas_opt.planning.continuation import Ended, to_safe_end
from mcdas_opt.planning.glance import verdicts
from mcdas_opt.planning.lane_stage import LaneStage, Solved
from mcdas_opt.planning.promise import by_promise
from mcdas_opt.planning.selection import WorthSettings, nearness, steering_price, worths
from mcdas_opt.planning.stage_settings import StageSettings
from mcdas_opt.planning.ways import Manoeuvre, Way, continued, keeping_way, shorter_side, spread_ways, strays, ways_out
from mcdas_opt.reference.offset_path import build_search
from mcdas_opt.situation.assess import assess
from mcdas_opt.tracking.prediction import predict_for

Solving = Callable[[Situation, Prediction, Way], Solved]
_UNPROMISING = "not solved: others promise more, and pass"


class MpcMethod:
    """Kinematic-bicycle MPC on the sigmoid offset path; keeps its warm starts and its last assessment between calls."""

    has_ladder = True

    def __init__(self, vehicle: Vehicle, settings: Settings | None = None, stage: StageSettings | None = None) -> None:
        self.vehicle, self.settings = vehicle, settings or Settings()
        self.stage = LaneStage(vehicle, self.settings, stage)
        self.close = self.stage.closer()
        for each in (self.stage, self.close):
            each.warm_up()
        build_search()
        build_family(self.settings.grid)
        CONSERVATIVE_ACCEPT.loaded()  # the judge's library too, before the first cycle
        self.worth = WorthSettings()
        self._assessment: Assessment | None = None
        self._solve_s = self._verify_s = 0.0
        self._iterations = self._pause = 0
        self._chosen = ""
        self._compared: float | None = None  # the least price of what was chosen since the ways were last compared
        self._tried: list[Candidate] = []
        self._failed: list[Attempt] = []
        self._strayed: list[Answer] = []  # pass the judge, half in a lane beside that somebody watches, though they were to keep theirs
        self._short: list[tuple[float, Way, bool]] = []  # failed for a little room [m] alone; whether they converged
        self._ends: list[tuple[Trajectory, Ended]] = []  # what was continued in this cycle: asked for in each comparison
        self.stop_at: float | None = None  # perf_counter after which no further candidate is begun

    def plan(self, situation: Situation, previous: Plan | None) -> Plan | Refusal:
        self.stage.vehicle = self.close.vehicle = self.vehicle  # that of a car that slips is told anew before every plan
        self._solve_s = self._verify_s = 0.0
        self._iterations, self._pause = 0, max(self._pause - 1, 0)
        if previous is None:
            self._pause = 0
            self.stage.forget()
            self.close.forget()
            self._assessment = self._compared = None
        assessment = assess(situation, self.vehicle, self.settings.selector, self._assessment)
        self._assessment = assessment
        prediction = predict_for(situation, self.settings.prediction)
        going = self._going(situation, previous)
        self._tried, self._failed, self._strayed, self._short, self._ends = [], [], [], [], []
        chosen = self._choose(situation, assessment, prediction, previous, going)
        candidates = tuple(self._tried)
        if chosen is None:
            reason = "; ".join(f"{c.name}: {c.refusal}" for c in candidates)
            return Refusal(
                reason=f"no way out passes ({reason})",
                candidates=candidates,
                iterations=self._iterations,
                attempts=tuple(self._failed),
            )
        answer, ended = chosen
        way = answer.way
        self._chosen = way.name
        cost = answer.candidate.cost or 0.0
        self._compared = cost if self._compared is None else min(self._compared, cost)
        return Plan(
            planner="mpc",
            mode=answer.mode,
            side=way.side,
            warning=assessment.warning,
            reason=f"{assessment.reason}; {way.name} is the cheapest way that passes",
            chosen=way.name,
            verdict=ended.verdict,
            prediction=prediction.name,
            trajectory=ended.trajectory,
            candidates=candidates,
            timing_ms=Timing(solve=1e3 * self._solve_s, verify=1e3 * self._verify_s),
            iterations=self._iterations,
            solver=self.stage.solver,
            literal_mode=assessment.literal_mode,
            safe_end=ended.end,
            time_s=situation.time_s,
            reference=way.manoeuvre,
        )

    def _going(self, situation: Situation, previous: Plan | None) -> Manoeuvre | None:
        """The manoeuvre under way, unless it is finished."""
        if previous is None or not isinstance(previous.reference, Manoeuvre) or previous.reference.finished(situation):
            return None
        return previous.reference

    def _choose(
        self,
        situation: Situation,
        assessment: Assessment,
        prediction: Prediction,
        previous: Plan | None,
        going: Manoeuvre | None,
    ) -> tuple[Answer, Ended] | None:
        """The gentlest set of ways that holds one which passes.

        When nothing threatens: what is under way, or the lane. At a threat: the four ways out and the best of the sampled family, those
        that promise most first and the others where none of these will do, and the four as driven without an optimiser. A manoeuvre under
        way goes on alone while it passes to a safe end for hardly more than when it was last compared with the others; else the family
        waits until none of the four does. What passed before takes part in the last comparison; where nothing did, or that finds no safe
        end, so does what was to keep its lane and only passes half out of it. Where not even that passes, closer drives and second opinions
        are asked for.
        """
        passed: list[Answer] = []
        undriven: tuple[Way, ...] = ()
        if not assessment.threatened:
            quiet = assessment.mode if assessment.mode in (Mode.CRUISE, Mode.PARK) else Mode.HOLD
            first = continued(situation, going) if going is not None else keeping_way(situation, quiet)
            passed = self._passed(situation, prediction, (first,), assessment)
            gentle = passed
            undriven = (first,) if going is None else ()
            if passed and going is None and (previous is None or self._chosen != first.name):  # who keeps the lane already goes on
                most = (passed[0].candidate.cost or 0.0) - self.worth.notable
                driven = self._closed_forms(situation, prediction, (first,), assessment)
                if not driven and previous is None:  # the closed form would begin with something else
                    others = ways_out(situation, assessment, self.vehicle, self.settings.sigmoid, going)
                    driven = self._closed_forms(situation, prediction, others, assessment)
                gentle = passed + [answer for answer in driven + self._strayed if (answer.candidate.cost or 0.0) < most]
                passed, undriven = passed + driven, ()
            best = self._cheapest(gentle, situation, prediction, None, going)
            if best is not None and best[1].sound:
                return best
        four = ways_out(situation, assessment, self.vehicle, self.settings.sigmoid, going)
        if going is not None and going.half_done(situation):
            # the lane that holds the car is the one that it steers for: keeping it is no way of its own
            four = tuple(way for way in four if way.side is not Side.NONE)
        before = None if previous is None else self._chosen
        others = four
        if going is not None and assessment.threatened:
            alone = tuple(way for way in four if way.side is going.side)
            others = tuple(way for way in four if way.side is not going.side)
            passed = self._passed(situation, prediction, alone, assessment)
            best = self._cheapest(passed, situation, prediction, before, going)
            if best is not None and best[1].sound and not self._has_risen(best[0]):
                return best
        self._compared = None
        forms: list[Answer] | None = None
        if going is None:
            spread = spread_ways(situation, self.vehicle, prediction, self.settings.grid)
            most, settings = self.stage.stage.first_ways, self.settings
            promising = by_promise(four + spread, most, before, situation, assessment, prediction, self.vehicle, settings, self.worth)
            passed += self._passed(situation, prediction, promising.first, assessment)
            if passed and promising.others:
                forms = self._compared_forms(situation, prediction, four + undriven, assessment)
                best = self._cheapest(passed + forms, situation, prediction, before, going)
                if best is not None and best[1].sound and self._price(best[0], before, going)[0] <= promising.least:
                    self._tried += [Candidate(name=way.name, cost=None, passed=False, refusal=_UNPROMISING) for way in promising.others]
                    return best
            passed += self._passed(situation, prediction, promising.others, assessment)
        else:
            passed += self._passed(situation, prediction, others, assessment)
            best = self._cheapest(passed, situation, prediction, before, going)
            if best is not None and best[1].sound:
                return best
            spread = spread_ways(situation, self.vehicle, prediction, self.settings.grid)
            passed += self._passed(situation, prediction, spread, assessment)
        if not passed and not self._strayed:
            passed = self._closer(situation, prediction, assessment) or self._second_opinions(situation, prediction, assessment)
        strayed = [] if passed else self._strayed.copy()
        if passed or strayed:  # a closed form alone is the ladder's to drive, and to label
            if forms is None:
                forms = self._compared_forms(situation, prediction, four + undriven, assessment)
            passed = passed + strayed + forms
        best = self._cheapest(passed, situation, prediction, before, going)
        if best is not None and not best[1].sound:
            best = self._cheapest(passed + self._strayed[len(strayed) :], situation, prediction, before, going)
        return best

    def _has_risen(self, answer: Answer) -> bool:
        """Whether it costs so much more than what was chosen before that the other ways are to be asked again."""
        return self._compared is None or (answer.candidate.cost or 0.0) > self.worth.risen * self._compared

    def _cheapest(
        self, passed: list[Answer], situation: Situation, prediction: Prediction, before: str | None, going: Manoeuvre | None
    ) -> tuple[Answer, Ended] | None:
        """The cheapest that comes to a safe end; where none does, or the deadline passes meanwhile, the cheapest, with its open end."""
        cheapest = None
        for answer in sorted(passed, key=lambda answer: self._price(answer, before, going)):
            if cheapest is not None and self.stop_at is not None and time.perf_counter() > self.stop_at:
                break
            ended = self._ended(answer, situation, prediction)
            if ended.sound:
                return answer, ended
            cheapest = cheapest or (answer, ended)
        return cheapest

    def _ended(self, answer: Answer, situation: Situation, prediction: Prediction) -> Ended:
        for trajectory, ended in self._ends:
            if trajectory is answer.trajectory:
                return ended
        ended = to_safe_end(answer.trajectory, answer.verdict, situation, self.vehicle, prediction, self.settings.safe_end)
        self._ends.append((answer.trajectory, ended))
        return ended

    def _price(self, answer: Answer, before: str | None, going: Manoeuvre | None) -> tuple[float, int]:
        """Cost, cheaper for what was chosen before; equal costs (to 1e-5 of each other) go to the tie-break side."""
        cost = answer.candidate.cost or 0.0
        if answer.way.manoeuvre == going if going is not None else answer.way.name == before:
            cost *= self.worth.persistence
        return (round(cost, 5), 0 if answer.way.side is self.settings.selector.tie_break else 1)

    def _solve(self, situation: Situation, prediction: Prediction, way: Way, by: Solving) -> Solved:
        """One way, unless there is a reason not even to try; without a trajectory the reason is the candidate's refusal."""
        if way.refusal:
            return Solved(trajectory=None, reason=way.refusal, iterations=0)
        started = time.perf_counter()
        if self.stop_at is not None and started > self.stop_at:
            return Solved(trajectory=None, reason="the deadline passed before it was tried", iterations=0)
        solved = by(situation, prediction, way)
        self._solve_s += time.perf_counter() - started
        self._iterations += solved.iterations
        return solved if solved.trajectory is not None else replace(solved, reason=f"not solved: {solved.reason}")

    def _passed(self, situation: Situation, prediction: Prediction, ways: tuple[Way, ...], assessment: Assessment) -> list[Answer]:
        """Solves the ways, one by one, and judges them."""
        return self._judged(
            situation, prediction, ways, [self._solve(situation, prediction, way, self.stage.solve) for way in ways], assessment
        )

    def _closer(self, situation: Situation, prediction: Prediction, assessment: Assessment) -> list[Answer]:
        """The ways that were a little short of room, the nearest ones, solved again with less of it asked for."""
        near = sorted(self._short, key=lambda one: one[0])[: self.stage.stage.closer_ways]
        ways = tuple(replace(way, name=f"{way.name}-close") for _, way, _ in near)
        solutions = [self._solve(situation, prediction, way, self.close.solve) for way in ways]
        return self._judged(situation, prediction, ways, solutions, assessment)

    def _second_opinions(self, situation: Situation, prediction: Prediction, assessment: Assessment) -> list[Answer]:
        """What the second engine makes of the ways that the first one left unfinished a little short of passing, the nearest ones."""
        most = 0 if self.stage.stage.solver == "osqp" or self._pause else self.stage.stage.second_opinions
        near = sorted((one for one in self._short if not one[2]), key=lambda one: one[0])[:most]
        ways = tuple(replace(way, name=f"{way.name}-again") for _, way, _ in near)
        solutions = [self._solve(situation, prediction, way, self.stage.second_opinion) for way in ways]
        answers = self._judged(situation, prediction, ways, solutions, assessment)
        if ways and not answers:
            self._pause = self.stage.stage.second_pause
        return answers

    def _closed_forms(self, situation: Situation, prediction: Prediction, ways: tuple[Way, ...], assessment: Assessment) -> list[Answer]:
        """The same ways as the bicycle drives them without an optimiser: what leaves is never worth less than the closed form."""
        ways = tuple(replace(way, name=f"{way.name}-driven") for way in ways if not way.refusal)
        drives = [drive(situation, way, self.vehicle, self.settings) for way in ways]
        solutions = [Solved(trajectory=trajectory, reason="", iterations=0, converged=True) for trajectory in drives]
        return self._judged(situation, prediction, ways, solutions, assessment)

    def _compared_forms(self, situation: Situation, prediction: Prediction, ways: tuple[Way, ...], assessment: Assessment) -> list[Answer]:
        """Closed forms for a comparison: what swings half out of its lane too, at the price of leaving it."""
        known = len(self._strayed)
        forms = self._closed_forms(situation, prediction, ways, assessment)
        swung = self._strayed[known:]
        del self._strayed[known:]
        return forms + swung

    def _judged(
        self, situation: Situation, prediction: Prediction, ways: tuple[Way, ...], solutions: list[Solved], assessment: Assessment
    ) -> list[Answer]:
        """Judges them, all at once; records them among the tried, and their drives among the failed. Those that pass."""
        started = time.perf_counter()
        leaning, needless = shorter_side(assessment), assessment.mode in (Mode.BRAKE, Mode.ACCELERATE)
        driven = [solved.trajectory for solved in solutions if solved.trajectory is not None]
        values: Iterator[tuple[Verdict, float]] = iter(())
        if driven:
            near = nearness(driven, self.vehicle, situation.road, prediction)
            judged = verdicts(driven, situation, self.vehicle, prediction, near)
            desired = situation.wanted_speed_mps
            prices = worths(near, vehicle=self.vehicle, prediction=prediction, desired_speed_mps=desired, settings=self.worth)
            values = zip(judged, prices, strict=True)
        answers: list[Answer] = []
        for way, solved in zip(ways, solutions, strict=True):
            if solved.trajectory is None:
                self._tried.append(Candidate(name=way.name, cost=None, passed=False, refusal=solved.reason))
                continue
            verdict, cost = next(values)
            cost += steering_price(way.side, leaning, needless, self.worth)
            cost += self.worth.waiting if way.waits else 0.0
            strayed = strays(solved.trajectory, situation, way, self.vehicle)
            watched = strayed is Side.NONE or situation.coverage.sees(Sector(strayed.value))
            refusal = "" if verdict.passed else verdict.reason
            if strayed is not Side.NONE:
                refusal = f"leaves its lane to the {strayed.value}{'' if watched else ', where nobody watches'}"
            candidate = Candidate(name=way.name, cost=cost, passed=not refusal, refusal=refusal)
            self._tried.append(candidate)
            answer = Answer(way, candidate, solved.trajectory, verdict)
            if candidate.passed:
                answers.append(answer)
            elif verdict.passed and watched:
                half_way = replace(candidate, cost=cost + steering_price(strayed, leaning, needless, self.worth), passed=True, refusal="")
                self._strayed.append(replace(answer, way=replace(way, mode=Mode.EVADE, side=strayed), candidate=half_way))
            elif solved.converged and not verdict.passed:
                # what was cut short is no plan to fall back on: it would not even mirror with its situation
                self._failed.append(answer.attempt())
            if not verdict.passed:
                short = answer.shortfall_m
                if short <= self.stage.stage.near_m:
                    self._short.append((short, way, solved.converged))
        self._verify_s += time.perf_counter() - started
        return answers
