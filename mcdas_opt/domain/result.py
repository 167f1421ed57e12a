"""What every answer can do: be read in three lines, drawn, put into a table, and written to a file."""

from __future__ import annotations

import csv
import io
import json
from abc import ABC, abstractmethod
from base64 import b64encode
from collections.abc import Mapping, Sequence
from html import escape
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Literal, overload

from mcdas_opt.domain.document import SCHEMA_VERSION, to_document
from mcdas_opt.domain.registry import imported
from mcdas_opt.domain.rules import Array, require_type, unit_of
from mcdas_opt.errors import InputError, MissingExtraError, ParameterError, writing

if TYPE_CHECKING:
    import pandas
    import polars
    from matplotlib.figure import Figure

Columns = Mapping[str, Sequence[Any] | Array]
PARQUET = ".parquet"
PICTURES = (".png", ".svg", ".pdf", ".gif", ".html")
_LIBRARIES = ("pandas", "polars")


class Result(ABC):
    """A plan, a drive, an escape map, a parking manoeuvre, a design, a benchmark.

    `drawn_by` names the function that draws it ("module:function"); drawing stands above the records and is imported only when it is
    asked for. `moves_by` names the one that writes it as an animation into a file (.gif), `plays_by` the one that makes a page that plays
    (.html) of it; empty where it does not.
    """

    __slots__ = ()
    drawn_by: ClassVar[str]
    moves_by: ClassVar[str] = ""
    plays_by: ClassVar[str] = ""

    @abstractmethod
    def in_brief(self) -> tuple[str, str, str]:
        """What matters, in three lines."""

    @abstractmethod
    def columns(self) -> Columns:
        """The table that it is: equally long columns by name."""

    def to_dict(self) -> dict[str, Any]:
        """The JSON document of the contract."""
        return {"schema_version": SCHEMA_VERSION, **to_document(self)}

    def __repr__(self) -> str:
        return "\n  ".join(self.in_brief())

    def _repr_html_(self) -> str:
        """The picture, where there is one, and every single value of the document, for notebooks."""
        try:
            png = b64encode(imported(self.drawn_by)(self)._repr_png_()).decode()
            picture = f'<img style="max-width: 100%" alt="{escape(self.in_brief()[0])}" src="data:image/png;base64,{png}">'
        except ParameterError:
            picture = ""
        return f"<div>{picture}<pre>{escape(repr(self))}</pre>{_facts(self.to_dict())}</div>"

    def plot(self, path: str | Path | None = None) -> Figure:
        """The picture; with `path` it is written there too: .png, .svg or .pdf, and where it moves .gif or .html (plays and scrubs).

        Raises `InputError` for another suffix or a missing folder, `ParameterError` for what cannot be drawn.
        """
        if path is not None:
            require_type("path", path, str, Path)
        figure: Figure = imported("mcdas_opt.plotting.export:plot")(self, path)
        return figure

    def to_json(self, indent: int | None = None) -> str:
        """The JSON document of the contract as text; holds no NaN."""
        return json.dumps(self.to_dict(), allow_nan=False, indent=indent)

    @overload
    def to_dataframe(self, library: Literal["pandas"] = ...) -> pandas.DataFrame: ...
    @overload
    def to_dataframe(self, library: Literal["polars"]) -> polars.DataFrame: ...
    def to_dataframe(self, library: str = "pandas") -> pandas.DataFrame | polars.DataFrame:
        """`columns` as a data frame of pandas or polars. Raises `MissingExtraError` where that is not installed."""
        if library not in _LIBRARIES:
            raise ParameterError("library", library, "must be pandas or polars")
        try:
            made = import_module(library).DataFrame({name: list(column) for name, column in self.columns().items()})
        except ModuleNotFoundError:
            raise MissingExtraError(library, "dataframe") from None
        return made

    def save(self, path: str | Path) -> Path:
        """Writes the document (.json), the table (.csv, .parquet) or the picture (as `plot`). Raises `InputError` where that cannot be,
        `MissingExtraError` for .parquet without pyarrow."""
        require_type("path", path, str, Path)
        path, suffix = Path(path), Path(path).suffix.lower()
        text = self.as_text(suffix)
        if text is None and suffix != PARQUET:
            if suffix not in PICTURES:
                rule = f"must end in .json (the document), .csv or {PARQUET} (the table), or {', '.join(PICTURES)} (a picture)"
                raise InputError(path, "", None, rule)
            self.plot(path)
            return path
        if not path.parent.is_dir():
            raise InputError(path, "", None, "no such folder")
        data = _parquet(self.columns()) if text is None else text.encode()
        with writing(path):
            path.write_bytes(data)
        return path

    def as_text(self, suffix: str) -> str | None:
        """What stands in a file of that suffix; None where it would be a picture."""
        if suffix == ".json":
            return self.to_json(indent=1) + "\n"
        return _table(self.columns()) if suffix == ".csv" else None


def _table(columns: Columns) -> str:
    """CSV, a header first; numbers to the last bit, nothing for None."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*(to_document(list(column)) for column in columns.values()), strict=True))
    return text.getvalue()


def _parquet(columns: Columns) -> bytes:
    """The table as a Parquet file."""
    try:
        from pyarrow import BufferOutputStream, Table
        from pyarrow.parquet import write_table
    except ImportError:
        raise MissingExtraError("pyarrow", "parquet") from None
    sink = BufferOutputStream()
    write_table(Table.from_pydict({name: to_document(list(column)) for name, column in columns.items()}), sink)
    data: bytes = sink.getvalue().to_pybytes()
    return data


def _facts(document: Mapping[str, Any]) -> str:
    """The single values of a document as an HTML table, with their units."""
    rows = ((name, value) for name, value in document.items() if isinstance(value, (str, int, float)) and value != "")
    cells = "".join(f"<tr><th>{escape(name)}</th><td>{escape(_shown(name, value))}</td></tr>" for name, value in rows)
    return f"<table>{cells}</table>"


def _shown(name: str, value: object) -> str:
    return f"{value:.4g} {unit_of(name)}".rstrip() if isinstance(value, float) else str(value)
