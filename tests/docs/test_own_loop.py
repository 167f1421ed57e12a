"""The page on a loop of one's own: its loop runs and prints what the page shows, at 20 Hz and with weak brakes it does not hit, and
only the measured state commanded does."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import pytest

PAGE = (Path(__file__).parents[2] / "docs" / "own-loop.md").read_text("utf-8")
LOOP = re.findall(r"```python\n(.*?)```", PAGE, re.S)[0]


def printed(loop: str) -> str:
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        exec(loop, {})  # the page's own
    return said.getvalue()


def nearest(old: str, new: str) -> float:
    assert old in LOOP
    return float(printed(LOOP.replace(old, new)).split()[1])


def test_the_loop_prints_what_the_page_shows() -> None:
    assert printed(LOOP) == re.findall(r"```text\n(.*?)```", PAGE, re.S)[0]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("CYCLE_S, STEP_S, LAG_S = 0.1", "CYCLE_S, STEP_S, LAG_S = 0.05"),
        ("asked.acceleration_mps2 - a)", "0.6 * asked.acceleration_mps2 - a)"),
        ("LAG_S = 0.1, 0.01, 0.2", "LAG_S = 0.1, 0.01, 0.02"),
    ],
    ids=["20 Hz", "60 % of the braking", "quick brakes"],
)
def test_it_keeps_away_from_the_car_ahead(old: str, new: str) -> None:
    assert nearest(old, new) > 1.0


def test_the_measured_state_commanded_runs_into_it() -> None:
    assert nearest("command_at(CYCLE_S)", "command_at(0.0)") < 0.0
