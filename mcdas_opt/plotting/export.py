"""What a command draws, by the suffix of the file that it is asked for."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from mcdas_opt.domain.arithmetic import usual_arithmetic
from mcdas_opt.domain.registry import imported
from mcdas_opt.domain.result import Result
from mcdas_opt.errors import InputError, ParameterError, writing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOVING = (".gif", ".png", ".html")
STILL = (".png", ".svg", ".pdf")


def check_picture(path: Path, suffixes: tuple[str, ...] = MOVING) -> Path:
    """`path`, if a picture can be written there. Raises `InputError` for another suffix, or a missing folder."""
    if path.suffix.lower() not in suffixes:
        raise InputError(path, "", None, f"a picture must end in {' or '.join(filter(None, (', '.join(suffixes[:-1]), suffixes[-1])))}")
    if not path.parent.is_dir():
        raise InputError(path, "", None, "no such folder")
    return path


def save_picture(result: Result, path: Path, figure: Figure | None = None) -> Path:
    """Any answer's picture by the suffix: its figure, which may be drawn already, an animation (.gif) or a page that plays (.html)."""
    from mcdas_opt.plotting.style import save_still

    moving = ((".gif", result.moves_by), (".html", result.plays_by))
    suffix = check_picture(path, (*STILL, *(suffix for suffix, by in moving if by))).suffix.lower()
    with whole_file(path) as file:
        if suffix == ".html":
            file.write_text(imported(result.plays_by)(result), encoding="utf-8")
        elif suffix == ".gif":
            imported(result.moves_by)(result, file)
        else:
            save_still(imported(result.drawn_by)(result) if figure is None else figure, file)
    return path


@usual_arithmetic
def plot(result: Result, path: str | Path | None = None) -> Figure:
    """The picture of any answer, as its own `plot`. Raises `InputError` for a suffix that is no picture's, or a missing folder."""
    if not isinstance(result, Result):
        raise ParameterError("result", result, "is no answer of this package: a plan, a drive, escapes, parking, a design, a benchmark")
    figure: Figure = imported(result.drawn_by)(result)
    if path is not None:
        save_picture(result, Path(path), figure)
    return figure


def save_figure(figure: Figure, path: Path) -> Path:
    """A figure that is already drawn (.png)."""
    from mcdas_opt.plotting.style import save_png

    with whole_file(check_picture(path, (".png",))) as file:
        save_png(figure, file)
    return path


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A file beside `path` to draw into, which takes its name when it is complete: what was there stays until then, and nothing
    half-written is left. Raises `InputError` where the disk or the folder takes no more."""
    beside = path.with_name(f".{path.stem}-{os.getpid()}{path.suffix}")
    try:
        with writing(path):
            yield beside
            os.replace(beside, path)
    finally:
        with suppress(OSError):
            beside.unlink()
