"""The report as one HTML file that needs nothing else: no script, no network, pictures inside."""

from __future__ import annotations

import base64
from html import escape

from mcdas_opt.evaluation.reporting.document import Block, Card, Cards, Heading, Paragraph, Picture, Report, Table

_STYLE = """
:root { --ink: #1b1f24; --soft: #59636e; --line: #d9dee4; --paper: #ffffff; --shade: #f4f6f8; --accent: #0072b2; }
* { box-sizing: border-box; }
body { margin: 0; color: var(--ink); background: var(--paper); font: 15px/1.5 system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
main, header > div, footer > div { max-width: 1360px; margin: 0 auto; padding: 0 24px; }
header { background: var(--shade); border-bottom: 1px solid var(--line); padding: 28px 0 22px; }
h1 { margin: 0 0 4px; font-size: 26px; line-height: 1.25; }
h2 { margin: 40px 0 10px; font-size: 20px; }
h3 { margin: 26px 0 8px; font-size: 16px; }
p { max-width: 82ch; margin: 8px 0; }
.subtitle { color: var(--soft); margin: 0; }
.wide { overflow-x: auto; margin: 12px 0 4px; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: 14px; }
th, td { padding: 6px 6px; text-align: right; white-space: nowrap; border-bottom: 1px solid var(--line); vertical-align: top; }
thead th { border-bottom: 2px solid var(--ink); vertical-align: bottom; white-space: normal; max-width: 11em; font-weight: 600; }
th:first-child, td:first-child { text-align: left; padding-left: 0; font-weight: 600; }
td small { display: block; color: var(--soft); font-size: 11px; line-height: 1.3; white-space: normal; }
td.best { color: var(--accent); font-weight: 700; }
tbody tr:hover { background: var(--shade); }
.caption { color: var(--soft); font-size: 13px; }
figure { margin: 14px 0 6px; }
figure img { max-width: 100%; height: auto; display: block; }
figcaption { color: var(--soft); font-size: 13px; max-width: 82ch; }
.cards { display: grid; grid-template-columns: repeat(auto-fill, minmax(500px, 1fr)); gap: 18px; }
.card { border: 1px solid var(--line); border-radius: 6px; padding: 12px 14px; min-width: 0; }
.card h3 { margin: 0 0 2px; }
.card p { margin: 0 0 8px; color: var(--soft); font-size: 13px; }
.card img { width: 100%; height: auto; display: block; }
code { display: block; overflow-x: auto; white-space: nowrap; background: var(--shade); border-radius: 4px; padding: 6px 8px;
  margin-top: 8px; font: 12px/1.4 ui-monospace, "DejaVu Sans Mono", monospace; }
footer { margin-top: 48px; border-top: 1px solid var(--line); padding: 18px 0 40px; color: var(--soft); font-size: 13px; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: 2px 18px; margin: 0; }
dt { font-weight: 600; }
dd { margin: 0; overflow-wrap: anywhere; }
@media (max-width: 600px) { .cards { grid-template-columns: 1fr; } main, header > div, footer > div { padding: 0 14px; } }
@media print { .card { break-inside: avoid; } }
"""


def html(report: Report) -> str:
    """The whole file."""
    origin = "".join(f"<dt>{escape(name)}</dt><dd>{escape(value)}</dd>" for name, value in report.origin)
    body = "\n".join(_block(block) for block in report.blocks)
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n<link rel="icon" href="data:,">\n'
        f"<title>{escape(report.title)}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n"
        f'<header><div><h1>{escape(report.title)}</h1><p class="subtitle">{escape(report.subtitle)}</p></div></header>\n'
        f"<main>\n{body}\n</main>\n<footer><div><dl>{origin}</dl></div></footer>\n</body>\n</html>\n"
    )


def _block(block: Block) -> str:
    match block:
        case Heading():
            return f"<h{block.level}>{escape(block.text)}</h{block.level}>"
        case Paragraph():
            return f"<p>{escape(block.text)}</p>"
        case Table():
            return _table(block)
        case Picture():
            return f"<figure>{_image(block)}<figcaption>{escape(block.says)}</figcaption></figure>"
        case Cards():
            return '<div class="cards">' + "".join(_card(card) for card in block.cards) + "</div>"


def _table(table: Table) -> str:
    head = "".join(f'<th scope="col">{escape(name)}</th>' for name in table.columns)
    rows = []
    for r, row in enumerate(table.rows):
        cells = []
        for c, cell in enumerate(row):
            text, small = cell if isinstance(cell, tuple) else (cell, "")
            inner = escape(text) + (f"<small>{_unbroken(small)}</small>" if small else "")
            cells.append(f'<td class="best">{inner}</td>' if (r, c) in table.best else f"<td>{inner}</td>")
        rows.append(f"<tr>{''.join(cells)}</tr>")
    caption = f'<p class="caption">{escape(table.caption)}</p>' if table.caption else ""
    return f'<div class="wide"><table><thead><tr>{head}</tr></thead><tbody>{"".join(rows)}</tbody></table></div>{caption}'


def _unbroken(text: str) -> str:
    """Breaks between a share and its interval, where there is no room for both; never inside one."""
    return escape(text).replace(", ", ",&nbsp;").replace(" .. ", "&nbsp;..&nbsp;").replace("(n ", "(n&nbsp;")


def _card(card: Card) -> str:
    return (
        f'<article class="card"><h3>{escape(card.title)}</h3><p>{escape(card.facts)}</p>{_image(card.picture)}'
        f"<code>{escape(card.command)}</code></article>"
    )


def _image(picture: Picture) -> str:
    data = base64.b64encode(picture.png).decode()
    return f'<img alt="{escape(picture.says, quote=True)}" src="data:image/png;base64,{data}">'
