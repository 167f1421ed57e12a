"""Figures that pages state come from benchmarks/claims: {claim}`name` is the value measured last, and the page of all of them is made."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from docutils import nodes

sys.path.insert(0, str(Path(__file__).parents[2]))

from benchmarks.claims.book import SIZES, Entry, claims, entry, records
from mcdas_opt.errors import McdasError

OLD = " (measured on an older planner)"


def _claim(
    role: str, raw: str, text: str, line: int, inliner: Any, options: Any = None, content: Any = None
) -> tuple[list[Any], list[Any]]:
    try:
        found = entry(text)
    except McdasError as error:
        said = inliner.reporter.error(str(error), line=line)
        return [inliner.problematic(raw, raw, said)], [said]
    old = found.record is None or found.record.is_old
    return [nodes.inline(raw, found.shown, classes=["claim"], **({"title": OLD} if old else {}))], []


def _row(one: Entry) -> str:
    state = "" if one.record is None else f"{one.record.date}, `{one.record.commit}`{', old' if one.record.is_old else ''}"
    return f"| `{one.claim.name}` | {one.claim.says} | {one.shown} | {one.claim.goal} | {state} |".replace("<", "&lt;")


def _bring(app: Any) -> None:
    lines = [
        "# Claims",
        "",
        "What the pages state, the command that measures it, and what was measured last. *Old*: the planner, the judge, the simulation or their data have",
        "changed since.",
        "",
        "```sh",
        "python -m benchmarks.claims run quick",
        "```",
    ]
    kept = records()
    for size in SIZES:
        lines += ["", f"## {size.capitalize()}", "", "| claim | what | measured | goal | when |", "|---|---|---|---|---|"]
        lines += [_row(Entry(claim=claim, record=kept.get(name))) for name, claim in claims().items() if claim.size == size]
    text, path = "\n".join(lines) + "\n", Path(app.srcdir) / "claims.md"
    if not path.is_file() or path.read_text("utf-8") != text:
        path.write_text(text, "utf-8")


def setup(app: Any) -> dict[str, Any]:
    app.add_role("claim", _claim)
    app.connect("builder-inited", _bring)
    return {"parallel_read_safe": True}
