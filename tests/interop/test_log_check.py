"""Logs as a whole: right ones pass, whatever the traffic; wrong signs and units are refused, with file and column."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mcdas_opt.catalogue.data_files import models_folder
from mcdas_opt.domain.measurement import RadarDetection, Scan
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.errors import InputError
from mcdas_opt.interop.esr_can import read_esr
from mcdas_opt.interop.host_motion import HostMotion
from mcdas_opt.interop.log_check import check_log
from mcdas_opt.interop.recordings.candump import CandumpRecording
from mcdas_opt.interop.recordings.csv_table import CsvTable
from mcdas_opt.interop.recordings.recording import Tally
from mcdas_opt.interop.replay import replay
from mcdas_opt.interop.sensor_log import SensorLog, Source
from mcdas_opt.interop.target_list import read_targets
from mcdas_opt.simulation.sensors import mounting
from tests.cli.command_line import run

LOGS = models_folder() / "logs"
COMMA = Path(__file__).resolve().parents[3] / "shared" / "data" / "comma2k19_radar"
ESR = COMMA.parent / "esr_candump"
MPH = 1.0 / 0.44704
WRONG = [(-1.0, "positive when closing"), (3.6, "in km/h"), (-3.6, "in km/h and positive"), (MPH, "in mph"), (-MPH, "in mph and positive")]


def traffic(seed: int, apart_m: float = 45.0, cars: int = 6, clutter: int = 2, still: bool = False) -> tuple[SensorLog, HostMotion]:
    """Half a minute of a front radar: posts every `apart_m` on the right, cars ahead, clutter, the ESR's noise. `still`: cars keep the
    host's speed but for 0.3 m/s."""
    rng = np.random.default_rng(seed)
    times = 0.1 * np.arange(300)
    speed = 15.0 + 8.0 * np.sin(2.0 * np.pi * times / 30.0 + rng.uniform(0.0, 6.0))
    driven = np.concatenate([[0.0], np.cumsum(0.05 * (speed[1:] + speed[:-1]))])
    own = rng.uniform(-0.3, 0.3, cars) if still else rng.uniform(-10.0, 10.0, cars)
    begin, lane = rng.uniform(10.0, 150.0, cars), rng.uniform(-6.0, 6.0, cars)
    scans = []
    for t, v, s in zip(times, speed, driven, strict=True):
        posts = np.arange(math.ceil(s / apart_m) * apart_m, s + 120.0, apart_m) - s if apart_m < 1e3 else np.empty(0)
        x = np.concatenate([posts, begin + own * t])
        y = np.concatenate([np.full(posts.size, -7.0), lane])
        along = np.concatenate([np.full(posts.size, -v), own])
        seen = (x > 2.0) & (x < 160.0) & (rng.random(x.size) > 0.05)
        points = [
            (math.hypot(a, b), math.atan2(b, a), u * a / math.hypot(a, b)) for a, b, u in zip(x[seen], y[seen], along[seen], strict=True)
        ]
        points += [(rng.uniform(5.0, 150.0), rng.uniform(-0.7, 0.7), rng.uniform(-40.0, 20.0)) for _ in range(rng.poisson(clutter))]
        radar = tuple(
            RadarDetection(
                range_m=r + rng.normal(0.0, 0.25), azimuth_rad=a + rng.normal(0.0, 0.009), range_rate_mps=u + rng.normal(0.0, 0.12)
            )
            for r, a, u in points
        )
        scans.append(Scan(sensor="radar", sector=Sector.FRONT, t_s=float(t), mounting=mounting(Sector.FRONT, Vehicle()), radar=radar))
    sources = {Sector.FRONT: Source(file="radar.csv", range_rate="vrel", bearing="angle")}
    log = SensorLog(scans=tuple(scans), arrivals_s=tuple(times.tolist()), good=1, bad=Tally(), sources=sources)
    return log, HostMotion(t_s=times, speed_mps=speed, source="host.csv")


def turned(log: SensorLog, sector: Sector, change: Callable[[RadarDetection], RadarDetection]) -> SensorLog:
    scans = [replace(scan, radar=tuple(map(change, scan.radar))) if scan.sector is sector else scan for scan in log.scans]
    return replace(log, scans=tuple(scans))


def scaled(log: SensorLog, factor: float, sector: Sector = Sector.FRONT) -> SensorLog:
    return turned(log, sector, lambda point: replace(point, range_rate_mps=factor * point.range_rate_mps))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("apart_m", [3.0, 8.0, 45.0, 1e9])
def test_right_logs_pass_with_posts_that_look_alike_clutter_and_quiet_traffic(seed: int, apart_m: float) -> None:
    for clutter, still in ((0, False), (8, False), (2, True)):
        check_log(*traffic(seed, apart_m, clutter=clutter, still=still))


@pytest.mark.parametrize(("factor", "words"), WRONG)
def test_a_range_rate_of_another_sign_or_unit_is_refused(factor: float, words: str) -> None:
    for seed in range(3):
        log, motion = traffic(seed)
        with pytest.raises(InputError, match=rf"^radar\.csv: vrel: .* it seems to be {words}.*must be in m/s, positive when opening"):
            check_log(scaled(log, factor), motion)


def test_a_range_rate_over_ground_is_refused() -> None:
    log, motion = traffic(1)

    def over_ground(scan: Scan) -> Scan:
        speed = float(np.interp(scan.t_s, motion.t_s, motion.speed_mps))
        points = [replace(point, range_rate_mps=point.range_rate_mps + speed * math.cos(point.azimuth_rad)) for point in scan.radar]
        return replace(scan, radar=tuple(points))

    with pytest.raises(InputError, match=r"^radar\.csv: vrel: .*over ground, and must be relative to the host"):
        check_log(replace(log, scans=tuple(map(over_ground, log.scans))), motion)


@pytest.mark.parametrize(("factor", "words"), [(3.6, "in km/h"), (MPH, "in mph")])
def test_the_hosts_speed_is_held_against_what_stands(factor: float, words: str) -> None:
    log, motion = traffic(2)
    wrong = replace(motion, speed_mps=factor * motion.speed_mps)
    with pytest.raises(InputError, match=rf"^host\.csv: speed_mps: .* it seems to be {words}, and must be in m/s"):
        check_log(log, wrong)
    nothing_stands, motion = traffic(2, apart_m=1e9)
    check_log(nothing_stands, replace(motion, speed_mps=factor * motion.speed_mps))


def test_overtaking_lorries_at_three_and_a_half_times_the_difference_is_no_wrong_unit() -> None:
    """110 km/h past a column at 80: they come nearer by a share of the host's speed that is nearly that of km/h."""
    log, _ = traffic(3, apart_m=1e9, cars=0, clutter=0)
    speed = 30.56 + 0.3 * np.sin(np.array(log.arrivals_s))
    scans = []
    for k, scan in enumerate(log.scans):
        gone = 8.34 * scan.t_s
        ahead = np.arange(60.0 * math.ceil((gone + 3.0) / 60.0), gone + 150.0, 60.0) - gone
        rate = 22.22 - speed[k]
        radar = [RadarDetection(range_m=float(x), azimuth_rad=-0.02, range_rate_mps=float(rate)) for x in ahead]
        scans.append(replace(scan, radar=tuple(radar)))
    check_log(replace(log, scans=tuple(scans)), HostMotion(t_s=np.array(log.arrivals_s), speed_mps=speed))


def test_degrees_and_targets_behind_the_radar_are_refused_and_exchanged_sides_show_nowhere() -> None:
    log, motion = traffic(4)
    with pytest.raises(InputError, match=r"^radar\.csv: angle: is beyond pi in \d+% of the detections.*are these degrees"):
        check_log(turned(log, Sector.FRONT, lambda p: replace(p, azimuth_rad=math.degrees(p.azimuth_rad))), motion)
    with pytest.raises(InputError, match=r"^radar\.csv: angle: has the targets behind the radar"):
        check_log(turned(log, Sector.FRONT, lambda p: replace(p, azimuth_rad=math.remainder(math.pi - p.azimuth_rad, math.tau))), motion)
    check_log(turned(log, Sector.FRONT, lambda p: replace(p, azimuth_rad=-p.azimuth_rad)), motion)


def test_what_is_no_number_or_absurd_counts_for_nothing() -> None:
    log, motion = traffic(5)
    odd = [(math.nan, 0.0, 0.0), (1e300, 0.0, 1e300), (5.0, math.inf, 0.0), (-3.0, 0.0, 1.0), (0.0, 0.0, 0.0), (9.0, 1.0, math.nan)]
    more = tuple(RadarDetection(range_m=r, azimuth_rad=a, range_rate_mps=u) for r, a, u in odd)
    noisy = replace(log, scans=tuple(replace(scan, radar=(*scan.radar, *more)) for scan in log.scans))
    check_log(noisy, motion)
    with pytest.raises(InputError, match="positive when closing"):
        check_log(scaled(noisy, -1.0), motion)


@pytest.mark.parametrize("sector", [Sector.FRONT, Sector.REAR])
def test_the_shipped_recording_passes_and_each_of_its_radars_is_looked_at(sector: Sector) -> None:
    log, motion = read_esr(CandumpRecording(LOGS / "front_and_rear.log")), HostMotion.read(LOGS / "front_and_rear.host.csv")
    check_log(log, motion)
    for factor, words in WRONG:
        with pytest.raises(InputError, match=rf"front_and_rear\.log: CAN_TX_TRACK_RANGE_RATE: .* it seems to be {words}"):
            check_log(scaled(log, factor, sector), motion)


@pytest.mark.published(COMMA, ESR)
def test_real_recordings_pass_and_their_wrong_copies_do_not() -> None:
    motion = HostMotion.read(COMMA / "host.csv")
    comma = read_targets(CsvTable(COMMA / "radar_tracks.csv"))
    check_log(comma, motion)
    for factor in (3.6, MPH):
        with pytest.raises(InputError, match=r"host\.csv: speed_mps"):
            check_log(comma, replace(motion, speed_mps=factor * motion.speed_mps))
    logs = [CandumpRecording(ESR / f"test1118_test3_host3_{name}.log") for name in ("front", "rear")]
    esr = read_esr(logs[0], rear=logs[1])
    held = HostMotion(t_s=np.array([0.0, 300.0]), speed_mps=np.array([15.6, 15.6]))
    check_log(esr, held)
    for log, sectors, own in ((comma, [Sector.FRONT], motion), (esr, [Sector.FRONT, Sector.REAR], held)):
        for sector in sectors:
            for factor, words in WRONG:
                with pytest.raises(InputError, match=f"it seems to be {words}"):
                    check_log(scaled(log, factor, sector), own)


def test_the_command_says_it_before_the_first_cycle_and_a_factor_mends_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    log, motion = traffic(6)
    rows = [(s.t_s, p.range_m, p.azimuth_rad, -3.6 * p.range_rate_mps) for s in log.scans for p in s.radar]
    speeds = np.interp([row[0] for row in rows], motion.t_s, motion.speed_mps)
    lines = ["t,range,angle,closing_kmh,ego", *(",".join(f"{x:.5f}" for x in (*row, v)) for row, v in zip(rows, speeds, strict=True))]
    path = tmp_path / "theirs.csv"
    path.write_text("\n".join(lines) + "\n")
    mapping = "time_s=t,range_m=range,azimuth_rad=angle,host_speed_mps=ego,range_rate_mps={}closing_kmh"
    code, out, err = run(monkeypatch, capsys, "replay", str(path), "--no-plan", "--columns", mapping.format(""))
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "theirs.csv: closing_kmh: is -3." in err
    assert "in km/h and positive when closing" in err
    mended = replay(
        path,
        columns={"time_s": "t", "azimuth_rad": "angle", "host_speed_mps": "ego", "range_rate_mps": "-0.277778*closing_kmh"},
        plan=False,
    )
    assert mended.log.scans[7].radar[0].range_rate_mps == pytest.approx(log.scans[7].radar[0].range_rate_mps, abs=1e-4)
