"""Whole replays: the shipped recording, the real ones where they are, and options that do not fit."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.radar_log import NAME, recording
from mcdas_opt.catalogue.data_files import models_folder
from mcdas_opt.catalogue.scenes import load_scene
from mcdas_opt.domain.doubt import Doubt, DoubtKind
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Mode, Role, Sector, Side, Status
from mcdas_opt.errors import InputError
from mcdas_opt.interop.replay import replay
from mcdas_opt.interop.replay_record import Replay
from mcdas_opt.interop.sensor_log import require_clock
from mcdas_opt.interop.truth import Comparison, TrueTarget, compare, read_truth
from mcdas_opt.planning.planner import Planner
from mcdas_opt.simulation.sensors import mounting

LOGS = models_folder() / "logs"
SHARED = Path(__file__).resolve().parents[3] / "shared" / "data"
ESR = SHARED / "esr_candump"
COMMA = SHARED / "comma2k19_radar"


@pytest.fixture(scope="module")
def tracked() -> Replay:
    return replay(NAME, "esr-candump", host=NAME, plan=False)


@pytest.fixture(scope="module")
def compared(tracked: Replay) -> Comparison:
    return compare(tracked, NAME)


def test_the_shipped_recording_is_what_the_script_writes() -> None:
    for suffix, text in recording(load_scene(LOGS / f"{NAME}.toml")).items():
        assert (LOGS / f"{NAME}{suffix}").read_text() == text, suffix


def test_every_frame_is_accounted_for(tracked: Replay) -> None:
    summary = tracked.summary
    assert (summary.frames_good, summary.frames_bad, summary.frames_other) == (2010, 0, 0)
    assert summary.detections + summary.gated["no target"] == 2 * 201 * 3
    assert summary.tracker["scans"] == summary.scans == 402
    assert summary.covered == {"front": 1.0, "rear": 1.0, "left": 0.0, "right": 0.0}
    assert (summary.plans, summary.statuses) == (0, {})
    assert sum(summary.modes.values()) == summary.cycles == len(tracked.cycles) == 101


def test_the_tracks_stay_near_the_truth_and_nearer_than_the_detections(compared: Comparison) -> None:
    assert set(compared.sectors) == {Sector.FRONT, Sector.REAR}
    for found in compared.sectors.values():
        assert found.breaks == 0
        assert found.covered > 0.97
        ours, raw = found.tracked, found.raw
        assert ours.samples > 95
        assert raw.samples > 190
        for name, limit in (("along_rmse_m", 0.15), ("across_rmse_m", 0.15), ("range_rate_rmse_mps", 0.15)):
            assert getattr(ours, name) < limit
        assert ours.along_rmse_m < 0.5 * raw.along_rmse_m
        assert ours.across_rmse_m < 0.7 * raw.across_rmse_m


def test_the_car_on_the_left_has_its_role_and_passes(tracked: Replay) -> None:
    seen = [(t.s_m, t.d_m) for c in tracked.cycles for t in c.tracks if t.role is Role.LEFT]
    along, across = np.array(seen).T
    assert along[0] < -20.0
    assert along[-1] > 50.0
    np.testing.assert_allclose(across, 3.7, atol=1.0)
    assert np.all(np.diff(along) > 0.0)


def test_a_replay_repeats_byte_for_byte_timings_aside(tracked: Replay) -> None:
    def document(done: Replay) -> str:
        whole = done.to_dict()
        del whole["summary"]["cycle_ms"]
        return json.dumps(whole, allow_nan=False)

    assert document(tracked) == document(replay(NAME, "esr-candump", host=NAME, plan=False))


def test_the_documents_keys_are_the_contracts(tracked: Replay) -> None:
    whole = tracked.to_dict()
    assert {"schema_version", "format", "planner", "cycles", "summary"} <= set(whole)
    cycle = whole["cycles"][-1]
    assert {"t_s", "tracks", "mode", "status"} <= set(cycle)
    assert cycle["status"] is None
    assert {"id", "role", "s_m", "d_m", "speed_s_mps", "speed_d_mps", "covariance"} <= set(cycle["tracks"][0])
    assert np.shape(cycle["tracks"][0]["covariance"]) == (4, 4)


def test_without_a_host_file_the_radar_says_the_speed(tracked: Replay) -> None:
    spoken = replay(NAME, "esr-candump", plan=False)
    for a, b in zip(tracked.cycles, spoken.cycles, strict=True):
        assert a.host.speed_mps == pytest.approx(b.host.speed_mps, abs=0.05)
        assert a.host.s_m == pytest.approx(b.host.s_m, abs=0.2)


def shortened(folder: Path, seconds: float) -> Path:
    path = folder / "short.log"
    lines = (LOGS / f"{NAME}.log").read_text().splitlines()
    path.write_text("\n".join(line for line in lines if float(line[1:9]) < seconds) + "\n")
    return path


def test_plans_are_judged_and_nobody_steers_out_of_one_lane(tmp_path: Path) -> None:
    done = replay(shortened(tmp_path, 1.0), "esr-candump", planner="mpc")
    summary = done.summary
    assert (summary.plans, summary.unverified_plans) == (summary.cycles, 0)
    assert sum(summary.statuses.values()) == summary.cycles
    assert all(isinstance(cycle.status, Status) for cycle in done.cycles)
    assert all(cycle.side is Side.NONE and cycle.mode is not Mode.EVADE for cycle in done.cycles)
    rows, cycles = done.columns(), done.to_dict()["cycles"]
    for name in ("acceleration_mps2", "steering_rad", "speed_mps"):
        later = [float(np.interp(0.1, c.plan.trajectory.t_s, getattr(c.plan.trajectory, name))) for c in done.cycles if c.plan is not None]
        assert [cycle[name] for cycle in cycles] == pytest.approx(later)
        told = dict(zip(rows["t_s"], rows[name], strict=True))
        assert list(told.values()) == pytest.approx(later)
    assert all(len(column) == len(rows["t_s"]) for column in rows.values())


def test_a_cycle_says_which_tracks_are_doubted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    doubt, plan = Doubt(kind=DoubtKind.DUPLICATE, tracks=("2", "3"), value=0.4, unit="m"), Planner.plan
    monkeypatch.setattr(Planner, "plan", lambda self, situation: replace(plan(self, situation), doubts=(doubt,)))
    done = replay(shortened(tmp_path, 0.5), "esr-candump", planner="mpc")
    assert [cycle["doubts"][0]["words"] for cycle in done.to_dict()["cycles"]] == ["tracks 2 and 3 are the same"] * len(done.cycles)
    assert done.cycles


def test_without_plans_nothing_is_asked_for(tracked: Replay) -> None:
    assert {(c.acceleration_mps2, c.steering_rad, c.speed_mps) for c in tracked.cycles} == {(None, None, None)}


def test_a_scene_gives_road_and_vehicle(tmp_path: Path) -> None:
    scene = load_scene(LOGS / f"{NAME}.toml")
    done = replay(shortened(tmp_path, 0.5), "esr-candump", road=scene, plan=False)
    assert done.road == scene.assumed_road
    assert done.road.lanes_left == 1


def test_a_cut_log_is_replayed_and_says_so(tmp_path: Path) -> None:
    path = shortened(tmp_path, 1.0)
    path.write_text(path.read_text()[:-8] + "\nnoise\n")
    summary = replay(path, "esr-candump", plan=False).summary
    assert summary.frames_bad == 2
    assert set(summary.bad) == {"cut short", "not a candump line"}


def test_a_dead_radar_covers_nothing(tmp_path: Path) -> None:
    text = shortened(tmp_path, 1.0).read_text()
    path = tmp_path / "dead.log"
    path.write_text(text.replace("can1 4E1#0000000000000000", "can1 4E1#0020000000000000"))
    done = replay(path, "esr-candump", plan=False)
    assert done.summary.covered["rear"] == 0.0
    assert done.summary.tracker["dead"] == 20
    assert all(track.role is not Role.REAR for cycle in done.cycles for track in cycle.tracks)


def test_broken_numbers_never_reach_a_track(tmp_path: Path) -> None:
    rows = [f"{0.05 * k:.2f},1,30,0.5,0,0\n{0.05 * k:.2f},2,nan,0,0,0\n{0.05 * k:.2f},3,20,0,inf,0" for k in range(20)]
    radar, host = tmp_path / "radar.csv", tmp_path / "host.csv"
    radar.write_text("time_s,slot,x_m,y_m,range_rate_mps,new_track\n" + "\n".join(rows) + "\n")
    host.write_text("t_s,speed_mps\n0,10\n1,10\n")
    done = replay(radar, "radar-csv", host=host, plan=False)
    assert done.summary.tracker["not_finite"] == 40
    assert done.summary.covered == {"front": 1.0, "rear": 0.0, "left": 0.0, "right": 0.0}
    (track,) = done.cycles[-1].tracks
    assert track.s_m == pytest.approx(30.0 + 2.25 + 2.25, abs=0.3)
    assert track.speed_s_mps == pytest.approx(10.0, abs=0.3)
    json.dumps(done.to_dict(), allow_nan=False)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"format": "esr"}, "--format = 'esr': is not a known format; did you mean 'esr-candump'|known: esr-candump"),
        (
            {"format": "esr-candump", "columns": {"x_m": "x"}},
            "'range_rate_mps or doppler_velocity': no such channel; there are: can0, can1",
        ),
        ({"format": "radar-csv", "dbc": "a.dbc"}, "--dbc: belongs to a recording of CAN frames"),
        ({"format": "esr-candump", "host": "nowhere.csv"}, "nowhere.csv: no such file"),
    ],
)
def test_options_that_do_not_fit_are_refused(options: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        replay(NAME, **options)


def test_an_unknown_speed_and_a_broken_clock_are_refused(tmp_path: Path) -> None:
    silent, endless = tmp_path / "silent.log", tmp_path / "endless.log"
    data = "can0 500#006079E210000251"
    silent.write_text(f"(0.0) {data}\n(0.1) {data}\n")
    with pytest.raises(InputError, match=r"silent\.log: does not say the host's speed: pass --host"):
        replay(silent, "esr-candump")
    endless.write_text("".join(f"({t}) {data}\n" for t in ("0.0", "0.1", "90000.0", "90000.1")))
    with pytest.raises(InputError, match="spans more than 21600 s"):
        replay(endless, "esr-candump", host=NAME)


def radar_csv(folder: Path, times: list[float]) -> tuple[Path, Path]:
    """A target list with one target in each of the scans, and the host's speed."""
    radar, host = folder / "radar.csv", folder / "host.csv"
    rows = "".join(f"{t!r},1,{30.0 - 0.1 * k!r},0.5,-2,0\n" for k, t in enumerate(times))
    radar.write_text("time_s,slot,x_m,y_m,range_rate_mps,new_track\n" + rows)
    said = np.arange(min(times), max(times) + 2.0, 2.0).tolist()
    host.write_text("t_s,speed_mps\n" + "".join(f"{t!r},10\n" for t in said))
    return radar, host


def test_milliseconds_are_refused_as_what_they_most_likely_are(tmp_path: Path) -> None:
    radar, host = radar_csv(tmp_path, [50.0 * k for k in range(100)])
    with pytest.raises(InputError, match=r"time = 50\.0: is between two scans \(median\).*at most 2 s.*not in seconds"):
        replay(radar, "radar-csv", host=host, plan=False)


def test_nothing_is_planned_while_no_radar_is_heard(tmp_path: Path) -> None:
    """An hour without a scan costs no time, and old tracks do not live through it."""
    before, after = [1.7e9 + 0.05 * k for k in range(41)], [1.7e9 + 3600.0 + 0.05 * k for k in range(41)]
    radar, host = radar_csv(tmp_path, before + after)
    done = replay(radar, "radar-csv", host=host, plan=False)
    assert (done.summary.cycles, done.summary.cycles_left_out) == (142, 36021 - 142)
    assert done.summary.span() == "3602.0 s from 1700000000 s, 35879 without a scan left out"
    late = next(cycle for cycle in done.cycles if cycle.t_s > 1.7e9 + 3599.0)
    assert not late.tracks
    assert done.cycles[-1].tracks


def test_a_speed_that_nobody_said_is_not_made_up(tmp_path: Path) -> None:
    """Five seconds at 25 m/s, a minute of nothing, then standing: halfway through it was 12.5 m/s."""
    radar, host = radar_csv(tmp_path, [0.05 * k for k in range(1400)])
    said = [(0.1 * k, 25.0) for k in range(51)] + [(65.0 + 0.1 * k, 0.0) for k in range(51)]
    host.write_text("t_s,speed_mps\n" + "".join(f"{t!r},{v}\n" for t, v in said))
    with pytest.raises(InputError, match=r"host\.csv: t_s: says nothing between 5 s and 65 s, where the log has scans"):
        replay(radar, "radar-csv", host=host, plan=False)


def test_a_logger_s_pause_is_left_out(tmp_path: Path) -> None:
    """Neither radar nor speed for five seconds: there is nothing to plan by, and nothing is lost."""
    times = [0.05 * k + (5.0 if k > 40 else 0.0) for k in range(81)]
    radar, host = radar_csv(tmp_path, times)
    host.write_text("t_s,speed_mps\n" + "".join(f"{t!r},10\n" for t in times))
    done = replay(radar, "radar-csv", host=host, plan=False)
    assert done.summary.cycles_left_out == 30
    assert not [cycle.t_s for cycle in done.cycles if 3.01 < cycle.t_s < 6.04]
    assert done.summary.scans == done.summary.tracker["scans"] == 81


@pytest.mark.parametrize("set_back_s", [2.02, 30.0, 3600.0])
def test_a_clock_that_is_set_back_is_told_with_its_line(set_back_s: float, tmp_path: Path) -> None:
    """What follows would come too late, all of it, and be left out."""
    times = [5000.0 + 0.05 * k - (set_back_s if k >= 200 else 0.0) for k in range(400)]
    radar, host = radar_csv(tmp_path, times)
    with pytest.raises(InputError, match=r"radar\.csv: line 202: time_s = .*: goes back by .*: split the recording"):
        replay(radar, "radar-csv", host=host, plan=False)
    can = tmp_path / "a.log"
    can.write_text("".join(f"({t:.6f}) can0 500#006079E210000251\n" for t in times))
    with pytest.raises(InputError, match=r"a\.log: line 201: time = .*: goes back by"):
        replay(can, host=host, plan=False)


@given(st.lists(st.floats(0.0, 0.45), min_size=5, max_size=40), st.integers(1, 3), st.floats(1.0, 5.0))
def test_late_records_are_no_clock_that_is_set_back(lates: list[float], at: int, very_late: float) -> None:
    stamps = [0.1 * k - late for k, late in enumerate(lates)]
    stamps[at] -= very_late
    require_clock("a.csv", "time_s", stamps, range(len(stamps)))


def truth_of(true: float, times: int = 101) -> dict[Sector, TrueTarget]:
    t = np.linspace(0.0, 10.0, times)
    still = np.full_like(t, true)
    return {Sector.FRONT: TrueTarget(t_s=t, range_m=still, azimuth_rad=0.0 * t, range_rate_mps=0.0 * t)}


def test_truth_elsewhere_is_not_covered_and_truth_at_another_time_is_refused(tracked: Replay) -> None:
    (found,) = compare(tracked, truth_of(150.0)).sectors.values()
    assert (found.covered, found.tracked.samples, found.tracked.along_rmse_m, found.first_covered_s) == (0.0, 0, None, None)
    target = truth_of(27.5)[Sector.FRONT]
    later = TrueTarget(t_s=target.t_s + 100.0, range_m=target.range_m, azimuth_rad=target.azimuth_rad, range_rate_mps=target.range_rate_mps)
    with pytest.raises(InputError, match="no sector or no time in common"):
        compare(tracked, {Sector.FRONT: later})


def test_silent_truth_is_not_interpolated_over() -> None:
    target = TrueTarget(
        t_s=np.array([0.0, 0.1, 2.0, 2.1, 2.2]),
        range_m=np.array([10.0, 10.0, 10.0, np.nan, 10.0]),
        azimuth_rad=np.zeros(5),
        range_rate_mps=np.zeros(5),
    )
    points, rates = target.at(np.array([-0.1, 0.05, 1.0, 2.05, 2.3]), mounting(Sector.REAR, Vehicle()))
    np.testing.assert_array_equal(np.isfinite(rates), [False, True, False, False, False])
    np.testing.assert_allclose(points[1], [-10.0, 0.0], atol=1e-12)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t,x\n0,1\n1,2\n", "front_range or rear_range"),
        ("t,front_range,front_azimuth_deg\n0,1,2\n1,1,2\n", "'front_range_rate': no such column"),
        ("t,front_range,front_azimuth_deg,front_range_rate\n0,1,2,3\n0,1,2,3\n", "line 3: .*times increase"),
        ("t,front_range,front_azimuth_deg,front_range_rate\n0,1,2,3\n1,a,2,3\n", "line 3: front_range is no number"),
    ],
)
def test_bad_truth_is_refused(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "truth.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        read_truth(path)


def test_truth_azimuths_turn_their_sign(tmp_path: Path) -> None:
    path = tmp_path / "truth.csv"
    path.write_text("t,rear_range,rear_azimuth_deg,rear_range_rate\n0,10,30,0\n1,10,30,0\n")
    points, _ = read_truth(path)[Sector.REAR].at(np.array([0.5]), mounting(Sector.REAR, Vehicle()))
    assert not np.isfinite(points).any()  # a second without truth
    points, _ = read_truth(path)[Sector.REAR].at(np.array([0.0, 1.0]), mounting(Sector.REAR, Vehicle()))
    assert not np.isfinite(points).any()
    path.write_text("t,rear_range,rear_azimuth_deg,rear_range_rate\n0,10,30,0\n0.1,10,30,0\n")
    points, _ = read_truth(path)[Sector.REAR].at(np.array([0.05]), mounting(Sector.REAR, Vehicle()))
    np.testing.assert_allclose(points, [[-10.0 * math.cos(math.pi / 6), 5.0]])


@pytest.mark.published(ESR)
def test_the_recorded_platoon_against_its_truth(tmp_path: Path) -> None:
    cars = np.genfromtxt(SHARED / "cats_platoon" / "test1118_test3.csv", delimiter=",", names=True)
    host = tmp_path / "host.csv"
    host.write_text("t_s,speed_mps\n" + "".join(f"{t!r},{v!r}\n" for t, v in zip(cars["t"].tolist(), cars["veh3_v"].tolist(), strict=True)))
    name = str(ESR / "test1118_test3_host3_{}.log")
    done = replay(name.format("front"), "esr-candump", rear=name.format("rear"), host=host, dbc=ESR / "ESR.dbc", plan=False)
    assert (done.summary.start_s, done.summary.end_s, done.summary.frames_good) == (15.0, 122.1, 2144)
    for found in compare(done, ESR / "test1118_test3_host3_truth.csv").sectors.values():
        ours, raw = found.tracked, found.raw
        assert found.breaks == 0
        assert found.covered > 0.99
        assert ours.along_rmse_m < 0.15 < raw.along_rmse_m
        assert ours.across_rmse_m < 0.25 < raw.across_rmse_m
        assert ours.range_rate_rmse_mps < raw.range_rate_rmse_mps < 0.13


@pytest.mark.published(COMMA)
def test_a_recorded_track_list_runs_through(tmp_path: Path) -> None:
    """The first ten seconds: a front car all along, gaps of the sensor bridged, standing things standing."""
    lines = (COMMA / "radar_tracks.csv").read_text().splitlines()
    path = tmp_path / "radar.csv"
    path.write_text("\n".join([lines[0], *(line for line in lines[1:] if float(line.split(",")[0]) < 10.0)]) + "\n")
    done = replay(path, "radar-csv", host=COMMA / "host.csv", plan=False)
    summary = done.summary
    assert summary.sensor_pieces is not None
    assert summary.tracks_started < summary.sensor_pieces
    assert summary.longest_track_s > 9.0
    assert all(any(track.role is Role.FRONT for track in cycle.tracks) for cycle in done.cycles[5:])
    standing = [track for track in done.cycles[80].tracks if abs(track.speed_s_mps) < 1.0]
    assert len(standing) >= 1
    json.dumps(done.to_dict(), allow_nan=False)


def test_a_rear_radar_s_target_list_stands_beside_the_front_one_s(tmp_path: Path) -> None:
    times = [0.1 * k for k in range(20)]
    for name, x_m in (("front", 30.0), ("rear", 25.0)):
        rows = [
            f"{t:g},{x_m + (0.0 if name == 'front' else 1.0 * t)!r},{0.0 if name == 'front' else 1.0},{0.0 if name == 'front' else 1.0}"
            for t in times
        ]
        (tmp_path / f"{name}.csv").write_text("\n".join(["t,ahead,right,rate", *rows]) + "\n")
    (tmp_path / "host.csv").write_text("t_s,speed_mps\n0,15\n2,15\n")
    columns = {"time_s": "t", "x_m": "ahead", "y_m": "-right", "range_rate_mps": "rate"}
    done = replay(tmp_path / "front.csv", rear=tmp_path / "rear.csv", host=tmp_path / "host.csv", columns=columns, plan=False)
    assert done.summary.covered == {"front": 1.0, "rear": 1.0, "left": 0.0, "right": 0.0}
    ahead, behind = sorted(done.cycles[-1].tracks, key=lambda track: -track.s_m)
    assert (ahead.role, behind.role) == (Role.FRONT, Role.REAR)
    assert behind.s_m < -25.0
    assert behind.d_m == pytest.approx(1.0, abs=0.3)  # what is right of the rear radar is left of the car
    assert behind.speed_s_mps == pytest.approx(14.0, abs=0.5)
