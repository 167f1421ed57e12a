"""The attack on every door, and what came of it, counted.

    python -m benchmarks.attack [--quick | --full] [--seed 1] [NAME ...]

| attack | what is tried |
|---|---|
| constructors | every record, with anything in its fields |
| situations | absurd traffic, hosts and roads, planned for |
| streams | cycles of hostile scans under clocks that jitter, stop, jump and run back |
| files | scenes, cars, sensors, cases, suites, recordings ... with bytes, lines, numbers and words changed |
| journals | journals cut off and damaged, their log too |
| kills | processes that write a journal, killed |
| commands | every command with wrong words, streams and locales |

Counted are: foreign exceptions, calls that took more than 2 s of the processor's time, numbers that are not finite, plans that left as
verified and are not, and records lost. Exit code 1 where there is one. Of each distinct fault the shortest input is shown.
"""

from __future__ import annotations

import argparse
import faulthandler
import logging
import sys
import time
import warnings
from collections.abc import Callable

from benchmarks.attack import commands, constructors, files, journals, kills, situations, streams
from benchmarks.attack.tally import Tally

# how many: quick, usual, full
ATTACKS: dict[str, tuple[Callable[[Tally, int, int], None], tuple[int, int, int]]] = {
    "constructors": (constructors.attack, (500, 20_000, 1_000_000)),
    "situations": (situations.attack, (60, 2_000, 100_000)),
    "streams": (streams.attack, (150, 2_000, 100_000)),
    "files": (files.attack, (500, 10_000, 100_000)),
    "journals": (journals.attack, (50, 1_000, 10_000)),
    "kills": (kills.attack, (2, 50, 1_000)),
    "commands": (commands.attack, (4, 60, 1_000)),
}
_NEVER_S = 600.0  # without an answer: say where it hangs, and end
_COLUMNS = ("tried", "answered", "refused", "foreign", "hangs", "non_finite", "unverified", "lost")


def run(name: str, count: int, seed: int) -> Tally:
    """A warning that leaves is foreign too."""
    tally = Tally()
    logging.disable()  # of what parsers of others tell
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ATTACKS[name][0](tally, count, seed)
    return tally


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    size = parser.add_mutually_exclusive_group()
    size.add_argument("--quick", action="store_const", dest="size", const=0, default=1, help="some seconds")
    size.add_argument("--full", action="store_const", dest="size", const=2, help="some hours")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, help="cases of each attack, instead of --quick or --full")
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(ATTACKS))
    asked = parser.parse_args()
    unknown = [name for name in asked.names if name not in ATTACKS]
    if unknown:
        parser.error(f"no such attack: {', '.join(unknown)}; known: {', '.join(ATTACKS)}")
    print(f"{'attack':13s}" + "".join(f"{column:>12s}" for column in _COLUMNS) + f"{'worst [s]':>12s}{'took [s]':>10s}", flush=True)
    wrong, faults = 0, list[tuple[str, str, str]]()
    for name in asked.names or ATTACKS:
        began = time.perf_counter()
        faulthandler.dump_traceback_later(_NEVER_S * (1 + 100 * (asked.size == 2)), exit=True)
        tally = run(name, asked.count or ATTACKS[name][1][asked.size], asked.seed)
        counts = "".join(f"{getattr(tally, column):12d}" for column in _COLUMNS)
        print(f"{name:13s}{counts}{tally.worst_s:12.2f}{time.perf_counter() - began:10.1f}", flush=True)
        wrong += tally.wrong
        faults += [(name, fault, shown) for fault, shown in sorted(tally.faults.items())]
    faulthandler.cancel_dump_traceback_later()
    for name, fault, shown in faults:
        print(f"{name}: {fault}\n    {shown}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
