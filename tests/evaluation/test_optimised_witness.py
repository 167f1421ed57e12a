"""The nonlinear program as last stage of the oracle: what it finds the judge passes; its rows are what they say."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mcdas_opt.catalogue.scenes import Scene, scene_from_document
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.evaluation.optimised_witness import optimised_witness_from
from mcdas_opt.geometry.rectangle import corners
from mcdas_opt.ocp.side_constrained_lane import SideConstrainedLaneProblem
from mcdas_opt.simulation.neighbours import known_bodies
from mcdas_opt.verification.judge import judge


def scene(*neighbours: dict[str, Any], speed: float = 20.0, **road: Any) -> Scene:
    document = {"duration_s": 5.0, "road": road, "host": {"speed_mps": speed}, "neighbour": list(neighbours)}
    return scene_from_document(document, Path("scene.toml"))


def test_what_it_finds_waits_and_passes_the_judge() -> None:
    it = scene({"s_m": 32.0, "speed_mps": 5.0}, {"s_m": -14.0, "speed_mps": 27.0}, lanes_left=1)
    bodies = known_bodies(it)
    drive, starts = optimised_witness_from(it, 0.2, bodies)
    assert drive is not None
    assert starts >= 1
    held = drive.t_s <= 0.2 + 1e-9
    assert np.all(drive.d_m[held] == 0.0)
    assert judge(drive, it.host_state, it.vehicle, it.true_road, Prediction(name="scene", bodies=bodies)).passed


def test_nothing_is_found_where_nothing_is_and_bends_are_left_alone() -> None:
    assert (
        optimised_witness_from(scene({"s_m": 9.0, "speed_mps": 0.0}), 0.0, known_bodies(scene({"s_m": 9.0, "speed_mps": 0.0})))[0] is None
    )
    bent = scene({"s_m": 60.0, "speed_mps": 5.0}, lanes_left=1, curvature=[[0.0, 0.004]])
    assert optimised_witness_from(bent, 0.0, known_bodies(bent)) == (None, 0)


@pytest.mark.parametrize("psi", [-0.3, 0.0, 0.2])
def test_the_rows_of_a_line_are_the_corners_distances_from_it(psi: float) -> None:
    car = Vehicle()
    problem = SideConstrainedLaneProblem(vehicle=car, neighbours=1).stage_problem()
    x = np.array([12.0, 1.5, psi, 20.0, 0.0, 0.0])
    p = dict.fromkeys(problem.parameters, 0.0) | {"line0_angle": 0.7, "line0_offset": 3.0, "grip": 8.8, "road_end": 1e4}
    rows = np.asarray(problem.inequality(x, np.zeros(2), [p[name] for name in problem.parameters])).ravel()
    mine = np.array([row for row, name in zip(rows, problem.rows, strict=True) if name.startswith("line")])
    points = corners(12.0, 1.5, psi, car.length_m, car.width_m)
    assert np.allclose(mine, 3.0 - points @ np.array([np.cos(0.7), np.sin(0.7)]))
