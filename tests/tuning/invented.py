"""Invented drives: the figures follow from the values by formula, so that a study takes no time. Run as a program it is one worker."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from mcdas_opt.catalogue.scenes import Scene, load_scene
from mcdas_opt.tuning.study import StudySpec, run_study
from mcdas_opt.tuning.traffic import DriveFigures


def scenes(count: int) -> tuple[Scene, ...]:
    scene = load_scene("sandwich-60-40")
    return tuple(scene.model_copy(update={"name": f"invented-{k}", "seed": k}) for k in range(count))


def figures(scene: Scene, values: Mapping[str, float]) -> DriveFigures:
    """Hard braking into the lane early collides in some scenes; nearness costs jerk."""
    push, near = values["sigmoid.lateral_acceleration_mps2"], values["cost.nearness"]
    return DriveFigures(
        collided=(7.0 * push + 1.3 * scene.seed) % 5.0 < 0.8 + 0.1 * near,
        peak_lateral_mps2=push,
        peak_jerk_mps3=abs(near - 5.0) + 0.1 * scene.seed,
        manoeuvre_m=60.0 / push,
        unverified=0,
    )


class Drives:
    """Counts what it drives; `pause_s` makes it slow enough to be killed."""

    def __init__(self, pause_s: float = 0.0) -> None:
        self.pause_s, self.count = pause_s, 0

    def __call__(self, scenes: Sequence[Scene], values: Mapping[str, float]) -> Iterator[DriveFigures]:
        for scene in scenes:
            self.count += 1
            time.sleep(self.pause_s)
            yield figures(scene, values)


def spec(method: str, count: int = 8) -> StudySpec:
    return StudySpec(suite="sandwich", scenes=scenes(count), seed=3, method=method)


if __name__ == "__main__":
    run_study(spec(sys.argv[2]), Path(sys.argv[1]), int(sys.argv[3]), Drives(pause_s=0.05))
