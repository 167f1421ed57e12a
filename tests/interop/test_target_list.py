"""Track lists: any names of columns, either sign, bad rows counted, wrong files refused."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.errors import InputError
from mcdas_opt.interop.recordings.csv_table import CsvTable
from mcdas_opt.interop.target_list import Columns, read_targets

COMMA = Path(__file__).resolve().parents[3] / "shared" / "data" / "comma2k19_radar"
HEADER = "time_s,slot,x_m,y_m,range_rate_mps,new_track"


def table(folder: Path, *rows: str, header: str = HEADER) -> Path:
    path = folder / "radar.csv"
    path.write_text("\n".join([header, *rows]) + "\n")
    return path


places = st.tuples(st.floats(0.5, 200.0), st.floats(-50.0, 50.0), st.floats(-60.0, 60.0))


@given(st.lists(places, min_size=1, max_size=6))
def test_positions_come_back_from_range_and_azimuth(
    tmp_path_factory: pytest.TempPathFactory, found: list[tuple[float, float, float]]
) -> None:
    rows = [f"0.5,{slot},{x!r},{y!r},{rate!r},0" for slot, (x, y, rate) in enumerate(found)]
    log = read_targets(CsvTable(table(tmp_path_factory.mktemp("csv"), *rows)))
    (scan,) = log.scans
    assert (scan.t_s, log.good, log.pieces) == (0.5, len(found), len(found))
    for (x, y, rate), seen in zip(found, scan.radar, strict=True):
        assert seen.range_m * math.cos(seen.azimuth_rad) == pytest.approx(x, abs=1e-9)
        assert seen.range_m * math.sin(seen.azimuth_rad) == pytest.approx(y, abs=1e-9)
        assert seen.range_rate_mps == rate


def test_other_names_and_a_turned_sign_say_the_same(tmp_path: Path) -> None:
    own = read_targets(CsvTable(table(tmp_path, "0,1,10,2,-1,0", "0.1,1,9.9,2,-1,0")))
    other = table(tmp_path, "2;0".replace(";", ",") + ",10,-1", "2,0.1,9.9,-1", header="right,clock,ahead,doppler")
    text = "time_s=clock, x_m=ahead,y_m=right,range_rate_mps=doppler"
    mirrored = read_targets(CsvTable(other), columns=Columns.parse(text.replace("y_m=", "y_m=-")))
    same = read_targets(CsvTable(other), columns=Columns.parse(text))
    assert same.scans == own.scans
    assert same.pieces is None
    assert [scan.radar[0].azimuth_rad for scan in mirrored.scans] == [-scan.radar[0].azimuth_rad for scan in own.scans]
    assert (
        read_targets(CsvTable(other), columns={"time_s": "clock", "x_m": "ahead", "y_m": "right", "range_rate_mps": "doppler"}).scans
        == own.scans
    )


def test_rows_of_one_cycle_make_one_scan_even_when_their_stamps_differ(tmp_path: Path) -> None:
    rows = [f"{0.05 * k + 0.003 * slot:.4f},{slot},{20 + slot},0,0,{int(k == 2)}" for k in range(4) for slot in range(3)]
    log = read_targets(CsvTable(table(tmp_path, *rows)))
    assert [len(scan.radar) for scan in log.scans] == [3] * 4
    assert log.scans[0].period_s == pytest.approx(0.05)
    assert log.pieces == 6
    assert log.arrivals_s[0] == pytest.approx(0.006)


@given(st.lists(st.integers(1, 8), min_size=3, max_size=12), st.floats(1e-4, 3e-3))
def test_without_slots_a_pause_ends_a_cycle_of_targets_that_have_times_of_their_own(
    tmp_path_factory: pytest.TempPathFactory, counts: list[int], apart_s: float
) -> None:
    rows = [f"{0.05 * k + apart_s * j!r},{20 + 15 * j},0,0" for k, count in enumerate(counts) for j in range(count)]
    log = read_targets(CsvTable(table(tmp_path_factory.mktemp("csv"), *rows, header="time_s,x_m,y_m,range_rate_mps")))
    assert [len(scan.radar) for scan in log.scans] == counts


def test_targets_in_an_even_row_need_slots(tmp_path: Path) -> None:
    path = table(tmp_path, *(f"{0.002 * k:.3f},{20 + 15 * (k % 4)},0,0" for k in range(80)), header="t,x_m,y_m,range_rate_mps")
    with pytest.raises(InputError, match=r"radar\.csv: t: has a time of its own for each target, .*--columns slot="):
        read_targets(CsvTable(path), columns={"time_s": "t"})


@given(st.lists(st.sampled_from(["", "A1", "b 2", "7", "7.0", "nan"]), min_size=1, max_size=8))
def test_a_slot_may_be_called_anything(tmp_path_factory: pytest.TempPathFactory, names: list[str]) -> None:
    """Names are told apart by their letters, numbers by what they are; nameless targets are each their own."""
    rows = [f"{0.05 * k},{name},{20 + j},0,0,0" for k in range(3) for j, name in enumerate(dict.fromkeys(names))]
    log = read_targets(CsvTable(table(tmp_path_factory.mktemp("csv"), *rows)))
    assert (log.good, log.bad.total) == (len(rows), 0)
    same = {"7", "7.0"} <= set(names) <= {"", "7", "7.0", "nan"}
    assert same or [len(scan.radar) for scan in log.scans] == [len(rows) // 3] * 3


def test_a_speed_below_zero_is_noise_or_names_its_line(tmp_path: Path) -> None:
    header = "time_s,slot,x_m,y_m,range_rate_mps,host_speed_mps"
    log = read_targets(CsvTable(table(tmp_path, "0,1,10,0,0,0.1", "0.1,1,10,0,0,-0.02", header=header)))
    assert log.host_speed is not None
    assert log.host_speed.tolist() == [[0.0, 0.1], [0.1, 0.0]]
    with pytest.raises(InputError, match=r"radar\.csv: line 3: host_speed_mps = -2\.0: reverses, and reversing is not driven"):
        read_targets(CsvTable(table(tmp_path, "0,1,10,0,0,0.1", "0.1,1,10,0,0,-2", header=header)))


def test_bad_rows_are_counted_by_kind_with_their_first_line(tmp_path: Path) -> None:
    rows = ["0,1,10,0,0,0", "0.1,1,ten,0,0,0", "0.2,1,10,0", "nan,1,10,0,0,0", ",1,10,0,0,0", "0.3,1,10,0,,0", "0.4,1,nan,0,0,0"]
    log = read_targets(CsvTable(table(tmp_path, *rows)))
    assert log.bad.to_document() == {
        "not 6 cells": {"count": 1, "first_line": 4},
        "time_s is not finite": {"count": 2, "first_line": 5},
        "x_m is no number": {"count": 1, "first_line": 3},
    }
    assert log.good == 3
    values = [scan.radar[0] for scan in log.scans]
    assert math.isnan(values[1].range_rate_mps)  # handed on: the tracker gates and counts it
    assert math.isnan(values[2].range_m)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x_m", "--columns: x_m: must be NAME=COLUMN"),
        ("x_m=", "--columns: x_m: must be NAME=COLUMN"),
        ("xm=a", "xm = 'a': unknown name; did you mean 'x_m'"),
        ("x_m=a,x_m=b", "x_m = 'b': given twice"),
    ],
)
def test_a_mapping_that_is_none_is_refused(text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Columns.parse(text)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ("x_m=x_mm", "'x_mm': no such column; did you mean 'x_m'"),
        ("slot=id", "'id': no such column"),
        ("y_m=-left", "'left': no such column"),
    ],
)
def test_a_column_that_is_not_there_is_named(tmp_path: Path, columns: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_targets(CsvTable(table(tmp_path, "0,1,10,0,0,0")), columns=Columns.parse(columns))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "header line and rows"),
        (HEADER + "\n", "header line and rows"),
        (HEADER + "\nnan,1,2,3,4,5\n", r"holds no row that can be read: time_s is not finite \(1, first in line 2\)"),
        (HEADER + "\n0,A,near,3,4,5\n1,A,far,3,4,5\n", r"holds no row that can be read: x_m is no number \(2, first in line 2\)"),
        ("time_s,x_m,y_m\n0,1,2\n", "'range_rate_mps or doppler_velocity': no such column; there are: time_s, x_m, y_m$"),
        ("time_s,x_m,x_m\n0,1,2\n", "two columns of this name"),
    ],
)
def test_other_files_are_refused(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "radar.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        read_targets(CsvTable(path))


def test_a_slot_that_is_given_away_is_another_piece(tmp_path: Path) -> None:
    """Three slots over forty cycles; each is given to another target every tenth cycle, one of them begins late."""
    held = [(k, slot) for k in range(40) for slot in range(3) if slot < 2 or k >= 15]
    log = read_targets(
        CsvTable(table(tmp_path, *(f"{0.05 * k:.2f},{slot},{20 + slot},0,0,{int(k > 0 and k % 10 == 0)}" for k, slot in held)))
    )
    assert (log.good, log.bad.total, log.pieces, len(log.scans)) == (105, 0, 4 + 4 + 3, 40)


@pytest.mark.published(COMMA)
def test_the_recorded_track_list() -> None:
    log = read_targets(CsvTable(COMMA / "radar_tracks.csv"))
    assert (log.good, log.bad.total, log.pieces, len(log.scans)) == (10100, 0, 144, 1200)


def test_a_factor_scales_and_a_column_of_that_name_is_taken_as_it_stands(tmp_path: Path) -> None:
    path = table(tmp_path, "0,1000,2,-36,5", header="t_ms,x_cm,y_m,kmh,2*kmh")
    text = "time_s=0.001*t_ms,x_m=.01*x_cm,range_rate_mps={}"
    (scan,) = read_targets(CsvTable(path), columns=Columns.parse(text.format("-0.5*kmh"))).scans
    assert (scan.t_s, scan.radar[0].range_m * math.cos(scan.radar[0].azimuth_rad)) == (0.0, pytest.approx(10.0))
    assert scan.radar[0].range_rate_mps == 18.0
    (scan,) = read_targets(CsvTable(path), columns=Columns.parse(text.format("2*kmh"))).scans
    assert scan.radar[0].range_rate_mps == 5.0
    for wrong in ("0*kmh", "2*", "9" * 400 + "*kmh"):
        with pytest.raises(InputError, match=r"must be NAME=COLUMN, NAME=-COLUMN or NAME=FACTOR\*COLUMN"):
            Columns.parse(text.format(wrong))


def test_a_mapping_takes_column_names_that_hold_commas_and_equal_signs(tmp_path: Path) -> None:
    path = table(tmp_path, "0,10,2,-1", "0.1,9.9,2,-1", header='t,"x, m","y=left, m",rate')
    columns = {"time_s": "t", "x_m": "x, m", "y_m": "-y=left, m", "range_rate_mps": "rate"}
    log = read_targets(CsvTable(path), columns=columns)
    assert [scan.radar[0].azimuth_rad for scan in log.scans] == [math.atan2(-2.0, 10.0), math.atan2(-2.0, 9.9)]
    for wrong, message in (({"xm": "t"}, "columns: xm = 't': unknown name"), ({"x_m": 3}, "columns: x_m = 3: must be NAME=COLUMN")):
        with pytest.raises(InputError, match=message):
            read_targets(CsvTable(path), columns=wrong)  # type: ignore[arg-type]
