"""`live` by the clock on the wall: buses that another process plays, everything hostile. Who is answered?

    python -m benchmarks.live_wall_clock [--minutes 60] [--seed 1]

The frames and faults are those of `live_hours`, sent when they are due through Unix datagram sockets, which lose what nobody reads as a
CAN socket does (its jump of time is a stall here: half a second without a frame). Beside them, for some seconds each: stamps an hour or
seconds ahead or behind (a clock that was set), a bus whose reads fail (bus off), a reader of the lines who takes a fifth of a second for
each. A session that ends since all radars are silent is counted, and begun anew. Told are the counts, and the slopes of memory, threads
and descriptors after the first fifth.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import socket
import struct
import threading
import time
from collections import Counter
from multiprocessing.connection import Connection
from multiprocessing.synchronize import Event
from unittest import mock

import can
import numpy as np

from benchmarks.endurance import resident_kib, slope
from benchmarks.live_hours import HostileBus
from mcdas_opt.domain.vocabulary import Status
from mcdas_opt.errors import InputError
from mcdas_opt.interop.live import session
from mcdas_opt.interop.live.loop import LiveSettings
from mcdas_opt.interop.live.record import FAULT, LATE, Line, LiveSummary

_PERIOD_S, _FAULT_SHARE, _LONGEST_S = 0.05, 0.01, 3.0
_STEPS_S = (3600.0, -3600.0, 2.0, -2.0)  # of a clock that is set
_SLOW_S = 0.2  # what a reader takes for a line
_SAMPLE_S = 20.0
_FRAME = struct.Struct("=dIB?8s")  # stamp [s], identifier, length, whether an error frame, data


class _Trouble:
    """What goes wrong beside the frames, and since when."""

    def __init__(self, seed: int, kinds: tuple[str, ...]) -> None:
        self._r, self._until_s, self._kinds, self.kind, self.step_s = np.random.default_rng(seed), 0.0, kinds, "", 0.0
        self.begun: Counter[str] = Counter()

    def look(self) -> None:
        """Once a cycle."""
        now = time.monotonic()
        if now > self._until_s:
            self.kind = ""
            if self._r.random() < _FAULT_SHARE:
                self.kind = self._kinds[int(self._r.integers(len(self._kinds)))]
                self.step_s = _STEPS_S[int(self._r.integers(len(_STEPS_S)))]
                self._until_s = now + float(self._r.uniform(0.1, _LONGEST_S))
                self.begun[self.kind] += 1


class _Bus:
    """A bus as python-can has them, of frames from a socket; the rear one's reads fail while it is off."""

    def __init__(self, reads: socket.socket, trouble: _Trouble, *, fails: bool) -> None:
        self._reads, self._trouble, self._fails = reads, trouble, fails

    def recv(self, timeout_s: float) -> can.Message | None:
        if self._fails and self._trouble.kind == "bus off":
            raise can.CanOperationError("bus off")
        self._reads.settimeout(timeout_s)
        try:
            stamp_s, identifier, length, is_error, data = _FRAME.unpack(self._reads.recv(_FRAME.size))
        except TimeoutError:
            return None
        return can.Message(
            timestamp=stamp_s, arbitration_id=identifier, data=data[:length], is_extended_id=False, is_error_frame=is_error, check=False
        )

    def shutdown(self) -> None:
        """The next session reads on."""


def _play(ended: Event, seed: int, sends: dict[str, socket.socket], told: Connection) -> None:
    """Each frame when it is due, by the clock on the wall; what came of it is told at the end."""
    hostile, trouble, sent = HostileBus(seed), _Trouble(seed, ("clock set",)), Counter[str]()
    began = time.monotonic()
    while not ended.is_set():
        trouble.look()
        behind_s = time.monotonic() - began - hostile.now
        if behind_s > 1.0:  # a sender that was not given the processor does not catch up
            began += behind_s
            sent["times the sender was over 1 s behind"] += 1
        for arrival in hostile.wait(hostile.now + _PERIOD_S):
            if (early_s := began + arrival.t_s - time.monotonic()) > 1e-3:
                time.sleep(early_s)
            stamp_s = time.time() + (trouble.step_s if trouble.kind == "clock set" else 0.0)
            frame = _FRAME.pack(stamp_s, arrival.identifier, len(arrival.data), bool(arrival.fault), arrival.data)
            sent["frames"] += 1
            try:
                sends[arrival.channel].send(frame)
            except BlockingIOError:
                sent["frames that nobody had read"] += 1
        time.sleep(max(began + hostile.now - time.monotonic(), 0.0))
    told.send((sent, hostile.begun + trouble.begun))


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    trouble = _Trouble(asked.seed, ("bus off", "slow reader"))
    counts, wrong, samples = Counter[str](), Counter[str](), list[tuple[float, ...]]()
    summaries = list[LiveSummary]()
    began = time.monotonic()

    def heard(line: Line) -> None:
        trouble.look()
        counts[line.status] += 1
        if line.passed is False and line.status not in (Status.UNAVOIDABLE.value, LATE):  # who is late holds the plan before
            wrong[f"unverified, {line.status}"] += 1
        if line.status == FAULT:
            wrong[line.reason[:80]] += 1
        if line.status != LATE and trouble.kind == "slow reader":
            time.sleep(_SLOW_S)
        if time.monotonic() - began > (len(samples) + 1) * _SAMPLE_S:
            samples.append(
                (float(sum(counts.values())), resident_kib(), float(threading.active_count()), float(len(os.listdir("/proc/self/fd"))))
            )
            if len(samples) % 15 == 0:
                print(f"{(time.monotonic() - began) / 60.0:.0f} min: {dict(counts)}, {samples[-1][1]:.0f} KiB", flush=True)

    pairs = {name: socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM) for name in HostileBus.channels}
    for sends, _ in pairs.values():
        sends.setblocking(False)
    buses = {name: _Bus(reads, trouble, fails=name == "can1") for name, (_, reads) in pairs.items()}
    ended, (hears, tells) = multiprocessing.Event(), multiprocessing.Pipe(duplex=False)
    sender = multiprocessing.Process(
        target=_play, args=(ended, asked.seed, {name: pair[0] for name, pair in pairs.items()}, tells), daemon=True
    )
    sender.start()
    with mock.patch.object(session, "open_bus", lambda channel, _: buses[channel]):
        while (left_s := 60.0 * asked.minutes - (time.monotonic() - began)) > _PERIOD_S:
            try:
                session.live(
                    heard,
                    bus="can0",
                    rear="can1",
                    interface=session.VIRTUAL,
                    settings=LiveSettings(cycle_s=_PERIOD_S),
                    cycles=max(int(left_s / _PERIOD_S), 1),
                    ended=summaries.append,
                )
            except InputError as error:
                counts["ended"] += 1
                print(f"ended: {error}", flush=True)
    ended.set()
    sent, begun = hears.recv()
    sender.join()
    _tell(summaries, counts, sent, begun + trouble.begun, wrong, samples)


def _tell(
    summaries: list[LiveSummary],
    counts: Counter[str],
    sent: Counter[str],
    begun: Counter[str],
    wrong: Counter[str],
    samples: list[tuple[float, ...]],
) -> None:
    cycles, duration_s = (sum(getattr(one, name) for one in summaries) for name in ("cycles", "duration_s"))
    print(f"{cycles} cycles in {duration_s:.0f} s, {len(summaries)} sessions; lines {dict(counts)}; sent {dict(sent)}")
    print(f"faults begun: {dict(begun)}")
    wrong["unverified plans"] += sum(one.unverified_plans for one in summaries)
    for one in summaries:
        ends = f"missed {one.missed_cycles}, late {one.late_cycles}, unverified {one.unverified_plans}, faults {one.faults}"
        print(f"  {ends}, drops {one.to_dict()['drops']}, {one.cycle_ms}")
    print(f"must not be: {dict(+wrong) or 'nothing'}")
    kept = np.array(samples[len(samples) // 5 :])
    if len(kept) >= 20:
        for name, column in zip(("resident [KiB]", "threads", "descriptors"), kept[:, 1:].T, strict=True):
            mean, half = slope(kept[:, 0], column)
            print(f"{name}: {column[0]:.0f} to {column[-1]:.0f}, {mean:+.3f} +- {half:.3f} per 1,000 lines")


if __name__ == "__main__":
    main()
