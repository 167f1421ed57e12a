"""A suite: families of scenes, manoeuvres, recordings and other suites, expanded in a fixed order."""

from __future__ import annotations

import os
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator

from mcdas_opt.catalogue.data_files import checked
from mcdas_opt.catalogue.part import Part
from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.domain.rules import within
from mcdas_opt.errors import InputError
from mcdas_opt.evaluation.case import Case, Traffic
from mcdas_opt.evaluation.families import MOST_SCENES, Family, suite_document, suite_file
from mcdas_opt.evaluation.manoeuvres import Manoeuvre
from mcdas_opt.evaluation.provenance import digest
from mcdas_opt.evaluation.recordings import Recordings


class PartOfSuite(Part):
    """So many scenes of another suite."""

    suite: Annotated[str, Field(description="a shipped suite or a path")]
    scenes: Annotated[Annotated[int, Field(ge=1, le=MOST_SCENES)] | None, Field(description="how many of its; default all")] = None


class SuiteFile(Part):
    """A suite file with more than one family in it; `sensors` are those of every member that names none."""

    KIND: ClassVar[str] = "suite"

    name: Annotated[str, Field(description="of the suite")]
    about: Annotated[list[str], Field(description="sources, and what was chosen where they are silent")] = Field(default_factory=list)
    seed: Annotated[Annotated[int, Field(ge=0)], Field(description="of the draws, where the command names none")] = 1
    sensors: Annotated[dict[str, Any], Field(description="as in a scene, for every member that names none")] = Field(default_factory=dict)
    family: Annotated[list[Family], Field(description="ranges from which scenes are drawn")] = Field(default_factory=list)
    manoeuvre: Annotated[list[Manoeuvre], Field(description="scenes written out")] = Field(default_factory=list)
    recorded: Annotated[Recordings | None, Field(description="scenes cut from recordings")] = None
    part: Annotated[list[PartOfSuite], Field(description="scenes of other suites")] = Field(default_factory=list)

    @model_validator(mode="after")
    def _holds_something(self) -> Self:
        if not (self.family or self.manoeuvre or self.recorded or self.part):
            raise ValueError("needs a [[family]], a [[manoeuvre]], a [[part]] or [recorded]")
        names = [*(member.name for member in self.family), *(member.name for member in self.manoeuvre)]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise ValueError(f"two members are called {twice!r}")
        return self

    def equipped(self) -> SuiteFile:
        """With the sensors handed down."""
        handed = {"sensors": self.sensors}
        family = [member if member.sensors else member.model_copy(update=handed) for member in self.family]
        manoeuvre = [member if member.sensors else member.model_copy(update=handed) for member in self.manoeuvre]
        recorded = self.recorded
        if recorded is not None and not recorded.sensors:
            recorded = recorded.model_copy(update=handed)
        return self.model_copy(update={"family": family, "manoeuvre": manoeuvre, "recorded": recorded})


@dataclass(frozen=True, slots=True, kw_only=True)
class Suite:
    """Every case of a suite under one seed; `about` is what it says of itself: sources, and what was chosen where they are silent."""

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


@dataclass(frozen=True, slots=True, kw_only=True)
class _Found:
    family: str
    scene: Scene
    nominal: bool = False
    labelled: bool = True
    recorded: bool = False


def expand(name: str | Path, scenes: int | None = None, seed: int | None = None, data: Path | None = None) -> Suite:
    """The suite behind a path or a shipped name, with so many scenes, shared evenly among its members.

    `data` is the folder of recordings, for suites that read them. Raises `InputError` that names file, key, value and rule;
    `ParameterError` for a number of scenes that nobody could drive.
    """
    if scenes is not None:
        within("scenes", scenes, 0, MOST_SCENES)
    path = suite_file(name)
    suite = _read(path)
    seed = suite.seed if seed is None else seed
    found = _expanded(suite, path, scenes, seed, data, ())
    if data is not None and not _reads_recordings(suite):
        raise InputError("--data", "", str(data), f"not read by the suite {suite.name}, which has no recordings")
    cases = tuple(_case(index, one) for index, one in enumerate(found))
    about = suite.about if isinstance(suite, Family) or not suite.part else [*suite.about, *_about_parts(suite)]
    return Suite(name=suite.name, seed=seed, cases=cases, about=tuple(about))


def _read(path: Path) -> Family | SuiteFile:
    document = suite_document(path)
    several = any(key in document for key in ("family", "manoeuvre", "recorded", "part"))
    return checked(SuiteFile, document, path, context=path).equipped() if several else checked(Family, document, path)


def _reads_recordings(suite: Family | SuiteFile) -> bool:
    """It, or a part of it; none of which is inside itself."""
    if isinstance(suite, Family):
        return False
    return suite.recorded is not None or any(_reads_recordings(_read(suite_file(part.suite))) for part in suite.part)


def _expanded(
    suite: Family | SuiteFile, path: Path, count: int | None, seed: int, data: Path | None, inside: tuple[Path, ...]
) -> list[_Found]:
    if isinstance(suite, Family):
        return _of_family(suite, suite.size if count is None else count, seed, path)
    if path in inside:
        raise InputError(path, "part", suite.name, "a suite cannot be part of itself")
    recorded = [
        _Found(family=family, scene=scene, labelled=False, recorded=True)
        for family, scene in (suite.recorded.scenes(data, seed) if suite.recorded is not None else ())
    ]
    parts = [(part, suite_file(part.suite)) for part in suite.part]
    files = [(_read(at), at) for _, at in parts]
    sizes = [family.size for family in suite.family] + [len(suite.manoeuvre), len(recorded)]
    wanted = [part.scenes if part.scenes is not None else _size(file, at) for (part, _), (file, at) in zip(parts, files, strict=True)]
    shares = allot(sum(sizes + wanted) if count is None else count, sizes + wanted)
    found: list[_Found] = []
    for family, share in zip(suite.family, shares, strict=False):
        found += _of_family(family, share, seed, path)
    with _of_file(path, *(f"{one.name}-" for one in suite.manoeuvre)):
        found += _of_manoeuvres(suite.manoeuvre, shares[len(suite.family)], seed)
    found += [recorded[k] for k in _spaced(shares[len(suite.family) + 1], len(recorded))]
    for (file, at), share in zip(files, shares[len(sizes) :], strict=True):
        found += _expanded(file, at, share, seed, data, (*inside, path))
    return found


def _size(suite: Family | SuiteFile, path: Path) -> int:
    """How many scenes a part has that says nothing of it."""
    if isinstance(suite, Family):
        return suite.size
    if suite.recorded is not None or suite.part:
        raise InputError(path, "part", suite.name, "as a part of another suite it needs a number of scenes")
    return sum(family.size for family in suite.family) + len(suite.manoeuvre)


def _of_family(family: Family, count: int, seed: int, path: Path) -> list[_Found]:
    size = family.size
    indices = _spaced(count, size) if family.grid and count < size else range(count)
    with _of_file(path, f"{family.name}-"):
        scenes = [family.scene(index, seed) for index in indices]
    return [_Found(family=family.name, scene=scene, nominal=family.nominal, labelled=family.labels) for scene in scenes]


@contextmanager
def _of_file(path: Path, *names: str) -> Iterator[None]:
    """A scene whose name begins so has no file, nor has a vehicle that is not there: the fault is the suite's."""
    try:
        yield
    except InputError as error:
        if os.path.exists(error.file):  # false, too, of what is too long for a file's name
            raise
        what = f"scene {error.file.removesuffix('.toml')}" if error.file.startswith(names) else error.file
        raise InputError(path, f"{what}: {error.key}" if error.key else what, error.value, error.rule) from None


def _of_manoeuvres(manoeuvres: Sequence[Manoeuvre], count: int, seed: int) -> list[_Found]:
    found = []
    for index in _spaced(count, len(manoeuvres)) if count < len(manoeuvres) else range(count):
        one = manoeuvres[index % len(manoeuvres)]
        branch = np.random.SeedSequence(entropy=seed, spawn_key=(zlib.crc32(one.name.encode()), index))
        scene = one.scene(index, int(branch.generate_state(1)[0]))
        found.append(_Found(family="manoeuvres", scene=scene, nominal=one.nominal, labelled=False))
    return found


def _spaced(count: int, size: int) -> list[int]:
    """`count` of `size` places, evenly spread; all of them where that is fewer."""
    count = min(count, size)
    return [k * size // count for k in range(count)]


def allot(total: int, sizes: Sequence[int]) -> list[int]:
    """`total` in proportion to the sizes, by largest remainders, earlier members first among equals."""
    whole = sum(sizes)
    shares = [total * size // whole for size in sizes]
    rest = sorted(range(len(sizes)), key=lambda k: (-(total * sizes[k] % whole), k))
    for k in rest[: total - sum(shares)]:
        shares[k] += 1
    return shares


def _about_parts(suite: SuiteFile) -> list[str]:
    lines: list[str] = []
    for part in suite.part:
        inner = _read(suite_file(part.suite))
        lines += [f"{inner.name}: {line}" for line in inner.about]
    return lines


def _case(index: int, found: _Found) -> Case:
    reacts = any(part.behaviour == "idm" for part in found.scene.neighbour)
    kind = Traffic.RECORDED if found.recorded else Traffic.REACTING if reacts else Traffic.SCRIPTED
    return Case(index=index, family=found.family, traffic=kind, nominal=found.nominal, labelled=found.labelled, scene=found.scene)
