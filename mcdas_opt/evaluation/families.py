"""Families of scenes: ranges as data, expanded into scenes by a tree of seeds."""

from __future__ import annotations

import math
import os
import zlib
from collections.abc import Iterator
from functools import lru_cache
from itertools import product
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import BaseModel, Field, model_validator

from mcdas_opt.catalogue.data_files import checked, data_folder, not_shipped, read_toml
from mcdas_opt.catalogue.scenes import Scene, scene_from_document
from mcdas_opt.errors import InputError
from mcdas_opt.evaluation.family_ranges import Ranges
from mcdas_opt.evaluation.family_scene import document_of
from mcdas_opt.evaluation.spread import Spread

_DRAWS = 500
MOST_SCENES = 1_000_000
_NAMES_FILES = ("vehicle", "sensors", "suite")


class Family(Ranges):
    """A family file of `benchmarks/suites`, or a [[family]] of one: the ranges that its scenes come from.

    `grid`: every combination of the lists in turn, instead of draws. `nominal`: nothing in it needs an intervention. `labels`: the
    oracle is asked. `count` and `seed` hold when nothing else is said (a grid has as many scenes as combinations).
    """

    KIND: ClassVar[str] = "suite"

    name: Annotated[str, Field(description="of the family")]
    about: Annotated[list[str], Field(description="sources, and what was chosen where they are silent")] = Field(default_factory=list)
    seed: Annotated[Annotated[int, Field(ge=0)], Field(description="of the draws, where the command names none")] = 1
    count: Annotated[Annotated[int, Field(ge=1, le=MOST_SCENES)], Field(description="scenes, where the command names no number")] = 100
    grid: Annotated[bool, Field(description="every combination of the lists in turn, instead of draws")] = False
    nominal: Annotated[bool, Field(description="nothing in it needs an intervention")] = False
    labels: Annotated[bool, Field(description="the oracle says what was avoidable")] = True

    @model_validator(mode="after")
    def _few_combinations(self) -> Self:
        if self.grid and math.prod(len(values) for _, values in _lists(self, ())) > MOST_SCENES:
            raise ValueError(f"a grid must have at most {MOST_SCENES} combinations")
        return self

    def scene(self, index: int, seed: int = 0) -> Scene:
        """Scene `index` of the family's tree under `seed`: the same whatever other scenes are expanded.

        Raises `InputError` where the ranges hold next to nothing that can be built.
        """
        branch = np.random.SeedSequence(entropy=seed, spawn_key=(zlib.crc32(self.name.encode()), index))
        rng = np.random.default_rng(branch)
        family = self.combinations()[index % self.size] if self.grid else self
        name = f"{self.name}-{seed}-{index}"
        for _ in range(_DRAWS):
            document = document_of(family, rng)
            if document is not None:
                document |= {"name": name, "seed": int(branch.generate_state(1)[0])}
                return scene_from_document(document, Path(f"{name}.toml"))
        raise InputError(name, "", None, f"of {_DRAWS} draws from the family's ranges none could be built")

    def scenes(self, count: int, seed: int = 0) -> tuple[Scene, ...]:
        return tuple(self.scene(index, seed) for index in range(count))

    @property
    def size(self) -> int:
        """How many scenes make up the family."""
        return len(self.combinations()) if self.grid else self.count

    def combinations(self) -> tuple[Family, ...]:
        """Families with one value for each list, the last list turning fastest."""
        return _combinations(self.model_dump_json())


@lru_cache(maxsize=64)
def _combinations(text: str) -> tuple[Family, ...]:
    family = Family.model_validate_json(text)
    lists = list(_lists(family, ()))
    return tuple(_with(family, dict(zip((path for path, _ in lists), chosen, strict=True))) for chosen in product(*(v for _, v in lists)))


def _lists(part: BaseModel, path: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], tuple[float, ...]]]:
    for name, value in part:
        if isinstance(value, Spread):
            if value.values is not None:
                yield (*path, name), value.values
        elif isinstance(value, BaseModel):
            yield from _lists(value, (*path, name))


def _with(family: Family, values: dict[tuple[str, ...], float]) -> Family:
    changed = family
    for path, value in values.items():
        if len(path) == 1:
            changed = changed.model_copy(update={path[0]: value})
        else:
            changed = changed.model_copy(update={path[0]: dict(changed)[path[0]].model_copy(update={path[1]: value})})
    return changed


def load_family(name: str | Path) -> Family:
    """The family behind a path or a shipped name. Raises `InputError` that names file, key, value and rule."""
    path = suite_file(name)
    return checked(Family, suite_document(path), path)


def suite_document(path: Path) -> dict[str, Any]:
    """What a suite file says; the vehicles, sensors and suites that it names by a path are sought beside it, wherever the command runs."""
    document: dict[str, Any] = _beside(read_toml(path), path.parent)
    return document


def _beside(part: Any, folder: Path, key: str = "") -> Any:
    if isinstance(part, dict):
        return {name: _beside(value, folder, "sensors" if key == "sensors" else name) for name, value in part.items()}
    if isinstance(part, list):
        return [_beside(value, folder, key) for value in part]
    is_path = key in _NAMES_FILES and isinstance(part, str) and ("/" in part or part.endswith(".toml"))
    return str(folder / part) if is_path else part


def suite_file(name: str | Path) -> Path:
    """The file behind a path or a shipped name. Raises `InputError` that lists the shipped ones."""
    path = Path(name)
    if os.path.isfile(path):
        return path
    path = suites_folder() / f"{name}.toml"
    if not os.path.isfile(path):
        raise not_shipped(str(name), "suite", shipped_suites())
    return path


def shipped_suites() -> tuple[str, ...]:
    return tuple(sorted(path.stem for path in suites_folder().glob("*.toml")))


def suites_folder() -> Path:
    return data_folder("_suites", "benchmarks/suites")
