"""Editing: what is edited is what the scene then says, all of it can be undone, shared and saved, and nothing else comes in that way."""

from __future__ import annotations

import base64
import json
import zlib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.catalogue.data_files import find, shipped
from mcdas_opt.catalogue.scene_file import scene_document
from mcdas_opt.catalogue.scenes import load_scene
from mcdas_opt.errors import InputError, McdasError, ParameterError
from mcdas_opt.evaluation.file_formats import keys
from mcdas_opt.studio.edits import History, edited
from mcdas_opt.studio.folder import ExistsError, Folder
from mcdas_opt.studio.form import form
from mcdas_opt.studio.handles import handles
from mcdas_opt.studio.planner_cache import installed, methods
from mcdas_opt.studio.sandwich_tab import SandwichTab
from mcdas_opt.studio.share import document_in, link_of

SCENE = load_scene("sandwich-60-40")


@pytest.fixture
def tab(tmp_path: Path) -> SandwichTab:
    return SandwichTab(Folder(root=tmp_path))


def edit(tab: SandwichTab, changes: dict[str, Any], stroke: str | None = None) -> None:
    tab.act({"do": "edit", "changes": changes, "stroke": stroke})


@given(st.lists(st.sampled_from(["new", "same", "undo", "redo"]), max_size=30))
def test_a_history_is_that_of_a_list_with_a_place_in_it(steps: list[str]) -> None:
    history, told, place, dragging = History(present=0), [0], 0, False
    for number, step in enumerate(steps, start=1):
        if step in ("undo", "redo"):
            history, before = history.undone() if step == "undo" else history.redone(), place
            place = max(place - 1, 0) if step == "undo" else min(place + 1, len(told) - 1)
            dragging = dragging and place == before  # what is undone ends a drag
        else:
            history = history.then(number, None if step == "new" else "drag")
            told = [*told[: place + (not (dragging and step == "same"))], number]
            place, dragging = len(told) - 1, step == "same"
        assert (history.present, len(history.past), len(history.future)) == (told[place], place, len(told) - 1 - place)


def test_a_history_ends_somewhere() -> None:
    history = History(present=0)
    for k in range(1, 500):
        history = history.then(k)
    assert len(history.past) == 100
    assert history.undone().present == 498


@given(
    st.dictionaries(
        st.sampled_from(["neighbour[0].s_m", "neighbour[0].speed_mps", "road.friction", "host.desired_speed_mps", "sensors.latency_s"]),
        st.floats(0.1, 1.0),
    )
)
def test_edited_keys_say_what_they_were_told_and_the_others_what_they_said(changes: dict[str, float]) -> None:
    before, after = scene_document(SCENE), edited(SCENE, changes)
    assert scene_document(SCENE) == before

    def flat(part: Any, path: str = "") -> dict[str, Any]:
        if isinstance(part, dict):
            return {k: v for key, value in part.items() for k, v in flat(value, f"{path}.{key}".lstrip(".")).items()}
        if isinstance(part, list):
            return {k: v for n, value in enumerate(part) for k, v in flat(value, f"{path}[{n}]").items()}
        return {path: part}

    assert flat(after) == flat(before) | changes


def test_cars_come_and_go(tab: SandwichTab) -> None:
    edit(tab, {"neighbour[2]": {"name": "third", "s_m": 60.0, "d_m": 3.7, "speed_mps": 11.0}})
    assert [car.name for car in tab.at.scene.neighbour] == ["front", "rear", "third"]
    edit(tab, {"neighbour[0]": None})
    assert [car.name for car in tab.at.scene.neighbour] == ["rear", "third"]
    edit(tab, {"neighbour[1].motion[0]": {"start_s": 1.0, "acceleration_mps2": -4.0}})
    assert tab.at.scene.neighbour[1].motion[0].acceleration_mps2 == -4.0
    edit(tab, {"destination": {"s_m": [100.0, 200.0]}, "road.curvature": [[0.0, 0.0], [80.0, 0.004]], "road.lanes_left": 2})
    assert tab.state()["scene"]["destination"]["s_m"] == [100.0, 200.0]
    for _ in range(4):
        tab.act({"do": "undo"})
    assert tab.at.scene == SCENE
    assert not tab.state()["undo"]
    for _ in range(4):
        tab.act({"do": "redo"})
    assert tab.at.scene.road.lanes_left == 2


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"neighbour[0].s_m": 1.0}, "overlaps host"),
        ({"neighbour[7].s_m": 1.0}, "is no key of this scene"),
        ({"neighbour[3]": {}}, "is no key of this scene"),
        ({"road.lanes_lef": 1}, "lanes_left"),
        ({"host.speed_mps": None}, "missing key"),
        ({"host.speed_mps": "x"}, "number"),
        ({"__class__.x[": 1}, "is no key of a scene"),
        ({"host": 3}, "table"),
        ({"name.x": 3}, "is no key of this scene"),
        ({"host.vehicle": "/etc/hostname"}, "outside of the folder"),
        ({"neighbour[0]": {"trajectory": "../x.csv"}}, "outside of the folder"),
        ({"neighbour": [{"s_m": 10.0 * k, "speed_mps": 1.0} for k in range(1, 200)]}, "more cars"),
    ],
)
def test_an_edit_that_makes_no_scene_changes_nothing(tab: SandwichTab, changes: dict[str, Any], said: str) -> None:
    before = tab.state()
    with pytest.raises(McdasError, match=said):
        edit(tab, changes)
    assert tab.state() == before


def test_a_drag_is_one_step(tab: SandwichTab) -> None:
    for k in range(20):
        edit(tab, {"neighbour[0].s_m": 30.0 + k}, "drag 1")
    edit(tab, {"a_per_m": -0.5}, "a_per_m 0")
    tab.act({"do": "undo"})
    assert tab.at.scene.neighbour[0].s_m == 49.0
    tab.act({"do": "undo"})
    assert tab.at.scene == SCENE


@pytest.mark.parametrize("name", shipped("scenes"))
def test_a_shared_scene_is_the_scene(tab: SandwichTab, tmp_path: Path, name: str) -> None:
    tab.open("shipped", name)
    edit(tab, {"road.friction": 0.61, "b": 40.0})
    other = SandwichTab(Folder(root=tmp_path))
    other.open("link", tab.state()["link"])
    assert other.at.scene.model_dump() == tab.at.scene.model_dump()
    assert other.at.sigmoid == tab.at.sigmoid


@pytest.mark.parametrize(
    ("link", "said"),
    [
        ("", "JSON"),
        ("%%%", "damaged"),
        (link_of({"scene": {"host": {"speed_mps": 1.0}}})[:-9], "JSON|damaged"),
        (link_of({"host": {}}), "scene"),
        (link_of({"scene": {"host": {"speed_mps": 1.0, "vehicle": "../x.toml"}}}), "outside"),
        (base64.urlsafe_b64encode(zlib.compress(b"0" * 50_000_000, 9)).decode(), "more than 101000 bytes"),
        (base64.urlsafe_b64encode(zlib.compress(b"[" * 100_000, 9)).decode(), "nests"),
    ],
)
def test_a_link_that_holds_no_scene_is_refused(tab: SandwichTab, link: str, said: str) -> None:
    before = tab.state()
    with pytest.raises(InputError, match=said):
        tab.open("link", link)
    assert tab.state() == before


def test_what_a_link_holds_is_what_was_put_into_it() -> None:
    document = {"scene": scene_document(SCENE), "text": "ä \u2028 <script>"}
    assert document_in(link_of(document)) == json.loads(json.dumps(document))


def test_a_scene_is_saved_and_not_over_another_unasked(tab: SandwichTab, tmp_path: Path) -> None:
    edit(tab, {"road.friction": 0.5})
    assert tab.save("mine", replace=False) == "mine.toml"
    assert load_scene(tmp_path / "mine.toml").road.friction == 0.5
    edit(tab, {"road.friction": 0.6})
    with pytest.raises(ExistsError, match=r"mine\.toml: is there already: replace it, or choose another name"):
        tab.save("mine.toml", replace=False)
    assert load_scene(tmp_path / "mine.toml").road.friction == 0.5
    tab.save("mine", replace=True)
    assert load_scene(tmp_path / "mine.toml").road.friction == 0.6
    (tmp_path / "case.toml").write_text("[slot]\nlength_m = 6.0\n")
    with pytest.raises(InputError, match="holds no scene"):
        tab.save("case", replace=True)
    assert tab.save("../../x/y", replace=False) == "x-y.toml", "names lead nowhere else"
    (tmp_path / "out.toml").symlink_to(tmp_path.parent / "out.toml")
    with pytest.raises(InputError, match="outside"):
        tab.save("out", replace=True)
    assert not (tmp_path.parent / "out.toml").exists()


def test_a_scene_in_a_folder_below_is_saved_beside_itself(tab: SandwichTab, tmp_path: Path) -> None:
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "car.toml").write_text(find("vehicles", "sedan").read_text())
    (tmp_path / "deep" / "one.toml").write_text('[host]\nspeed_mps = 11.1\nvehicle = "car.toml"\n')
    tab.open("scene", "deep/one.toml")
    assert tab.save("two", replace=False) == "deep/two.toml"
    assert load_scene(tmp_path / "deep" / "two.toml").vehicle == tab.at.scene.vehicle


def test_every_key_of_a_scene_is_in_the_form(tmp_path: Path) -> None:
    def paths(fields: list[dict[str, Any]], table: str) -> set[tuple[str, str]]:
        found = set()
        for field in fields:
            if "fields" in field:
                path = f"{table}.{field['key']}".lstrip(".")
                found |= paths(field["fields"], path)
            else:
                found.add((table, field["key"]))
        return found

    assert paths(form(Folder(root=tmp_path)), "") == {(key.table.strip("[]"), key.name) for key in keys("scene")}


@pytest.mark.parametrize("name", shipped("scenes"))
def test_handles_lie_where_the_cars_do(name: str) -> None:
    scene = load_scene(name)
    found = handles(scene)
    assert [one["key"] for one in found["handles"]] == ["host", *(f"neighbour[{k}]" for k in range(len(scene.neighbour)))]
    for one, car in zip(found["handles"][1:], scene.neighbour, strict=True):
        s, d, *_ = car.initial
        x, y, _ = one["pose"]
        if found["axis"]:
            nearest = min(found["axis"], key=lambda row: (row[1] - x) ** 2 + (row[2] - y) ** 2)
            assert abs(nearest[0] - s) <= 1.5
        else:
            assert (x, y) == pytest.approx((s, d), abs=1e-3)


def test_only_planners_that_can_be_built_are_offered(monkeypatch: pytest.MonkeyPatch) -> None:
    from mcdas_opt.errors import MissingExtraError
    from mcdas_opt.studio import planner_cache

    def build(name: str, *_: object) -> object:
        if name == "mpc":
            raise MissingExtraError("x", "y")
        return object()

    monkeypatch.setattr(planner_cache, "build_method", build)
    assert installed(methods()) == tuple(name for name in methods() if name != "mpc")


def test_unknown_actions_are_refused(tab: SandwichTab) -> None:
    for action in ({}, {"do": "exec"}, {"do": "edit"}, {"do": "edit", "changes": [1]}):
        with pytest.raises(ParameterError, match="do"):
            tab.act(action)
