"""The ESR codec: facts of the DBC, signs, gates, round trips, and logs that are not as they should be."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import cantools
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.catalogue.data_files import models_folder
from mcdas_opt.domain.measurement import RadarDetection, Scan
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.errors import InputError, MissingExtraError, ParameterError
from mcdas_opt.interop.esr_can import read_esr, write_esr
from mcdas_opt.interop.esr_codec import EsrCodec, EsrHealth, EsrMotion, EsrTarget, TargetStatus, WrongLengthError
from mcdas_opt.interop.recordings.candump import CandumpRecording, write_candump
from mcdas_opt.interop.sensor_log import SensorLog
from mcdas_opt.simulation.sensors import mounting

SHARED = Path(__file__).resolve().parents[3] / "shared" / "data"
ESR = SHARED / "esr_candump"
SHIPPED = models_folder() / "can" / "esr_minimal.dbc"
published = pytest.mark.published(ESR)
# of a track message, after the radar's own description: (first bit, length, signed, scale)
LAYOUT = {
    "STATUS": (15, 3, False, 1.0), "ANGLE": (12, 10, True, 0.1), "RANGE": (18, 11, False, 0.1), "WIDTH": (37, 4, False, 0.5),
    "RANGE_RATE": (53, 14, True, 0.01),
}  # fmt: skip

detections = st.builds(
    RadarDetection,
    range_m=st.floats(0.0, 204.7),
    azimuth_rad=st.floats(math.radians(-51.1), math.radians(51.1)),
    range_rate_mps=st.floats(-81.9, 81.9),
)


def esr(log: Path, *, rear: Path | None = None, dbc: Path | None = None) -> SensorLog:
    return read_esr(CandumpRecording(log), rear=None if rear is None else CandumpRecording(rear), dbc=dbc)


def scan_of(found: list[RadarDetection], t_s: float = 1.0, sector: Sector = Sector.FRONT, working: bool = True) -> Scan:
    return Scan(
        sensor=f"esr-{sector.value}", sector=sector, t_s=t_s, mounting=mounting(sector, Vehicle()), radar=tuple(found),
        working=working, period_s=0.05,
    )  # fmt: skip


def written(folder: Path, scans: list[Scan], **options: object) -> Path:
    path = folder / "a.log"
    path.write_text(write_candump(write_esr(scans, **options)))
    return path


def test_a_recorded_frame_decodes_to_known_values() -> None:
    target = EsrCodec().decode(0x500, bytes.fromhex("006079E210000251"))
    assert isinstance(target, EsrTarget)
    assert (target.slot, target.status, target.range_m, target.range_rate_mps) == (0, TargetStatus.UPDATED, 48.2, 5.93)
    assert target.azimuth_rad == -math.radians(1.5)
    assert target.width_m == 2.0


def test_the_shipped_dbc_lays_out_every_track_message_alike() -> None:
    database = cantools.database.load_file(str(SHIPPED))
    for slot in range(64):
        message = database.get_message_by_frame_id(0x500 + slot)
        found = {signal.name.removeprefix("CAN_TX_TRACK_"): signal for signal in message.signals}
        assert message.length == 8
        assert {name: (s.start, s.length, s.is_signed, s.scale) for name, s in found.items()} == LAYOUT
        assert {(s.byte_order, s.offset) for s in found.values()} == {("big_endian", 0)}


@published
def test_the_shipped_dbc_states_the_facts_of_the_published_one() -> None:
    ours, theirs = (cantools.database.load_file(str(path)) for path in (SHIPPED, ESR / "ESR.dbc"))
    assert len(ours.messages) == 66
    for message in ours.messages:
        published = theirs.get_message_by_frame_id(message.frame_id)
        assert message.length == published.length
        for signal in message.signals:
            other = published.get_signal_by_name(signal.name)
            for fact in ("start", "length", "byte_order", "is_signed", "scale", "offset"):
                assert getattr(signal, fact) == getattr(other, fact), (message.name, signal.name, fact)


@published
def test_both_dbcs_decode_the_recording_alike() -> None:
    front, rear = (ESR / f"test1118_test3_host3_{side}.log" for side in ("front", "rear"))
    ours, theirs = (esr(front, rear=rear, dbc=dbc) for dbc in (None, ESR / "ESR.dbc"))
    assert ours.scans == theirs.scans
    assert (ours.good, ours.bad.total, ours.other, len(ours.scans), ours.detections) == (2144, 0, 0, 2144, 2144)


@published
def test_the_azimuth_sign_agrees_with_the_recorded_positions() -> None:
    """The cars' positions are the judge: which side of the host's path the others were on, by their tracks in the plane."""
    cars = np.genfromtxt(SHARED / "cats_platoon" / "test1118_test3.csv", delimiter=",", names=True)
    log = esr(ESR / "test1118_test3_host3_front.log", rear=ESR / "test1118_test3_host3_rear.log")
    host = np.column_stack([cars["veh3_x"], cars["veh3_y"]])
    for sector, car in ((Sector.FRONT, "veh2"), (Sector.REAR, "veh4")):
        other = np.column_stack([cars[f"{car}_x"], cars[f"{car}_y"]])
        seen, true = [], []
        for scan in (scan for scan in log.scans if scan.sector is sector):
            k = round(scan.t_s / 0.1)
            way = host[k] - host[max(k - 5, 0)] if k + 5 >= len(host) else host[k + 5] - host[k - 5]
            if math.hypot(*way) < 5.0:
                continue
            ahead = way / math.hypot(*way)
            across = other[k] - host[k]
            true.append(ahead[0] * across[1] - ahead[1] * across[0])
            detection = scan.radar[0]
            seen.append(detection.range_m * math.sin(scan.mounting.yaw_rad + detection.azimuth_rad))
        assert len(seen) > 500
        assert np.corrcoef(seen, true)[0, 1] > 0.7


@settings(max_examples=15)
@given(st.lists(detections, max_size=8), st.booleans())
def test_scans_survive_the_round_trip(tmp_path_factory: pytest.TempPathFactory, found: list[RadarDetection], working: bool) -> None:
    folder = tmp_path_factory.mktemp("esr")
    scans = [scan_of(found, working=working), scan_of([], 1.05), scan_of(found[:1], 1.0, Sector.REAR)]
    once = esr(written(folder, scans, slots=8))
    read = {(scan.sector, scan.t_s): scan for scan in once.scans}
    for scan in scans:
        back = read[scan.sector, scan.t_s]
        assert (back.working, back.mounting, len(back.radar)) == (scan.working, scan.mounting, len(scan.radar))
        for sent, got in zip(scan.radar, back.radar, strict=True):
            assert abs(got.range_m - sent.range_m) <= 0.05 + 1e-9
            assert abs(got.azimuth_rad - sent.azimuth_rad) <= math.radians(0.05) + 1e-9
            assert abs(got.range_rate_mps - sent.range_rate_mps) <= 0.005 + 1e-9
    text = write_candump(write_esr(once.scans, slots=8))
    assert text == (folder / "a.log").read_text()


@pytest.mark.parametrize("status", list(TargetStatus))
def test_only_targets_seen_in_this_cycle_pass_the_gate(tmp_path: Path, status: TargetStatus) -> None:
    codec, slot = EsrCodec(), 7 * int(status)
    path = tmp_path / "a.log"
    identifier, data = codec.encode(EsrTarget(slot=slot, status=status))
    path.write_text(f"(0.0) can0 {identifier:03X}#{data.hex()}\n")
    log = esr(path)
    assert codec.decode(identifier, data) == EsrTarget(slot=slot, status=status)
    assert len(log.scans[0].radar) == int(status in (1, 2, 3, 5))
    assert sum(log.gated.values()) == int(status not in (1, 2, 3, 5))


def test_empty_slots_look_valid_and_are_gated(tmp_path: Path) -> None:
    log = esr(written(tmp_path, [scan_of([], t) for t in (0.0, 0.05, 0.1)]))
    assert log.gated == {"no target": 3 * 64}
    assert log.detections == 0
    assert [scan.t_s for scan in log.scans] == [0.0, 0.05, 0.1]
    raw = EsrCodec().decode(*EsrCodec().encode(EsrTarget(slot=0, status=TargetStatus.NO_TARGET)))
    assert isinstance(raw, EsrTarget)
    assert (raw.range_m, raw.range_rate_mps) == (200.0, 81.91)


@pytest.mark.parametrize("spare", [0.0, 0.004])
def test_one_scan_a_radar_cycle(tmp_path: Path, spare: float) -> None:
    scans = [
        scan_of([RadarDetection(range_m=10.0 + k, azimuth_rad=0.0, range_rate_mps=0.0)], 0.05 * k + spare * (k % 2)) for k in range(20)
    ]
    log = esr(written(tmp_path, scans, speeds_mps=[10.0] * 20))
    assert [len(scan.radar) for scan in log.scans] == [1] * 20
    assert log.scans[0].period_s == pytest.approx(0.05, abs=spare + 1e-9)
    assert log.host_speed is not None
    np.testing.assert_array_equal(log.host_speed[:, 1], 10.0)


def test_a_faulty_radar_is_a_dead_one(tmp_path: Path) -> None:
    log = esr(written(tmp_path, [scan_of([], 0.0), scan_of([], 0.1, working=False), scan_of([], 0.2)]))
    assert [scan.working for scan in log.scans] == [True, False, True]


def test_health_and_motion_round_trip() -> None:
    codec = EsrCodec()
    for item in (EsrHealth(working=True), EsrHealth(working=False), EsrMotion(speed_mps=12.5, scan_index=65535)):
        assert codec.decode(*codec.encode(item)) == item


@pytest.mark.parametrize(
    "detection",
    [
        RadarDetection(range_m=math.nan, azimuth_rad=0.0, range_rate_mps=0.0),
        RadarDetection(range_m=205.0, azimuth_rad=0.0, range_rate_mps=0.0),
        RadarDetection(range_m=-1.0, azimuth_rad=0.0, range_rate_mps=0.0),
        RadarDetection(range_m=5.0, azimuth_rad=1.0, range_rate_mps=0.0),
        RadarDetection(range_m=5.0, azimuth_rad=0.0, range_rate_mps=90.0),
    ],
)
def test_what_the_message_cannot_carry_is_refused(detection: RadarDetection) -> None:
    with pytest.raises(ParameterError, match="CAN_TX_TRACK"):
        write_esr([scan_of([detection])])


def test_more_detections_than_slots_and_sectors_without_a_bus_are_refused() -> None:
    detection = RadarDetection(range_m=5.0, azimuth_rad=0.0, range_rate_mps=0.0)
    with pytest.raises(ParameterError, match="radar = 3"):
        write_esr([scan_of([detection] * 3)], slots=2)
    with pytest.raises(ParameterError, match="sector = 'rear'"):
        write_esr([scan_of([], sector=Sector.REAR)], buses={Sector.FRONT: "can0"})
    with pytest.raises(ParameterError, match="slots"):
        write_esr([], slots=65)


def two_buses(folder: Path) -> Path:
    return written(folder, [scan_of([], 0.1 * k, sector) for k in range(3) for sector in (Sector.FRONT, Sector.REAR)], slots=2)


def test_the_first_bus_by_name_is_the_front(tmp_path: Path) -> None:
    log = esr(two_buses(tmp_path))
    assert log.sectors == (Sector.FRONT, Sector.REAR)
    assert [scan.sector for scan in log.scans[:2]] == [Sector.FRONT, Sector.REAR]
    path = tmp_path / "b.log"
    path.write_text(two_buses(tmp_path).read_text().replace("can1", "can9").replace("can0", "can1"))
    assert esr(path).scans == log.scans


def test_buses_are_in_the_order_of_their_numbers(tmp_path: Path) -> None:
    log = esr(two_buses(tmp_path))
    path = tmp_path / "b.log"
    path.write_text(two_buses(tmp_path).read_text().replace("can1", "can10").replace("can0", "can2"))
    renamed = esr(path)
    assert renamed.scans == log.scans
    assert {sector: source.bus for sector, source in renamed.sources.items()} == {Sector.FRONT: "can2", Sector.REAR: "can10"}


def test_two_buses_and_a_rear_log_exclude_each_other(tmp_path: Path) -> None:
    both = two_buses(tmp_path)
    front = tmp_path / "front.log"
    front.write_text(written(tmp_path, [scan_of([])]).read_text())
    both = two_buses(tmp_path)
    for log, rear in ((both, front), (front, both)):
        with pytest.raises(InputError, match="bus = 'can0, can1'"):
            esr(log, rear=rear)
    three = tmp_path / "three.log"
    three.write_text(both.read_text() + both.read_text().replace("can1", "can2"))
    with pytest.raises(InputError, match="can0, can1, can2"):
        esr(three)


def cut(log: SensorLog) -> tuple[int, dict[str, dict[str, int]]]:
    return log.good, log.bad.to_document()


def test_a_log_cut_in_mid_frame_keeps_the_good_frames(tmp_path: Path) -> None:
    detection = RadarDetection(range_m=10.0, azimuth_rad=0.0, range_rate_mps=0.0)
    path = written(tmp_path, [scan_of([detection], 0.1 * k) for k in range(3)], slots=1)
    whole = path.read_text()
    assert cut(esr(path)) == (6, {})
    for missing in (3, 4):  # half a byte, a whole byte (and the line's end)
        path.write_text(whole[: -1 - missing])
        log = esr(path)
        assert cut(log) == (5, {"cut short": {"count": 1, "first_line": 6}})
        assert log.detections == 2


def test_long_and_repeated_frames_are_bad_and_foreign_ones_other(tmp_path: Path) -> None:
    path = written(tmp_path, [scan_of([], 0.1 * k) for k in range(3)], slots=1)
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines, lines[-1], "(0.3) can0 123#00", "(0.3) can7 4E1#00"]) + "\n")
    log = esr(path)
    assert cut(log) == (6, {"cut short": {"count": 1, "first_line": 9}, "repeated": {"count": 1, "first_line": 7}})
    assert log.other == 1
    with pytest.raises(WrongLengthError):
        EsrCodec().decode(0x500, bytes(9))


def test_stamps_that_go_back_arrive_late_but_keep_their_time(tmp_path: Path) -> None:
    path = tmp_path / "a.log"
    data = "006079E210000251"
    path.write_text("".join(f"({t:.6f}) can0 500#{data}\n" for t in (0.0, 0.1, 0.2, 0.05, 0.3)))
    log = esr(path)
    assert [scan.t_s for scan in log.scans] == [0.0, 0.1, 0.2, 0.05, 0.3]
    assert log.arrivals_s == (0.0, 0.1, 0.2, 0.2, 0.3)


@pytest.mark.parametrize("text", ["(0.0) can0 123#00\n", "(0.0) can0 4E1#0000000000000000\n"])
def test_a_log_without_the_radar_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "a.log"
    path.write_text(text)
    with pytest.raises(InputError, match=r"a\.log: holds no ESR track frame"):
        esr(path)


def test_a_dbc_without_the_messages_is_refused_by_their_names(tmp_path: Path) -> None:
    text = SHIPPED.read_text()
    empty, partial, bare = (tmp_path / name for name in ("empty.dbc", "partial.dbc", "bare.dbc"))
    empty.write_text('VERSION ""\n\nNS_ :\n\nBS_:\n\nBU_: A\n\nBO_ 1 Other: 8 A\n SG_ X : 0|8@1+ (1,0) [0|0] "" A\n')
    with pytest.raises(InputError, match=r"empty\.dbc: lacks 64 .*ESR_Track01 \(0x500\).*ESR_Track64 \(0x53F\)"):
        EsrCodec(dbc=empty)
    partial.write_text("\n\n".join(block for block in text.split("\n\n") if not block.startswith("BO_ 1285 ")))
    with pytest.raises(InputError, match=r"lacks 1 of the 64 ESR track messages: ESR_Track06 \(0x505\)$"):
        EsrCodec(dbc=partial)
    bare.write_text(text.replace(' SG_ CAN_TX_TRACK_RANGE : 18|11@0+ (0.1,0) [0|204.7] "m" Gateway\n', "", 1))
    with pytest.raises(InputError, match=r"ESR_Track01 \(0x500\): lacks the signal CAN_TX_TRACK_RANGE$"):
        EsrCodec(dbc=bare)


def test_a_dbc_without_status_messages_is_enough_to_read(tmp_path: Path) -> None:
    path = tmp_path / "tracks.dbc"
    path.write_text("\n\n".join(b for b in SHIPPED.read_text().split("\n\n") if not b.startswith(("BO_ 1248 ", "BO_ 1249 ", "CM_"))))
    log = esr(written(tmp_path, [scan_of([], working=False)], speeds_mps=[10.0]), dbc=path)
    assert (log.host_speed, log.other, log.scans[0].working) == (None, 2, True)
    with pytest.raises(ParameterError, match="0x4E1"):
        write_esr([scan_of([])], dbc=path)


def test_a_file_that_is_no_dbc_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.dbc"
    path.write_text("hello")
    with pytest.raises(InputError, match=r"a\.dbc: is no DBC"):
        EsrCodec(dbc=path)
    with pytest.raises(InputError, match="cannot be read"):
        EsrCodec(dbc=tmp_path / "none.dbc")


def test_without_cantools_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cantools", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'mcdas-opt\[can\]'"):
        EsrCodec()
