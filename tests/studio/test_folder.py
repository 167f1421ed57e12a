"""The studio reads its folder and the shipped files, nothing else."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.catalogue.data_files import models_folder, read_toml
from mcdas_opt.errors import InputError
from mcdas_opt.studio.folder import Folder, shipped_file

SCENE = '[host]\nspeed_mps = 11.1\nvehicle = "{vehicle}"\n[sensors]\nfront = "{sensor}"\n'


@pytest.fixture
def folder(tmp_path: Path) -> Folder:
    room = tmp_path / "room"
    (room / "deep").mkdir(parents=True)
    (tmp_path / "secret.toml").write_text(SCENE.format(vehicle="sedan", sensor="ideal"))
    (room / "mine.toml").write_text(SCENE.format(vehicle="sedan", sensor="ideal"))
    (room / "deep" / "case.toml").write_text("[slot]\nlength_m = 6.3\n")
    (room / "notes.toml").write_text("a = 1\n")
    (room / "broken.toml").write_text("host = [")
    (room / "way_out.toml").symlink_to(tmp_path / "secret.toml")
    return Folder(root=room)


def test_scenes_and_cases_are_told_apart_and_links_out_are_not_offered(folder: Folder) -> None:
    assert folder.scenes() == ["mine.toml"]
    assert folder.cases() == ["deep/case.toml"]


def test_a_crowded_folder_is_looked_at_in_part(tmp_path: Path) -> None:
    deep = tmp_path
    for k in range(9):
        (deep / "log.log").write_text("")
        deep = deep / f"level{k}"
        deep.mkdir()
    (tmp_path / ".hidden").mkdir()
    (tmp_path / ".hidden" / "log.log").write_text("")
    found = Folder(root=tmp_path).names(".log")
    assert len(found) == 6
    assert not any(".hidden" in name or "level5" in name for name in found)
    for k in range(450):
        (tmp_path / f"{k}.log").write_text("")
    found = Folder(root=tmp_path).names(".log")
    assert len(found) == 400
    assert found == sorted(found)


@pytest.mark.parametrize("name", ["../secret.toml", "/etc/passwd", "way_out.toml", "deep/../../secret.toml", "~/x", "absent.toml"])
def test_what_is_not_in_the_folder_is_refused(folder: Folder, name: str) -> None:
    with pytest.raises(InputError, match="folder that the studio was started with"):
        folder.file(name)


@given(st.text(alphabet="./\\ab~%2e", max_size=24))
def test_no_name_leads_out(name: str) -> None:
    folder = Folder(root=Path(__file__).parent)
    try:
        found = folder.file(name)
    except InputError:
        return
    assert found.is_relative_to(folder.root)


@pytest.mark.parametrize(
    ("document", "key"),
    [
        ({"host": {"vehicle": "../secret.toml"}}, "host.vehicle"),
        ({"host": {"vehicle": "/etc/passwd"}}, "host.vehicle"),
        ({"sensors": {"rear": "../../x"}}, "sensors.rear"),
        ({"neighbour": [{}, {"trajectory": "../rows.csv"}]}, "neighbour[1].trajectory"),
        ({"vehicle": {"name": "../../car.toml"}}, "vehicle.name"),
    ],
)
def test_a_scene_may_not_name_files_outside(folder: Folder, document: dict[str, object], key: str) -> None:
    with pytest.raises(InputError, match="outside") as told:
        folder.confine(document, folder.root / "mine.toml")
    assert told.value.key == key


@pytest.mark.parametrize("name", ["a" * 5000, "a\0b", "\ud800"])
def test_a_name_that_no_file_can_have_is_told(folder: Folder, name: str) -> None:
    with pytest.raises(InputError):
        folder.file(name)
    with pytest.raises(InputError):
        folder.save(folder.root / name, "", replace=False)
    with pytest.raises(InputError) as told:
        folder.confine({"host": {"vehicle": name}}, folder.root / "mine.toml")
    assert told.value.key == "host.vehicle"


def test_a_scene_may_name_shipped_files_and_those_beside_it(folder: Folder) -> None:
    (folder.root / "deep" / "my-car.toml").write_text("")
    cars = {"host": {"vehicle": "sedan"}, "sensors": {"front": "delphi_esr", "left": "ideal", "rear": "none"}}
    folder.confine(cars, folder.root / "mine.toml")
    folder.confine({"host": {"vehicle": "my-car.toml"}}, folder.root / "deep" / "scene.toml")


@pytest.mark.parametrize("name", ["../vehicles/sedan", "nobody", "/etc/passwd", ""])
def test_shipped_files_have_bare_names(name: str) -> None:
    with pytest.raises(InputError):
        shipped_file("scenes", name)
    assert shipped_file("scenes", "cut-in") == models_folder() / "scenes" / "cut-in.toml"


def test_a_folder_must_be_one(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such folder"):
        Folder(root=tmp_path / "absent")


def test_a_file_is_read_once_and_again_when_it_changes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder with sixty files of 69 kB took 12 s a page: each was read for each of the lists."""
    read: list[str] = []

    def counted(path: Path) -> dict[str, Any]:
        read.append(path.name)
        return read_toml(path)

    monkeypatch.setattr("mcdas_opt.studio.folder.read_toml", counted)
    names = [f"{k}.toml" for k in range(5)]
    for name in names:
        (tmp_path / name).write_text("[host]\nspeed_mps = 10.0\n")
    for _ in range(3):
        folder = Folder(root=tmp_path)
        assert (folder.scenes(), folder.cases(), folder.vehicles()) == (names, [], [])
    assert sorted(read) == names
    (tmp_path / "3.toml").write_text("[slot]\nlength_m = 6.0\n")
    os.utime(tmp_path / "3.toml", ns=(1, 1))
    assert (folder.scenes(), folder.cases()) == ([*names[:3], "4.toml"], ["3.toml"])
    assert len(read) == 6
