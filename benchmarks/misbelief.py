"""What it costs to be wrong: friction believed too high or too low, measurements that come late, tyres that the planner knows not of.

    python benchmarks/misbelief.py --scenes 60 --seed 5 --workers 2

Avoidable scenes of a suite (labelled as they are, with the true friction and no latency) are driven by `mpc` under each condition, with
the same seeds; friction is believed to be so many times the road's. `dynamic` drives the single-track car with tyres.
"""

from __future__ import annotations

import argparse
import multiprocessing
from functools import partial

from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.evaluation.families import load_family
from mcdas_opt.evaluation.oracle import witness
from mcdas_opt.evaluation.statistics import Share
from mcdas_opt.simulation.loop import simulate

CONDITIONS = {
    "as it is": {},
    "friction believed 0.5 of the road's": {"believed": 0.5},
    "friction believed 0.75 of the road's": {"believed": 0.75},
    "friction believed 1.25 of the road's": {"believed": 1.25},
    "friction believed 1.5 of the road's": {"believed": 1.5},
    "latency 0.1 s": {"latency_s": 0.1},
    "latency 0.2 s": {"latency_s": 0.2},
    "latency 0.3 s": {"latency_s": 0.3},
    "dynamic": {"plant": "dynamic"},
    "dynamic, friction believed 1.5 of the road's": {"plant": "dynamic", "believed": 1.5},
}


def changed(scene: Scene, believed: float = 1.0, latency_s: float = 0.0) -> Scene:
    """The scene as the planner is misled about it."""
    document = scene.model_dump(exclude_none=True)
    document["host"]["assumed_friction"] = min(believed * scene.road.friction, 1.5)
    document["sensors"]["latency_s"] = latency_s
    return Scene.model_validate(document)


def outcomes(index: int, *, family: str, seed: int) -> dict[str, str] | None:
    """Outcome of every condition in one scene; None where the scene is not avoidable."""
    scene = load_family(family).scene(index, seed)
    if witness(scene) is None:
        return None
    found = {}
    for name, condition in CONDITIONS.items():
        settings = dict(condition)
        plant = str(settings.pop("plant", "kinematic"))
        drive = simulate(changed(scene, **settings), plant=plant)
        found[name] = f"unverified {drive.unverified_plans}" if drive.unverified_plans else drive.outcome.value
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("family", nargs="?", default="sandwich")
    parser.add_argument("--scenes", type=int, default=40)
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    with multiprocessing.get_context("spawn").Pool(arguments.workers) as pool:
        task = partial(outcomes, family=arguments.family, seed=arguments.seed)
        rows = [row for row in pool.imap(task, range(arguments.scenes)) if row is not None]
    print(f"{arguments.family}, seed {arguments.seed}: {len(rows)} avoidable of {arguments.scenes} scenes")
    for name in CONDITIONS:
        ended = [row[name] for row in rows]
        share = Share(k=ended.count("safe"), n=len(ended))
        low, high = share.interval
        others = ", ".join(f"{ended.count(kind)} {kind}" for kind in sorted(set(ended) - {"safe"}))
        print(f"{name:>46}  safe {share.k}/{share.n} [{100 * low:.0f}, {100 * high:.0f}] %  {others}")


if __name__ == "__main__":
    main()
