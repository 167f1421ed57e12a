"""Values that are numbers, texts and files of a kind that nobody thinks of: taken, or refused in one sentence; nothing foreign leaves."""

from __future__ import annotations

import copy
import dataclasses
import json
import math
import pickle
import threading
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mcdas_opt as mo
from mcdas_opt.catalogue import data_files
from mcdas_opt.catalogue.data_files import find, read_bytes
from mcdas_opt.errors import InputError, ParameterError, SharedPlannerError
from mcdas_opt.interop import esr_codec
from mcdas_opt.interop.recordings import candump
from mcdas_opt.interop.recordings.csv_table import CsvTable
from mcdas_opt.interop.recordings.mcap import McapRecording
from tests.cli.command_line import run

HUGE = 10**400
HOST = mo.HostState(speed_mps=10.0)
POINT = {"range_m": 20.0, "azimuth_rad": 0.0, "range_rate_mps": 0.0}
BODY = {"name": "lorry", "s_m": 20.0, "d_m": 0.0, "speed_s_mps": 0.0, "speed_d_mps": 0.0, "length_m": 4.0, "width_m": 2.0}


def seen(**changed: Any) -> mo.Plan:
    scan = {"sensor": "ahead", "sector": "front", "t_s": 0.0} | changed
    return mo.Planner().step([mo.Scan(**scan)], HOST, 0.0)


@pytest.mark.parametrize("name", [*POINT, "range_sd_m", "azimuth_sd_rad", "range_rate_sd_mps"])
def test_a_sensor_may_say_an_integer_of_hundreds_of_digits(name: str) -> None:
    for value in (HUGE, -HUGE):
        assert seen(radar=(mo.RadarDetection(**(POINT | {name: value})),)).verdict.passed


def test_so_may_its_clock_its_place_and_an_ideal_sensor() -> None:
    assert seen(t_s=HUGE).verdict.passed
    assert seen(mounting=mo.Mounting(x_m=HUGE, y_m=-HUGE)).verdict.passed
    for name in list(BODY)[1:]:
        assert seen(bodies=(mo.BodyDetection(**(BODY | {name: HUGE})),)).verdict.passed
    assert mo.Mounting(x_m=HUGE, y_m=-HUGE).y_m == -math.inf


@pytest.mark.parametrize("kind", [np.float16, np.float32, np.float64, np.longdouble, np.int8, np.uint64])
def test_numbers_of_numpy_become_plain_ones(kind: Callable[[float], Any]) -> None:
    """Single precision overflowed, with a warning of numpy's out of `step`, where a length of 1e300 m stood beside it."""
    records = [
        mo.RadarDetection(**dict.fromkeys(POINT, kind(3))),
        mo.BodyDetection(**(BODY | {"width_m": kind(3), "length_m": 1e300})),
        mo.Mounting(x_m=kind(3)),
        mo.Scan(sensor="ahead", sector="front", t_s=kind(3), period_s=kind(3)),
    ]
    for record in records:
        values = [getattr(record, field.name) for field in dataclasses.fields(record)]
        assert not [value for value in values if isinstance(value, np.generic)]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert seen(bodies=(records[1],)).verdict.passed


class Unwritable:
    def __repr__(self) -> str:
        raise AttributeError


def nested() -> list[Any]:
    inside: list[Any] = []
    for _ in range(100_000):
        inside = [inside]
    return inside


@pytest.mark.parametrize(
    "made",
    [
        lambda: mo.HostState(speed_mps=np.timedelta64(5, "ns")),  # type: ignore[arg-type]
        lambda: mo.Scan(sensor="a", sector="front", t_s=np.timedelta64(5, "ns")),  # type: ignore[arg-type]
        lambda: mo.Planner().step([], HOST, np.timedelta64(100, "ms")),  # type: ignore[arg-type]
        lambda: mo.HostState(speed_mps=Unwritable()),  # type: ignore[arg-type]
        lambda: mo.HostState(speed_mps=nested()),  # type: ignore[arg-type]
        lambda: mo.Destination(lane=10**5000),
        lambda: mo.Destination(lane=1001),
        lambda: mo.Track(id="\ud800", s_m=20.0, d_m=0.0, speed_s_mps=0.0),
    ],
)
def test_what_is_no_number_of_this_kind_is_refused(made: Callable[[], object]) -> None:
    with pytest.raises(ParameterError, match="must "):
        made()


def test_a_copy_of_a_planner_is_nobody_s() -> None:
    """Made in mid-plan, by a thread that keeps checkpoints, it could never be asked."""
    planner, answers = mo.Planner(), []
    with planner._one_thread.inside():
        copies = [pickle.loads(pickle.dumps(planner)), copy.deepcopy(planner)]

    def asked() -> None:
        answers.extend(twin.plan(mo.Situation(host=HOST, coverage=mo.Coverage())).status for twin in copies)

    other = threading.Thread(target=asked)
    other.start()
    other.join()
    assert answers == ["planned", "planned"]


def test_its_error_comes_back_from_a_worker() -> None:
    assert str(pickle.loads(pickle.dumps(SharedPlannerError()))) == str(SharedPlannerError())


class SpeechlessError(Exception):
    def __str__(self) -> str:
        raise ValueError


class Odd:
    """A method that can neither say by what it solves nor what went wrong."""

    has_ladder = True

    def __init__(self, vehicle: mo.Vehicle, settings: mo.Settings) -> None:
        self.vehicle = vehicle

    @property
    def solver(self) -> str:
        raise RuntimeError

    def plan(self, situation: mo.Situation, previous: mo.Plan | None) -> mo.Plan:
        raise SpeechlessError


@pytest.mark.filterwarnings("ignore::mcdas_opt.errors.PlannerFaultWarning")
def test_a_method_that_cannot_say_what_went_wrong_is_answered_by_the_ladder() -> None:
    planner = mo.Planner(method=Odd(mo.Vehicle(), mo.Settings()))
    plan = planner.plan(mo.Situation(host=HOST, coverage=mo.Coverage()))
    assert plan.verdict.passed
    assert plan.solver == ""


NAMED = find("scenes", "sandwich-60-40").read_text("utf-8")


def test_names_are_drawn_as_they_are(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """Matplotlib takes what is between two dollars for a formula."""
    scene, out = tmp_path / "scene.toml", tmp_path / "out.png"
    scene.write_text(NAMED.replace('name = "sandwich-60-40"', 'name = "$x_{$"'), "utf-8")
    code, _, said = run(monkeypatch, capsys, "simulate", str(scene), "--planner", "closed-form-corrected", "--out", str(out))
    assert (code, out.is_file()) == (0, True), said


def test_half_of_a_surrogate_pair_in_a_document_is_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    situation = mo.Situation(host=HOST, coverage=mo.Coverage(), tracks=(mo.Track(id="a", s_m=30.0, d_m=0.0, speed_s_mps=9.0),))
    file = tmp_path / "situation.json"
    file.write_text(situation.to_json().replace('"a"', '"\\ud800"'), "utf-8")
    code, out, said = run(monkeypatch, capsys, "plan", str(file))
    assert (code, out) == (2, "")
    assert "half of a surrogate pair" in said


def test_a_table_may_have_many_columns(tmp_path: Path) -> None:
    """Looking for names that are there twice took the square of their number: minutes for 100,000."""
    file = tmp_path / "wide.csv"
    names = [f"a{k}" for k in range(100_000)]
    file.write_text(f"{','.join(names)}\n{','.join('1' for _ in names)}\n", "utf-8")
    assert len(CsvTable(file).header) == len(names)
    file.write_text(f"{','.join([*names, 'a7'])}\n1\n", "utf-8")
    with pytest.raises(InputError, match="two columns of this name"):
        CsvTable(file)


def test_of_a_recording_that_is_too_large_no_more_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "large"
    file.write_bytes(bytes(100))
    assert read_bytes(file, 100) == bytes(100)
    with pytest.raises(InputError, match="must be at most 99 bytes"):
        read_bytes(file, 99)
    monkeypatch.setattr(data_files.read_bytes, "__defaults__", (99,))
    monkeypatch.setattr(esr_codec, "LARGEST_DBC", 99)
    for read in (CsvTable, candump.read_candump, lambda dbc: esr_codec.EsrCodec(dbc=dbc)):
        with pytest.raises(InputError, match="must be at most 99 bytes"):
            read(file)


def recorded(file: Path, data: bytes) -> Path:
    """An MCAP file of one message, in one chunk."""
    writer = pytest.importorskip("mcap.writer")
    with file.open("wb") as out:
        made = writer.Writer(out, chunk_size=200_000_000)
        made.start()
        schema = made.register_schema(name="any", encoding="jsonschema", data=b"{}")
        channel = made.register_channel(topic="radar", message_encoding="json", schema_id=schema)
        made.add_message(channel_id=channel, log_time=0, publish_time=0, data=data)
        made.finish()
    return file


def test_what_unpacks_to_gigabytes_is_refused(tmp_path: Path) -> None:
    bomb = recorded(tmp_path / "bomb.mcap", b" " * 110_000_000 + b"{}")
    with pytest.raises(InputError, match="must be at most 100000000 bytes, unpacked"):
        McapRecording(bomb)


def test_a_recorded_integer_of_hundreds_of_digits_is_not_finite(tmp_path: Path) -> None:
    table = McapRecording(recorded(tmp_path / "long.mcap", json.dumps({"range": HUGE}).encode())).table("radar.range")
    assert [row.values for row in table.rows([0], None)] == [(math.inf,)]  # type: ignore[arg-type]


def test_lanes_are_told_of_places_beyond_all_numbers() -> None:
    road = mo.Road(lanes_left=1, lanes_right=1, lane_width_m=3.5)
    assert [road.lane_of(d, 0.0) for d in (-math.inf, -1e308, -1.76, -1.74, 1.74, 1.76, 1e308, math.inf)] == [-1, -1, -1, 0, 0, 1, 1, 1]


def test_a_table_does_not_take_the_place_of_what_was_read(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    table = tmp_path / "host.csv"
    table.write_text("t_s,speed_mps\n0,10\n1,10\n", "utf-8")
    before = table.read_bytes()
    words = ("replay", "front_and_rear", "--format", "esr-candump", "--host", str(table), "--out", str(table), "--no-plan")
    code, _, said = run(monkeypatch, capsys, *words)
    assert code == 2
    assert "would be written over" in said
    assert table.read_bytes() == before


def test_a_screen_without_columns_is_one_of_the_usual_width(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv("COLUMNS", "0")
    assert "python" in run(monkeypatch, capsys, "doctor")[1]
