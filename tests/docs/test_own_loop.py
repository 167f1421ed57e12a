"""The page on a loop of one's own: its loop runs and prints what the page shows, as near at every rate as the page's table says, with
weak brakes it does not hit, and only the measured state commanded does."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import pytest

PAGE = (Path(__file__).parents[2] / "docs" / "own-loop.md").read_text("utf-8")
TABLE = re.findall(r"^\| \| 100 Hz .*?\n\n", PAGE, re.S | re.M)[0]
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
        ("asked_mps2 - a)", "0.6 * asked_mps2 - a)"),
        ("LAG_S = 0.1, 0.01, 0.2", "LAG_S = 0.1, 0.01, 0.02"),
    ],
    ids=["60 % of the braking", "quick brakes"],
)
def test_it_keeps_away_from_the_car_ahead(old: str, new: str) -> None:
    assert nearest(old, new) > 0.0


@pytest.mark.parametrize("asked", ["command_at(CYCLE_S + LAG_S)", "command_at(CYCLE_S)"])
@pytest.mark.parametrize("rate_hz", [100, 50, 20, 10, 5])
def test_it_comes_as_near_as_the_table_says_at_every_rate(rate_hz: int, asked: str) -> None:
    heads, *rows = ([cell.strip() for cell in row.strip("|").split("|")] for row in re.findall(r"^\|.*\|$", TABLE, re.M))
    told = next(row for row in rows if row[0] == f"`{asked}`")[heads.index(f"{rate_hz} Hz")]
    loop = LOOP.replace("STEP_S, LAG_S = 0.1", f"STEP_S, LAG_S = {1.0 / rate_hz}").replace("command_at(CYCLE_S + LAG_S)", asked)
    assert float(printed(loop).split()[1]) == float(told)


def test_the_measured_state_commanded_runs_into_it() -> None:
    assert nearest("command_at(CYCLE_S + LAG_S)", "command_at(0.0)") < 0.0
