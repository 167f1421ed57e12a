"""The report as Markdown, with its pictures as files beside it."""

from __future__ import annotations

from mcdas_opt.evaluation.reporting.document import Block, Cards, Heading, Paragraph, Picture, Report, Table

FIGURES = "figures"


def markdown(report: Report) -> str:
    """The text; each picture is expected at `figures/NAME`."""
    parts = [f"# {report.title}", report.subtitle, *(_block(block) for block in report.blocks), "---"]
    parts.append("\n".join(f"- {name}: `{value}`" for name, value in report.origin))
    return "\n\n".join(parts) + "\n"


def _block(block: Block) -> str:
    match block:
        case Heading():
            return f"{'#' * block.level} {block.text}"
        case Paragraph():
            return block.text
        case Table():
            return _table(block)
        case Picture():
            return f"{_image(block)}\n\n*{block.says}*"
        case Cards():
            cards = (f"### {card.title}\n\n{card.facts}\n\n{_image(card.picture)}\n\n```sh\n{card.command}\n```" for card in block.cards)
            return "\n\n".join(cards)


def _table(table: Table) -> str:
    def line(cells: list[str]) -> str:
        return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"

    rows = []
    for r, row in enumerate(table.rows):
        cells = []
        for c, cell in enumerate(row):
            text, small = cell if isinstance(cell, tuple) else (cell, "")
            text = f"**{text}**" if (r, c) in table.best else text
            cells.append(f"{text}<br>{small}" if small else text)
        rows.append(line(cells))
    head = [line(list(table.columns)), "|" + "|".join([":--"] + ["--:"] * (len(table.columns) - 1)) + "|"]
    return "\n".join([*head, *rows]) + (f"\n\n*{table.caption}*" if table.caption else "")


def _image(picture: Picture) -> str:
    return f"![{picture.says}]({FIGURES}/{picture.name})"
