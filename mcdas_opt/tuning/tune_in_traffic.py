"""The whole of a study: scenes apart, trials, the choice, its acceptance, and what is written."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from mcdas_opt.catalogue.toml_text import toml_text
from mcdas_opt.domain.document import to_document
from mcdas_opt.domain.result import Columns, Result
from mcdas_opt.domain.sigmoid_design import SigmoidDesign
from mcdas_opt.errors import InputError, writing
from mcdas_opt.evaluation.running.executor import working
from mcdas_opt.reference.offset_path import corrected
from mcdas_opt.tuning.choice import Choice, Guarded, choose, compared, importance, judged
from mcdas_opt.tuning.design import STEP_M, PathSamples, sampled
from mcdas_opt.tuning.gain import Gain, gain_of
from mcdas_opt.tuning.search_space import default_values
from mcdas_opt.tuning.study import StudySpec, Trial, run_study
from mcdas_opt.tuning.study_options import StudyOptions
from mcdas_opt.tuning.traffic import SEEDS, Drives, avoidable, in_turn, on_executor

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Progress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class StudyReport(Result):
    """What a study found; attributes are the keys of the JSON document. a, b and y_max are the closed form's at `speed_mps` with the chosen
    values; `value` is the chosen trial's score on the training scenes; `gain` is what the values bring on the test scenes. Saved as `.toml`
    it is what planners take."""

    drawn_by: ClassVar[str] = "mcdas_opt.tuning.tune_in_traffic:sheet"

    a_per_m: float
    b: float
    y_max_m: float
    speed_mps: float
    length_m: float
    objective: str
    value: float
    constraints: tuple[dict[str, Any], ...]
    method: str
    evaluations: int
    pruned: int
    accepted: bool
    reason: str
    reasons: tuple[str, ...]
    values: dict[str, float]
    defaults: dict[str, float]
    importance: dict[str, float]
    guarded: Guarded
    gain: Gain
    path: PathSamples
    spec: StudySpec = field(repr=False)
    choice: Choice = field(repr=False)
    trials: tuple[Trial, ...] = field(repr=False)

    def to_dict(self) -> dict[str, Any]:
        """The JSON document of the contract."""
        front = [{"number": one.number, **to_document(one.cost)} for one in self.choice.front]
        return Result.to_dict(self) | {"front": front, "suite": self.spec.suite, "gain": self.gain.to_dict()}

    def in_brief(self) -> tuple[str, str, str]:
        return (
            f"Study of {self.method} on {self.spec.suite}: {self.evaluations} trials, {self.pruned} pruned, score {self.value:.4g}",
            self.reason,
            f"trial {self.choice.trial.number} of a front of {len(self.choice.front)}; {self.gain.verdict}",
        )

    def columns(self) -> Columns:
        """A row for each trial: its values, and what it cost."""
        rows = [{"number": one.number, "pruned": one.pruned, **one.values, **to_document(one.cost)} for one in self.trials]
        return {name: [row.get(name) for row in rows] for name in dict.fromkeys(name for row in rows for name in row)}

    def as_text(self, suffix: str) -> str | None:
        return values_text(self) if suffix == ".toml" else Result.as_text(self, suffix)


def tune_in_traffic(
    suite: str,
    trials: int,
    storage: Path,
    options: StudyOptions | None = None,
    *,
    out: Path | None = None,
    progress: Progress | None = None,
) -> StudyReport:
    """Trains on avoidable scenes of `suite`, validates and tests on others. Goes on with what `storage` holds.

    `out` gets a TOML of the values, only where they are accepted, and a picture of the front either way. Raises `InputError` for the
    storage of another study or a suite that is not known.
    """
    how = options or StudyOptions()
    if out is not None and out.suffix.lower() not in (".toml", ".png"):
        raise InputError(out, "", None, "must end in .toml or .png: both are written side by side")
    train = avoidable(suite, SEEDS["train"], how.scenes)
    spec = StudySpec(suite=suite, scenes=train, seed=how.seed, method=how.method, space=how.space)
    default = default_values(how.space)
    with ExitStack() as stack:
        drives = _drives(stack, how)
        found = run_study(spec, storage, trials, drives, progress)
        choice = choose(found)
        sets = []
        for name, tree in SEEDS.items():
            scenes = train if name == "train" else avoidable(suite, tree, how.held_out)
            known = [trial for trial in found if name == "train" and not trial.pruned]
            sets.append(compared(name, tree, scenes, default, choice.trial.values, drives, known))
    guarded = judged(sets)
    test = next(one for one in sets if one.name == "test")
    gain = gain_of(test.default_drives, test.tuned_drives)
    report = _report(spec, found, choice, guarded, gain, importance(found, how.space), how.speed_mps)
    if out is not None:
        _write(report, out)
    return report


def _drives(stack: ExitStack, how: StudyOptions) -> Drives:
    """Here, on child processes, or on a Dask cluster, as the benchmark does."""
    if how.scheduler is None and how.workers == 1:
        return in_turn
    return on_executor(stack.enter_context(working(how.workers, how.scheduler)))


def _report(
    spec: StudySpec,
    found: tuple[Trial, ...],
    choice: Choice,
    guarded: Guarded,
    gain: Gain,
    importance: dict[str, float],
    speed_mps: float,
) -> StudyReport:
    values, cost = choice.trial.values, choice.trial.cost
    path = corrected(
        0.0,
        0.0,
        3.7,
        speed_mps,
        values.get("sigmoid.lateral_acceleration_mps2", 4.0),
        b=values.get("sigmoid.b", 50.0),
    )
    design = SigmoidDesign(a_per_m=path.a_per_m, b=path.b, y_max_m=path.amplitude_m)
    samples = sampled(design)
    settled = float(samples.x_m[int((samples.y_m >= design.reach_m - 0.1).argmax())])
    limits = (
        ("collisions on training", cost.collisions, guarded.sets[0].default.collisions, "share"),
        ("unverified plans", float(cost.unverified), 0.0, "plans"),
    )
    return StudyReport(
        a_per_m=path.a_per_m,
        b=path.b,
        y_max_m=path.amplitude_m,
        speed_mps=speed_mps,
        length_m=max(settled - 0.5 * STEP_M, 0.0),
        objective="traffic",
        value=cost.score,
        constraints=tuple(
            {"name": name, "value": value, "limit": limit, "unit": unit, "multiplier": None} for name, value, limit, unit in limits
        ),
        method=f"{spec.method} on {len(spec.scenes)} scenes of {spec.suite}",
        evaluations=len(found),
        pruned=sum(trial.pruned for trial in found),
        accepted=guarded.accepted,
        reason=guarded.reason,
        reasons=choice.reasons,
        values=values,
        defaults=default_values(spec.space),
        importance=importance,
        guarded=guarded,
        gain=gain,
        path=samples,
        spec=spec,
        choice=choice,
        trials=found,
    )


def _write(report: StudyReport, out: Path) -> None:
    from mcdas_opt.plotting.style import save_png

    with writing(out):
        save_png(sheet(report), out.with_suffix(".png"), dpi=120)
        if report.accepted:
            out.with_suffix(".toml").write_text(values_text(report), encoding="utf-8")


def sheet(report: StudyReport) -> Figure:
    """The front of the trials, the one that was chosen, and what the values matter."""
    from mcdas_opt.plotting.study import study_sheet

    default = next((trial for trial in report.trials if trial.values == report.defaults and not trial.pruned), None)
    return study_sheet(
        objectives=[trial.cost.objectives for trial in report.trials if not trial.pruned],
        front=[trial.cost.objectives for trial in report.choice.front],
        chosen=report.choice.trial.cost.objectives,
        default=None if default is None else default.cost.objectives,
        importance=report.importance,
        title=f"{report.method}: {report.evaluations} trials, {report.pruned} pruned",
    )


def values_text(report: StudyReport) -> str:
    """The TOML that `plan --params` takes: the values, and where they come from."""
    rows = [
        {"name": one.name, "seed": one.seed, "scenes": list(one.scenes), **{f"{who}_{key}": value for who, key, value in _figures(one)}}
        for one in report.guarded.sets
    ]
    document = {
        "values": report.values,
        "provenance": {
            "made_by": f"mcdas-opt {version('mcdas-opt')} tune --scenes {report.spec.suite}",
            "method": report.method,
            "evaluations": report.evaluations,
            "guard": report.reason,
            "test": report.gain.verdict,
            "reasons": list(report.reasons),
        },
        "set": rows,
    }
    return toml_text(document)


def _figures(one: Any) -> list[tuple[str, str, Any]]:
    return [(who, key, value) for who, cost in (("default", one.default), ("tuned", one.tuned)) for key, value in to_document(cost).items()]
