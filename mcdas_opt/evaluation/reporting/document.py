"""The report before it has a form: headings, paragraphs, tables, pictures and cards."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Heading:
    text: str
    level: int = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Paragraph:
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """The first column names the row. `best` marks cells (row, column) that stand out; a cell may have a second, smaller line."""

    columns: Sequence[str]
    rows: Sequence[Sequence[str | tuple[str, str]]]
    caption: str = ""
    best: frozenset[tuple[int, int]] = frozenset()


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """A PNG; `name` is the file that the Markdown version refers to."""

    name: str
    png: bytes
    says: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Card:
    """One scene: a title, facts, a picture and the command that replays it."""

    title: str
    facts: str
    picture: Picture
    command: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Cards:
    cards: Sequence[Card]


Block = Heading | Paragraph | Table | Picture | Cards


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
