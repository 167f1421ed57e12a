"""How the processor time of a plan grows with the number of tracks around the host, and with the length of the road.

    python benchmarks/growth.py [--tracks 2 4 8 16 32 64] [--knots 10 100 1000 10000] [--drives 6] [--cycles 10] [--seed 1] [--quick]

Five lanes, the host in the middle one. Everybody stands about evenly around it: first the next ahead, behind, to the left and to the right,
then the nearest, so that more tracks are the same traffic and others farther away. `even` drives within 1.5 m/s of the host, `closing` is
up to 6 m/s slower ahead and faster behind. Each drive is planned cycle by cycle, the host along its own plan, the others at constant speed.
Times are processor time of the thread, of every plan, the first of a planner left out; `bodies` is the median number of those who can
matter within the horizon. Read the ratios: they are what should stay small.

The road is told by so many knots of its curvature, and of the widths of three lanes, 50 m apart; four tracks drive there, evenly.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, replace

import numpy as np

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.lane import Lane
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.domain.vocabulary import Status
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.lane_problem.lane_mpc_solver import LaneMpcSolver
from mcdas_opt.planning.planner import Planner

KINDS = ("even", "closing")
SPEED_MPS, GAP_M, CYCLE_S = 25.0, 28.0, 0.1
KNOWN = np.diag([0.2, 0.2, 0.1, 0.1]) ** 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """Processor times of plans [ms], bodies in the optimiser, and how many plans were `planned`."""

    times_ms: tuple[float, ...]
    bodies: float
    planned: int

    def percentile(self, share: float) -> float:
        return float(np.percentile(self.times_ms, share))


def traffic(kind: str, tracks: int, random: np.random.Generator) -> Situation:
    """The host and the `tracks` nearest of everybody."""
    road = Road(lanes_left=2, lanes_right=2)
    everybody: list[tuple[float, Track]] = []
    for lane in range(-2, 3):
        shift = float(random.uniform(0.0, GAP_M)) if lane else 0.0
        for k in range(-10, 11):
            ahead = shift + GAP_M * k + float(random.normal(0.0, 3.0))
            slower = (
                float(random.uniform(-1.5, 1.5)) if kind == "even" else float(random.uniform(0.0, 6.0)) * (1.0 if ahead > 0.0 else -1.0)
            )
            if lane == 0 and k == 0:
                continue
            if lane and abs(ahead) < 7.0:
                slower = 0.0
            track = Track(id=f"{lane}/{k}", s_m=ahead, d_m=lane * road.lane_width_m, speed_s_mps=SPEED_MPS - slower, covariance=KNOWN)
            everybody.append((abs(ahead), track))
    nearest = [track for _, track in sorted(everybody, key=lambda one: one[0])]
    lanes = (
        lambda t: t.d_m == 0.0 and t.s_m > 0.0,
        lambda t: t.d_m == 0.0 and t.s_m < 0.0,
        lambda t: t.d_m == 3.7,
        lambda t: t.d_m == -3.7,
    )
    first = [next(track for track in nearest if holds(track)) for holds in lanes]
    others = [track for track in nearest if track not in first]
    return Situation(host=HostState(speed_mps=SPEED_MPS), coverage=Coverage(), tracks=tuple([*first, *others][:tracks]), road=road)


def long_road(knots: int) -> Road:
    """The traffic's, with bends and with lanes that are a little wider here and narrower there."""
    places = [50.0 * (k - 5) for k in range(knots)]
    widths = [tuple((s, 3.7 + 0.1 * ((k + lane) % 2)) for k, s in enumerate(places)) for lane in range(3)]
    lanes = tuple(Lane(lane=lane - 1, width_m=width) for lane, width in enumerate(widths))
    return Road(lanes_left=2, lanes_right=2, lanes=lanes, curvature=tuple((s, 0.0005 * (k % 2)) for k, s in enumerate(places)))


def later(situation: Situation, plan: Plan) -> Situation:
    """One cycle on: the host along its plan, the others at constant speed."""
    drive = plan.trajectory
    s, d, psi, v, a, delta = (float(np.interp(CYCLE_S, drive.t_s, column)) for column in drive.table[1:7])
    host = HostState(s_m=s, d_m=d, heading_rad=psi, speed_mps=max(v, 0.0), acceleration_mps2=a, steering_rad=delta)
    tracks = tuple(replace(track, s_m=track.s_m + CYCLE_S * track.speed_s_mps) for track in situation.tracks)
    return replace(situation, time_s=situation.time_s + CYCLE_S, host=host, tracks=tracks)


def row(kind: str, tracks: int, drives: int, cycles: int, seed: int, road: Road | None = None) -> Row:
    planner, times, statuses, bodies = Planner(), [], [], []
    solver = LaneMpcSolver(planner.vehicle, planner.settings)
    for number in range(drives):
        planner.reset()
        situation = traffic(kind, tracks, np.random.default_rng([seed, number]))
        situation = situation if road is None else replace(situation, road=road)
        for _ in range(cycles):
            started = time.thread_time()
            plan = planner.plan(situation)
            times.append(1e3 * (time.thread_time() - started))
            statuses.append(plan.status)
            bodies.append(len(solver.who_matters(Cycle.of(situation, planner.vehicle))))
            situation = later(situation, plan)
    return Row(times_ms=tuple(times[1:]), bodies=float(np.median(bodies)), planned=statuses.count(Status.PLANNED))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tracks", type=int, nargs="+", default=[2, 4, 8, 16, 32, 64])
    parser.add_argument("--knots", type=int, nargs="+", default=[10, 100, 1000, 10000])
    parser.add_argument("--drives", type=int, default=6)
    parser.add_argument("--cycles", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--quick", action="store_true", help="two drives of five cycles")
    arguments = parser.parse_args()
    drives, cycles = (2, 5) if arguments.quick else (arguments.drives, arguments.cycles)
    asked = drives, cycles, arguments.seed
    for kind in KINDS:
        rows = [(tracks, row(kind, tracks, *asked)) for tracks in arguments.tracks]
        tell(f"{kind} traffic", "tracks", rows, 4)
    tell("a longer road", "knots", [(knots, row("even", 4, *asked, long_road(knots))) for knots in arguments.knots], usual=10)


def tell(what: str, grows: str, rows: list[tuple[int, Row]], usual: int) -> None:
    """A table of them, with ratios to the row of `usual`, or to the first one."""
    of, base = next((row for row in rows if row[0] == usual), rows[0])
    print(f"\n{what}\n\n| {grows} | bodies | p50 [ms] | p99 [ms] | p50 over that of {of} | planned |\n|" + "---|" * 6)
    for number, one in rows:
        half, most = one.percentile(50.0), one.percentile(99.0)
        ratio = half / base.percentile(50.0)
        print(f"| {number} | {one.bodies:.0f} | {half:.1f} | {most:.1f} | {ratio:.2f} | {one.planned}/{len(one.times_ms) + 1} |")


if __name__ == "__main__":
    main()
