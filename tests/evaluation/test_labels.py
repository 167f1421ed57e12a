"""Labels: hand-made scenes whose class is known, laws over families."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mcdas_opt.catalogue.scenes import Scene, scene_from_document
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.errors import ParameterError
from mcdas_opt.evaluation.families import load_family
from mcdas_opt.evaluation.labels import REACTIONS_S, ROOM_M, Kind, Label, label_chunk, label_scene, with_room
from mcdas_opt.evaluation.oracle import unbraked
from mcdas_opt.simulation.neighbours import known_bodies
from mcdas_opt.verification.judge import judge

ORDER = {Kind.A: 0, Kind.C: 1, Kind.U: 2}
ALONG = 15.0


def scene(*neighbours: dict[str, Any], speed: float = ALONG, duration: float = 6.0, **road: Any) -> Scene:
    document = {"duration_s": duration, "road": road, "host": {"speed_mps": speed}, "neighbour": list(neighbours)}
    return scene_from_document(document, Path("scene.toml"))


def wall(gap_m: float) -> dict[str, Any]:
    return {"name": "wall", "s_m": gap_m + 4.5, "speed_mps": 0.0}


def rear(gap_m: float, faster: float, **more: Any) -> dict[str, Any]:
    return {"name": "rear", "s_m": -gap_m - 4.5, "speed_mps": ALONG + faster, **more}


BRAKES = [{"start_s": 1.5, "acceleration_mps2": -6.0, "until_speed_mps": ALONG}]
SAME = {"name": "front", "s_m": 8.0, "speed_mps": ALONG}


@pytest.mark.parametrize(
    ("it", "kind"),
    [
        (scene(), Kind.A),
        (scene(wall(60.0)), Kind.A),
        (scene(wall(8.0)), Kind.U),
        (scene(wall(20.0)), Kind.A),
        (scene(wall(16.4)), Kind.C),  # stops in 16 m if it begins at once: before anybody can have seen the need
        (scene(wall(8.0), speed=30.0, lanes_left=1), Kind.U),
        (scene(wall(24.0), speed=30.0, lanes_left=1), Kind.A),
        (scene(SAME, rear(20.0, 5.0)), Kind.U),
        (scene(SAME, rear(20.0, 5.0, motion=BRAKES)), Kind.C),  # boxed in: only that the rear car brakes helps
        (scene(SAME, rear(20.0, 5.0), lanes_right=1), Kind.A),
        (scene({"s_m": 50.0, "speed_mps": ALONG - 9.0}, lanes_left=1, curvature=[[0.0, 0.005]]), Kind.A),
    ],
)
def test_scenes_whose_class_is_known(it: Scene, kind: Kind) -> None:
    label = label_scene(it)
    assert label.kind is kind, label.reason
    assert (label.witness is not None) == (kind in (Kind.A, Kind.C))


@pytest.fixture(scope="module", params=["sandwich", "striking-rear"])
def labelled(request: pytest.FixtureRequest) -> list[tuple[Scene, Label, Label]]:
    scenes = load_family(request.param).scenes(8, seed=33)
    early, late = ([label_scene(it, reaction) for it in scenes] for reaction in REACTIONS_S)
    return list(zip(scenes, early, late, strict=True))


def test_who_reacts_later_avoids_no_more(labelled: list[tuple[Scene, Label, Label]]) -> None:
    for _, early, late in labelled:
        assert (early.kind is Kind.U) == (late.kind is Kind.U)
        if late.kind is Kind.A:
            assert early.kind is Kind.A
        if early.kind is Kind.C:
            assert late.kind is Kind.C


def test_with_room_everybody_is_larger_on_each_side() -> None:
    room_m = 3.0
    assert label_scene(scene(wall(16.4 + room_m))).kind is Kind.A
    assert label_scene(with_room(scene(wall(16.4 + room_m)), room_m)).kind is label_scene(scene(wall(16.4))).kind is Kind.C


def test_what_is_avoidable_with_room_is_avoidable(labelled: list[tuple[Scene, Label, Label]]) -> None:
    """Its witness is safe in the scene as it is; of a scene that is not avoidable nothing is asked."""
    scenes = [it for it, _, _ in labelled]
    records = label_chunk(scenes, REACTIONS_S[0])
    assert [record["label"] for record in records] == [label.kind.value for _, label, _ in labelled]
    for it, record in zip(scenes, records, strict=True):
        if record["label"] != "A":
            assert record["with_room"] == record["label"]
            continue
        roomy = label_scene(with_room(it, ROOM_M))
        assert record["with_room"] == roomy.kind.value
        if roomy.kind is Kind.A:
            bodies = Prediction(name="as they are", bodies=(*known_bodies(it), *unbraked(it)))
            assert judge(roomy.witness, it.host_state, it.vehicle, it.true_road, bodies).passed
    assert "A" in {record["with_room"] for record in records}


def test_witnesses_of_a_wait_and_pass_the_judge_in_both_versions(labelled: list[tuple[Scene, Label, Label]]) -> None:
    shown = 0
    for it, *labels in labelled:
        for label in labels:
            if label.kind is not Kind.A:
                continue
            shown += 1
            drive = label.witness
            assert drive is not None
            held = drive.t_s <= label.onset_s + label.reaction_s + 1e-9
            assert np.all(drive.d_m[held] == it.host_state.d_m)
            assert np.allclose(drive.speed_mps[held], it.host_state.speed_mps)
            assert drive.t_s[-1] > it.duration_s - 0.051
            bodies = (*known_bodies(it), *unbraked(it))
            assert judge(drive, it.host_state, it.vehicle, it.true_road, Prediction(name="scene", bodies=bodies)).passed
    assert shown >= 5


def test_mirrored_scenes_have_the_same_label(labelled: list[tuple[Scene, Label, Label]]) -> None:
    for it, early, _ in labelled[:4]:
        road = it.road.model_copy(update={"lanes_left": it.road.lanes_right, "lanes_right": it.road.lanes_left})
        parts = [part.model_copy(update={"d_m": -(part.d_m or 0.0)}) for part in it.neighbour]
        assert label_scene(it.model_copy(update={"road": road, "neighbour": parts})).kind is early.kind


def test_what_cannot_be_labelled_is_refused() -> None:
    with pytest.raises(ParameterError, match="idm"):
        label_scene(scene({"s_m": -30.0, "speed_mps": ALONG, "behaviour": "idm"}))
    with pytest.raises(ParameterError, match="reaction_s"):
        label_scene(scene(), reaction_s=-0.1)
