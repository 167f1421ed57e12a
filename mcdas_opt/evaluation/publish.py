"""From the finished rows to files: table, summary, worst scenes and report."""

from __future__ import annotations

import json
import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcdas_opt.catalogue.scene_file import scene_file
from mcdas_opt.evaluation.benchmark import Progress, Results
from mcdas_opt.evaluation.case import Case
from mcdas_opt.evaluation.reporting.contents import card, report
from mcdas_opt.evaluation.reporting.document import FIGURES, Card, html, markdown
from mcdas_opt.evaluation.running.executor import Executor
from mcdas_opt.evaluation.running.journal import write_whole
from mcdas_opt.evaluation.running.messages import Ended, Task
from mcdas_opt.evaluation.suites import Suite
from mcdas_opt.evaluation.summary import lost, pairs, summarise, worst
from mcdas_opt.evaluation.table import write_table

WORST = "worst"
CARDS = 20  # scenes with a picture in the report
MOST_PAGES = 60  # that play a scene
SCHEMA_VERSION = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Published:
    """The document of the command, and where everything is."""

    document: dict[str, Any]
    rows: Path
    report: Path


def publish(suite: Suite, results: Results, folder: Path, executor: Executor, progress: Progress) -> Published:
    """Writes `rows.csv` (and Parquet), `timings.csv`, `summary.json`, `report.html`, `report.md`, `figures/` and `worst/` into `folder`."""
    planners = results.manifest["planners"]
    origin = {**results.manifest, "rows_hash": results.rows_hash}
    table = write_table(folder, results, origin)
    summary = summarise(results.rows, results.cycles_ms, results.took_s, planners)
    cards, pages = _worst(suite, results, folder, executor, progress)
    document = report(origin, results.rows, results.cycles_ms, summary, cards, suite.about, pages)
    (folder / FIGURES).mkdir(exist_ok=True)
    for picture in document.pictures:
        write_whole(folder / FIGURES / picture.name, picture.png)
    write_whole(folder / "report.html", html(document))
    write_whole(folder / "report.md", markdown(document))
    answer = {
        "schema_version": SCHEMA_VERSION,
        **{key: value for key, value in origin.items() if key != "schema_version"},
        "rows": str(table),
        "summary": summary,
        "pairs": pairs(results.rows, planners),
        "report": str(folder / "report.html"),
    }
    write_whole(folder / "summary.json", json.dumps(answer, allow_nan=False, indent=1) + "\n")
    return Published(document=answer, rows=table, report=folder / "report.html")


def portrait(case: Case, planner: str, plant: str) -> tuple[bytes, str]:
    """The drive once more, as a picture and as a page that plays it."""
    from mcdas_opt.plotting.animation import draw_thumbnail
    from mcdas_opt.plotting.player import drive_page
    from mcdas_opt.plotting.style import png_bytes
    from mcdas_opt.simulation.loop import simulate

    drive = simulate(case.scene, planner, plant)
    return png_bytes(draw_thumbnail(drive)), drive_page(drive)


def _worst(suite: Suite, results: Results, folder: Path, executor: Executor, progress: Progress) -> tuple[list[Card], dict[int, str]]:
    """The first planner's worst drives: each scene as a file, its picture, its page, and how to see it again; and the page of every scene.

    Avoidable ones that were lost come first, and have a page each up to `MOST_PAGES`.
    """
    planner, plant = results.manifest["planners"][0], results.manifest["plant"]
    mine = worst(results.rows, planner, len(results.rows))
    avoidable = sum(lost(row) and row["label"] in "A-" for row in mine)
    chosen = mine[: max(CARDS, min(avoidable, MOST_PAGES))]
    cases = {case.index: case for case in suite.cases}
    (folder / WORST).mkdir(exist_ok=True)
    tasks = [Task(portrait, (cases[row["index"]], planner, plant), results.manifest["limit_s"]) for row in chosen]
    pictures: dict[int, bytes] = {}
    pages: dict[int, str] = {}
    progress("pictures", 0, len(tasks))
    for number, answer in executor.run(tasks):
        if answer.ended is Ended.RETURNED:
            pictures[number], text = answer.value
            page = f"{WORST}/{chosen[number]['scene']}.html"
            write_whole(folder / page, text)
            pages[chosen[number]["index"]] = page
        else:
            pictures[number] = _blank(answer.reason)
        progress("pictures", len(pictures), len(tasks))
    cards = []
    for number, row in enumerate(chosen):
        path = folder / WORST / f"{row['scene']}.toml"
        write_whole(path, scene_file(cases[row["index"]].scene))
        how = f"--planner {planner} --plant {plant} --out {row['scene']}.gif"
        if number < CARDS:
            command = f"mcdas-opt simulate {shlex.quote(str(path))} {how}"
            cards.append(card(row, pictures[number], command, pages.get(row["index"], "")))
    return cards, pages


def _blank(reason: str) -> bytes:
    """A picture of why there is none."""
    from mcdas_opt.plotting.style import figure, png_bytes, styled

    with styled():
        fig = figure(5.6, 1.2)
        fig.text(0.02, 0.5, f"not driven again: {reason}", va="center", fontsize=9, wrap=True)
    return png_bytes(fig)
