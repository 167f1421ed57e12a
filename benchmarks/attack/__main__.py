"""The attack on every door, and what came of it, counted.

    python -m benchmarks.attack [--quick | --full] [--seed 1] [--out FILE] [NAME ...]

| attack | what is tried |
|---|---|
| constructors | every record, with anything in its fields |
| situations | absurd traffic, hosts and roads, planned for |
| sequences | traffic from cycle to cycle: vanishes, comes back, jumps, doubles, swaps names, while sectors, roads and destinations change |
| crowds | hundreds of bodies, in one place or along the road, who vanish together |
| methods | methods of others: drives of any sampling, refusals, exceptions |
| parkings | parking cases that nobody would draw, for every planner |
| planners | cars and settings that nobody would have, and plans of theirs |
| streams | cycles of hostile scans under clocks that jitter, stop, jump and run back |
| files | scenes, cars, sensors, cases, suites, recordings ... with bytes, lines, numbers and words changed |
| journals | journals cut off and damaged, their log too |
| kills | processes that write a journal, killed |
| commands | every command with wrong words, streams, locales and limits |
| interrupts | commands that are interrupted, terminated or hung up at any moment |
| studio | sessions of one server: slow ones, ones that leave in mid-solve, hostile files and wishes |
| clocks | a drive by two clocks, from 0 and from Unix time: the same decisions? 24 h |
| deadlines | plans that are due in 5 to 50 ms, beside two busy processes |
| live | radars that flood, stall and restart, 3 h on a clock of its own; by the wall's clock: `benchmarks.live_wall_clock` |

Counted are: foreign exceptions, calls that took more than 2 s of the processor's time, numbers that are not finite, plans that left as
verified and are not, records lost, and decisions that differ by the origin of the clock. Exit code 1 where there is one. Of each distinct
fault the shortest input is shown.

A campaign is counted block by block. With `--out` each block is kept there, with the commit that it ran on, and the same command goes on
where it was stopped; when all is there it prints the table. After a fault is mended, `--again` asks the blocks that found it once more.
"""

from __future__ import annotations

import argparse
import faulthandler
import logging
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

from benchmarks.attack import (
    clocks,
    commands,
    constructors,
    crowds,
    deadlines,
    files,
    interrupts,
    journals,
    kills,
    live,
    methods,
    parkings,
    planners,
    sequences,
    situations,
    streams,
    studio,
)
from benchmarks.attack.table import Block, Table
from benchmarks.attack.tally import Tally
from mcdas_opt.errors import MeasurementWarning
from mcdas_opt.evaluation.provenance import commit
from mcdas_opt.evaluation.running.journal import Journal

# how many: quick, usual, full; and how many a block
ATTACKS: dict[str, tuple[Callable[[Tally, int, int], None], tuple[int, int, int], int]] = {
    "constructors": (constructors.attack, (500, 20_000, 1_000_000), 20_000),
    "situations": (situations.attack, (60, 2_000, 100_000), 1_000),
    "sequences": (sequences.attack, (60, 2_000, 100_000), 1_000),
    "crowds": (crowds.attack, (6, 60, 1_000), 100),
    "methods": (methods.attack, (50, 1_000, 10_000), 1_000),
    "parkings": (parkings.attack, (40, 1_000, 10_000), 500),
    "planners": (planners.attack, (50, 1_000, 10_000), 1_000),
    "streams": (streams.attack, (150, 2_000, 100_000), 1_000),
    "files": (files.attack, (500, 10_000, 100_000), 5_000),
    "journals": (journals.attack, (50, 1_000, 10_000), 1_000),
    "kills": (kills.attack, (2, 50, 1_000), 50),
    "commands": (commands.attack, (4, 60, 1_000), 20),
    "interrupts": (interrupts.attack, (9, 100, 1_000), 100),
    "studio": (studio.attack, (4, 20, 200), 200),
    "clocks": (clocks.attack, (50, 1_000, 864_000), 36_000),
    "deadlines": (deadlines.attack, (40, 400, 100_000), 4_000),
    "live": (live.attack, (200, 4_000, 216_000), 36_000),
}
_NEVER_S = 3600.0  # a block without an end: say where it hangs, and end
_SEEDS = 100_000  # between those of two campaigns


def run(name: str, count: int, seed: int) -> Tally:
    """A warning that leaves is foreign too, but for those that answer measurements, and those that Python hides from users."""
    tally = Tally()
    logging.disable()  # of what parsers of others tell
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", DeprecationWarning)  # matplotlib 3.9 meets pyparsing 3.3
            warnings.simplefilter("ignore", MeasurementWarning)
            ATTACKS[name][0](tally, count, seed)
    except Exception as error:  # of a case that could not even be made: the block ends there
        tally.tried += 1
        tally.fault(error, f"seed {seed}, after {tally.tried} cases")
    finally:
        logging.disable(logging.NOTSET)
    return tally


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    size = parser.add_mutually_exclusive_group()
    size.add_argument("--quick", action="store_const", dest="size", const=0, default=1, help="some seconds")
    size.add_argument("--full", action="store_const", dest="size", const=2, help="some hours")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, help="cases of each attack, instead of --quick or --full")
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(ATTACKS))
    parser.add_argument(
        "--again", action="store_true", help="blocks of FILE that found something are asked again, on the code as it is now"
    )
    parser.add_argument("--out", type=Path, metavar="FILE", help="where the blocks are kept")
    asked = parser.parse_args()
    unknown = [name for name in asked.names if name not in ATTACKS]
    if unknown:
        parser.error(f"no such attack: {', '.join(unknown)}; known: {', '.join(ATTACKS)}")
    with tempfile.TemporaryDirectory() as folder, Journal(asked.out or Path(folder) / "blocks") as kept:
        table = Table(list(asked.names or ATTACKS), map(Block.of, kept.records), {name: ATTACKS[name][1][2] for name in ATTACKS})
        for block in [block for name in table.names for block in table.of(name) if asked.again and block.tally.wrong]:
            again = one_block(block.attack, block.tally.tried, block.seed)
            kept.append(again.to_dict())
            table.add(again)
        print(table.heading, flush=True)
        for name in table.names:
            _, counts, per_block = ATTACKS[name]
            count = asked.count or counts[asked.size]
            for block in blocks(name, count, per_block, asked.seed * _SEEDS, table):
                kept.append(block.to_dict())
                table.add(block)
                if asked.out:
                    print(table.row(name), file=sys.stderr, flush=True)
            print(table.row(name), flush=True)
    print(table.closing)
    return 1 if table.wrong else 0


def blocks(name: str, count: int, per_block: int, seed: int, table: Table) -> Iterator[Block]:
    """Those that `count` cases still lack."""
    while (left := count - table.tried(name)) > 0:
        yield one_block(name, min(left, per_block), table.free_seed(name, seed))


def one_block(name: str, count: int, seed: int) -> Block:
    began = time.perf_counter()
    faulthandler.dump_traceback_later(_NEVER_S, exit=True)
    tally = run(name, count, seed)
    faulthandler.cancel_dump_traceback_later()
    return Block(attack=name, seed=seed, took_s=time.perf_counter() - began, commit=commit(), tally=tally)


if __name__ == "__main__":
    sys.exit(main())
