"""A suite: families of scenes and lists of cases, expanded in a fixed order."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from mcdas_opt.evaluation.case import Case, Traffic
from mcdas_opt.evaluation.families import load_family
from mcdas_opt.evaluation.provenance import digest


@dataclass(frozen=True, slots=True, kw_only=True)
class Suite:
    """Every case of a suite under one seed."""

    name: str
    seed: int
    cases: tuple[Case, ...]
    about: tuple[str, ...] = ()

    @property
    def hash(self) -> str:
        """Of every scene and of what the statistics know about it, in their order."""
        return digest(
            [case.index, case.family, case.traffic.value, case.nominal, case.labelled, case.scene.model_dump(mode="json")]
            for case in self.cases
        )


def expand(name: str | Path, scenes: int | None = None, seed: int | None = None) -> Suite:
    family = load_family(name)
    seed = 1 if seed is None else seed
    cases = []
    for index, scene in enumerate(family.scenes(scenes or 100, seed)):
        reacts = any(part.behaviour == "idm" for part in scene.neighbour)
        traffic = Traffic.REACTING if reacts else Traffic.SCRIPTED
        cases.append(Case(index=index, family=family.name, traffic=traffic, scene=scene, nominal=family.name == "benign"))
    return Suite(name=family.name, seed=seed, cases=tuple(cases))
