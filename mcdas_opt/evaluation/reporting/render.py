"""The report as files: one HTML page that needs nothing else, and Markdown with its pictures as files beside it."""

from __future__ import annotations

from functools import lru_cache

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape

from mcdas_opt.evaluation.reporting.document import Report

FIGURES = "figures"


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
