"""The shipped scenes, and the real planner in the loop."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mcdas_opt.catalogue.data_files import models_folder, shipped
from mcdas_opt.catalogue.scenes import Scene, load_scene
from mcdas_opt.domain.prediction import BodyMotion
from mcdas_opt.planning.planner import Planner
from mcdas_opt.simulation.contact import surroundings
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.neighbours import Traffic
from mcdas_opt.simulation.record import Outcome, Simulation
from tests.simulation.fake_driver import FakeDriver

SCENES = shipped("scenes")
IDEAL = {"front": "ideal", "rear": "ideal", "left": "ideal", "right": "ideal"}


def changed(name: str, **parts: Any) -> Scene:
    document = load_scene(name).model_dump(exclude_none=True)
    for part in document["neighbour"]:
        if part["behaviour"] == "idm":
            del part["motion"]
    return Scene.model_validate({**document, **parts})


def repeatable(drive: Simulation) -> str:
    document = drive.to_dict()
    del document["cycle_ms"]
    return json.dumps(document, allow_nan=False)


def test_there_are_the_scenes_of_the_issue() -> None:
    wanted = {
        "sandwich-60-40", "sandwich-offset-left", "sandwich-offset-right", "rear-closing", "front-braking-with-follower",
        "both-lanes-blocked", "stopped-obstacle", "curved-road", "low-friction", "benign-following",
    }  # fmt: skip
    assert wanted <= set(SCENES)


@pytest.mark.parametrize("name", SCENES)
def test_a_scene_is_named_as_its_file_says_what_it_shows_and_begins_on_the_road(name: str) -> None:
    text = (models_folder() / "scenes" / f"{name}.toml").read_text()
    assert re.match(r"# \w", text)
    scene = load_scene(name)
    assert scene.name == name
    road = scene.true_road
    for body, part in zip(Traffic(scene).bodies(0.0), scene.neighbour, strict=True):
        if part.heading_rad is not None:  # comes from elsewhere
            continue
        assert road.right_edge_m < body.d_m - 0.5 * body.width_m < body.d_m + 0.5 * body.width_m < road.left_edge_m


@pytest.mark.parametrize("name", SCENES)
def test_neighbours_do_not_drive_through_one_another(name: str) -> None:
    """For 3 s, while the host goes straight on (later the paper's rear car would run into its front car)."""
    scene = load_scene(name)
    drive = simulate(scene, FakeDriver())
    early = drive.trajectory.t_s < 3.0
    motions = [
        BodyMotion(
            s_m=n.s_m[early], d_m=n.d_m[early], heading_rad=n.heading_rad[early], speed_s_mps=n.speed_mps[early], speed_d_mps=n.d_m[early]
        )
        for n in drive.neighbours
    ]
    zero = np.zeros(int(early.sum()))
    for i, (one, rest) in enumerate(zip(drive.neighbours, (motions[k + 1 :] for k in range(len(motions))), strict=True)):
        states = np.column_stack([motions[i].s_m, motions[i].d_m, motions[i].heading_rad, zero, zero, zero])
        sizes = tuple((n.length_m, n.width_m) for n in drive.neighbours[i + 1 :])
        body = replace(scene.vehicle, width_m=one.width_m)
        assert not surroundings(states, tuple(rest), sizes, body, scene.true_road).touching.any()


def test_the_dead_end_leaves_nothing() -> None:
    scene = load_scene("both-lanes-blocked")
    wall = next(body for body in Traffic(scene).bodies(0.0) if body.name == "wall")
    room = wall.s_m - 0.5 * (wall.length_m + scene.vehicle.length_m)
    assert scene.host.speed_mps**2 / (2.0 * -scene.vehicle.acceleration_min_mps2) > room


@pytest.mark.parametrize("name", ["sandwich-60-40", "curved-road"])
def test_the_sandwich_is_driven_through(name: str) -> None:
    drive = simulate(load_scene(name), "closed-form-corrected")
    assert drive.outcome is Outcome.SAFE
    assert drive.lane_change_completed
    assert (drive.unverified_plans, drive.unavoidable) == (0, 0)
    assert drive.min_clearance_m is not None
    assert drive.min_clearance_m > 1.5


def test_a_planner_used_again_begins_afresh() -> None:
    scene = changed("sandwich-60-40", duration_s=0.6)
    planner = Planner(vehicle=scene.vehicle, method="mpc", road=scene.assumed_road)
    first, second = simulate(scene, planner), simulate(scene, planner)
    by_name = simulate(scene, "mpc")
    assert repeatable(first) == repeatable(second) == repeatable(by_name)


@pytest.mark.parametrize(("planner", "seconds"), [("closed-form-corrected", 4.0), ("mpc", 0.6)])
def test_mirror_the_scene_and_the_drive_mirrors(planner: str, seconds: float) -> None:
    left, right = (
        simulate(changed(f"sandwich-offset-{side}", duration_s=seconds, sensors=IDEAL), planner).trajectory for side in ("left", "right")
    )
    assert np.abs(left.d_m).max() > 0.01
    for key, sign in (("s_m", 1.0), ("d_m", -1.0), ("heading_rad", -1.0), ("speed_mps", 1.0), ("steering_rad", -1.0)):
        np.testing.assert_allclose(getattr(left, key), sign * getattr(right, key), atol=1e-6)
