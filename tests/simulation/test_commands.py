"""`simulate` and `judge` from the command line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from mcdas_opt.domain.trajectory import Trajectory
from tests.cli.command_line import run
from tests.simulation.fake_driver import plan_of
from tests.simulation.scene_maker import make_scene

SCENE = """
duration_s = 0.5
[road]
lanes_left = 1
[host]
speed_mps = 11.1
[[neighbour]]
name = "front"
s_m = 24.5
speed_mps = 11.1
[[neighbour.motion]]
start_s = 0.0
acceleration_mps2 = -8.0
"""


@pytest.fixture
def scene(tmp_path: Path) -> str:
    path = tmp_path / "scene.toml"
    path.write_text(SCENE)
    return str(path)


def written(path: Path, trajectory: Trajectory, **more: Any) -> str:
    path.write_text(json.dumps({"trajectory": trajectory.to_dict(), **more}))
    return str(path)


def test_simulate_prints_a_table_or_one_document_and_draws(
    scene: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    planner = ("--planner", "closed-form-corrected")
    code, out, _ = run(monkeypatch, capsys, "simulate", scene, *planner, "--out", str(tmp_path / "drive.gif"))
    assert code == 0
    assert "outcome" in out
    assert "seed 1" in " ".join(out.split("outcome")[0].split())
    assert "largest jerk along" in out
    assert (tmp_path / "drive.gif").read_bytes()[:6] == b"GIF89a"
    code, out, _ = run(monkeypatch, capsys, "simulate", scene, *planner, "--seed", "7", "--json")
    document = json.loads(out)
    assert (code, document["seed"], document["plans"]) == (0, 7, 5)


@pytest.mark.parametrize(("until_m", "said"), [(30.0, "destination reached after"), (50.0, "destination unreachable: ")])
def test_simulate_says_what_became_of_the_destination(
    until_m: float, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "there.toml"
    path.write_text(
        f"duration_s = 3.0\n[host]\nspeed_mps = 12.0\n[destination]\ns_m = [{until_m - 10.0}, {until_m}]\ntime_s = [0.0, 3.0]\n"
    )
    _, out, _ = run(monkeypatch, capsys, "simulate", str(path), "--planner", "acc")
    assert said in " ".join(out.replace("│", " ").split())


def test_a_drive_can_be_judged_afterwards(
    scene: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    _, out, _ = run(monkeypatch, capsys, "simulate", scene, "--planner", "closed-form-corrected", "--json")
    (tmp_path / "drive.json").write_text(out)
    code, out, _ = run(monkeypatch, capsys, "judge", scene, str(tmp_path / "drive.json"), "--json")
    document = json.loads(out)
    assert (code, document["prediction"]) == (0, "scene")
    assert document["verdict"] == {"violations": [], "passed": True}


def test_the_files_own_prediction_is_the_default(
    scene: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    straight = plan_of(make_scene().host_state, [(0.0, 0.0)] * 40).trajectory
    path = written(tmp_path / "plan.json", straight, prediction="constant-velocity")
    for more, passed in (((), True), (("--prediction", "scene"), False)):
        code, out, _ = run(monkeypatch, capsys, "judge", scene, path, *more, "--json")
        assert (code, json.loads(out)["verdict"]["passed"]) == (0, passed)
    code, out, _ = run(monkeypatch, capsys, "judge", scene, path, "--prediction", "scene")
    assert "collision with front" in out


def test_a_saved_situation_can_be_judged_in(
    scene: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    situation = str(tmp_path / "situation.json")
    planner = ("--planner", "closed-form-corrected")
    _, out, _ = run(monkeypatch, capsys, "plan", scene, *planner, "--out", situation, "--json")
    (tmp_path / "plan.json").write_text(out)
    code, out, _ = run(monkeypatch, capsys, "judge", situation, str(tmp_path / "plan.json"), "--json")
    assert (code, json.loads(out)["verdict"]["passed"], json.loads(out)["prediction"]) == (0, True, "constant-velocity")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("simulate", "no-such-scene"), ("no-such-scene", "known:")),
        (("simulate", "SCENE", "--planner", "mcp"), ("mcp", "mpc")),
        (("simulate", "SCENE", "--plant", "kinetic"), ("plant", "kinematic")),
        (("simulate", "SCENE", "--out", "drive.mp4"), ("drive.mp4", ".gif")),
        (("verify", "SCENE", "nothing.csv"), ("nothing.csv", "no such file")),
        (("verify", "SCENE", "PLAN", "--prediction", "sceen"), ("prediction", "scene")),
    ],
)
def test_bad_input_is_one_line_and_exit_2(
    arguments: tuple[str, ...],
    words: tuple[str, ...],
    scene: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    plan = written(tmp_path / "plan.json", plan_of(make_scene().host_state, [(0.0, 0.0)] * 3).trajectory)
    code, out, err = run(monkeypatch, capsys, *({"SCENE": scene, "PLAN": plan}.get(a, a) for a in arguments))
    assert (code, out) == (2, "")
    assert len(err.strip().splitlines()) == 1
    for word in words:
        assert word in err


def test_the_document_of_a_drive_says_of_every_cycle_why(
    scene: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    _, out, _ = run(monkeypatch, capsys, "simulate", scene, "--json")
    document = json.loads(out)
    assert [cycle["time_s"] for cycle in document["cycles"]] == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])
    assert len(document["cycles"]) == document["plans"]
    assert all(list(cycle) == ["time_s", "mode", "status", "alert", "chosen", "reason"] for cycle in document["cycles"])
    assert all(cycle["reason"] and cycle["chosen"] for cycle in document["cycles"])


@pytest.mark.parametrize("plant", ["kinematic", "dynamic"])
@pytest.mark.parametrize(
    ("planner", "params"),
    [
        ("closed-form-corrected", '[sigmoid]\na_per_m = -0.2\nb = 40.0\ny_max_m = 3.7\noffset_m = 0.0\nside = "left"\n'),
        ("mpc", '[values]\n"comfort.share" = 0.5\n'),
    ],
)
def test_what_was_tuned_can_be_driven(
    planner: str, params: str, plant: str, scene: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "best.toml").write_text(params)
    asked = ("--planner", planner, "--plant", plant, "--params", str(tmp_path / "best.toml"), "--json")
    code, out, err = run(monkeypatch, capsys, "simulate", scene, *asked)
    assert (code, err) == (0, "")
    assert json.loads(out)["planner"] == planner


def test_parameters_that_are_none_are_refused_before_the_drive(
    scene: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "best.toml").write_text('[values]\n"comfort.shares" = 0.5\n')
    code, _, err = run(monkeypatch, capsys, "simulate", scene, "--params", str(tmp_path / "best.toml"))
    assert code == 2
    assert "best.toml: values.comfort.shares" in err
