"""Live for hours: radars that flood, stall, restart and talk nonsense, on a clock of its own, full rate. Is every cycle answered?

    python -m benchmarks.live_hours [--hours 3] [--seed 1]

Two ESRs at 20 Hz tell of a car ahead and one behind, over and over, as frames of virtual buses. Now and then, for some seconds each: a
flood (10,000 frames a second of other identifiers), frames of random bytes under the radar's identifiers, frames lost, a bus that reports
errors, a radar that restarts (0.6 s of silence), a time that jumps ahead by half a second. A session that ends since both radars are silent
for a second is begun anew. Told are the counts, and the slopes of memory
as `endurance` has them.
"""

from __future__ import annotations

import argparse
import contextlib
import time
from collections import Counter
from collections.abc import Callable, Iterator

import numpy as np

from benchmarks.endurance import sample, slope
from mcdas_opt import Planner, RadarDetection, Scan, Sector, Settings, Status, Vehicle, load_sensor
from mcdas_opt.interop.esr_can import write_esr
from mcdas_opt.interop.esr_codec import EsrCodec
from mcdas_opt.interop.live.inbox import Arrival
from mcdas_opt.interop.live.loop import LiveLoop, LiveSettings
from mcdas_opt.interop.live.record import Line, LiveSummary
from mcdas_opt.interop.live.silence import SilentBusError
from mcdas_opt.simulation.sensors import mounting

_PERIOD_S, _SPEED_MPS, _ROUND = 0.05, 15.0, 400  # cycles after which the cars are where they were
_SECTORS = {"can0": Sector.FRONT, "can1": Sector.REAR}
_FAULT_SHARE, _LONGEST = 0.02, 60  # of the cycles in which one begins, and how many cycles it lasts at most
_SAMPLES = 50
_LATE_S = 5e-4  # on average: who waits for a time wakes up later


def _recording() -> list[list[Arrival]]:
    """What arrives in each cycle of a round, stamped from its beginning."""
    front = 30.0 + 10.0 * np.sin(2.0 * np.pi * np.arange(_ROUND) / _ROUND)
    scans = [
        Scan(
            sensor=f"esr-{sector.value}",
            sector=sector,
            t_s=round(k * _PERIOD_S, 6),
            mounting=mounting(sector, Vehicle()),
            radar=(RadarDetection(range_m=float(gap), azimuth_rad=0.0, range_rate_mps=0.0),),
            period_s=_PERIOD_S,
        )
        for sector in _SECTORS.values()
        for k, gap in enumerate(front)
    ]
    frames = write_esr(scans, slots=4, speeds_mps=[_SPEED_MPS] * len(scans))
    cycles: list[list[Arrival]] = [[] for _ in range(_ROUND)]
    for frame in frames:
        k = min(int(frame.t_s / _PERIOD_S + 1e-9), _ROUND - 1)
        cycles[k].append(Arrival(frame.t_s - k * _PERIOD_S, frame.channel, frame.identifier, frame.data))
    return cycles


class HostileBus:
    """An inbox on a clock of its own: waiting is what makes time pass."""

    channels = tuple(_SECTORS)

    def __init__(self, seed: int) -> None:
        self._r, self._round, self.now, self._cycle = np.random.default_rng(seed), _recording(), 0.0, 0
        self._fault: Callable[[list[Arrival]], list[Arrival]] | None = None
        self._left = 0
        self.begun: Counter[str] = Counter()

    def clock(self) -> float:
        return self.now

    def wait(self, until_s: float) -> list[Arrival]:
        start, self.now = self.now, max(self.now, until_s) + float(self._r.exponential(_LATE_S))
        here = [arrival._replace(t_s=start + arrival.t_s) for arrival in self._round[self._cycle % _ROUND]]
        self._cycle += 1
        if self._left == 0 and self._r.random() < _FAULT_SHARE:
            self._begin()
        if self._left > 0 and self._fault is not None:
            self._left -= 1
            here = self._fault(here)
        return [arrival for arrival in sorted(here) if arrival.t_s <= self.now]

    def _begin(self) -> None:
        faults = (self._flood, self._garbage, self._lose, self._fail, self._restart, self._jump)
        fault = faults[int(self._r.integers(len(faults)))]
        self.begun[fault.__name__.strip("_")] += 1
        self._fault, self._left = fault, int(self._r.integers(1, _LONGEST))
        if fault == self._restart:
            self._left = 12
        if fault == self._jump:
            self._left = 1

    def _flood(self, here: list[Arrival]) -> list[Arrival]:
        others = self._r.integers(0x100, 0x4D0, round(1e4 * _PERIOD_S))
        return here + [Arrival(self.now - _PERIOD_S, "can0", int(identifier), b"\x00" * 8) for identifier in others]

    def _garbage(self, here: list[Arrival]) -> list[Arrival]:
        return [one._replace(data=self._r.bytes(int(self._r.integers(0, 9)))) if self._r.random() < 0.2 else one for one in here]

    def _lose(self, here: list[Arrival]) -> list[Arrival]:
        return [one for one in here if self._r.random() < 0.8]

    def _fail(self, here: list[Arrival]) -> list[Arrival]:
        return [*here, Arrival(self.now - _PERIOD_S, "can1", 0, b"", "the bus failed: bus off")]

    def _restart(self, here: list[Arrival]) -> list[Arrival]:
        return [one for one in here if one.channel != "can1"]

    def _jump(self, here: list[Arrival]) -> list[Arrival]:
        self.now += 0.5
        return here


def live(cycles: int, bus: HostileBus, heard: Callable[[Line], None]) -> Iterator[LiveSummary]:
    """So many cycles of a planner on the bus; the summary of each session, which ends, and is begun anew, where both radars are silent."""
    answered = 0

    def counted(line: Line) -> None:
        nonlocal answered
        answered += 1
        heard(line)

    planner = Planner(settings=Settings(cycle_s=_PERIOD_S))
    settings, codec, sensor = LiveSettings(cycle_s=_PERIOD_S), EsrCodec(), load_sensor("delphi_esr")
    while answered < cycles:
        loop = LiveLoop(bus, _SECTORS, planner, counted, codec=codec, sensor=sensor, settings=settings, clock=bus.clock)
        with contextlib.suppress(SilentBusError):
            loop.run(cycles - answered)
        yield loop.summary


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--hours", type=float, default=3.0)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    cycles = round(3600.0 * asked.hours / _PERIOD_S)
    bus, statuses, samples = HostileBus(asked.seed), Counter[str](), []
    wrong = Counter[str]()

    def heard(line: Line) -> None:
        statuses[line.status] += 1
        if line.passed is False and line.status != Status.UNAVOIDABLE.value:
            wrong["unverified"] += 1
        if line.status == "fault":
            wrong[line.reason[:80]] += 1
        if sum(statuses.values()) % max(cycles // _SAMPLES, 1) == 0:
            samples.append(sample(sum(statuses.values())))

    began = time.perf_counter()
    summaries = list(live(cycles, bus, heard))
    took = time.perf_counter() - began
    print(f"{cycles} cycles ({bus.now / 3600.0:.2f} h) in {took:.0f} s: {sum(statuses.values())} answered, {dict(statuses)}")
    print(f"faults begun: {dict(bus.begun)}; cycles missed: {sum(one.missed_cycles for one in summaries)}")
    for one in summaries:
        print(f"  {one.cycles} cycles, unverified {one.unverified_plans}, faults {one.faults}, drops {one.to_dict()['drops']}")
    print(f"must not be: {dict(wrong) or 'nothing'}")
    table = np.array(samples)
    if len(table) >= 20:  # ten stretches after the first fifth
        for name, column in zip(("resident [KiB]", "heap [KiB]", "Python's blocks"), table[:, 1:].T, strict=True):
            mean, half = slope(table[:, 0], column)
            print(f"{name}: {column[0]:.0f} to {column[-1]:.0f}, {mean:+.3f} +- {half:.3f} per 1,000 cycles")


if __name__ == "__main__":
    main()
