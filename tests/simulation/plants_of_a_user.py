"""A distribution with plants of its own, as a user would install one: one that drives, and some that misbehave."""

from __future__ import annotations

from pathlib import Path

MODULE = '''
from dataclasses import replace
from mcdas_opt.simulation.kinematic_plant import KinematicPlant

class Lazy(KinematicPlant):
    """Its wheels turn at half the rate that is asked for."""

    def step(self, jerk_mps3, steering_rate_radps):
        return super().step(jerk_mps3, 0.5 * steering_rate_radps)

class Raises(KinematicPlant):
    steps = 0

    def step(self, jerk_mps3, steering_rate_radps):
        self.steps += 1
        if self.steps == 35:
            raise RuntimeError("out of petrol")
        return super().step(jerk_mps3, steering_rate_radps)

def unborn(vehicle, road, state):
    raise KeyError("engine")
'''
NAMES = {"lazy": "Lazy", "raises": "Raises", "unborn": "unborn", "broken": "Nobody"}


def install(folder: Path) -> None:
    """Writes the distribution into a folder that is, or will be, on the path."""
    (folder / "their_plants.py").write_text(MODULE, encoding="utf-8")
    facts = folder / "their_plants-0.1.dist-info"
    facts.mkdir()
    (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: their-plants\nVersion: 0.1\n", encoding="utf-8")
    lines = "".join(f"{name} = their_plants:{attribute}\n" for name, attribute in NAMES.items())
    (facts / "entry_points.txt").write_text(f"[mcdas_opt.plants]\n{lines}", encoding="utf-8")
