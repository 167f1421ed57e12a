"""How a study is run: everything but its suite, its number of trials and its file."""

from __future__ import annotations

from dataclasses import dataclass, field

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.rules import positive, require, whole
from mcdas_opt.tuning.search_space import SPACE, Range


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyOptions:
    """`method`: tpe, nsga2, de, cma-es or random. `scenes` avoidable ones are trained on; `held_out` validate, as many test.

    `workers` child processes drive them, or whoever is connected to the Dask `scheduler` at that address; `speed_mps` is where the
    chosen sigmoid is reported.
    """

    method: str = "tpe"
    seed: int = 0
    scenes: int = 12
    held_out: int = 8
    workers: int = 1
    scheduler: str | None = None
    speed_mps: float = 60.0 / 3.6
    space: tuple[Range, ...] = field(default=SPACE)

    def __post_init__(self) -> None:
        require_types(self)
        require(self, positive, "scenes", "held_out", "workers", "speed_mps")
        whole("seed", self.seed)
