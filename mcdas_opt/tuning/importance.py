"""Which of the values mattered: analysis of variance of a study's scores."""

from __future__ import annotations

from collections.abc import Sequence

from mcdas_opt.tuning.search_space import Range, shares_of
from mcdas_opt.tuning.searchers import optuna_module
from mcdas_opt.tuning.study import Trial

_LEAST = 8  # of fewer trials nothing can be said


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
