"""Logs for others' viewers: read back by the libraries that read them, and what they say is what was driven."""

from __future__ import annotations

import itertools
import json
import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from mcdas_opt.catalogue.scenes import load_scene
from mcdas_opt.cli import main
from mcdas_opt.cli.export_log import export_log
from mcdas_opt.errors import InputError
from mcdas_opt.interop.logs.mcap_log import write_mcap
from mcdas_opt.interop.logs.moments import PERIOD_S, lines, moments
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.record import Simulation


@pytest.fixture(scope="module")
def drive() -> Simulation:
    scene = load_scene("curved-road")
    return simulate(scene.model_copy(update={"duration_s": 1.5}), "closed-form-corrected")


def test_moments_are_what_was_driven(drive: Simulation) -> None:
    found = list(moments(drive))
    assert [moment.t_s for moment in found] == pytest.approx([k * PERIOD_S for k in range(31)])
    assert sum(moment.plan is not None for moment in found) == drive.plans
    for moment in found:
        speed = np.interp(moment.t_s, drive.trajectory.t_s, drive.trajectory.speed_mps)
        assert moment.host["speed_mps"] == pytest.approx(float(speed))
        assert len(moment.bodies) == 1 + len(drive.neighbours)
        assert moment.bodies[0].name == "host"
    travelled = sum(math.hypot(b.bodies[0].x_m - a.bodies[0].x_m, b.bodies[0].y_m - a.bodies[0].y_m) for a, b in itertools.pairwise(found))
    assert travelled == pytest.approx(float(np.trapezoid(drive.trajectory.speed_mps, drive.trajectory.t_s)), rel=0.01)


def test_the_roads_lines_keep_their_distance(drive: Simulation) -> None:
    drawn, road = lines(drive), drive.scene.true_road
    assert len(drawn) == 2 + road.lanes_left + road.lanes_right
    apart = np.hypot(*(drawn["left edge"] - drawn["right edge"]).T)
    assert apart == pytest.approx(np.full(len(apart), road.left_edge_m - road.right_edge_m), abs=1e-6)


def test_an_mcap_reads_back(drive: Simulation, tmp_path: Path) -> None:
    reader = pytest.importorskip("mcap.reader")
    path = write_mcap(drive, tmp_path / "drive.mcap")
    with path.open("rb") as file:
        read = reader.make_reader(file)
        found: dict[str, list[tuple[int, Any]]] = {}
        schemas = {}
        for schema, channel, message in read.iter_messages():
            found.setdefault(channel.topic, []).append((message.log_time, json.loads(message.data)))
            schemas[channel.topic] = (schema.name, schema.encoding, channel.message_encoding)
    assert schemas == {
        "/scene": ("foxglove.SceneUpdate", "jsonschema", "json"),
        "/host": ("mcdas.Host", "jsonschema", "json"),
        "/plan": ("mcdas.Plan", "jsonschema", "json"),
    }
    assert len(found["/host"]) == len(found["/scene"]) == 31
    assert len(found["/plan"]) == drive.plans
    assert [time for time, _ in found["/host"]] == [round(k * PERIOD_S * 1e9) for k in range(31)]
    assert found["/host"][10][1]["speed_mps"] == pytest.approx(float(np.interp(0.5, drive.trajectory.t_s, drive.trajectory.speed_mps)))
    first = {entity["id"]: entity for entity in found["/scene"][0][1]["entities"]}
    assert set(first) == {"road", "bodies", "plan", "tracks"}
    assert len(first["bodies"]["cubes"]) == 1 + len(drive.neighbours)
    host = first["bodies"]["cubes"][0]
    assert host["size"]["x"] == pytest.approx(drive.scene.vehicle.length_m)
    assert host["pose"]["orientation"]["z"] ** 2 + host["pose"]["orientation"]["w"] ** 2 == pytest.approx(1.0)
    assert {message["status"] for _, message in found["/plan"]} <= {"planned", "fallback", "unavoidable"}


def test_the_same_drive_is_the_same_mcap(drive: Simulation, tmp_path: Path) -> None:
    pytest.importorskip("mcap")
    one, two = (write_mcap(drive, tmp_path / name).read_bytes() for name in ("one.mcap", "two.mcap"))
    assert one == two


def test_an_rrd_is_written_and_nothing_is_sent_or_remembered(tmp_path: Path) -> None:
    """In a home of its own: Rerun's analytics would leave an identity and their events there."""
    pytest.importorskip("rerun")
    script = (
        "from mcdas_opt.catalogue.scenes import load_scene\nfrom mcdas_opt.simulation.loop import simulate\n"
        "from mcdas_opt.interop.logs.rerun_log import write_rrd\n"
        "scene = load_scene('benign-following').model_copy(update={'duration_s': 0.5})\n"
        f"write_rrd(simulate(scene, 'closed-form-corrected'), {str(tmp_path / 'drive.rrd')!r})\n"
    )
    home = tmp_path / "home"
    home.mkdir()
    places = {name: str(home) for name in ("HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME", "XDG_CACHE_HOME", "XDG_STATE_HOME")}
    subprocess.run([sys.executable, "-c", script], check=True, env={**os.environ, **places})
    content = (tmp_path / "drive.rrd").read_bytes()
    assert content[:4] in (b"RRF2", b"RRIO", b"RRF0")
    assert b"neighbours" in content
    assert [path for path in home.rglob("*") if "rerun" in path.name or "analytics" in path.name] == []


@pytest.mark.parametrize(
    ("name", "options", "said"),
    [
        ("drive.bag", [], "must be .mcap (Foxglove) or .rrd (Rerun)"),
        ("no/such/drive.mcap", [], "no such folder"),
        ("drive.mcap", ["--show"], "--show: belongs to an .rrd"),
    ],
)
def test_bad_input_is_named(
    name: str, options: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["mcdas-opt", "export-log", "benign-following", str(tmp_path / name), *options])
    with pytest.raises(SystemExit) as stop:
        main()
    assert stop.value.code == 2
    assert said in capsys.readouterr().err


def test_the_command_writes_and_says_so(tmp_path: Path) -> None:
    pytest.importorskip("mcap")
    import typer

    app = typer.Typer()
    app.command()(export_log)
    out = tmp_path / "drive.mcap"
    result = CliRunner().invoke(app, ["benign-following", str(out), "--planner", "closed-form-corrected", "--json"], catch_exceptions=False)
    document = json.loads(result.stdout)
    assert document["bytes"] == out.stat().st_size > 0


def test_a_folder_that_cannot_be_written_is_named(drive: Simulation, tmp_path: Path) -> None:
    pytest.importorskip("mcap")
    with pytest.raises(InputError, match="cannot be written"):
        write_mcap(drive, tmp_path / "none" / "drive.mcap")
