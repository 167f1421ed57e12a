"""Does the memory of one planner grow that drives scene after scene?

    python -m benchmarks.endurance --cycles 100000 [--scenes NAME ...] [--planner NAME]

Sensors, tracker, planner, plant and traffic, over and over with ever new noise, by one planner that is never built anew. Sampled after
every hundredth of the cycles, garbage collected: resident memory, what is taken from the C heap (glibc), and Python's allocated blocks.
The
slope after the first fifth is the mean of ten stretches' own slopes, with Student's 95 % interval: a staircase of the allocator does not
pass for precision. Stopped early, it tells of what it has.
"""

from __future__ import annotations

import argparse
import ctypes
import gc
import signal
import sys
from collections import Counter
from pathlib import Path

import numpy as np

from mcdas_opt import Planner, load_scene, simulate
from mcdas_opt.domain.rules import Array

SCENES = ("sandwich-60-40", "front-braking-with-follower", "benign-following", "curved-road", "low-friction", "cut-in")
_STRETCHES, _STUDENT = 10, 2.262  # 97.5 % of t with 9 degrees of freedom


class _Mallinfo(ctypes.Structure):
    _fields_ = [
        (name, ctypes.c_size_t)
        for name in ("arena", "ordblks", "smblks", "hblks", "hblkhd", "usmblks", "fsmblks", "uordblks", "fordblks", "keepcost")
    ]


def resident_kib() -> float:
    """Not a number where the system does not say."""
    status = Path("/proc/self/statm")
    return int(status.read_text("utf-8").split()[1]) * 4.0 if status.exists() else float("nan")


def heap_kib() -> float:
    """What is taken from glibc's heap, its own mappings included; not a number where there is no glibc, or an old one."""
    try:
        told = ctypes.CDLL(None).mallinfo2
    except (AttributeError, OSError):
        return float("nan")
    told.restype = _Mallinfo
    found = told()
    return float(found.uordblks + found.hblkhd) / 1024.0


def sample(cycles: int) -> tuple[float, float, float, float]:
    gc.collect()
    return float(cycles), resident_kib(), heap_kib(), float(sys.getallocatedblocks())


def slope(cycles: Array, values: Array) -> tuple[float, float]:
    """Per 1,000 cycles, and half the width of its 95 % interval."""
    parts = [index for index in np.array_split(np.arange(len(cycles)), _STRETCHES) if len(index) > 1]
    slopes = 1000.0 * np.array([np.polyfit(cycles[index], values[index], 1)[0] for index in parts])
    return float(slopes.mean()), float(_STUDENT * slopes.std(ddof=1) / len(slopes) ** 0.5)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cycles", type=int, default=100_000, help="at least 10,000: fewer tell no slope")
    parser.add_argument("--scenes", nargs="+", default=SCENES)
    parser.add_argument("--planner", default="mpc")
    asked = parser.parse_args()
    scenes = [load_scene(name) for name in asked.scenes]
    planner = Planner(vehicle=scenes[0].vehicle, method=asked.planner)
    ends: Counter[str] = Counter()
    samples, done, drives = [], 0, 0
    stopped = False

    def stop(*_: object) -> None:
        nonlocal stopped
        stopped = True

    for told in (signal.SIGINT, signal.SIGTERM):
        signal.signal(told, stop)
    while done < asked.cycles and not stopped:
        drive = simulate(scenes[drives % len(scenes)], planner, seed=drives)
        done, drives = done + drive.plans, drives + 1
        ends[drive.outcome.value] += 1
        ends["unverified plans"] += drive.unverified_plans
        ends["fallbacks"] += drive.fallbacks
        del drive
        if done >= (len(samples) + 1) * asked.cycles / 100:
            samples.append(sample(done))
            if len(samples) % 10 == 0:
                print("after {:.0f} cycles: {:.0f} KiB resident, {:.0f} KiB of heap, {:.0f} blocks".format(*samples[-1]), flush=True)
    print(f"{done} cycles in {drives} drives: " + ", ".join(f"{count} {kind}" for kind, count in sorted(ends.items())))
    kept = np.array(samples[len(samples) // 5 :])
    if len(kept) < 2 * _STRETCHES:
        print(f"{len(kept)} samples are too few for a slope")
        return
    for column, (name, unit) in enumerate((("resident", "KiB"), ("C heap", "KiB"), ("Python", "blocks")), start=1):
        mean, half = slope(kept[:, 0], kept[:, column])
        change = kept[-1, column] - kept[0, column]
        interval = f"[{mean - half:+.3f}, {mean + half:+.3f}]"
        print(f"{name:>9}: {mean:+.3f} {interval} {unit} per 1000 cycles; {change:+.0f} {unit} over {len(kept)} samples")


if __name__ == "__main__":
    main()
