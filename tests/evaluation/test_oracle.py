"""The witness half of the oracle: what it calls avoidable has a witness that the judge passes, in both versions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mcdas_opt.catalogue.scenes import Scene, scene_from_document
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.errors import ParameterError
from mcdas_opt.evaluation.families import load_family
from mcdas_opt.evaluation.oracle import REACTION_S, onset_s, unbraked, witness
from mcdas_opt.simulation.neighbours import known_bodies
from mcdas_opt.verification.judge import judge


def scene(*neighbours: dict[str, Any], speed: float = 15.0, duration: float = 6.0, **road: Any) -> Scene:
    document = {"duration_s": duration, "road": road, "host": {"speed_mps": speed}, "neighbour": list(neighbours)}
    return scene_from_document(document, Path("scene.toml"))


def test_witnesses_hold_until_they_may_act_and_pass_in_both_versions() -> None:
    found = 0
    for one in load_family("sandwich").scenes(12, seed=11):
        drive, host = witness(one), one.host_state
        if drive is None:
            continue
        found += 1
        held = drive.t_s <= onset_s(one) + REACTION_S + 1e-9
        assert np.all(drive.d_m[held] == 0.0)
        assert np.allclose(drive.speed_mps[held], host.speed_mps)
        bodies = (*known_bodies(one), *unbraked(one))
        assert drive.t_s[-1] > one.duration_s - 0.051
        assert judge(drive, host, one.vehicle, one.true_road, Prediction(name="scene", bodies=bodies)).passed
    assert found >= 3


def test_onset_is_the_first_change_or_a_near_collision() -> None:
    braking = [{"start_s": 2.0, "acceleration_mps2": -3.0}]
    assert onset_s(scene({"s_m": 60.0, "speed_mps": 15.0, "motion": braking})) == 2.0
    # 10 m/s closing on 64.5 - 4.5 m: four seconds are left at 2 s
    assert onset_s(scene({"s_m": 64.5, "speed_mps": 5.0})) == pytest.approx(2.0, abs=0.03)
    assert onset_s(scene({"s_m": -64.5, "speed_mps": 25.0})) == pytest.approx(2.0, abs=0.03)
    assert onset_s(scene({"s_m": 64.5, "d_m": 3.7, "speed_mps": 5.0}, lanes_left=1)) == 6.0


def test_a_rear_car_that_must_be_known_to_brake_leaves_no_witness() -> None:
    """One lane, a wall of traffic ahead at the same speed: only the rear car's own braking helps."""
    brakes = {"start_s": 1.5, "acceleration_mps2": -6.0, "until_speed_mps": 10.0}
    cars = ({"name": "front", "s_m": 8.0, "speed_mps": 15.0}, {"name": "rear", "s_m": -24.5, "speed_mps": 20.0, "motion": [brakes]})
    assert witness(scene(*cars)) is None
    never = (cars[0], {"name": "rear", "s_m": -24.5, "speed_mps": 20.0})
    assert witness(scene(*never)) is None
    assert witness(scene(*never, lanes_left=1)) is not None


def test_a_stopped_wall_too_near_leaves_no_witness() -> None:
    assert witness(scene({"s_m": 12.0, "speed_mps": 0.0}, speed=30.0)) is None


def test_neighbours_that_react_are_refused() -> None:
    with pytest.raises(ParameterError, match="idm"):
        witness(scene({"s_m": -30.0, "speed_mps": 15.0, "behaviour": "idm"}))
