"""The report: headings, paragraphs, tables, pictures and cards; as one HTML page that needs nothing else, and as Markdown."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape

FIGURES = "figures"


@dataclass(frozen=True, slots=True, kw_only=True)
class Heading:
    kind: ClassVar[str] = "heading"
    text: str
    level: int = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Paragraph:
    kind: ClassVar[str] = "paragraph"
    text: str


@dataclass(frozen=True, slots=True)
class Cell:
    """A cell's text, perhaps a second, smaller line, whether it stands out, and the file beside the report that it leads to."""

    text: str
    small: str = ""
    best: bool = False
    page: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """The first column names the row. `is_text`: the others hold words, not numbers."""

    kind: ClassVar[str] = "table"
    columns: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    caption: str = ""
    is_text: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Bar:
    """A share with its interval, all between 0 and 1, and what it counts."""

    name: str
    rate: float
    low: float
    high: float
    says: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Bars:
    """Shares under one another, on one scale."""

    kind: ClassVar[str] = "bars"
    bars: Sequence[Bar]
    caption: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """A PNG; `name` is the file that the Markdown version refers to."""

    kind: ClassVar[str] = "picture"
    name: str
    png: bytes
    says: str

    @property
    def data_url(self) -> str:
        return f"data:image/png;base64,{base64.b64encode(self.png).decode()}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Card:
    """One scene: a title, facts, a picture, the command that drives it again, and the file beside it that plays it (empty: none)."""

    title: str
    facts: str
    picture: Picture
    command: str
    page: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Cards:
    kind: ClassVar[str] = "cards"
    cards: Sequence[Card]


Block = Heading | Paragraph | Table | Bars | Picture | Cards


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    title: str
    subtitle: str
    blocks: Sequence[Block]
    origin: Sequence[tuple[str, str]]  # suite hash, seed, versions, commit

    @property
    def pictures(self) -> list[Picture]:
        found: list[Picture] = []
        for block in self.blocks:
            if isinstance(block, Picture):
                found.append(block)
            elif isinstance(block, Cards):
                found += [card.picture for card in block.cards]
        return found


def html(report: Report) -> str:
    """The whole page: no script, no network, pictures inside."""
    return _templates().get_template("report.html").render(report=report)


def markdown(report: Report) -> str:
    """The text; each picture is expected at `figures/NAME`."""
    return _templates().get_template("report.md").render(report=report, figures=FIGURES)


@lru_cache(maxsize=1)
def _templates() -> Environment:
    return Environment(
        loader=PackageLoader("mcdas_opt.evaluation.reporting"),
        autoescape=select_autoescape(["html"]),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
