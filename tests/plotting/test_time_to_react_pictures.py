"""The pictures of the time to react, and their command."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from mcdas_opt.cli.app import app
from mcdas_opt.domain.escapes import Closer, Escape, Escapes
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.plotting.time_to_react_map import time_to_react_map
from mcdas_opt.plotting.time_to_react_timeline import time_to_react_sheet
from mcdas_opt.time_to_react.escapes import escapes
from mcdas_opt.time_to_react.library import KINDS
from mcdas_opt.time_to_react.sweep import swept
from tests.planning.situations import sandwich


def test_the_timeline_has_a_bar_for_every_manoeuvre_that_is_open() -> None:
    situation = sandwich()
    found = escapes(situation)
    fig = time_to_react_sheet(found)
    bars = [patch for patch in fig.axes[1].patches if patch.get_facecolor()[3] == 1.0]
    expected = sum((one.last_moment_s is not None) + (one.last_comfortable_s is not None) for one in found.candidates)
    assert len(bars) == expected
    assert {label.get_text() for label in fig.axes[1].get_yticklabels()} == set(KINDS)


def test_the_map_shows_what_is_closed_and_where_table_1_has_a_mode() -> None:
    sweep = swept(sandwich(rear_gap_m=20.0), Vehicle(), front_gap_m=np.linspace(5.0, 50.0, 7), closing_mps=np.linspace(0.0, 14.0, 5))
    assert (sweep.table1_row > 0).any()
    assert set(sweep.front_gap_m[(sweep.table1_row > 0).any(axis=0)]) <= {x for x in sweep.front_gap_m if 25.0 <= x <= 35.0}
    fig = time_to_react_map(sweep)
    assert [axes.get_xlabel() for axes in fig.axes[2:4]] == ["gap to the car ahead [m]"] * 2


def test_the_command_prints_one_document_and_draws(tmp_path: Path) -> None:
    out = tmp_path / "times.png"
    answer = CliRunner().invoke(app, ["escapes", "sandwich-60-40", "--json", "--out", str(out)])
    assert answer.exit_code == 0
    document = json.loads(answer.stdout)
    assert set(document["escapes"]) == set(KINDS)
    assert out.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("name", ["nothing-there", "sandwich-60-40.json"])
def test_a_scene_that_is_not_there_is_named(name: str) -> None:
    answer = CliRunner().invoke(app, ["escapes", name])
    assert answer.exit_code != 0
    assert name in str(answer.exception)


def test_the_words_beside_the_bars_lie_within_the_picture() -> None:
    longest = Escape(open=True, last_moment_s=9.98, closed_by=Closer.EDGE, demand_mps2=10.5, last_comfortable_s=1.0)
    found = Escapes(
        brake=longest, accelerate=longest, left=longest, right=longest, keeping_on_s=3.0, situation=sandwich(), vehicle=Vehicle()
    )
    fig = time_to_react_sheet(found)
    fig.canvas.draw()
    for text in fig.axes[1].texts:
        reach = text.get_window_extent()
        assert reach.x0 >= 0.0
        assert reach.x1 <= fig.bbox.x1
        assert "asks 10.5 m/s² now" in text.get_text()


def test_what_cannot_begin_just_now_is_hatched() -> None:
    now = Escape(open=True, last_moment_s=2.0, demand_mps2=1.0)
    later = Escape(open=True, last_moment_s=2.4, last_comfortable_s=1.3, closed_by=Closer.SIDE)
    for brake, hatched in ((now, 0), (later, 2)):
        found = Escapes(brake=brake, left=now, situation=sandwich(), vehicle=Vehicle())
        axes = time_to_react_sheet(found).axes[1]
        assert len([patch for patch in axes.patches if patch.get_hatch()]) == hatched
        said = [text.get_text() for text in axes.get_legend().get_texts()]
        assert ("open later, not just now" in said) == bool(hatched)
