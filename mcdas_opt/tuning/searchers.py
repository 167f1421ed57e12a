"""Searches without derivatives behind one interface: a function on the unit cube, a number of evaluations, a seed."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.errors import ParameterError, nearest, of_extra

Function = Callable[[Array], float]
_POPULATION = 5  # of differential evolution, per dimension


@dataclass(frozen=True, slots=True, kw_only=True)
class Trace:
    """What a search tried, in its order: points (n, d) of the unit cube and their scores (n,), the less the better."""

    method: str
    points: Array
    scores: Array

    @property
    def best(self) -> Array:
        return np.asarray(self.points[int(np.argmin(self.scores))])

    @property
    def curve(self) -> Array:
        """The best so far, after every evaluation."""
        return np.asarray(np.minimum.accumulate(self.scores))


class Searcher(Protocol):
    """Calls `function` until it raises; `start` is a point to begin with."""

    def __call__(self, function: Function, dimensions: int, seed: int, start: Array | None) -> None: ...


class BudgetSpentError(Exception):
    """Ends a search: no further evaluation is to be had."""


def search(method: str, function: Function, dimensions: int, evaluations: int, seed: int, start: Array | None = None) -> Trace:
    """Exactly `evaluations` calls. Same seed, same points. Raises `ParameterError` for an unknown method."""
    if method not in SEARCHERS:
        raise ParameterError("search", method, f"is not a known search; {nearest(method, SEARCHERS)}")
    points: list[Array] = []
    scores: list[float] = []

    def counted(x: Array) -> float:
        if len(scores) >= evaluations:
            raise BudgetSpentError
        point = np.clip(np.asarray(x, dtype=np.float64), 0.0, 1.0)
        score = float(function(point))
        points.append(point)
        scores.append(score)
        return score

    with contextlib.suppress(BudgetSpentError):
        SEARCHERS[method](counted, dimensions, seed, start)
    return Trace(method=method, points=np.array(points), scores=np.array(scores))


def _random(function: Function, dimensions: int, seed: int, start: Array | None) -> None:
    rng = np.random.default_rng(seed)
    if start is not None:
        function(start)
    while True:
        function(rng.random(dimensions))


def _evolution(function: Function, dimensions: int, seed: int, start: Array | None) -> None:
    """Differential evolution (Storn, Price 1997) of scipy, begun anew with another seed when it has converged."""
    from scipy.optimize import Bounds, differential_evolution

    bounds = Bounds(np.zeros(dimensions), np.ones(dimensions))
    while True:
        how: dict[str, Any] = {"rng": np.random.default_rng(seed), "popsize": _POPULATION, "polish": False, "x0": start}
        differential_evolution(function, bounds, tol=1e-12, maxiter=100_000, **how)
        seed, start = seed + 1, None


def _cma(function: Function, dimensions: int, seed: int, start: Array | None) -> None:
    """CMA-ES (Hansen 2016), begun anew when it has converged."""
    with of_extra("cmaes", "tune"):
        from cmaes import CMA
    while True:
        mean = np.full(dimensions, 0.5) if start is None else np.clip(start, 1e-6, 1.0 - 1e-6)
        optimiser = CMA(mean=mean, sigma=0.25, bounds=np.array([[0.0, 1.0]] * dimensions), seed=seed)
        while not optimiser.should_stop():
            asked = [optimiser.ask() for _ in range(optimiser.population_size)]
            optimiser.tell([(x, function(x)) for x in asked])
        seed, start = seed + 1, None


def _tpe(function: Function, dimensions: int, seed: int, start: Array | None) -> None:
    """Optuna's tree-structured Parzen estimator (Bergstra et al. 2011)."""
    optuna = optuna_module()
    names = [f"x{i}" for i in range(dimensions)]
    study = optuna.create_study(sampler=optuna.samplers.TPESampler(seed=seed, multivariate=True))
    if start is not None:
        study.enqueue_trial(dict(zip(names, start.tolist(), strict=True)))
    while True:
        trial = study.ask()
        study.tell(trial, function(np.array([trial.suggest_float(name, 0.0, 1.0) for name in names])))


SEARCHERS: dict[str, Searcher] = {"random": _random, "de": _evolution, "cma-es": _cma, "tpe": _tpe}


def optuna_module() -> Any:
    """Optuna, silenced: what it would log is in the study."""
    with of_extra("optuna", "tune"):
        import optuna
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    return optuna
