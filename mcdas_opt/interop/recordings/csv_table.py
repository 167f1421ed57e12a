"""CSV tables from outside: a header line, then numbers."""

from __future__ import annotations

import csv
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from copy import copy
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from mcdas_opt.catalogue.data_files import read_bytes
from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.errors import InputError
from mcdas_opt.interop.recordings.recording import Row, Tally, position


@dataclass(slots=True)
class CsvTable:
    """A table with a header, and a recording that is nothing else.

    Raises `InputError` where the file cannot be read, is empty, or names a column twice.
    """

    suffixes: ClassVar[tuple[str, ...]] = (".csv",)

    path: str | Path
    header: tuple[str, ...] = ()
    _lines: tuple[tuple[int, tuple[str, ...]], ...] = ()

    def __post_init__(self) -> None:
        require_types(self)
        text = read_bytes(Path(self.path)).decode("utf-8-sig", errors="replace")
        try:
            reader = csv.reader(text.splitlines(), skipinitialspace=True)
            lines = [(reader.line_num, tuple(cell.strip() for cell in cells)) for cells in reader if any(cells)]
        except csv.Error as error:
            raise InputError(self.path, "", None, f"is no CSV table: {error}") from None
        if len(lines) < 2:
            raise InputError(self.path, "", None, "must be a CSV table with a header line and rows")
        self.header = lines[0][1]
        twice = next((name for name, count in Counter(self.header).items() if count > 1), None)
        if twice is not None:
            raise InputError(self.path, "line 1", twice, "two columns of this name")
        self._lines = tuple(lines[1:])

    @property
    def channels(self) -> tuple[str, ...]:
        return self.header

    def can_log(self) -> None:
        """A table carries no CAN."""

    def table(self, *names: str) -> CsvTable:
        """The whole file. Raises `InputError` that lists its columns where none of the names is one."""
        self.column(*names)
        return self

    def column(self, *names: str) -> int:
        """Index of the column of the first of `names` that there is; raises `InputError` that lists the columns when there is none."""
        return position(self.path, names, self.header, "column")

    def rows(self, columns: Sequence[int], bad: Tally) -> Iterator[Row]:
        """Rows with a number (or nothing) in each of `columns`; others are left out and counted in `bad`, by kind and column."""
        for line, cells in self._lines:
            if len(cells) != len(self.header):
                bad.add(f"not {len(self.header)} cells", line)
                continue
            values = []
            for column in columns:
                try:
                    values.append(float(cells[column]) if cells[column] else math.nan)
                except ValueError:
                    bad.add(f"{self.header[column]} is no number", line)
                    break
            else:
                yield Row(line=line, values=tuple(values))

    def numbered(self, column: int) -> CsvTable:
        """This table, a column that holds names (`A1`) as numbers, one for each name; a column of numbers stays as it is."""
        cells = [cells[column] for _, cells in self._lines if len(cells) == len(self.header)]
        if all(_is_number(cell) for cell in cells if cell):
            return self
        number = {name: str(k) for k, name in enumerate(dict.fromkeys(filter(None, cells)))}
        table = copy(self)
        table._lines = tuple(
            (line, (*row[:column], number.get(row[column], ""), *row[column + 1 :]) if len(row) == len(self.header) else row)
            for line, row in self._lines
        )
        return table

    def sound_rows(self, columns: Sequence[int]) -> list[Row]:
        """Every row. Raises `InputError` with the line of one that `rows` would leave out."""
        bad = Tally()
        rows = list(self.rows(columns, bad))
        if bad.total:
            kind, entry = next(iter(bad.to_document().items()))
            raise InputError(self.path, f"line {entry['first_line']}", None, kind)
        return rows


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
