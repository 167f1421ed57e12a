"""The same drive in every format that we read, written by the formats' own libraries; and recordings that hold something else."""

from __future__ import annotations

import contextlib
import json
import math
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from asammdf import MDF, Signal, Source
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.writer import CompressionType, Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as BagWriter

from benchmarks.attack.mutators import mutated
from mcdas_opt.catalogue.data_files import models_folder
from mcdas_opt.domain.document import to_document
from mcdas_opt.errors import InputError, McdasError
from mcdas_opt.interop.recordings.candump import read_candump, write_candump
from mcdas_opt.interop.recordings.messages import flattened, time_of
from mcdas_opt.interop.recordings.recording import READERS, Frame, format_of, open_recording
from mcdas_opt.interop.recordings.rosbag2 import _DEFINITIONS, type_store
from mcdas_opt.interop.replay import replay
from mcdas_opt.interop.replay_record import Replay
from mcdas_opt.interop.target_list import read_targets

NAME = "front_and_rear"
LOG = models_folder() / "logs" / f"{NAME}.log"
NS = 1_000_000_000
CAN_DTYPE = np.dtype(
    [
        ("CAN_DataFrame.BusChannel", "<u1"),
        ("CAN_DataFrame.ID", "<u4"),
        ("CAN_DataFrame.IDE", "<u1"),
        ("CAN_DataFrame.DLC", "<u1"),
        ("CAN_DataFrame.DataLength", "<u1"),
        ("CAN_DataFrame.DataBytes", "(8,)u1"),
    ]
)


def tracks(done: Replay) -> list[object]:
    return [to_document(cycle) for cycle in done.cycles]


@pytest.fixture(scope="module")
def frames() -> tuple[Frame, ...]:
    return tuple(frame for frame in read_candump(LOG).frames if frame.t_s < 2.0)


@pytest.fixture(scope="module")
def as_candump(frames: tuple[Frame, ...], tmp_path_factory: pytest.TempPathFactory) -> Replay:
    path = tmp_path_factory.mktemp("candump") / "drive.log"
    path.write_text(write_candump(frames))
    return replay(path, plan=False)


def mdf4(frames: tuple[Frame, ...], path: Path) -> Path:
    """Bus logging, a group a bus as loggers write it."""
    source = Source(source_type=Source.SOURCE_BUS, bus_type=Source.BUS_TYPE_CAN, name="CAN", path="", comment="")
    with MDF(version="4.10") as mdf:
        for number, bus in enumerate(sorted({frame.channel for frame in frames}), start=1):
            own = [frame for frame in frames if frame.channel == bus]
            samples = np.zeros(len(own), dtype=CAN_DTYPE)
            samples["CAN_DataFrame.BusChannel"] = number
            samples["CAN_DataFrame.ID"] = [frame.identifier for frame in own]
            samples["CAN_DataFrame.DLC"] = samples["CAN_DataFrame.DataLength"] = [len(frame.data) for frame in own]
            samples["CAN_DataFrame.DataBytes"] = [list(frame.data.ljust(8, b"\0")) for frame in own]
            times = np.array([frame.t_s for frame in own])
            mdf.append(Signal(samples=samples, timestamps=times, name="CAN_DataFrame", source=source), acq_source=source)
        mdf.save(path, overwrite=True)
    return path


def ros_frame(store: object, frame: Frame) -> object:
    """A can_msgs/msg/Frame."""
    kinds = store.types  # type: ignore[attr-defined]
    stamp = kinds["builtin_interfaces/msg/Time"](sec=round(frame.t_s * NS) // NS, nanosec=round(frame.t_s * NS) % NS)
    return kinds["can_msgs/msg/Frame"](
        header=kinds["std_msgs/msg/Header"](stamp=stamp, frame_id=""),
        id=frame.identifier, is_rtr=False, is_extended=False, is_error=False, dlc=len(frame.data),
        data=np.frombuffer(frame.data.ljust(8, b"\0"), dtype=np.uint8),
    )  # fmt: skip


def rosbag2(frames: tuple[Frame, ...], path: Path, storage: StoragePlugin = StoragePlugin.SQLITE3) -> Path:
    store, kind = type_store(), "can_msgs/msg/Frame"
    with BagWriter(path, version=9, storage_plugin=storage) as writer:
        buses = {bus: writer.add_connection(f"/{bus}", kind, typestore=store) for bus in sorted({frame.channel for frame in frames})}
        for frame in frames:
            writer.write(buses[frame.channel], round(frame.t_s * NS), store.serialize_cdr(ros_frame(store, frame), kind))
    return path


def rosbag2_in_mcap(frames: tuple[Frame, ...], path: Path) -> Path:
    return rosbag2(frames, path, StoragePlugin.MCAP)


@contextmanager
def mcap_writer(path: Path) -> Iterator[Writer]:
    with path.open("wb") as file:
        writer = Writer(file, compression=CompressionType.NONE)
        writer.start()
        yield writer
        writer.finish()


def mcap_ros(frames: tuple[Frame, ...], path: Path) -> Path:
    """As ROS 2 records into MCAP."""
    store, kind = type_store(), "can_msgs/msg/Frame"
    definition, _ = store.generate_msgdef(kind, ros_version=2)
    with mcap_writer(path) as writer:
        schema = writer.register_schema(name=kind, encoding="ros2msg", data=definition.encode())
        buses = {bus: writer.register_channel(f"/{bus}", "cdr", schema) for bus in sorted({frame.channel for frame in frames})}
        for frame in frames:
            t, data = round(frame.t_s * NS), bytes(store.serialize_cdr(ros_frame(store, frame), kind))
            writer.add_message(buses[frame.channel], log_time=t, publish_time=t, data=data)
    return path


def mcap_json(frames: tuple[Frame, ...], path: Path) -> Path:
    with mcap_writer(path) as writer:
        schema = writer.register_schema(name="can_msgs/msg/Frame", encoding="jsonschema", data=b"{}")
        buses = {bus: writer.register_channel(f"/{bus}", "json", schema) for bus in sorted({frame.channel for frame in frames})}
        for frame in frames:
            t, data = round(frame.t_s * NS), json.dumps({"id": frame.identifier, "dlc": len(frame.data), "data": list(frame.data)})
            writer.add_message(buses[frame.channel], log_time=t, publish_time=t, data=data.encode())
    return path


@pytest.mark.parametrize(
    ("write", "name", "format"),
    [
        (mdf4, "drive.mf4", "mdf4"),
        (rosbag2, "drive", "rosbag2"),
        (rosbag2_in_mcap, "drive", "rosbag2"),
        (mcap_ros, "drive.mcap", "mcap"),
        (mcap_json, "drive.mcap", "mcap"),
    ],
)
def test_the_same_drive_replays_to_the_same_tracks(
    write: Callable[[tuple[Frame, ...], Path], Path],
    name: str,
    format: str,
    frames: tuple[Frame, ...],
    as_candump: Replay,
    tmp_path: Path,
) -> None:
    done = replay(write(frames, tmp_path / name), plan=False)
    assert done.format == format
    assert any(cycle.tracks for cycle in done.cycles)
    assert tracks(done) == tracks(as_candump)
    assert (done.summary.frames_good, done.summary.bad) == (as_candump.summary.frames_good, {})


TARGETS = [(round(0.05 * k, 2), 1, 30.0 - 0.1 * k, 0.5, -2.0) for k in range(40)]
MAPPING = {"x_m": "Radar_dx", "y_m": "-Radar_right", "range_rate_mps": "Radar_vrel", "host_speed_mps": "Ego_v"}
SPEED = [(round(0.05 * k, 2), 10.0) for k in range(40)]


def as_csv(path: Path) -> Path:
    rows = [f"{t},{slot},{x},{y},{rate},{SPEED[0][1]}" for t, slot, x, y, rate in TARGETS]
    path.write_text("\n".join(["time_s,slot,x_m,y_m,range_rate_mps,host_speed_mps", *rows]) + "\n")
    return path


def as_mdf_channels(path: Path) -> Path:
    """Radar channels in one group, y to the right and the rate in km/h; the speed in another group, in km/h."""
    t, slot, x, y, rate = (np.array(column, dtype=np.float64) for column in zip(*TARGETS, strict=True))
    with MDF(version="4.10") as mdf:
        mdf.append(
            [
                Signal(samples=slot, timestamps=t, name="slot"),
                Signal(samples=x, timestamps=t, name="Radar_dx", unit="m"),
                Signal(samples=-y, timestamps=t, name="Radar_right", unit="m"),
                Signal(samples=rate, timestamps=t, name="Radar_vrel", unit="m/s"),
            ]
        )
        mdf.append(Signal(samples=np.full(t.size, 36.0), timestamps=t, name="Ego_v", unit="km/h"))
        mdf.save(path, overwrite=True)
    return path


@given(st.lists(st.lists(st.tuples(st.floats(1.0, 99.0), st.booleans()), min_size=1, max_size=4), min_size=1, max_size=6))
@settings(max_examples=10, deadline=None)
def test_targets_that_share_a_time_are_rows_of_their_own(scans: list[list[tuple[float, bool]]]) -> None:
    """As loggers write target lists: a record a target, all of a cycle at one time; what is invalid is missing from its own row alone."""
    whole = [(0.05 * k, x, bad, float(slot)) for k, scan in enumerate(scans) for slot, (x, bad) in enumerate(scan)]
    times, x, bad, slots = (np.array(column) for column in zip(*whole, strict=True))
    with TemporaryDirectory() as folder, MDF(version="4.10") as mdf:
        signals = [Signal(samples=x, timestamps=times, name="x_m", unit="m", invalidation_bits=bad)]
        signals += [Signal(samples=zeros, timestamps=times, name=name) for name, zeros in (("y_m", 0.0 * x), ("range_rate_mps", 0.0 * x))]
        mdf.append([*signals, Signal(samples=slots, timestamps=times, name="slot")])
        mdf.save(Path(folder) / "radar.mf4", overwrite=True)
        log = read_targets(open_recording(Path(folder) / "radar.mf4", "mdf4"))
    assert (log.good, [len(scan.radar) for scan in log.scans]) == (len(whole), [len(scan) for scan in scans])
    ranges = [point.range_m for scan in log.scans for point in scan.radar]
    np.testing.assert_allclose(ranges, np.where(bad, np.nan, x))


def with_units(path: Path, speed: str, azimuth: str, slot: str = "") -> Path:
    """A target at 20 m, 0.1 to the left in that unit; the host's speed is 36 in that unit."""
    t = 0.05 * np.arange(20)
    with MDF(version="4.10") as mdf:
        values = (("range_m", 20.0, "m"), ("azimuth_rad", 0.1, azimuth), ("range_rate_mps", 0.0, "m/s"), ("slot", 1.0, slot))
        mdf.append([Signal(samples=np.full(t.size, value), timestamps=t, name=name, unit=unit) for name, value, unit in values])
        mdf.append(Signal(samples=np.full(t.size, 36.0), timestamps=t, name="host_speed_mps", unit=speed))
        mdf.save(path, overwrite=True)
    return path


@pytest.mark.parametrize(
    ("speed", "mps", "azimuth", "rad"),
    [
        *((unit, 10.0, "Deg", math.radians(0.1)) for unit in ("km/h", "Km/h", "km/hr", "KPH", "kmph", " KMH", "km·h-1")),
        *((unit, 16.09344, "°", math.radians(0.1)) for unit in ("mph", "mi/h", "MPH")),
        ("knots", 18.52, "mrad", 1e-4),
        *((unit, 36.0, azimuth, 0.1) for unit, azimuth in (("m/s", "rad"), ("M/S", ""), ("", "RAD"), ("m s-1", "radians"))),
    ],
)
def test_units_are_known_however_they_are_spelt(speed: str, mps: float, azimuth: str, rad: float, tmp_path: Path) -> None:
    log = read_targets(open_recording(with_units(tmp_path / "a.mf4", speed, azimuth, slot="ID"), "mdf4"))
    assert log.host_speed is not None
    assert log.host_speed[:, 1] == pytest.approx(mps)
    assert log.scans[0].radar[0].azimuth_rad == pytest.approx(rad)


def test_a_unit_that_nobody_knows_is_refused_by_name_until_a_factor_is_given(tmp_path: Path) -> None:
    odd = open_recording(with_units(tmp_path / "a.mf4", "furlong/h", "rad"), "mdf4")
    with pytest.raises(
        InputError, match=r"a\.mf4: unit of host_speed_mps = 'furlong/h': is no unit that we know: .*host_speed_mps=FACTOR\*h"
    ):
        read_targets(odd)
    log = read_targets(odd, columns={"host_speed_mps": "0.5*host_speed_mps"})
    assert log.host_speed is not None
    assert set(log.host_speed[:, 1]) == {18.0}
    with pytest.raises(InputError, match=r"unit of azimuth_rad = 'gon'"):
        read_targets(open_recording(with_units(tmp_path / "a.mf4", "m/s", "gon"), "mdf4"))


def as_json_messages(path: Path) -> Path:
    with mcap_writer(path) as writer:
        schema = writer.register_schema(name="radar", encoding="jsonschema", data=b"{}")
        radar, ego = (writer.register_channel(topic, "json", schema) for topic in ("/radar", "/ego"))
        for t, slot, x, y, rate in TARGETS:
            stamp = round(t * NS)
            targets = [{"slot": slot, "x_m": x, "y_m": y, "range_rate_mps": rate}]
            writer.add_message(radar, log_time=stamp, publish_time=stamp, data=json.dumps({"targets": targets}).encode())
            writer.add_message(ego, log_time=stamp, publish_time=stamp, data=json.dumps({"host_speed_mps": 10.0}).encode())
    return path


def test_a_target_list_by_mapping_is_the_same_in_every_format(tmp_path: Path) -> None:
    own = replay(as_csv(tmp_path / "radar.csv"), plan=False)
    assert [len(cycle.tracks) for cycle in own.cycles[5:]] == [1] * (len(own.cycles) - 5)
    assert own.cycles[-1].host.speed_mps == 10.0
    assert tracks(replay(as_json_messages(tmp_path / "radar.mcap"), plan=False)) == tracks(own)
    mdf = replay(as_mdf_channels(tmp_path / "radar.mf4"), plan=False, columns=MAPPING)
    for one, other in zip(mdf.cycles, own.cycles, strict=True):
        assert one.host.speed_mps == pytest.approx(other.host.speed_mps, abs=1e-9)
        for a, b in zip(one.tracks, other.tracks, strict=True):
            assert (a.s_m, a.d_m, a.speed_s_mps) == pytest.approx((b.s_m, b.d_m, b.speed_s_mps), abs=1e-6)


def test_a_ros_radar_scan_needs_no_mapping_and_an_empty_one_is_a_scan(tmp_path: Path) -> None:
    store, kind = type_store(), "radar_msgs/msg/RadarScan"
    kinds = store.types
    with BagWriter(tmp_path / "bag", version=9) as writer:
        radar, ego = (
            writer.add_connection(topic, msgtype, typestore=store)
            for topic, msgtype in (("/radar", kind), ("/odom", "geometry_msgs/msg/TwistStamped"))
        )
        for k in range(40):
            stamp = kinds["builtin_interfaces/msg/Time"](sec=1_700_000_000 + k // 20, nanosec=50_000_000 * (k % 20))
            header = kinds["std_msgs/msg/Header"](stamp=stamp, frame_id="radar")
            seen = kinds["radar_msgs/msg/RadarReturn"](range=30.0, azimuth=0.0, elevation=0.0, doppler_velocity=0.0, amplitude=1.0)
            scan = kinds[kind](header=header, returns=[seen] if k < 30 else [])
            vector = kinds["geometry_msgs/msg/Vector3"]
            twist = kinds["geometry_msgs/msg/Twist"](linear=vector(x=10.0, y=0.0, z=0.0), angular=vector(x=0.0, y=0.0, z=0.0))
            t = stamp.sec * NS + stamp.nanosec + 3_000_000  # recorded a little later than measured
            writer.write(radar, t, store.serialize_cdr(scan, kind))
            moving = kinds["geometry_msgs/msg/TwistStamped"](header=header, twist=twist)
            writer.write(ego, t, store.serialize_cdr(moving, "geometry_msgs/msg/TwistStamped"))
    done = replay(tmp_path / "bag", plan=False)
    assert (done.summary.scans, done.summary.detections) == (40, 30)
    assert done.cycles[0].t_s == 1_700_000_000.0
    (track,) = done.cycles[12].tracks
    assert (track.s_m, track.speed_s_mps) == (pytest.approx(30.0 + 4.5, abs=0.1), pytest.approx(10.0, abs=0.2))
    assert {"/radar.returns.range", "/odom.twist.linear.x"} <= set(open_recording(tmp_path / "bag", "rosbag2").channels)


def test_what_is_missing_is_named_beside_what_is_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"radar\.mf4: channel = 'range_rate_mps or .*': no such channel; there are: slot, Radar_dx"):
        replay(as_mdf_channels(tmp_path / "radar.mf4"), plan=False)
    with pytest.raises(InputError, match=r"channel = 'Radar_vre': no such channel; did you mean 'Radar_vrel'\?; there are: "):
        replay(tmp_path / "radar.mf4", plan=False, columns={"range_rate_mps": "Radar_vre"})
    with pytest.raises(InputError, match=r"channel = '/ego\.x': no such channel; .*there are: /radar\.targets\.slot, .*, /ego\.host"):
        replay(as_json_messages(tmp_path / "radar.mcap"), plan=False, columns={"range_rate_mps": "/ego.x"})
    path = tmp_path / "candump.log"
    path.write_text("(0.0) can0 500#006079E210000251\n(0.1) can1 500#006079E210000251\n")
    with pytest.raises(InputError, match=r"candump\.log: channel = 'a': no such channel; there are: can0, can1"):
        replay(path, columns={"range_rate_mps": "a"})
    with pytest.raises(InputError, match=r"does not say the host's speed: pass --host, .*or name its channel"):
        replay(tmp_path / "radar.mf4", columns={"x_m": "Radar_dx", "y_m": "Radar_right", "range_rate_mps": "Radar_vrel"})
    with pytest.raises(InputError, match=r"rear\.log: cannot be read: No such file or directory"):
        replay(tmp_path / "radar.mcap", rear="rear.log")


@pytest.mark.parametrize(
    ("stamp", "speed", "said"),
    [
        (lambda t: 7.0, "10.0", "says the host's speed at one time only: are its time stamps all equal?"),
        (lambda t: t, "nan", "says the host's speed nowhere as a number with a time"),
        (lambda t: 1e3 * t, "10.0", "is between two scans (median), which must be at most 2 s: are its time stamps not in seconds?"),
        (lambda t: 1e9 * t, "10.0", "is one of its time stamps broken, or are they not in seconds?"),
    ],
)
def test_a_clock_that_stands_or_counts_otherwise_is_told_as_that(
    stamp: Callable[[float], float], speed: str, said: str, tmp_path: Path
) -> None:
    path = tmp_path / "log.csv"
    rows = [f"{stamp(t)},{x},{y},{rate},{speed}" for t, _, x, y, rate in TARGETS]
    path.write_text("\n".join(["stamp,x_m,y_m,range_rate_mps,ego", *rows]) + "\n")
    with pytest.raises(InputError, match=re.escape(said)):
        replay(path, plan=False, columns={"time_s": "stamp", "host_speed_mps": "ego"})


def test_a_radar_that_sees_nobody_for_long_is_known_by_its_first_target(tmp_path: Path) -> None:
    """An empty road for 30 s, and two other topics of which one never fills its list."""
    with mcap_writer(tmp_path / "late.mcap") as writer:
        schema = writer.register_schema(name="radar", encoding="jsonschema", data=b"{}")
        topics = [writer.register_channel(topic, "json", schema) for topic in ("/radar", "/ego", "/faults")]
        for k in range(640):
            targets = [{"x_m": 30.0, "y_m": 0.0, "range_rate_mps": 0.0}] if k >= 600 else []
            for topic, document in zip(topics, ({"targets": targets}, {"host_speed_mps": 10.0}, {"faults": []}), strict=True):
                stamp = k * NS // 20
                writer.add_message(topic, log_time=stamp, publish_time=stamp, data=json.dumps(document).encode())
    done = replay(tmp_path / "late.mcap", plan=False)
    assert (done.summary.scans, done.summary.detections, done.summary.tracks_started) == (640, 40, 1)


def test_two_radars_of_one_name_are_told_apart(tmp_path: Path) -> None:
    with mcap_writer(tmp_path / "two.mcap") as writer:
        schema = writer.register_schema(name="radar", encoding="jsonschema", data=b"{}")
        for topic in ("/front", "/rear"):
            channel = writer.register_channel(topic, "json", schema)
            writer.add_message(channel, log_time=0, publish_time=0, data=b'{"x_m": 1, "y_m": 0, "range_rate_mps": 0}')
    with pytest.raises(InputError, match=r"'range_rate_mps': is the end of several: /front\.range_rate_mps, /rear\.range_rate"):
        replay(tmp_path / "two.mcap")


@pytest.mark.parametrize(("name", "words"), [("a.mf4", "as MDF4"), ("a.mcap", "as MCAP"), ("a.db3", "as a bag of ROS 2")])
@pytest.mark.parametrize("data", [b"", b"no such thing\n" * 40])
def test_another_file_under_that_name_is_refused(name: str, words: str, data: bytes, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(data)
    with pytest.raises(InputError, match=f"{name}: cannot be read {words}"):
        replay(tmp_path / name)


def test_a_file_that_was_cut_short_is_refused(tmp_path: Path) -> None:
    path = as_json_messages(tmp_path / "radar.mcap")
    path.write_bytes(path.read_bytes()[:-400])
    with pytest.raises(InputError, match=r"radar\.mcap: "):
        replay(path)


@given(st.integers(0, 2**32))
@settings(max_examples=5, deadline=None)
def test_a_broken_recording_is_read_or_refused_and_says_nothing_else(broken: dict[str, bytes], seed: int) -> None:
    """Whatever the libraries raise; `broken` are sound files, which are broken here."""
    rng = np.random.default_rng(seed)
    with TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        told: list[object] = []
        patch.setattr(sys, "unraisablehook", told.append)
        for name, data in broken.items():
            path = Path(folder) / name
            path.write_bytes(mutated(data, rng))
            with contextlib.suppress(McdasError):
                replay(path, plan=False, columns=MAPPING if name == "channels.mf4" else None)
    assert told == []


@pytest.fixture(scope="module")
def broken(frames: tuple[Frame, ...], tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    folder, few = tmp_path_factory.mktemp("sound"), frames[:60]
    files = (mdf4(few, folder / "bus.mf4"), mcap_ros(few, folder / "bus.mcap"))
    files += (as_mdf_channels(folder / "channels.mf4"), as_json_messages(folder / "radar.mcap"))
    return {path.name: path.read_bytes() for path in files}


def test_formats_are_found_by_the_files_name_and_by_their_own(tmp_path: Path) -> None:
    assert [format_of(Path(name)) for name in ("a.log", "a.CSV", "a.mf4", "a.mcap", "a.db3")] == list(READERS.own)
    assert format_of(tmp_path) == "rosbag2"
    with pytest.raises(InputError, match=r"a\.xyz: is of no known format by its name; say --format, one of esr-candump, mcap"):
        format_of(Path("a.xyz"))
    assert set(READERS.own) <= set(READERS.known())


def test_messages_are_flattened_and_dated() -> None:
    document = {"a": 1, "b": {"c": 2.5, "d": True, "e": "text"}, "f": [{"g": 1}, {"g": None}], "h": [1, 2]}
    assert flattened(document) == ({"a": 1.0, "b.c": 2.5, "b.d": 1.0}, {"f": [{"g": 1.0}, {}]})
    assert time_of({"header": {"stamp": {"sec": 2, "nanosec": 5}}}, 7) == 2.000000005
    assert time_of({"header": {"stamp": {"sec": 2, "nsec": 5}}}, 7) == 2.000000005
    for undated in ({}, {"header": {"stamp": {"sec": 0, "nanosec": 0}}}, {"header": {"stamp": {"sec": "2"}}}, {"header": 3}):
        assert time_of(undated, 7) == 7e-9


def test_every_type_that_we_define_is_known_with_its_parts() -> None:
    store = type_store()
    assert set(_DEFINITIONS) <= set(store.fielddefs)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="operating system: no named pipes")
@pytest.mark.parametrize("name", ["a.log", "a.csv", "a.mf4", "a.mcap", "a.db3", "a.toml"])
def test_a_pipe_that_nobody_writes_to_is_not_waited_for(name: str, tmp_path: Path) -> None:
    """In a process of its own: who waits there cannot be told to stop."""
    os.mkfifo(tmp_path / name)
    command = "plan" if name.endswith(".toml") else "replay"
    ended = subprocess.run([sys.executable, "-m", "mcdas_opt", command, str(tmp_path / name)], capture_output=True, text=True, timeout=60)
    assert ended.returncode == 2
    assert name in ended.stderr
    assert "file" in ended.stderr
