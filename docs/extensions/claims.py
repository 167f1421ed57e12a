"""Figures that pages state come from benchmarks/claims: {claim}`name` is the value measured last, and the page of all of them is made."""

from __future__ import annotations

import sys
from functools import lru_cache
from pathlib import Path
from typing import Any

from docutils import nodes

sys.path.insert(0, str(Path(__file__).parents[2]))

from benchmarks.claims.book import SIZES, Entry, claims, records
from mcdas_opt.errors import nearest


@lru_cache(maxsize=1)
def _entries() -> dict[str, Entry]:
    """Of this build."""
    kept = records()
    return {name: Entry(claim=claim, record=kept.get(name)) for name, claim in claims().items()}


def _claim(
    role: str, raw: str, text: str, line: int, inliner: Any, options: Any = None, content: Any = None
) -> tuple[list[Any], list[Any]]:
    found = _entries().get(text)
    if found is None:
        said = inliner.reporter.error(f"claim: {nearest(text, _entries())}", line=line)
        return [inliner.problematic(raw, raw, said)], [said]
    old = found.record is not None and found.record.is_old
    return [nodes.inline(raw, found.shown, classes=["claim", "old"] if old else ["claim"])], []


def _row(one: Entry) -> str:
    state = "" if one.record is None else f"{one.record.date}, `{one.record.commit}`{', old' if one.record.is_old else ''}"
    return f"| `{one.claim.name}` | {one.claim.says} | {one.shown} | {one.claim.goal} | {state} |".replace("<", "&lt;")


def _bring(app: Any) -> None:
    lines = [
        "# Claims",
        "",
        "What the pages state, and what was measured last. *Old*: the planner, the judge, the simulation or their data have changed since. Every claim can be",
        "measured again by its name or its size, in the clone's own folder:",
        "",
        "```sh",
        "python -m benchmarks.claims run quick             # those under Quick: some minutes",
        "python -m benchmarks.claims run full              # those under Full: an hour or two",
        "python -m benchmarks.claims run sandwich-lost     # one, or several, by name",
        "```",
        "",
        "The command that a claim runs, and the value that it reads, stand in `benchmarks/claims/*.toml` under that name.",
    ]
    for size in SIZES:
        lines += ["", f"## {size.capitalize()}", "", "| claim | what | measured | goal | when |", "|---|---|---|---|---|"]
        lines += [_row(one) for one in _entries().values() if one.claim.size == size]
    text, path = "\n".join(lines) + "\n", Path(app.srcdir) / "claims.md"
    if not path.is_file() or path.read_text("utf-8") != text:
        path.write_text(text, "utf-8")


def setup(app: Any) -> dict[str, Any]:
    app.add_role("claim", _claim)
    app.connect("builder-inited", _bring)
    return {"parallel_read_safe": True}
