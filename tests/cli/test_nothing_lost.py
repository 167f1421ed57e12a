"""What was computed is said even where its picture cannot be written, and no half-written file is left."""

from __future__ import annotations

import errno
import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from mcdas_opt.catalogue.data_files import models_folder
from mcdas_opt.cli.app import app
from mcdas_opt.errors import InputError
from mcdas_opt.plotting import style
from mcdas_opt.plotting.export import whole_file
from mcdas_opt.simulation.first_situation import save_situation, situation_of


def test_a_file_appears_whole_or_not_at_all(tmp_path: Path) -> None:
    target = tmp_path / "picture.png"
    target.write_text("before")

    def full() -> None:
        with whole_file(target) as file:
            file.write_text("half")
            raise OSError(errno.ENOSPC, "No space left on device")

    with pytest.raises(InputError, match=r"picture\.png: cannot be written: No space left on device"):
        full()
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("picture.png", "before")]
    with whole_file(target) as file:
        assert file.suffix == target.suffix
        file.write_text("after")
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("picture.png", "after")]


@pytest.mark.parametrize("command", ["plan", "escapes"])
@pytest.mark.parametrize("as_json", [True, False])
def test_the_answer_is_printed_before_it_is_drawn(command: str, as_json: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(style, "save_png", full)
    arguments = [command, "sandwich-60-40", "--out", str(tmp_path / "x.png"), *(["--json"] if as_json else [])]
    answer = CliRunner().invoke(app, arguments)
    assert isinstance(answer.exception, InputError)
    assert "drawn" not in answer.stdout
    if as_json:
        assert "escapes" in json.loads(answer.stdout)
    else:
        assert "time to react" in answer.stdout
    assert not list(tmp_path.iterdir())


def test_a_plan_says_how_it_ends_and_how_long_each_candidate_stays_open() -> None:
    said = CliRunner().invoke(app, ["plan", "sandwich-60-40"], env={"COLUMNS": "160"}).stdout
    for words in ("ends", "after 4.0 s", "alert", "last moment", "comfortable until", "left-same"):
        assert words in said


def test_a_situation_of_another_version_is_refused(tmp_path: Path) -> None:
    saved = tmp_path / "situation.json"
    assert CliRunner().invoke(app, ["plan", "benign-following", "--out", str(saved)]).exit_code == 0
    document = json.loads(saved.read_text())
    assert CliRunner().invoke(app, ["plan", str(saved)]).exit_code == 0
    saved.write_text(json.dumps({**document, "schema_version": 99}))
    answer = CliRunner().invoke(app, ["plan", str(saved)])
    assert isinstance(answer.exception, InputError)
    assert f"{saved}: schema_version = 99: must be 1" in str(answer.exception)


def test_a_situation_takes_a_vehicle_along_that_its_name_does_not_lead_to(tmp_path: Path) -> None:
    """A scene's own vehicle file lies beside the scene, and not where the situation is saved."""
    own, elsewhere = tmp_path / "own", tmp_path / "elsewhere"
    own.mkdir()
    elsewhere.mkdir()
    text = (models_folder() / "vehicles" / "sedan.toml").read_text("utf-8")
    (own / "mine.toml").write_text(re.sub("(?m)^width_m = .*$", "width_m = 2.05", text), "utf-8")
    (own / "scene.toml").write_text('name = "mine"\nduration_s = 2.0\n[road]\n[host]\nspeed_mps = 20.0\nvehicle = "mine.toml"\n', "utf-8")
    said = CliRunner().invoke(app, ["plan", str(own / "scene.toml"), "--out", str(elsewhere / "saved.json")]).stdout
    assert sorted(path.name for path in elsewhere.iterdir()) == ["saved-mine.toml", "saved.json"]
    assert "saved-mine.toml" in said.replace("\n", "")
    situation, vehicle = situation_of(str(elsewhere / "saved.json"))
    first, car = situation_of(str(own / "scene.toml"))
    assert (vehicle.width_m, replace(vehicle, name=car.name)) == (2.05, car)
    assert replace(situation, vehicle=first.vehicle) == first
    assert CliRunner().invoke(app, ["plan", str(elsewhere / "saved.json")]).exit_code == 0

    save_situation(first, car, own / "beside.json")
    assert sorted(path.name for path in own.iterdir()) == ["beside.json", "mine.toml", "scene.toml"]
