"""The page on a loop of one's own: its loop runs and prints what the page shows, as near at every rate as the page's table says, with
weak brakes it does not hit, and only the measured state commanded does; its car moves as the model does, on a bend too as the page says."""

from __future__ import annotations

import contextlib
import io
import math
import re
import textwrap
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mcdas_opt as mo
from mcdas_opt.dynamics.bicycle import road_bicycle

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "own-loop.md").read_text("utf-8")
TABLE = re.findall(r"^\| \| 100 Hz .*?\n\n", PAGE, re.S | re.M)[0]
LOOP = re.findall(r"```python\n(.*?)```", PAGE, re.S)[0]
FROM_PLANE = re.findall(r"```python\n(.*?)```", (DOCS / "api.md").read_text("utf-8"), re.S)[0]
MOTION = textwrap.dedent(re.findall(r"^ +turn = .*?heading \+=.*?\n", LOOP, re.S | re.M)[0])


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
    found: dict[str, Any] = {}
    loop = re.sub(r"command_at\(.*?\)\.", "command_at(0.0).", LOOP)
    with contextlib.redirect_stdout(io.StringIO()):
        exec(loop, found)
    assert found["nearest"] < 0.0
    assert abs(found["d"]) < 0.1


@pytest.mark.parametrize("curvature", [0.0, 0.01, -0.02])
def test_its_car_moves_as_the_model_says_and_on_a_bend_as_the_page_says(curvature: float) -> None:
    car, step_s = mo.load_vehicle("sedan"), 1e-3
    now = {"s": 3.0, "d": 1.2, "heading": 0.1, "v": 12.0, "steering": 0.05}
    after: dict[str, Any] = {**now, "car": car, "math": math, "STEP_S": step_s}
    exec(MOTION, {}, after)
    along = (after["s"] - now["s"]) / (1.0 - now["d"] * curvature)
    moved = (along, after["d"] - now["d"], after["heading"] - now["heading"] - curvature * along)
    state = (now["s"], now["d"], now["heading"], now["v"], 0.0, now["steering"])
    told = road_bicycle(state, (0.0, 0.0), curvature, car.wheelbase_m, car.centre_m, math)[:3]
    assert np.array(moved) / step_s == pytest.approx(told, abs=1e-9)


@pytest.mark.parametrize("curvature", [0.0, 0.01])
def test_a_place_in_the_plane_is_one_on_the_road(curvature: float) -> None:
    road = mo.Road(lanes_left=1, curvature=((0.0, curvature),))
    found: dict[str, Any] = {"road": road, "x": 30.0, "y": 2.0, "yaw": 0.2, "s": 0.0}
    exec(FROM_PLANE, found)
    host = mo.HostState(s_m=found["s"], d_m=found["d"], heading_rad=found["heading"], speed_mps=14.0)
    centre_y = 1.0 / curvature if curvature else 0.0
    from_centre = math.hypot(30.0, 2.0 - centre_y) if curvature else 0.0
    assert host.d_m == pytest.approx(centre_y - from_centre if curvature else 2.0, abs=1e-6)
    assert host.heading_rad == pytest.approx(0.2 - curvature * host.s_m, abs=1e-6)
