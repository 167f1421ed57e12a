"""The table of rows as files: CSV always, Parquet where pyarrow is there."""

from __future__ import annotations

import csv
import importlib.util
import io
import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mcdas_opt.catalogue.data_files import read_text
from mcdas_opt.domain.parsing import parsed_json
from mcdas_opt.evaluation.running.journal import write_whole

if TYPE_CHECKING:
    from mcdas_opt.evaluation.benchmark import Results

CSV, PARQUET, TIMINGS = "rows.csv", "rows.parquet", "timings.csv"


def write_table(folder: Path, results: Results, origin: dict[str, Any]) -> Path:
    """`rows.csv`, `timings.csv` (seconds of every drive, milliseconds of every plan), and `rows.parquet` if there is pyarrow.

    Returns the path of the first.

    `origin` (suite hash, seed, versions, commit ...) stands in the CSV's first line, behind a #, and in the Parquet file's metadata.
    """
    rows = results.rows
    columns = list(rows[0]) if rows else []
    text = io.StringIO()
    text.write(f"# {json.dumps(origin)}\n")
    table = csv.DictWriter(text, columns, lineterminator="\n")
    table.writeheader()
    table.writerows({name: _cell(row[name]) for name in columns} for row in rows)
    write_whole(folder / CSV, text.getvalue())
    lines = [f"# {json.dumps(origin)}", "index,planner,took_s,cycles_ms"]
    for row, took, cycles in zip(rows, results.took_s, results.cycles_ms, strict=True):
        lines.append(f"{row['index']},{row['planner']},{took:g},{' '.join(f'{ms:g}' for ms in cycles)}")
    write_whole(folder / TIMINGS, "\n".join(lines) + "\n")
    if importlib.util.find_spec("pyarrow") is not None:
        _write_parquet(folder / PARQUET, rows, origin)
    return folder / CSV


def read_table(path: Path) -> tuple[dict[str, Any], list[dict[str, str]]]:
    """(origin, rows as text) of a `rows.csv`."""
    first, _, rest = read_text(path).partition("\n")
    origin: dict[str, Any] = parsed_json(first.removeprefix("# "), path)
    return origin, list(csv.DictReader(io.StringIO(rest)))


def markdown_table(head: Sequence[str], rows: Sequence[tuple[str, Sequence[str]]]) -> str:
    """A table of titles, and cells behind each."""
    lines = [" | ".join(head), "|".join(["---"] * len(head)), *(" | ".join([title, *cells]) for title, cells in rows)]
    return "".join(f"| {line} |\n" for line in lines)


def _cell(value: Any) -> Any:
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value) if isinstance(value, float) else value


def _write_parquet(path: Path, rows: Sequence[dict[str, Any]], origin: dict[str, Any]) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pa.Table.from_pylist(list(rows)).replace_schema_metadata({"mcdas_opt": json.dumps(origin)})
    sink = pa.BufferOutputStream()
    pq.write_table(table, sink)
    write_whole(path, sink.getvalue().to_pybytes())
