"""Planners side by side, from Python: the benchmark command's rows, shares and pairs as one record."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from mcdas_opt.domain.arithmetic import usual_arithmetic
from mcdas_opt.domain.registry import importable
from mcdas_opt.domain.result import Columns, Result
from mcdas_opt.domain.rules import require_type
from mcdas_opt.errors import ParameterError
from mcdas_opt.evaluation.benchmark import LIMIT_S, Progress, run
from mcdas_opt.evaluation.publish import publish
from mcdas_opt.evaluation.running.executor import working
from mcdas_opt.evaluation.suites import expand
from mcdas_opt.evaluation.summary import kinds, pairs, summarise

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mcdas_opt.planning.method import Method, PlannerName

Record = dict[str, Any]
_PLANNERS = ("mpc", "closed-form", "closed-form-corrected")


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Comparison(Result):
    """A benchmark's answer. `rows`: a drive each, with its labels. `pairs`: for each two planners who lost what the other did not (exact
    McNemar). `summary[planner][traffic][share]`: `k`, `n`, `rate`, and `low`, `high` of its 95 % interval (Clopper and Pearson)."""

    drawn_by: ClassVar[str] = "mcdas_opt.evaluation.comparison:clearance_against_comfort"

    suite: str
    seed: int
    scenes: int
    planners: tuple[str, ...]
    plant: str
    rows_hash: str
    rows: tuple[Record, ...] = field(repr=False)
    summary: Mapping[str, Any]
    pairs: tuple[Record, ...]

    def shares(self, name: str = "lost_on_A", traffic: str | None = None) -> dict[str, Record]:
        """One share of every planner, in one kind of traffic (default the first that there is). Raises `ParameterError` for no share."""
        kind = kinds(self.rows)[0] if traffic is None else traffic
        found = {planner: self.summary[planner].get(kind, {}).get(name) for planner in self.planners}
        if not all(isinstance(one, Mapping) and "k" in one for one in found.values()):
            raise ParameterError("name", name, f"is no share of {kind} traffic")
        return found

    def in_brief(self) -> tuple[str, str, str]:
        key = "lost_on_A" if any(one["n"] for one in self.shares().values()) else "lost"
        told = "; ".join(f"{planner} {one['k']}/{one['n']}{_interval(one)}" for planner, one in self.shares(key).items())
        decided = [pair for pair in self.pairs if pair["measure"] == key.replace("_", " ") and pair["p"] < 0.05]
        apart = ", ".join(f"{pair['first']} and {pair['second']} (p = {pair['p']:.2g})" for pair in decided)
        return (
            f"Benchmark {self.suite}: {self.scenes} scenes, {len(self.planners)} planners, {self.plant} plant, seed {self.seed}",
            f"{key.replace('_', ' ')}: {told}",
            f"apart at 5 %: {apart or 'no pair'}",
        )

    def columns(self) -> Columns:
        """The rows."""
        return {name: [row.get(name) for row in self.rows] for name in (self.rows[0] if self.rows else ())}

    def to_dict(self) -> dict[str, Any]:
        return Result.to_dict(self) | {"rows": list(self.rows)}


@usual_arithmetic
def benchmark(
    suite: str | Path,
    planners: Sequence[PlannerName | str | type[Method]] = _PLANNERS,
    scenes: int | None = None,
    *,
    seed: int | None = None,
    plant: Literal["kinematic", "dynamic"] | str = "kinematic",
    workers: int = 1,
    data: str | Path | None = None,
    out: str | Path | None = None,
    progress: Progress = lambda stage, done, of: None,
) -> Comparison:
    """Every planner on the same scenes and seeds of a suite (a shipped name or a path), on `workers` child processes.

    A planner is a registered name, "module:Class", or the class itself, which must stand in a module that other processes can import.
    `scenes` and `seed` are the suite's own unless given. With `out` the folder gets what the command writes: rows, summary, report, worst
    scenes. `progress` is told the stage, how many are done, and of how many. Raises `InputError` or `ParameterError` for what is not known.
    """
    for name, value, least in (("scenes", scenes, 1), ("seed", seed, 0), ("workers", workers, 1)):
        if value is not None and (isinstance(value, bool) or not isinstance(value, int) or value < least):
            raise ParameterError(name, value, f"must be a whole number from {least} up")
    asked = [planners] if isinstance(planners, (str, type)) else planners
    for one in asked:
        require_type("planners", one, str, type)
    names = tuple(importable("planners", one) if isinstance(one, type) else one for one in asked)
    chosen = expand(str(suite), scenes, seed, None if data is None else Path(data))
    with ExitStack() as stack:
        folder = Path(stack.enter_context(TemporaryDirectory()) if out is None else out)
        executor = stack.enter_context(working(workers))
        results = run(chosen, names, folder, executor, plant=plant, limit_s=LIMIT_S, progress=progress)
        if out is not None:
            publish(chosen, results, folder, executor, progress)
    return Comparison(
        suite=chosen.name,
        seed=chosen.seed,
        scenes=len(chosen.cases),
        planners=names,
        plant=plant,
        rows_hash=results.rows_hash,
        rows=results.rows,
        summary=summarise(results.rows, results.cycles_ms, results.took_s, names),
        pairs=tuple(pairs(results.rows, names)),
    )


def clearance_against_comfort(found: Comparison) -> Figure:
    """Each drive: how near it came to anybody, against how hard it accelerated."""
    from mcdas_opt.evaluation.reporting.contents import points_of
    from mcdas_opt.plotting.benchmark import draw_scatter

    return draw_scatter({planner: points_of([row for row in found.rows if row["planner"] == planner]) for planner in found.planners})


def _interval(share: Record) -> str:
    return f" [{100.0 * share['low']:.0f}, {100.0 * share['high']:.0f}] %" if share["n"] else ""
