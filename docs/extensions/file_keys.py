"""Writes the reference of every file into the site's sources for the time of a build: a page of tables, and a JSON Schema beside it."""

from __future__ import annotations

import json
from itertools import groupby
from pathlib import Path
from typing import Any

from mcdas_opt.evaluation.file_formats import MODELS, keys, schema

TITLES = {
    "scene": (
        "A scene",
        "Somebody ahead, somebody behind, a road, a car: what `plan`, `simulate` and `escapes` take. Shipped ones are in `models/scenes`.",
    ),
    "vehicle": (
        "A vehicle",
        "The limits that the judge enforces; below them, for the dynamic plant, the chassis. Shipped ones are in `models/vehicles`.",
    ),
    "sensor": ("A sensor", "A radar. Shipped ones are in `models/sensors`; `ideal` and `none` are words, not files."),
    "motion": ("A target's motion", "How much others may change their speed, for the tracker. Shipped ones are in `models/motion`."),
    "parking-case": ("A parking case", "What `park` and `follow` take. Poses are rear-axle midpoints: x along the road, y to the left."),
    "suite": ("A suite", "What `benchmark` takes. A number may be a value, a range or a choice. Shipped ones are in `benchmarks/suites`."),
    "family": ("A family of scenes", "A suite of one family may be written without `[[family]]`, with these keys at the top."),
}


def _page(kind: str) -> str:
    title, about = TITLES[kind]
    lines = [
        f"# {title}",
        "",
        about,
        "",
        f"Unknown keys are an error that names the nearest known one. For editors: {{download}}`{kind}.schema.json`,",
        f"or `mcdas-opt schema {kind} --json`.",
        "",
    ]
    for table, rows in groupby(keys(kind), key=lambda key: key.table):
        lines += [f"## `{table}`" if table else "## At the top", "", "| key | unit | default | allowed | what |", "|---|---|---|---|---|"]
        lines += [
            f"| `{key.name}` | {key.unit} | {_code(key.default)} | {key.allowed or key.kind} | {key.about} |".replace("<", "&lt;")
            for key in rows
        ]
        lines.append("")
    return "\n".join(lines)


def _code(default: str) -> str:
    return f"`{default}`" if default and default != "required" else default


def _write(path: Path, text: str) -> None:
    if not path.is_file() or path.read_text("utf-8") != text:
        path.write_text(text, "utf-8")


def _bring(app: Any) -> None:
    folder = Path(app.srcdir) / "files"
    folder.mkdir(exist_ok=True)
    for kind in MODELS:
        _write(folder / f"{kind}.md", _page(kind))
        _write(folder / f"{kind}.schema.json", json.dumps(schema(kind), indent=1) + "\n")
    listed = "\n".join(MODELS)
    _write(
        folder / "index.md",
        f"# Files\n\nEvery key of every file that you may write, from the models that check it.\n\n```{{toctree}}\n:maxdepth: 1\n\n{listed}\n```\n",
    )


def setup(app: Any) -> dict[str, Any]:
    app.connect("builder-inited", _bring)
    return {"parallel_read_safe": True}
