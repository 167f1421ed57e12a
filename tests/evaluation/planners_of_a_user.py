"""A distribution with planners of its own, as a user would install one: some good, some that misbehave."""

from __future__ import annotations

from pathlib import Path

MODULE = """
import os, time
from mcdas_opt.baselines.lane import judged

class Gently:
    def wanted_mps2(self, t_s, s_m, speed_mps):
        return -1.0

class Gentle:
    has_ladder = False

    def __init__(self, vehicle, settings):
        self.vehicle, self.settings = vehicle, settings

    def plan(self, situation, previous):
        return judged("gentle", situation, self.vehicle, self.settings, law=Gently(), reason="always")

class Raises(Gentle):
    def plan(self, situation, previous):
        if situation.time_s > 0.25:
            raise RuntimeError("no idea")
        return super().plan(situation, previous)

class Hangs(Gentle):
    def plan(self, situation, previous):
        time.sleep(1000.0)

class Dies(Gentle):
    def plan(self, situation, previous):
        os._exit(7)

class Prints(Gentle):
    def plan(self, situation, previous):
        print("planning at", situation.time_s)
        os.write(1, b"and from below\\\\n")
        return super().plan(situation, previous)
"""
NAMES = ("gentle", "raises", "hangs", "dies", "prints")


def install(folder: Path) -> None:
    """Writes the distribution into a folder that is, or will be, on the path."""
    (folder / "their_planners.py").write_text(MODULE, encoding="utf-8")
    facts = folder / "their_planners-0.1.dist-info"
    facts.mkdir()
    (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: their-planners\nVersion: 0.1\n", encoding="utf-8")
    lines = "".join(f"{name} = their_planners:{name.capitalize()}\n" for name in NAMES)
    (facts / "entry_points.txt").write_text(f"[mcdas_opt.methods]\n{lines}", encoding="utf-8")
