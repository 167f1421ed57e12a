"""Speeds on the command line: metres per second, or with their unit."""

from __future__ import annotations

import math
import re
from typing import Annotated

import typer

from mcdas_opt.cli.log import hint

_UNITS = {"": 1.0, "m/s": 1.0, "mps": 1.0, "km/h": 1 / 3.6, "kmh": 1 / 3.6, "kph": 1 / 3.6, "mph": 0.44704}
_SPEED = re.compile(r"\s*([-+]?[0-9.]+(?:e[-+]?[0-9]+)?)\s*([a-z/]*)\s*", re.IGNORECASE)
_SAID = "[m/s], or with its unit (m/s, mps, km/h, kmh, kph, mph), as 60km/h"
_DOUBTED_MPS = 36.0  # 130 km/h: whoever writes more without a unit may mean km/h


def speed(text: str | float) -> float:
    """`16.7`, `16.7m/s` or `60km/h` as m/s. A bare number that looks like km/h is taken as it stands, and asked about on stderr."""
    if isinstance(text, float):
        return text
    found = _SPEED.fullmatch(text)
    scale = None if found is None else _UNITS.get(found[2].lower())
    try:
        value = math.nan if found is None or scale is None else float(found[1]) * scale
    except ValueError:
        value = math.nan
    if found is None or not 0.0 <= value < math.inf:
        raise typer.BadParameter(f"{text!r} is not a speed: a number in m/s that is not negative, or with its unit, as 60km/h")
    if not found[2] and value > _DOUBTED_MPS:
        hint(f"speed {value:g} is in m/s, which is {3.6 * value:.0f} km/h; if km/h is meant, write {value:g}km/h")
    return value


Speed = Annotated[float, typer.Option("--speed", parser=speed, metavar="SPEED", help=f"Speed K {_SAID}.")]
HostSpeed = Annotated[
    float | None, typer.Option("--speed", parser=speed, metavar="SPEED", help=f"Host speed {_SAID}, where no radar is told it.")
]
FrontSpeed = Annotated[
    float | None, typer.Option("--front-speed", parser=speed, metavar="SPEED", help=f"Its speed {_SAID}; default 20 km/h less.")
]
RearSpeed = Annotated[
    float | None, typer.Option("--rear-speed", parser=speed, metavar="SPEED", help=f"Its speed {_SAID}; default 20 km/h more.")
]
DesiredSpeed = Annotated[
    float | None,
    typer.Option("--desired", parser=speed, metavar="SPEED", help=f"Desired speed {_SAID}; default the speed limit."),
]
SpeedBounds = Annotated[
    tuple[str, str] | None,
    typer.Option("--speed-bounds", metavar="LOW HIGH", help=f"K is chosen too, between these {_SAID}."),
]
