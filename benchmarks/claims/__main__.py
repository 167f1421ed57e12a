"""What the pages claim, and whether it still holds.

    python -m benchmarks.claims                        # every claim, its goal, what was measured last, and whether that is old
    python -m benchmarks.claims run quick              # measures the quick ones (some minutes); exit 1 where one is broken
    python -m benchmarks.claims run full --write       # measures the long ones (an hour or two) and keeps each as it is measured
    python -m benchmarks.claims run full --write --old # goes on where that was stopped: only those that are old
    python -m benchmarks.claims run sandwich-lost slot-110-driving

A claim is old when the planner, the judge, the simulation or their data have changed since it was measured.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from benchmarks.claims.book import SIZES, Entry, claims, entry, records
from benchmarks.claims.measuring import Measuring, NotMeasuredError, write
from mcdas_opt.errors import McdasError


def main(arguments: list[str] | None = None) -> int:
    """0: kept, 1: broken or not measured, 2: bad input, 130: stopped."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.claims", description=(__doc__ or "").splitlines()[0])
    commands = parser.add_subparsers(dest="command")
    commands.add_parser("list", help="what is claimed, and what was measured last")
    running = commands.add_parser("run", help="measure")
    running.add_argument("which", metavar="quick|full|NAME", nargs="+")
    running.add_argument("--write", action="store_true", help="keep what was measured as the record, each as soon as it is there")
    running.add_argument("--old", action="store_true", help="leave out what was measured on this planner")
    options = parser.parse_args(arguments)
    try:
        return run(options.which, keep=options.write, only_old=options.old) if options.command == "run" else show()
    except McdasError as error:
        print(error, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("stopped; what was measured before is kept where --write was given", file=sys.stderr)
        return 130


def show() -> int:
    found = [Entry(claim=claim, record=records().get(name)) for name, claim in claims().items()]
    for one in found:
        state = "not measured" if one.record is None else "fresh" if one.is_fresh else "old"
        print(f"{one.claim.name:32} {one.claim.size:5}  {one.shown:34} goal {one.claim.goal!s:14} {state}")
    measured = sum(one.record is not None for one in found)
    fresh = sum(one.is_fresh for one in found)
    sizes = ", ".join(f"{sum(one.claim.size == size for one in found)} {size}" for size in SIZES)
    print(f"{len(found)} claims ({sizes}), {measured} measured, {fresh} of them on this planner")
    return 0


def _names(which: Sequence[str]) -> list[str]:
    """Of the claims asked for, in the files' order. Raises `ParameterError` for a name that is none."""
    wanted = {entry(name).claim.name for name in which if name not in SIZES}
    return [name for name, claim in claims().items() if name in wanted or claim.size in which]


def run(which: Sequence[str], *, keep: bool, only_old: bool = False) -> int:
    found = [entry(name) for name in _names(which)]
    chosen = [one.claim for one in found if not (only_old and one.is_fresh)]
    measuring, broken = Measuring(), 0
    for claim in chosen:
        try:
            record = measuring.record(claim)
        except NotMeasuredError as error:
            print(f"NOT MEASURED  {claim.name}: {error}", flush=True)
            broken += 1
            continue
        holds = claim.goal.kept_by(record.value)
        broken += not holds
        said = Entry(claim=claim, record=record).shown
        print(f"{'kept' if holds else 'BROKEN':12}  {claim.name}: {said} (goal {claim.goal})", flush=True)
        if keep:
            write(records() | {claim.name: record})
    print(f"{len(chosen) - broken} of {len(chosen)} kept")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
