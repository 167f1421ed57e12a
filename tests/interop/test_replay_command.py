"""The command: one JSON document or a table, a picture, and exit 2 with one clear line for bad input."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.interop.replay import replay
from mcdas_opt.interop.truth import compare
from mcdas_opt.plotting.replay import draw_against_truth, draw_tracks
from tests.cli.command_line import run

NAME = "front_and_rear"
GOOD = ("replay", NAME, "--format", "esr-candump", "--no-plan")


def test_json_is_one_document(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = run(monkeypatch, capsys, *GOOD, "--truth", NAME, "--json")
    document = json.loads(out, parse_constant=lambda word: pytest.fail(f"{word} in JSON"))
    assert code == 0
    assert len(document["cycles"]) == document["summary"]["cycles"] == 101
    assert document["summary"]["radars"] == {"front": "front_and_rear.log can0", "rear": "front_and_rear.log can1"}
    assert document["truth"]["front"]["breaks"] == 0
    assert 0.0 < document["truth"]["rear"]["tracked"]["along_rmse_m"] < document["truth"]["rear"]["raw"]["along_rmse_m"]


def test_the_table_and_the_pictures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    for name, more in (("truth.png", ("--truth", NAME)), ("tracks.png", ())):
        path = tmp_path / name
        code, out, _ = run(monkeypatch, capsys, *GOOD, *more, "--out", str(path))
        assert code == 0
        assert path.read_bytes().startswith(b"\x89PNG")
        assert "2010 good, 0 bad" in out
        assert out.index("front_and_rear.log can0") < out.index("front_and_rear.log can1")
        assert ("against the truth" in out) is bool(more)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("replay", "front_and_rea", "--format", "esr-candump"), "no shipped log of that name; did you mean 'front_and_rear'?"),
        (("replay", NAME, "--format", "csv"), "--format = 'csv': is not a known format"),
        ((*GOOD, "--dbc", __file__), "is no DBC"),
        ((*GOOD, "--out", "/nowhere/a.png"), "/nowhere/a.png: no such folder"),
        (("replay", NAME, "--format", "radar-csv"), "'range_rate_mps or doppler_velocity': no such column; there are: "),
        ((*GOOD, "--road", "no-such-scene"), "no-such-scene: no such file"),
        (("replay", NAME, "--format", "esr-candump", "--planner", "magic"), "planner = 'magic'"),
    ],
)
def test_bad_input_exits_2_with_one_line(
    arguments: tuple[str, ...], message: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, err = run(monkeypatch, capsys, *arguments)
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1


def test_the_pictures_show_what_was_compared() -> None:
    done = replay(NAME, "esr-candump", plan=False)
    sectors = compare(done, NAME).sectors
    axes = np.array(draw_against_truth(sectors).axes).reshape(5, 2)
    for column, sector in enumerate((Sector.FRONT, Sector.REAR)):
        shown = {line.get_label(): line.get_ydata() for line in axes[0, column].lines}
        np.testing.assert_array_equal(shown["truth"], sectors[sector].true_points[:, 0])
        np.testing.assert_array_equal(shown[f"track, {sector.value}"], sectors[sector].tracked_points[:, 0])
        assert all("[m" in axis.get_ylabel() for axis in axes[:, column])
    above, *_ = draw_tracks(done.cycles).axes
    drawn = sum(len(line.get_xdata()) for line in above.lines if line.get_label() in ("front", "rear", "left", "right", "other"))
    assert drawn == sum(len(cycle.tracks) for cycle in done.cycles)
