"""A study in traffic: trials of the MPC's values on the same scenes, kept in a file, by as many workers as like to."""

from __future__ import annotations

import hashlib
import json
import math
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.rules import Array
from mcdas_opt.errors import ParameterError, nearest
from mcdas_opt.evaluation.provenance import digest
from mcdas_opt.tuning.search_space import SPACE, Range, default_values, shares_of, values_at
from mcdas_opt.tuning.searchers import BudgetSpentError, optuna_module, search
from mcdas_opt.tuning.storage import open_study, take_over
from mcdas_opt.tuning.traffic import OBJECTIVES, DriveFigures, Drives, TrafficCost, cost_of, figures_of
from mcdas_opt.tuning.workers import Others, heard_of, sign

_WAIT_S = 0.2
_DRIVES, _KEY = "drives", "values"
METHODS = ("tpe", "nsga2", "de", "cma-es", "random")


@dataclass(frozen=True, slots=True, kw_only=True)
class StudySpec:
    """What makes a study that study: another of these is another study.

    A trial is pruned after `early` scenes when it has by then collided more often than the best finished one had, and after twice as
    many again.
    """

    suite: str
    scenes: tuple[Scene, ...]
    seed: int
    method: str = "tpe"
    space: tuple[Range, ...] = SPACE
    early: int = 3

    def __post_init__(self) -> None:
        require_types(self)
        if self.method not in METHODS:
            raise ParameterError("search", self.method, f"is not a known search; {nearest(self.method, METHODS)}")
        if not self.scenes:
            raise ParameterError("scenes", self.suite, "holds no avoidable scene to train on")

    @property
    def name(self) -> str:
        return f"mcdas-opt tune {self.suite}"

    @property
    def fingerprint(self) -> dict[str, Any]:
        space = json.dumps([(part.name, part.low, part.high, part.log) for part in self.space])
        return {
            "suite": self.suite,
            "seed": self.seed,
            "scenes": digest([scene.model_dump(mode="json") for scene in self.scenes])[:16],
            "search": self.method,
            "space": hashlib.sha256(space.encode()).hexdigest()[:12],
            "early": self.early,
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """A finished trial: its number in the file, its values, and its cost; a pruned one was not driven to the end."""

    number: int
    values: dict[str, float]
    cost: TrafficCost
    pruned: bool


def run_study(
    spec: StudySpec, storage: Path, trials: int, drives: Drives, progress: Callable[[int, int], None] | None = None
) -> tuple[Trial, ...]:
    """Goes on until the file holds `trials` finished trials, whoever finished them; returns them by number.

    The first is the defaults'. What a killed worker left is taken over. Raises `InputError` for the file of another study.
    """
    if trials < 1:
        raise ParameterError("trials", trials, "must be at least 1")
    study = open_study(storage, spec.name, spec.fingerprint, len(OBJECTIVES))
    if not study.get_trials(deepcopy=False):
        study.enqueue_trial(default_values(spec.space), skip_if_exists=True)
    worker = _Worker(spec, study, trials, drives, progress)
    if spec.method in ("tpe", "nsga2"):
        while worker.one(None) is not None:
            pass
    else:
        worker.guided()
    return finished(study)


def finished(study: Any) -> tuple[Trial, ...]:
    optuna = optuna_module()
    state = optuna.trial.TrialState
    return tuple(
        Trial(
            number=trial.number,
            values=dict(trial.params),
            cost=cost_of([figures_of(row) for row in trial.user_attrs[_DRIVES]]),
            pruned=trial.state is state.PRUNED,
        )
        for trial in study.get_trials(deepcopy=False, states=(state.COMPLETE, state.PRUNED))
    )


def _sampler(spec: StudySpec, trials: int) -> Any:
    """Drawn anew for every trial from the seed and the number of trials before it, so that neither a stop nor a kill repeats a draw."""
    optuna = optuna_module()
    seed = int(np.random.SeedSequence((spec.seed, trials)).generate_state(1)[0])
    if spec.method == "nsga2":
        return optuna.samplers.NSGAIISampler(seed=seed, population_size=12)
    return optuna.samplers.TPESampler(seed=seed, n_startup_trials=8)


class _Worker:
    """One of those at work on a study."""

    def __init__(self, spec: StudySpec, study: Any, trials: int, drives: Drives, progress: Callable[[int, int], None] | None) -> None:
        self.spec, self.study, self.trials, self.drives, self.progress = spec, study, trials, drives, progress
        optuna = optuna_module()
        self.state = optuna.trial.TrialState
        self.distributions = {part.name: optuna.distributions.FloatDistribution(part.low, part.high, log=part.log) for part in spec.space}
        self._taken_over = optuna.exceptions.UpdateFinishedTrialError
        self._others = Others()

    def guided(self) -> None:
        """A search that asks for points itself. After a kill it asks for the same ones again: what is in the file is not driven twice."""
        spec = self.spec

        def score(shares: Array) -> float:
            known = self.one(values_at(spec.space, shares))
            if known is None:
                raise BudgetSpentError
            return known.score

        start = shares_of(spec.space, default_values(spec.space))
        budget = 1000 * self.trials  # points asked for; only new ones are driven
        search(spec.method, score, len(spec.space), budget, spec.seed, start)

    def one(self, values: dict[str, float] | None) -> TrafficCost | None:
        """The next trial, with these values or those of the sampler; None when the study has all it needs.

        Values that are in the file are not driven again; those that another worker has in hand are waited for.
        """
        while True:
            take_over(self.study, len(self.distributions), self._others)
            done = finished(self.study)
            running = self.study.get_trials(deepcopy=False, states=(self.state.RUNNING,))
            if values is not None:
                known = next((trial.cost for trial in done if _same(trial.values, values)), None)
                if known is not None:
                    return known
            if self.progress is not None:
                self.progress(min(len(done), self.trials), self.trials)
            if len(done) >= self.trials:
                return None
            in_hand = [] if values is None else [trial for trial in running if _same(trial.params, values)]
            if in_hand or len(done) + len(running) >= self.trials:
                self._others.are_waited_for(in_hand or running)  # in case they die
                time.sleep(_WAIT_S)
                continue
            trial = self._begun(values)
            if trial is None:
                continue
            try:
                with heard_of(trial):
                    cost = self._drive(trial)
            except self._taken_over:
                continue  # others took this worker for dead
            if values is None or _same(trial.params, values):
                return cost

    def _begun(self, values: dict[str, float] | None) -> Any:
        """A trial of this worker's own; None where another began the last one, or the same, at the same moment."""
        if values is not None and not self.study.get_trials(deepcopy=False, states=(self.state.WAITING,)):
            self.study.enqueue_trial(values)
        self.study.sampler = _sampler(self.spec, len(self.study.get_trials(deepcopy=False)))
        trial = self.study.ask(self.distributions)
        sign(trial)
        alive = (self.state.COMPLETE, self.state.PRUNED, self.state.RUNNING)
        before = [t for t in self.study.get_trials(deepcopy=False, states=alive) if t.number < trial.number]
        if len(before) >= self.trials or any(t.params == trial.params for t in before):
            self.study.tell(trial, state=self.state.FAIL)
            return None
        return trial

    def _drive(self, trial: Any) -> TrafficCost:
        """Scene after scene; pruned early where it is already worse than the best that was finished."""
        rows: list[DriveFigures] = []
        documents: list[dict[str, Any]] = []
        scenes, at = self.spec.scenes, 0
        step = self.spec.early
        while at < len(scenes):
            part = scenes[at : at + step]
            for figures in self.drives(part, dict(trial.params)):
                rows.append(figures)
                documents.append(asdict(figures))
            at, step = at + len(part), 2 * step
            if at < len(scenes) and sum(row.collided for row in rows) > self._least_collisions(len(rows)):
                trial.set_user_attr(_DRIVES, documents)
                self.study.tell(trial, state=self.state.PRUNED, skip_if_finished=True)
                return cost_of(rows)
        trial.set_user_attr(_DRIVES, documents)
        cost = cost_of(rows)
        trial.set_constraint("unverified plans", float(cost.unverified))
        self.study.tell(trial, cost.objectives, skip_if_finished=True)
        return cost

    def _least_collisions(self, scenes: int) -> float:
        """Over the same first scenes, of the finished trials that collide least over all of them."""
        complete = [t.user_attrs[_DRIVES] for t in self.study.get_trials(deepcopy=False, states=(self.state.COMPLETE,))]
        if not complete:
            return float("inf")
        best = min(complete, key=lambda rows: sum(row["collided"] for row in rows))
        return float(sum(row["collided"] for row in best[:scenes]))


def _same(params: dict[str, float], values: dict[str, float]) -> bool:
    return all(abs(params.get(name, math.inf) - value) <= 1e-12 * max(1.0, abs(value)) for name, value in values.items())
