"""What the tuner may turn: at its defaults it is the planner as it is, and a turned knob turns what it names."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import InputError
from mcdas_opt.ocp.lane_mpc import LaneProblem, default_weights
from mcdas_opt.planning.adjustable import adjusted, defaults
from mcdas_opt.planning.mpc import MpcMethod
from mcdas_opt.planning.parameter_files import planner_with


def test_defaults_are_the_settings_that_there_are() -> None:
    made = adjusted({})
    for group in ("sigmoid", "selector", "headway", "comfort", "manners", "safe_end", "warning"):
        assert getattr(made.settings, group) == getattr(Settings(), group)
    assert made.solver.weights is None
    again = adjusted({name: value for name, value in defaults().items() if not name.startswith("weight.")})
    assert again.weights == made.weights
    assert again.solver == made.solver
    assert again.settings.selector.ttc_clear_s == pytest.approx(made.settings.selector.ttc_clear_s)


def test_free_weights_at_their_defaults_are_the_built_in_ones_and_scale_the_squares() -> None:
    fixed = LaneProblem(vehicle=Vehicle(), neighbours=1).stage_problem()
    free = LaneProblem(vehicle=Vehicle(), neighbours=1, free_weights=True).stage_problem()
    rng = np.random.default_rng(3)
    x, u = rng.normal(size=6) + np.array([0.0, 0.0, 0.0, 15.0, 0.0, 0.0]), rng.normal(size=2)
    p = dict(zip(fixed.parameters, rng.uniform(1.0, 3.0, len(fixed.parameters)), strict=True)) | {"ref_a": -0.2, "ref_b": 40.0}
    weights = default_weights()
    known = np.array([p[name] for name in fixed.parameters])

    def residuals(times: float) -> tuple[np.ndarray, np.ndarray]:
        full = np.array([times * weights[name] if name in weights else p[name] for name in free.parameters])
        return np.array(free.residual(x, u, full)).ravel(), np.array(free.terminal_residual(x, full)).ravel()

    assert np.allclose(residuals(1.0)[0], np.array(fixed.residual(x, u, known)).ravel(), rtol=1e-12)
    assert np.allclose(residuals(1.0)[1], np.array(fixed.terminal_residual(x, known)).ravel(), rtol=1e-12)
    assert np.allclose(residuals(4.0)[0], 2.0 * residuals(1.0)[0], rtol=1e-12)


def test_files_of_values_are_for_the_mpc_and_told_their_faults(tmp_path: Path) -> None:
    file = tmp_path / "values.toml"
    file.write_text(
        '[values]\n"cost.nearness" = 4.0\n"worth.waiting" = 1.0\n"selector.hysteresis" = 1.6\n"comfort.share" = 0.5\n', encoding="utf-8"
    )
    planner = planner_with(file, Vehicle(), "mpc")
    assert planner.name == "mpc"
    assert isinstance(planner.method, MpcMethod)
    assert (planner.method.weights.nearness, planner.method.weights.delayed) == (4.0, 1.0)  # the second as earlier versions named it
    assert planner.settings.comfort.share == 0.5
    assert planner.settings.selector.ttc_clear_s == pytest.approx(1.6 * planner.settings.selector.ttc_threat_s)
    with pytest.raises(InputError, match="does not take them"):
        planner_with(file, Vehicle(), "closed-form-corrected")
    file.write_text('[values]\n"cost.nearnes" = 4.0\n', encoding="utf-8")
    with pytest.raises(InputError, match=r"did you mean 'cost\.nearness'"):
        planner_with(file, Vehicle(), "mpc")
    file.write_text("[provenance]\nmade_by = 'me'\n", encoding="utf-8")
    with pytest.raises(InputError, match="one of them"):
        planner_with(file, Vehicle(), "mpc")
