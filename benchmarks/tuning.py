"""What the tuner must show. Each part prints its table; `--out DIR` gets the figures.

    python benchmarks/tuning.py grid          # the NLP against 10^6 grid points, and TPE, CMA-ES, DE, random at equal evaluations
    python benchmarks/tuning.py table         # the paper's parameters against tuned ones, 30 to 120 km/h, offsets -2 to 2 m
    python benchmarks/tuning.py schedule      # writes models/tuned/sedan.toml anew, and draws it
    python benchmarks/tuning.py gradient      # tuning along the gradient through the MPC against random search
    python benchmarks/tuning.py costs         # microseconds of a tuned path, seconds of a design

Traffic is the benchmark's: mcdas-opt benchmark sandwich --seed 303 --planners closed-form,closed-form-corrected,closed-form-tuned,mpc
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.lane_situations import evasion
from mcdas_opt.catalogue.designs import load_schedule
from mcdas_opt.domain.gain_schedule import GainSchedule
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.settings import PredictionSettings
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.ocp.sensitivities import PlanSensitivity
from mcdas_opt.plotting.style import BLUE, GREEN, GREY, LITERAL, ORANGE, SKY, VERMILION, figure, save_png, styled
from mcdas_opt.reference.literal import A_PER_M, SETTLING_X_M, B
from mcdas_opt.reference.tuned_path import tuned_path
from mcdas_opt.tracking.prediction import predict
from mcdas_opt.tuning.design import design
from mcdas_opt.tuning.gradient import MeanMerit, at_random, by_gradient, posed_plan
from mcdas_opt.tuning.request import DesignRequest
from mcdas_opt.tuning.schedule import build_schedule, schedule_text
from mcdas_opt.tuning.searchers import search

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KM_H = (30, 40, 60, 80, 100, 120)
OFFSETS_M = (-2.0, -1.0, 0.0, 1.0, 2.0)
SHARES = np.linspace(0.0, 1.0, 48)
_COLOURS = (SKY, BLUE, GREEN, ORANGE, VERMILION)
_MARKS = ("o", "s", "^", "D", "v")


def lengths(a: Array, b: Array, reach: Array, request: DesignRequest) -> Array:
    """Length of each sigmoid [m], infinite where it breaks a limit: the design's constraints written anew, for a whole grid at once."""
    v, car, lane = request.speed_mps, request.vehicle, request.lane_width_m
    start, gain = 1.0 / (1.0 + b), reach * (b + 1.0) / (b - 1.0)
    bound = min(request.lateral_acceleration_mps2, 0.97 * request.friction * GRAVITY_MPS2)
    kept = v**2 * gain * a**2 / (6.0 * np.sqrt(3.0)) <= bound
    kept &= v**3 * gain * -(a**3) / 8.0 <= request.lateral_jerk_mps3
    kept &= np.arctan(-gain * a * b / (1.0 + b) ** 2) <= request.heading_jump_rad
    kept &= np.abs(reach - lane) <= request.settling_m
    rate = np.zeros_like(a)
    for share in SHARES:
        shape = start + (0.5 - start) * share
        q = shape * (1.0 - shape)
        first, second, third = -gain * a * q, gain * a**2 * q * (1.0 - 2.0 * shape), -gain * a**3 * q * (1.0 - 6.0 * q)
        bent = 1.0 + first**2
        kappa, change = second / bent**1.5, (third * bent - 3.0 * first * second**2) / bent**2.5
        kept &= kappa <= request.curvature_1pm
        rate = np.maximum(rate, np.abs(v * car.wheelbase_m * change / (1.0 + (car.wheelbase_m * kappa) ** 2)))
    kept &= rate <= car.steering_rate_max_radps
    at = start + (lane - 0.1) / reach * (1.0 - 2.0 * start)
    return np.where(kept, np.log((1.0 - at) / (at * b)) / a, np.inf)


A_RANGE, B_RANGE = (0.05, 0.8), (4.0, 250.0)


def grid() -> None:
    """10^6 points: 200 of a, 200 of b (both by logarithm), 25 of y_max."""
    print("speed   NLP length      time    evals | grid length    time  cell  | best of ... at as many evaluations, then at 300 [m]")
    for km_h in KM_H:
        request = DesignRequest(speed_mps=km_h / 3.6)
        design(request)
        started = time.perf_counter()
        found = design(request)
        nlp_s = time.perf_counter() - started
        a, b = np.geomspace(*A_RANGE, 200), np.geomspace(*B_RANGE, 200)
        reach = 3.7 + request.settling_m * np.linspace(-1.0, 1.0, 25)
        started = time.perf_counter()
        best = min(float(lengths(-a[:, None], b[None, :], np.full((1, 1), y), request).min()) for y in reach)
        grid_s = time.perf_counter() - started
        cell = found.length_m * (A_RANGE[1] / A_RANGE[0]) ** (1.0 / 199.0) - found.length_m
        cell += found.length_m * np.log((B_RANGE[1] / B_RANGE[0]) ** (1.0 / 199.0)) / np.log(found.b)
        others = "  ".join(f"{method} {_searched(method, request, found.evaluations)}" for method in ("tpe", "cma-es", "de", "random"))
        print(f"{km_h:3d} km/h {found.length_m:8.3f} m {1e3 * nlp_s:7.1f} ms {found.evaluations:4d} | ", end="")
        print(f"{best:8.3f} m {grid_s:6.1f} s {cell:5.2f} m | {others}", flush=True)


def _searched(method: str, request: DesignRequest, few: int) -> str:
    """Median over three seeds of the best length after `few` and after 300 evaluations; a dash where nothing kept the limits."""

    def score(x: Array) -> float:
        a = -A_RANGE[0] * (A_RANGE[1] / A_RANGE[0]) ** x[0]
        b = B_RANGE[0] * (B_RANGE[1] / B_RANGE[0]) ** x[1]
        length = float(lengths(np.array([a]), np.array([b]), np.array([3.7 + request.settling_m * (2.0 * x[2] - 1.0)]), request)[0])
        return length if np.isfinite(length) else 1e3 * (1.0 - a) * (1.0 + b) / b  # gentler is nearer to what is allowed

    curves = np.array([search(method, score, 3, 300, seed).curve for seed in range(3)])
    told = [float(np.median(curves[:, at])) for at in (few - 1, 299)]
    return "/".join(f"{value:.2f}" if value < 1e3 else "-" for value in told)


def table() -> None:
    """The side is the paper's, the shorter one; limits are the design's: 4 m/s^2, 20 m/s^3, 0.015 rad at the start, 0.1 m at the end."""
    print("speed  offset side  | paper: peak g, jerk, jump at the start, length, off the lane centre at 20 m, what it breaks")
    print("                    | tuned: peak g, jerk, jump, length, off the lane centre; a, b, y_max")
    for km_h in KM_H:
        for offset in OFFSETS_M:
            side = Side.RIGHT if offset > 0.0 else Side.LEFT
            found = design(DesignRequest(speed_mps=km_h / 3.6, offset_m=offset, side=side))
            rows = {row.name: row.value for row in found.constraints}
            tuned = _line(rows["lateral acceleration"], rows["lateral jerk"], rows["initial heading jump"])
            numbers = f"{found.a_per_m:.4f} {found.b:.1f} {found.y_max_m:.2f}"
            print(f"{km_h:3d} km/h {offset:+4.1f} m {side:5} | {_paper(km_h / 3.6, 3.7 - abs(offset))}")
            print(f"{'':19} | {tuned} {found.length_m:6.1f} m {rows['settling error']:5.2f} m  {numbers}")


def _paper(v: float, reach: float) -> str:
    """a = -0.4, b = 50 as published: never renormalised."""
    push, jolt, jump = v**2 * reach * 0.16 / (6.0 * np.sqrt(3.0)), v**3 * reach * 0.064 / 8.0, np.arctan(reach * 0.4 * 50.0 / 51.0**2)
    end = reach * (1.0 / (1.0 + 50.0 * np.exp(-8.0)) - 1.0 / 51.0)
    rest = 3.7 - reach * 50.0 / 51.0
    limits = (("acceleration", push, 4.0), ("jerk", jolt, 20.0), ("heading jump", jump, 0.015), ("settling", rest, 0.1))
    broken = ", ".join(name for name, value, limit in limits if value > limit)
    length = "never" if rest > 0.1 else f"{_literal_length(reach):.1f} m"
    return f"{_line(push, jolt, jump)} {length:>8} {3.7 - end:5.2f} m  {f'breaks {broken}' if broken else 'feasible'}"


def _line(push: float, jolt: float, jump: float) -> str:
    return f"{push / GRAVITY_MPS2:5.2f} g {jolt:7.1f} m/s^3 {jump:6.4f} rad"


def _literal_length(reach: float) -> float:
    x = np.linspace(0.0, 60.0, 6001)
    y = reach * (1.0 / (1.0 + 50.0 * np.exp(-0.4 * x)) - 1.0 / 51.0)
    return float(x[np.flatnonzero(np.abs(y - 3.7) > 0.1)[-1]])


def schedule_sheet(schedule: GainSchedule, offset_m: float = 0.0) -> Figure:
    """At the crossing nearest to `offset_m`."""
    j = int(np.argmin(np.abs(np.array(schedule.offset_m) - offset_m)))
    speeds = 3.6 * np.array(schedule.speed_mps)
    panels = (
        (schedule.a_per_m, "a [1/m]", A_PER_M, "paper: a = -0.4"),
        (schedule.b, "b [-]", B, "paper: b = 50"),
        (schedule.length_m, "length [m]", SETTLING_X_M, "paper: 20 m"),
    )
    with styled():
        fig = figure(9.6, 3.4)
        for axes, (table, label, paper, words) in zip(fig.subplots(1, 3), panels, strict=True):
            for i, friction in enumerate(schedule.friction):
                mark, colour = _MARKS[i % len(_MARKS)], _COLOURS[i % len(_COLOURS)]
                axes.plot(speeds, table[i, j], color=colour, marker=mark, ms=3.5, lw=1.5, label=f"friction {friction:g}")
            axes.axhline(paper, color=LITERAL, ls="--", lw=1.2, label=words)
            axes.set(xlabel="speed [km/h]", ylabel=label)
            axes.set_title(label.split(" ")[0])
            axes.legend()
    return fig


def schedule(out: Path | None) -> None:
    started = time.perf_counter()
    found = build_schedule("sedan")
    print(f"{found.a_per_m.size} designs in {time.perf_counter() - started:.1f} s")
    (Path(__file__).resolve().parent.parent / "models" / "tuned" / "sedan.toml").write_text(schedule_text(found), encoding="utf-8")
    if out is not None:
        save_png(schedule_sheet(found), out / "tuning-schedule.png", dpi=110)


def gradient(out: Path | None, steps: int, times: int, scenes: int, nodes: int, urgency: float) -> None:
    """`times` as many rollouts for random search; both checked on problems that neither saw."""
    sensitivity = PlanSensitivity(Vehicle(), neighbours=2, nodes=nodes)
    rng = np.random.default_rng(5)
    plans = []
    while len(plans) < 2 * scenes:
        situation, proposed = evasion(rng, 2, urgency=urgency)
        posed = posed_plan(sensitivity, situation, proposed, predict(situation.tracks, PredictionSettings()).bodies)
        if sensitivity.measured(posed.parameters, posed.guess, gradients=False).converged:
            plans.append(posed)
    seen, unseen = MeanMerit(plans[:scenes], sensitivity), MeanMerit(plans[scenes:], sensitivity)
    started = time.perf_counter()
    down = by_gradient(seen, steps)
    gradient_s = time.perf_counter() - started
    started = time.perf_counter()
    drawn = at_random(seen, times * steps, seed=1)
    random_s = time.perf_counter() - started
    own = unseen(np.zeros(len(seen.knobs)), gradient=False)[0]
    print("rollouts  gradient | rollouts  random")
    for k in range(len(down.merits)):
        far = min(times * (k + 1), len(drawn.merits)) - 1
        print(f"{down.rollouts[k]:8.0f} {down.merits[k]:9.4f} | {drawn.rollouts[far]:8.0f} {drawn.merits[far]:7.4f}")
    print(f"gradient: {down.rollouts[-1]:.0f} rollouts, {gradient_s:.0f} s; random: {drawn.rollouts[-1]:.0f} rollouts, {random_s:.0f} s")
    for curve in (down, drawn):
        print(f"{curve.method:8} unseen problems: {unseen(curve.best, gradient=False)[0]:.4f} (own values {own:.4f})")
    print("gradient's factors: " + ", ".join(f"{k} {np.exp(f):.2f}" for k, f in zip(seen.knobs, down.best, strict=True)))
    if out is not None:
        with styled():
            fig = figure(6.4, 3.4)
            axes = fig.subplots()
            axes.axhline(down.merits[0], color=GREY, lw=1.0, ls=":", label="own values")
            axes.step(drawn.rollouts, drawn.merits, where="post", color=ORANGE, label="random search")
            axes.step(down.rollouts, down.merits, where="post", color=BLUE, marker="o", ms=3.5, label="gradient through the MPC")
            axes.set(xscale="log", xlabel="rollouts [-]", ylabel="best mean merit so far [-]")
            axes.legend(loc="lower left")
        save_png(fig, out / "tuning-gradient.png", dpi=110)


def costs() -> None:
    table_of = load_schedule("sedan")
    count = 20000
    started = time.perf_counter()
    for k in range(count):
        tuned_path(
            table_of,
            start_s_m=0.0,
            start_d_m=0.0,
            target_d_m=3.7,
            speed_mps=8.0 + 0.001 * k,
            offset_m=0.4,
            friction=0.7,
            lateral_acceleration_mps2=4.0,
        )
    print(f"a tuned path: {1e6 * (time.perf_counter() - started) / count:.1f} us")
    for objective in ("shortest", "clearance", "jerk"):
        started = time.perf_counter()
        design(DesignRequest(objective=objective))
        first = time.perf_counter() - started
        started = time.perf_counter()
        design(DesignRequest(objective=objective, speed_mps=20.0))
        print(f"a design, {objective}: first {first:.2f} s, another {1e3 * (time.perf_counter() - started):.0f} ms")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("part", choices=("grid", "table", "schedule", "gradient", "costs"))
    parser.add_argument("--out", type=Path, help="folder for figures")
    parser.add_argument("--steps", type=int, default=12, help="evaluations of the gradient")
    parser.add_argument("--times", type=int, default=20, help="as many times the rollouts for random search")
    parser.add_argument("--scenes", type=int, default=6)
    parser.add_argument("--nodes", type=int, default=25)
    parser.add_argument("--urgency", type=float, default=0.7, help="of the evasions; above 1 many of them end in a scrape")
    arguments = parser.parse_args()
    if arguments.part == "grid":
        grid()
    elif arguments.part == "table":
        table()
    elif arguments.part == "schedule":
        schedule(arguments.out)
    elif arguments.part == "gradient":
        gradient(arguments.out, arguments.steps, arguments.times, arguments.scenes, arguments.nodes, arguments.urgency)
    else:
        costs()


if __name__ == "__main__":
    main()
