"""What a command draws, by the suffix of the file that it is asked for."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from mcdas_opt.domain.parking import Parking, ParkingCase
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.result import Result, called
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import InputError, ParameterError, writing
from mcdas_opt.parking.closed_loop.record import ParkingDrive
from mcdas_opt.simulation.record import Simulation

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mcdas_opt.plotting.replay import DrawnReplay

MOVING = (".gif", ".png", ".html")
STILL = (".png", ".svg", ".pdf")


def check_picture(path: Path, suffixes: tuple[str, ...] = MOVING) -> Path:
    """`path`, if a picture can be written there. Raises `InputError` for another suffix, or a missing folder."""
    if path.suffix.lower() not in suffixes:
        raise InputError(path, "", None, f"a picture must end in {' or '.join(filter(None, (', '.join(suffixes[:-1]), suffixes[-1])))}")
    if not path.parent.is_dir():
        raise InputError(path, "", None, "no such folder")
    return path


def save_drive(simulation: Simulation, path: Path) -> Path:
    """A drive as an animation (.gif), a sheet of moments (.png) or a page that plays and scrubs (.html)."""
    from mcdas_opt.plotting import animation, player

    with whole_file(check_picture(path)) as file:
        (player.save_drive if _is_page(path) else animation.save)(simulation, file)
    return path


def save_replay(replay: DrawnReplay, path: Path) -> Path:
    """A recording as a page that plays and scrubs (.html)."""
    from mcdas_opt.plotting import replay_player

    with whole_file(check_picture(path, (".html",))) as file:
        replay_player.save(replay, file)
    return path


def save_parking(case: ParkingCase, parking: Parking, path: Path) -> Path | None:
    """A manoeuvre as an animation (.gif), a sheet (.png) or a page (.html); None for a refusal, of which only a page shows anything."""
    from mcdas_opt.plotting import parking as still
    from mcdas_opt.plotting import player

    check_picture(path)
    if parking.trajectory is None and not _is_page(path):
        return None
    with whole_file(path) as file:
        (player.save_parking if _is_page(path) else still.save)(case, parking, file)
    return path


def save_follow(truth: ParkingCase, drive: ParkingDrive, path: Path) -> Path:
    """A manoeuvre that was driven, as an animation (.gif), a sheet (.png) or a page (.html)."""
    from mcdas_opt.plotting import parking_follow, player

    with whole_file(check_picture(path)) as file:
        (player.save_follow if _is_page(path) else parking_follow.save)(truth, drive, file)
    return path


def save_plan(situation: Situation, vehicle: Vehicle, plan: Plan, path: Path) -> Path:
    """A plan in its situation as a sheet (.png), an animation of what it means to do (.gif), or a page that looks ahead (.html)."""
    from mcdas_opt.plotting import plan_sheet, player

    with whole_file(check_picture(path)) as file:
        (player.save_plan if _is_page(path) else plan_sheet.save)(situation, vehicle, plan, file)
    return path


def save_result(result: Result, path: Path | None) -> Figure:
    """Any answer's figure; written to `path` as that, or as an animation or a page where the answer moves and the suffix says so."""
    from mcdas_opt.plotting.style import save_still

    if not isinstance(result, Result):
        raise ParameterError("result", result, "is no answer of this package: a plan, a drive, escapes, parking, a design, a benchmark")
    if path is not None:
        check_picture(path, (*STILL, ".gif", ".html") if result.moves_by else STILL)
    figure: Figure = called(result.drawn_by)(result)
    if path is None:
        return figure
    if path.suffix.lower() in STILL:
        with whole_file(path) as file:
            save_still(figure, file)
    else:
        called(result.moves_by)(result, path)
    return figure


def plot(result: Result, path: str | Path | None = None) -> Figure:
    """The picture of any answer, as its own `plot`. Raises `InputError` for a suffix that is no picture's, or a missing folder."""
    return save_result(result, None if path is None else Path(path))


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


def _is_page(path: Path) -> bool:
    return path.suffix.lower() == ".html"
