"""The parking program by IPOPT (as the package does) and by fatrop (stage by stage, through CasADi): setting up, iterations, CPU seconds.

    python benchmarks/parking_solvers.py [--ratio 1.3]

The programs are those of `park`'s exchange loop for a slot, every round; `--whole` compares `park` itself with either solver.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

from mcdas_opt.parking.case_file import slot_case
from mcdas_opt.parking.cost import ParkingCosts
from mcdas_opt.parking.park import park
from mcdas_opt.parking.program import exchange as loop
from mcdas_opt.parking.program import nlp as program_module
from mcdas_opt.parking.program.exchange import ExchangeSettings
from mcdas_opt.parking.program.records import SOLVERS, ParkingPhysics, ParkingProgram, ParkingSolution
from mcdas_opt.parking.program.stages import Stages
from mcdas_opt.parking.settings import ParkSettings


def by_fatrop(
    program: ParkingProgram, physics: ParkingPhysics, costs: ParkingCosts, iterations: int
) -> tuple[float, float, ParkingSolution]:
    """(CPU seconds of setting up, of solving, solution)."""
    begin = time.process_time()
    stages = Stages(program, physics, costs, iterations)
    ready = time.process_time()
    solution = stages.solve()
    return ready - begin, time.process_time() - ready, solution


def whole(ratios: tuple[float, ...]) -> None:
    """`park` with either solver: driving, iterations, programs that the second one had to solve, CPU seconds."""
    for ratio in ratios:
        for solver in SOLVERS:
            begin = time.process_time()
            answer = park(slot_case(4.5 * ratio), settings=ParkSettings(exchange=ExchangeSettings(solver=solver)))
            driven = "none" if answer.duration_s is None else f"{answer.duration_s:.3f} s"
            print(f"{ratio:.2f} L, {solver}: {driven}, {answer.iterations} iterations, {time.process_time() - begin:.2f} s", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ratio", type=float, default=1.3)
    parser.add_argument("--rounds", type=int, default=4)
    parser.add_argument("--whole", default=None, help="slot lengths in car lengths, with commas: park itself, by either solver")
    arguments = parser.parse_args()
    if arguments.whole is not None:
        whole(tuple(float(r) for r in arguments.whole.split(",")))
        return
    met: list[tuple[Any, ...]] = []
    plain = program_module.solve_parking

    def kept(program: ParkingProgram, *rest: Any, **named: Any) -> ParkingSolution:
        begin = time.process_time()
        solution = plain(program, *rest, **named)
        met.append((program, rest, named, time.process_time() - begin, solution))
        return solution

    loop.solve_parking = kept
    park(slot_case(4.5 * arguments.ratio), settings=ParkSettings(guesses=("search",), starts=1, polish_up_to=0, left_out=0))
    for number, (program, rest, named, _, _) in enumerate(met[: arguments.rounds], start=1):
        program_module._solver.cache_clear()
        begin = time.process_time()
        plain(program, *rest, **named)
        both = time.process_time() - begin
        begin = time.process_time()
        again = plain(program, *rest, **named)
        seconds = time.process_time() - begin
        print(f"round {number}: {len(program.segments)} intervals, {len(program.checks.angles)} checks")
        print(
            f"  ipopt: set up {max(both - seconds, 0.0):.3f} s, {seconds:.3f} s, {again.iterations} iterations, "
            f"{again.duration_s:.3f} s of driving, {again.status}"
        )
        try:
            ready, seconds, found = by_fatrop(program, rest[0], rest[1], rest[2])
        except RuntimeError as error:
            print(f"  fatrop: {str(error).splitlines()[-1][:160]}")
            continue
        print(
            f"  fatrop: set up {ready:.3f} s, {seconds:.3f} s, {found.iterations} iterations, {found.duration_s:.3f} s of driving, "
            f"violation {found.violation:.1e}, {found.status}"
        )


if __name__ == "__main__":
    main()
