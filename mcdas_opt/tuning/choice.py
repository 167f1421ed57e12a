"""Which of a study's trials is taken, and why; whether it may become the default, and which of the values mattered."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from operator import attrgetter

import numpy as np

from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.errors import ParameterError
from mcdas_opt.tuning.search_space import Range, shares_of
from mcdas_opt.tuning.searchers import optuna_module
from mcdas_opt.tuning.study import Trial
from mcdas_opt.tuning.traffic import OBJECTIVES, DriveFigures, Drives, TrafficCost, cost_of

_WORDS = {
    "peak_lateral_mps2": "m/s^2 of peak lateral acceleration",
    "peak_jerk_mps3": "m/s^3 of peak jerk",
    "manoeuvre_m": "m driven beside a lane's middle",
}
_LEAST = 8  # of fewer trials nothing can be said


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """The trial that is taken, the front it was taken from, and the reasons in words."""

    trial: Trial
    front: tuple[Trial, ...]
    reasons: tuple[str, ...]


def pareto(trials: Sequence[Trial]) -> tuple[Trial, ...]:
    """Finished, unpruned trials without an unverified plan, of which none other is at least as good in all and better in one."""
    able = [trial for trial in trials if not trial.pruned and trial.cost.unverified == 0]
    points = np.array([trial.cost.objectives for trial in able]).reshape(len(able), len(OBJECTIVES))
    front = []
    for i, trial in enumerate(able):
        no_worse, better = np.all(points <= points[i], axis=1), np.any(points < points[i], axis=1)
        if not np.any(no_worse & better):
            front.append(trial)
    return tuple(front)


def choose(trials: Sequence[Trial]) -> Choice:
    """Fewest collisions first; of those on the front the least sum of comforts, each in units of what is usual."""
    front = pareto(trials)
    if not front:
        raise ParameterError("trials", len(trials), "no trial was driven to its end without an unverified plan: nothing to choose from")
    least = min(trial.cost.collisions for trial in front)
    safest = [trial for trial in front if trial.cost.collisions == least]
    taken = min(safest, key=lambda trial: (trial.cost.score, trial.number))
    cost = taken.cost
    reasons = [
        f"fewest collisions on training: {round(cost.collisions * cost.drives)} of {cost.drives} avoidable scenes"
        f" ({len(safest)} of {len(front)} points of the front have as few)",
        f"of these the least {cost.peak_lateral_mps2:.2f}/4 + {cost.peak_jerk_mps3:.1f}/20 + {cost.manoeuvre_m:.1f}/50",
    ]
    for name in OBJECTIVES[1:]:
        figure = attrgetter(name)
        best = min(front, key=lambda trial: figure(trial.cost))
        if best is not taken:
            gap = figure(cost) - figure(best.cost)
            reasons.append(f"gives up {gap:.3g} {_WORDS[name]} against trial {best.number}")
    return Choice(trial=taken, front=front, reasons=tuple(reasons))


@dataclass(frozen=True, slots=True, kw_only=True)
class SetResult:
    """The defaults and the tuned values on one set of scenes; drives that are known from the study's file are not told one by one."""

    name: str
    seed: int
    scenes: tuple[str, ...]
    default: TrafficCost
    tuned: TrafficCost
    default_drives: tuple[DriveFigures, ...] = field(default=(), repr=False)
    tuned_drives: tuple[DriveFigures, ...] = field(default=(), repr=False)

    @property
    def wins(self) -> bool:
        return self.tuned.score < self.default.score


@dataclass(frozen=True, slots=True, kw_only=True)
class Guarded:
    """What happened on training, validation and test scenes, and whether the tuned values may become the default."""

    sets: tuple[SetResult, ...]
    accepted: bool
    reason: str


def judged(sets: Sequence[SetResult]) -> Guarded:
    """Accepted where the tuned values win on training and do not lose on validation, in score or in collisions. Test only reports."""
    train, validation = (next(one for one in sets if one.name == name) for name in ("train", "validation"))
    if not train.wins:
        reason = "refused: no better than the defaults on the training scenes"
    elif validation.tuned.collisions > validation.default.collisions:
        reason = "refused: wins on training, but collides more than the defaults on validation"
    elif validation.tuned.score > validation.default.score:
        reason = "refused: wins on training, loses on validation: overfit"
    else:
        reason = "accepted: wins on training and does not lose on validation"
    return Guarded(sets=tuple(sets), accepted=reason.startswith("accepted"), reason=reason)


def compared(
    name: str,
    seed: int,
    scenes: Sequence[Scene],
    default: Mapping[str, float],
    tuned: Mapping[str, float],
    drives: Drives,
    known: Sequence[Trial] = (),
) -> SetResult:
    """Both sets of values through the same scenes; `known` are trials that have driven them already."""

    def driven(values: Mapping[str, float]) -> tuple[TrafficCost, tuple[DriveFigures, ...]]:
        there = next((trial.cost for trial in known if trial.values == values), None)
        if there is not None:
            return there, ()
        figures = tuple(drives(scenes, values))
        return cost_of(figures), figures

    old = driven(default)
    new = old if tuned == default else driven(tuned)
    names = tuple(scene.name for scene in scenes)
    return SetResult(name=name, seed=seed, scenes=names, default=old[0], tuned=new[0], default_drives=old[1], tuned_drives=new[1])


def importance(trials: Sequence[Trial], space: Sequence[Range]) -> dict[str, float]:
    """Shares of one, largest first, by PED-ANOVA (Watanabe et al., IJCAI 2023) on the scores; empty for fewer than eight trials."""
    whole = [trial for trial in trials if not trial.pruned]
    if len(whole) < _LEAST or len({trial.cost.score for trial in whole}) < 2:
        return {}
    optuna = optuna_module()
    study = optuna.create_study()
    even = {part.name: optuna.distributions.FloatDistribution(0.0, 1.0) for part in space}
    for trial in whole:
        shares = dict(zip(even, shares_of(space, trial.values).tolist(), strict=True))
        study.add_trial(optuna.trial.create_trial(params=shares, distributions=even, value=trial.cost.score))
    evaluator = optuna.importance.PedAnovaImportanceEvaluator(target_quantile=0.5)
    found = optuna.importance.get_param_importances(study, evaluator=evaluator)
    return {name: float(value) for name, value in sorted(found.items(), key=lambda item: -item[1])}
