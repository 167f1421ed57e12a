"""What the pages claim, and whether it still holds.

    python -m benchmarks.claims                        # every claim, its goal, what was measured last, and whether that is old
    python -m benchmarks.claims run quick              # measures the quick ones (some minutes); exit 1 where one is broken
    python -m benchmarks.claims run full --write       # measures the long ones (hours) and keeps what it measured
    python -m benchmarks.claims run sandwich-lost      # one of them

A claim is old when the planner, the judge, the simulation or their data have changed since it was measured.
"""

from __future__ import annotations

import argparse
import sys

from benchmarks.claims.book import SIZES, Entry, claims, entry, records
from benchmarks.claims.measuring import Measuring, NotMeasuredError, write
from mcdas_opt.errors import McdasError


def main(arguments: list[str] | None = None) -> int:
    """0: kept, 1: broken or not measured, 2: bad input."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.claims", description=(__doc__ or "").splitlines()[0])
    commands = parser.add_subparsers(dest="command")
    commands.add_parser("list", help="what is claimed, and what was measured last")
    running = commands.add_parser("run", help="measure")
    running.add_argument("which", metavar="quick|full|NAME")
    running.add_argument("--write", action="store_true", help="keep what was measured as the record")
    options = parser.parse_args(arguments)
    try:
        return run(options.which, keep=options.write) if options.command == "run" else show()
    except McdasError as error:
        print(error, file=sys.stderr)
        return 2


def show() -> int:
    found = [Entry(claim=claim, record=records().get(name)) for name, claim in claims().items()]
    for one in found:
        state = "not measured" if one.record is None else "old" if one.record.is_old else "fresh"
        print(f"{one.claim.name:32} {one.claim.size:5}  {one.shown:34} goal {one.claim.goal!s:14} {state}")
    measured = [one for one in found if one.record is not None]
    fresh = sum(not one.record.is_old for one in measured if one.record is not None)
    sizes = ", ".join(f"{sum(one.claim.size == size for one in found)} {size}" for size in SIZES)
    print(f"{len(found)} claims ({sizes}), {len(measured)} measured, {fresh} of them on this planner")
    return 0


def run(which: str, *, keep: bool) -> int:
    chosen = [one for one in claims().values() if one.size == which] if which in SIZES else [entry(which).claim]
    measuring, kept, broken = Measuring(), records(), 0
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
        kept[claim.name] = record
    if keep:
        write(kept)
    print(f"{len(chosen) - broken} of {len(chosen)} kept")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
