"""The visual language in a browser: the same colours by meaning, a line style for every planner, and the drawing scripts.

The scripts and the style sheet are files of this package (`web/`), served by the studio and written into self-contained pages alike:
neither needs a network.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from html import escape
from pathlib import Path
from string import Template
from typing import Any

from mcdas_opt.plotting import style

_FOLDER = Path(__file__).resolve().parent / "web"
_POLICY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:"
_SCRIPTS = ("draw.js", "bird.js", "strip.js", "transport.js", "bands.js", "drive.js", "parking.js", "outlook.js")


@dataclass(frozen=True, slots=True, kw_only=True)
class Look:
    """How a planner's line looks: its colour, and its dashes (SVG), so that colour alone never tells."""

    label: str
    colour: str
    dash: str


PLANNERS = {
    "closed-form": Look(label="literal", colour=style.PURPLE, dash="2 4"),
    "closed-form-corrected": Look(label="corrected", colour=style.GREEN, dash="9 5"),
    "closed-form-tuned": Look(label="tuned", colour=style.BLACK, dash="8 3 2 3"),
    "mpc": Look(label="MPC", colour=style.PLAN, dash=""),
}
_DARK = {
    "paper": "#17191c",
    "ink": "#e2e4e8",
    "grid": "#3a3e44",
    "asphalt": "#2b2e33",
    "edge": "#8d9199",
    "marking": "#c9ccd1",
    "obstacle": "#5b6068",
    "black": "#f0f1f3",
    "grey": "#a3a8af",
    "plan": "#4aa8e0",
}
_OTHER_COLOURS = (style.ORANGE, style.SKY, style.VERMILION, style.GREY)
_OTHER_DASHES = ("14 4", "3 3", "12 3 2 3 2 3", "6 2")


def look_of(planner: str, others: Sequence[str] = ()) -> dict[str, str]:
    """Label, colour and dashes of a planner; those of one that is none of `PLANNERS` follow from its place among `others`."""
    look = PLANNERS.get(planner)
    if look is None:
        k = list(others).index(planner) if planner in others else 0
        colours, dashes = len(_OTHER_COLOURS), len(_OTHER_DASHES)
        look = Look(label=planner, colour=_OTHER_COLOURS[k % colours], dash=_OTHER_DASHES[(k + k // colours) % dashes])
    return asdict(look)


def palette(dark: bool = False) -> dict[str, str]:
    """Colours by meaning, for the scripts; on a dark page what stands on the paper is light."""
    light = {
        "paper": "#ffffff",
        "ink": "#222222",
        "grid": "#e2e2e2",
        "asphalt": style.ASPHALT,
        "edge": style.EDGE,
        "marking": style.MARKING,
        "obstacle": "#c9c9ce",
        "black": style.BLACK,
        "grey": "#5f5f5f",
        "host": style.HOST,
        "front": style.FRONT,
        "rear": style.REAR,
        "plan": style.PLAN,
        "track": style.PURPLE,
        "danger": style.VERMILION,
        "safe": style.GREEN,
        "forward": style.BLUE,
        "reverse": style.ORANGE,
    }
    return {**light, **_DARK} if dark else light


def script() -> str:
    """The drawing scripts, in the order in which they build on one another; they make one global, `mcdas`."""
    return "\n".join((_FOLDER / name).read_text(encoding="utf-8") for name in _SCRIPTS)


def style_sheet() -> str:
    return (_FOLDER / "pictures.css").read_text(encoding="utf-8")


def in_script(document: Any) -> str:
    """JSON that may stand inside a script element whatever its texts hold: no '<' is left, so no tag can begin or end in it.

    Raises `ValueError` for NaN and infinity.
    """
    text = json.dumps(document, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def page(title: str, view: str, document: Any) -> str:
    """A self-contained HTML page that shows `document` in the script's class `view` (`Drive`, `Parking` or `PlanPage`)."""
    return Template((_FOLDER / "page.html").read_text(encoding="utf-8")).substitute(
        policy=_POLICY,
        title=escape(title),
        style=style_sheet(),
        script=script(),
        dark=in_script(palette(dark=True)),
        light=in_script(palette()),
        view=view,
        document=in_script(document),
    )
