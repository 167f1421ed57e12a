"""Crash rates too small to be counted: subset simulation and importance sampling on the least signed gap.

Both work in independent standard normal variables. Signed gap means: the least clearance [m] of a drive, or minus the way [m] that was
missing where it crashed; a crash is a gap of 0 or less.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp
from scipy.stats import multivariate_normal

from mcdas_opt.domain.rules import Array
from mcdas_opt.errors import ParameterError

Gap = Callable[[Array], Array]  # (n, dimensions) standard normal variables -> (n,) signed gaps

_CHUNK = 100_000  # runs at once
_LEVEL_SHARE = 0.1
_CORRELATION = 0.8  # of a chain's next state with its last, where it is accepted
_MOST_LEVELS = 20
_WIDENING = 1.15  # of the proposal over the failures that it is fitted to: its tails must not be the lighter ones
_DEFENSIVE = 0.1  # share of the proposal that is the original density: no weight exceeds 1 / share


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """A crash probability. `variation` is the coefficient of variation that the method estimates for itself; `levels_m` are a subset
    simulation's intermediate gaps, `effective_sample_size` counts the weighted crashes of importance sampling (of crude sampling: the
    crashes). `crashes` (k, dimensions) are the crashes that were found."""

    method: str
    probability: float
    variation: float
    runs: int
    levels_m: tuple[float, ...] = ()
    effective_sample_size: float | None = None
    crashes: Array = field(repr=False, compare=False)


def crude(gap: Gap, dimensions: int, runs: int, seed: int) -> Estimate:
    """Crude Monte Carlo."""
    rng = np.random.default_rng(seed)
    crashes: list[Array] = []
    for first in range(0, runs, _CHUNK):
        u = rng.standard_normal((min(_CHUNK, runs - first), dimensions))
        crashes.append(u[gap(u) <= 0.0])
    found = np.concatenate(crashes)
    p = len(found) / runs
    variation = float(np.sqrt((1.0 - p) / (p * runs))) if p else float("inf")
    return Estimate(method="crude", probability=p, variation=variation, runs=runs, effective_sample_size=float(len(found)), crashes=found)


def subset_simulation(gap: Gap, dimensions: int, seed: int, per_level: int = 1000) -> Estimate:
    """P(gap <= 0) as a product of conditional probabilities of 0.1 (Au and Beck, Prob. Eng. Mech. 16 (2001) 263).

    Each level is grown from the tenth of the last that came nearest to a crash, by Markov chains that propose 0.8 u + 0.6 xi and
    accept what stays in the level (Papaioannou et al., Prob. Eng. Mech. 41 (2015) 89). The coefficient of variation counts the chains'
    own correlation (Au and Beck, eq 29), not the correlation between levels. Raises `ParameterError` for fewer than 100 a level; a
    probability under 0.1^20 comes back as 0.
    """
    if per_level < 100:
        raise ParameterError("per_level", per_level, "must be at least 100")
    rng = np.random.default_rng(seed)
    seeds = round(_LEVEL_SHARE * per_level)
    u = rng.standard_normal((per_level, dimensions))
    g = gap(u)
    runs, squares = per_level, 0.0
    levels: list[float] = []
    probability = 1.0
    chains = per_level  # how many independent ones there are, side by side
    for _ in range(_MOST_LEVELS):
        order = np.argsort(g, kind="stable")
        level = float(0.5 * (g[order[seeds - 1]] + g[order[seeds]]))
        done = level <= 0.0
        inside = g <= (0.0 if done else level)
        share = float(inside.mean())
        squares += (1.0 - share) / (share * per_level) * (1.0 + _correlation(inside, chains))
        probability *= share
        if done:
            return Estimate(
                method="subset simulation",
                probability=probability,
                variation=float(np.sqrt(squares)),
                runs=runs,
                levels_m=tuple(levels),
                crashes=u[inside],
            )
        levels.append(level)
        chosen = order[:seeds]
        u, g = _grown(gap, u[chosen], g[chosen], level, per_level, rng)
        runs, chains = runs + len(u) - seeds, seeds
    return Estimate(method="subset simulation", probability=0.0, variation=float("inf"), runs=runs, levels_m=tuple(levels), crashes=u[:0])


def _grown(gap: Gap, u: Array, g: Array, level: float, count: int, rng: np.random.Generator) -> tuple[Array, Array]:
    """Chains from every seed, side by side, until there are `count` states; ordered step by step, so that state i belongs to chain
    i modulo the number of seeds."""
    states, gaps = [u], [g]
    while sum(map(len, states)) < count:
        step = np.sqrt(1.0 - _CORRELATION**2) * rng.standard_normal(u.shape)
        proposed = _CORRELATION * u + step
        there = gap(proposed)
        stays = there <= level
        u, g = np.where(stays[:, None], proposed, u), np.where(stays, there, g)
        states.append(u)
        gaps.append(g)
    return np.concatenate(states)[:count], np.concatenate(gaps)[:count]


def _correlation(inside: NDArray[np.bool_], chains: int) -> float:
    """gamma: twice the autocorrelation of the indicator along the chains, weighted (Au and Beck 2001, eq 29)."""
    length = len(inside) // chains
    if length < 2:
        return 0.0
    rows = inside[: length * chains].reshape(length, chains).astype(np.float64)
    p = float(rows.mean())
    spread = p * (1.0 - p)
    if spread <= 0.0:
        return 0.0
    total = sum((1.0 - lag / length) * float((rows[:-lag] * rows[lag:]).mean() - p * p) / spread for lag in range(1, length))
    return max(2.0 * total, 0.0)


def importance_sampling(gap: Gap, crashes: Array, runs: int, seed: int) -> Estimate:
    """P(gap <= 0) from a normal density fitted to crashes that were found before, mixed with a tenth of the original one.

    The fit is the cross-entropy method's (Rubinstein and Kroese 2004), widened; the mixture bounds the weights (Owen and Zhou, J. Am.
    Stat. Ass. 95 (2000) 135). Raises `ParameterError` for too few crashes to fit to.
    """
    count, dimensions = crashes.shape
    if count <= 2 * dimensions:
        raise ParameterError("crashes", count, f"must be more than {2 * dimensions} to fit a density in {dimensions} dimensions")
    rng = np.random.default_rng(seed)
    mean = crashes.mean(axis=0)
    covariance = _WIDENING**2 * (np.cov(crashes.T).reshape(dimensions, dimensions) + 1e-3 * np.eye(dimensions))
    fitted, original = multivariate_normal(mean, covariance), multivariate_normal(np.zeros(dimensions))
    u = rng.standard_normal((runs, dimensions))
    moved = rng.random(runs) >= _DEFENSIVE
    u[moved] = mean + u[moved] @ np.linalg.cholesky(covariance).T
    mixed = logsumexp([np.log1p(-_DEFENSIVE) + fitted.logpdf(u), np.log(_DEFENSIVE) + original.logpdf(u)], axis=0)
    crashed = gap(u) <= 0.0
    weights = np.where(crashed, np.exp(original.logpdf(u) - mixed), 0.0)
    p = float(weights.mean())
    squares = float((weights * weights).sum())
    variation = float(weights.std() / (p * np.sqrt(runs))) if p else float("inf")
    return Estimate(
        method="importance sampling",
        probability=p,
        variation=variation,
        runs=runs,
        effective_sample_size=float(weights.sum() ** 2 / squares) if squares else 0.0,
        crashes=u[crashed],
    )
