"""The paper's tables to 1e-7, its figures as files, and the readings under which they agree."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from mcdas_opt.cli.app import app
from mcdas_opt.errors import InputError
from mcdas_opt.evaluation import published
from mcdas_opt.evaluation.paper_tracking import TRACKING, TrackingChoices, crash_position, study
from mcdas_opt.evaluation.reproduction import Reproduction, Row, reproduce
from mcdas_opt.plotting.style import save_png
from mcdas_opt.plotting.tracking_bands import draw_trajectory_band

FEW = dataclasses.replace(TRACKING, runs=40)


@pytest.fixture(scope="module")
def reproduction() -> Reproduction:
    return reproduce(choices=FEW)


def rows(reproduction: Reproduction, start: str) -> list[Row]:
    return [row for row in reproduction.rows if row.item.startswith(start)]


def computed(reproduction: Reproduction, item: str) -> float:
    (row,) = (row for row in reproduction.rows if row.item == item)
    assert isinstance(row.computed, float)
    return row.computed


@pytest.mark.parametrize(("table", "count"), [("Table 2", 3), ("Table 3: off", 54), ("Table 3: initial", 1), ("Table 4", 4)])
def test_tables_2_to_4_are_exact(reproduction: Reproduction, table: str, count: int) -> None:
    found = rows(reproduction, table)
    assert len(found) == count
    assert all(row.deviation is not None and abs(row.deviation) <= 1e-7 for row in found)


def test_table_5_under_its_reading_and_by_the_criterion_of_table_3(reproduction: Reproduction) -> None:
    assert [row.computed for row in rows(reproduction, "Table 5: ")] == pytest.approx([0.0804, 0.0607], abs=5e-5)
    assert [round(row.computed, 2) for row in rows(reproduction, "Table 5: ")] == [0.08, 0.06]
    assert all(0.133 < row.computed < 0.136 for row in rows(reproduction, "Table 5 by"))


def test_published_table_is_consistent_in_itself() -> None:
    for row in published.TABLE_3:
        assert row.absolute_left - row.y_left == pytest.approx(row.error_left, abs=2e-7)
        assert row.absolute_right - row.y_right == pytest.approx(row.error_right, abs=2e-7)


@pytest.mark.parametrize(
    ("item", "value", "tolerance"),
    [
        ("literal path at 40 km/h: lateral peak", 0.66, 0.005),
        ("literal path at 60 km/h: lateral peak", 1.48, 0.005),
        ("literal path at 80 km/h: lateral peak", 2.64, 0.005),
        ("literal path at 100 km/h: lateral peak", 4.12, 0.005),
        ("literal path at K = 60 km/h: lateral peak", 1.61, 0.005),
        ("literal path at K = 100 km/h: lateral peak", 4.48, 0.005),
        ("literal path: fastest speed at 0.4 g", 31.0, 0.5),
        ("literal path: fastest speed at 0.8 g", 44.0, 0.5),
        ("corrected path in a 25 m gap's time: lateral peak", 0.11, 0.005),
        ("literal path: heading jump at the start", 1.63, 0.005),
        ("eq 11: acceleration from 40 to 60 km/h", 1.13, 0.005),
        ("eq 24: commanded speed", 360.0, 1e-9),
        ("eq 5-7: speed of a front vehicle at 40 km/h", 80.0, 1e-9),
        ("largest |off| on a three-lane road", 0.95, 1e-9),
        ("Table 1: share of dangerous states with a mode", 1.0, 0.1),
    ],
)
def test_facts(reproduction: Reproduction, item: str, value: float, tolerance: float) -> None:
    assert computed(reproduction, item) == pytest.approx(value, abs=tolerance)


def test_the_corrected_path_keeps_its_bound_from_20_to_130_kmh(reproduction: Reproduction) -> None:
    assert 0.9 < computed(reproduction, "corrected path, 20-130 km/h: peak / bound") <= 1.0


@pytest.mark.parametrize("gap", [1.0, 33.3, 40.0])
def test_crash_position_is_three_gaps_from_the_rear_start(gap: float) -> None:
    assert crash_position(gap, 60 / 3.6, 40 / 3.6) == pytest.approx(3 * gap)


def test_each_row_says_whether_it_agrees_with_the_paper(reproduction: Reproduction) -> None:
    said = {row.item: row.agreement for row in reproduction.rows}
    assert set(said.values()) == {"equal", "differs", "ours only"}
    assert all(word == "equal" for item, word in said.items() if item.startswith(("Table 2", "Table 3", "Table 4", "Table 5: ")))
    assert said["text below Table 4: least error"] == "differs"
    assert said["Fig 7: distance in 11 samples at 60 km/h"] == "differs"
    assert said["Table 1 with nothing known"] == "ours only"


def test_the_command_marks_the_rows_and_says_the_tolerance_once(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["reproduce", "--out", str(tmp_path)], env={"COLUMNS": "100"})
    lines = result.stdout.splitlines()
    assert any(line.split()[:4] == ["equal", "Table", "2:", "D_(R-1)"] for line in lines)
    assert result.stdout.count("half a unit of the last digit") == 1


def test_the_command_prints_json_and_draws_every_figure(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["reproduce", "--out", str(tmp_path / "new"), "--json"])
    assert result.exit_code == 0
    document = json.loads(result.stdout)
    assert all({"item", "published", "computed", "reading"} <= set(row) for row in document["rows"])
    assert all(row["reading"] for row in document["rows"])
    names = ["figure-07", "figure-08", "figure-09", "figure-10", "figure-11", "figure-12", "figure-12-demand"]
    assert [Path(path).stem for path in document["figures"]] == names
    for path in document["figures"]:
        assert Path(path).read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    again = save_png(draw_trajectory_band(study(1), "rear"), tmp_path / "again.png")
    assert again.read_bytes() == Path(document["figures"][0]).read_bytes()


def test_a_file_in_the_place_of_the_folder_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    place = tmp_path / "taken"
    place.write_text("")
    monkeypatch.setattr("mcdas_opt.plotting.style.save_png", lambda *_: None)
    with pytest.raises(InputError, match="taken"):
        reproduce(place, choices=FEW)


def test_without_a_folder_nothing_is_drawn(reproduction: Reproduction) -> None:
    assert reproduction.figures == ()
    assert reproduction.rows == reproduce(choices=FEW).rows


def test_the_filter_narrows_the_bands_and_is_unbiased() -> None:
    bands = study(5, TrackingChoices(runs=150))
    for error in (bands.rear_error_y, bands.front_error_y, bands.rear_error_x, bands.front_error_x, bands.crash_m - bands.true_crash_m):
        spread = error.std(axis=0)
        assert spread[-1] < 0.75 * spread[0]
        assert abs(error[:, -1].mean()) < 4 * spread[-1] / np.sqrt(len(error))


def test_the_study_depends_on_its_seed_alone() -> None:
    np.testing.assert_array_equal(study(2, FEW).crash_m, study(2, FEW).crash_m)
    assert not np.array_equal(study(2, FEW).crash_m, study(3, FEW).crash_m)
