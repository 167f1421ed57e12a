"""The command `follow`, and the costs and guesses of `park` by name."""

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from mcdas_opt.cli.app import app
from mcdas_opt.cli.follow import follow
from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.plotting import style
from tests.plotting.pixels import coloured, pixels

runner = CliRunner()
WIDE = "[slot]\nlength_m = 7.2\n"


def test_a_slot_shorter_than_believed_is_followed_and_drawn(tmp_path: Path):
    case, picture = tmp_path / "wide.toml", tmp_path / "drive.png"
    case.write_text(WIDE)
    options = ["follow", str(case), "--planner", "search", "--shorter", "0.2", "--out", str(picture), "--json"]
    result = runner.invoke(app, options, catch_exceptions=False)
    assert result.exit_code == 0
    drive = json.loads(result.stdout)
    assert drive["outcome"] == "parked"
    assert drive["min_clearance_m"] > 0.0
    assert drive["stops_judged"] > 0
    assert any("rear car" in event["text"] for event in drive["events"])
    shown = pixels(picture)
    assert shown.shape == (1170, 1440, 3)
    assert coloured(shown, style.BLUE).sum() > 500  # the speed
    assert coloured(shown, style.PURPLE).sum() > 500  # off the plans
    assert coloured(shown, style.VERMILION).sum() > 100  # an event


def test_bad_options_are_named(tmp_path: Path):
    with pytest.raises(ParameterError, match="--person"):
        follow("parallel", person=["1,2"])
    with pytest.raises(ParameterError, match="planner"):
        follow("parallel", planner="two-arc")
    with pytest.raises(InputError, match=r"\.png"):
        follow("parallel", out=tmp_path / "drive.json")


@pytest.mark.parametrize(
    ("option", "value", "said"), [("--cost", "tme", "time"), ("--guesses", "serch", "search"), ("--checks", "dual", "duals")]
)
def test_unknown_names_get_the_nearest(option, value, said):
    with pytest.raises(ParameterError, match=f"did you mean '{said}'"):
        runner.invoke(app, ["park", "parallel", option, value], catch_exceptions=False)
