"""`live` by the clock on the wall: virtual buses, radars that another thread plays, everything hostile. Who is answered?

    python -m benchmarks.live_wall_clock [--minutes 60] [--seed 1]

The frames and faults are those of `live_hours`, sent when they are due (its jump of time is a stall here: half a second without a frame).
Beside them, for some seconds each: a bus whose reads fail (bus off), stamps an hour ahead or behind (a clock that was set), a reader of the
lines who takes a fifth of a second for each. A session that ends since all radars are silent is counted, and begun anew. Told are the
counts, and the slopes of memory, threads and descriptors after the first fifth.
"""

from __future__ import annotations

import argparse
import os
import threading
import time
from collections import Counter
from unittest import mock

import can
import numpy as np

from benchmarks.endurance import resident_kib, slope
from benchmarks.live_hours import HostileBus
from mcdas_opt.domain.vocabulary import Status
from mcdas_opt.errors import InputError
from mcdas_opt.interop.live import session
from mcdas_opt.interop.live.inbox import open_bus
from mcdas_opt.interop.live.loop import LiveSettings
from mcdas_opt.interop.live.record import FAULT, LATE, Line, LiveSummary

_PERIOD_S, _FAULT_SHARE, _LONGEST_S = 0.05, 0.01, 3.0
_STEPS_S = (3600.0, -3600.0, 2.0, -2.0)  # of a clock that is set
_SLOW_S = 0.2  # what a reader takes for a line
_SAMPLE_S = 20.0


class _Trouble:
    """What goes wrong beside the frames, and since when; asked and set by several threads."""

    def __init__(self, seed: int) -> None:
        self._r, self._until_s, self.kind, self.step_s = np.random.default_rng(seed), 0.0, "", 0.0
        self.begun: Counter[str] = Counter()

    def look(self) -> None:
        """Once a cycle."""
        now = time.monotonic()
        if now > self._until_s:
            self.kind = ""
            if self._r.random() < _FAULT_SHARE:
                self.kind = ("bus off", "clock set", "slow reader")[int(self._r.integers(3))]
                self.step_s = _STEPS_S[int(self._r.integers(len(_STEPS_S)))]
                self._until_s = now + float(self._r.uniform(0.1, _LONGEST_S))
                self.begun[self.kind] += 1


class _Bus:
    """A virtual bus; the rear one's reads fail while it is off."""

    def __init__(self, channel: str, trouble: _Trouble) -> None:
        self._bus, self._trouble, self._fails = open_bus(channel, session.VIRTUAL), trouble, channel == "can1"

    def recv(self, timeout_s: float) -> can.Message | None:
        if self._fails and self._trouble.kind == "bus off":
            raise can.CanOperationError("bus off")
        message: can.Message | None = self._bus.recv(timeout_s)
        return message

    def shutdown(self) -> None:
        self._bus.shutdown()


def _play(ended: threading.Event, hostile: HostileBus, trouble: _Trouble, sent: Counter[str]) -> None:
    """Each frame when it is due, by the clock on the wall."""
    buses = {name: can.Bus(channel=name, interface=session.VIRTUAL, preserve_timestamps=True) for name in hostile.channels}
    began = time.monotonic() - hostile.now
    while not ended.is_set():
        trouble.look()
        behind_s = time.monotonic() - began - hostile.now
        if behind_s > 1.0:  # a sender that was not given the processor does not catch up
            began += behind_s
            sent["late by over 1 s"] += 1
        for arrival in hostile.wait(hostile.now + _PERIOD_S):
            time.sleep(max(began + arrival.t_s - time.monotonic(), 0.0))
            stamp_s = time.time() + (trouble.step_s if trouble.kind == "clock set" else 0.0)
            message = can.Message(
                timestamp=stamp_s,
                arbitration_id=arrival.identifier,
                data=arrival.data,
                is_extended_id=False,
                is_error_frame=bool(arrival.fault),
            )
            buses[arrival.channel].send(message)
            sent["frames"] += 1
        time.sleep(max(began + hostile.now - time.monotonic(), 0.0))
    for bus in buses.values():
        bus.shutdown()


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    hostile, trouble, ended = HostileBus(asked.seed), _Trouble(asked.seed), threading.Event()
    counts, wrong, sent, samples = Counter[str](), Counter[str](), Counter[str](), list[tuple[float, ...]]()
    summaries = list[LiveSummary]()
    began = time.monotonic()

    def heard(line: Line) -> None:
        counts[line.status] += 1
        if line.passed is False and line.status != Status.UNAVOIDABLE.value:
            wrong["unverified"] += 1
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

    sender = threading.Thread(target=_play, args=(ended, hostile, trouble, sent), daemon=True)
    sender.start()
    with mock.patch.object(session, "open_bus", lambda channel, _: _Bus(channel, trouble)):
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
    sender.join()
    _tell(summaries, counts, sent, hostile.begun + trouble.begun, wrong, samples)


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
    for one in summaries:
        print(f"  missed {one.missed_cycles}, late {one.late_cycles}, faults {one.faults}, drops {one.to_dict()['drops']}, {one.cycle_ms}")
    print(f"must not be: {dict(wrong) or 'nothing'}")
    kept = np.array(samples[len(samples) // 5 :])
    if len(kept) >= 20:
        for name, column in zip(("resident [KiB]", "threads", "descriptors"), kept[:, 1:].T, strict=True):
            mean, half = slope(kept[:, 0], column)
            print(f"{name}: {column[0]:.0f} to {column[-1]:.0f}, {mean:+.3f} +- {half:.3f} per 1,000 lines")


if __name__ == "__main__":
    main()
