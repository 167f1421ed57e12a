"""An .rrd for Rerun's viewer. Such files are read by one minor version of Rerun: look at them, do not archive them.

Written to a file, nothing is started and nothing is sent. The viewer sends analytics by default; `show` turns that off before it opens.
Everything is drawn in three dimensions: Rerun's two-dimensional view has y pointing down.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

from mcdas_opt.errors import InputError, of_extra
from mcdas_opt.interop.logs.moments import HEIGHT_M, Box, lines, moments
from mcdas_opt.simulation.record import Simulation

APPLICATION = "mcdas-opt"
_HOST, _OTHER, _TRACK, _PATH, _ROAD = (0, 114, 178), (230, 159, 0), (86, 180, 233), (0, 158, 115), (120, 120, 125)


def write_rrd(drive: Simulation, path: str | Path) -> Path:
    """The drive at `path`. Raises `MissingExtraError` without rerun-sdk, `InputError` where the file cannot be written."""
    rr = _rerun()
    path = Path(path)
    if not path.parent.is_dir():
        raise InputError(path, "", None, "cannot be written: no such folder")
    recording = rr.RecordingStream(APPLICATION, recording_id=drive.name)
    try:
        recording.save(str(path))
    except (OSError, RuntimeError) as error:
        raise InputError(path, "", None, f"cannot be written: {error}") from None
    recording.log("/", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    for name, points in lines(drive).items():
        recording.log(f"road/{name}", rr.LineStrips3D([_raised(points)], colors=[_ROAD], radii=[0.08]), static=True)
    for moment in moments(drive):
        recording.set_time("drive", duration=moment.t_s)
        host, *others = moment.bodies
        recording.log("host", _boxes(rr, [host], _HOST))
        recording.log("neighbours", _boxes(rr, others, _OTHER))
        for name, value in moment.host.items():
            recording.log(f"numbers/{name}", rr.Scalars(value))
        if moment.plan is not None:
            recording.log("plan/path", rr.LineStrips3D([_raised(moment.path)], colors=[_PATH], radii=[0.12]))
            recording.log("plan/tracks", _boxes(rr, list(moment.tracks), _TRACK))
            recording.log("plan/said", rr.TextLog(f"{moment.plan.mode.value} ({moment.plan.status.value}): {moment.plan.reason}"))
    recording.flush()
    recording.disconnect()
    return path


def show(path: Path) -> None:
    """Opens a file in Rerun's viewer, its analytics disabled first (they stay so for this user: `rerun analytics enable` undoes it)."""
    _rerun()
    quiet = subprocess.run([sys.executable, "-m", "rerun", "analytics", "disable"], capture_output=True, text=True, check=False)
    if quiet.returncode != 0:
        raise InputError("rerun", "analytics", None, f"could not be disabled, so the viewer is not opened: {quiet.stderr.strip()}")
    subprocess.Popen([sys.executable, "-m", "rerun", str(path)])


def _rerun() -> Any:
    with of_extra("rerun-sdk", "rerun"):
        import rerun
    return rerun


def _boxes(rr: Any, boxes: list[Box], colour: tuple[int, int, int]) -> Any:
    return rr.Boxes3D(
        centers=[(box.x_m, box.y_m, 0.5 * HEIGHT_M) for box in boxes],
        half_sizes=[(0.5 * box.length_m, 0.5 * box.width_m, 0.5 * HEIGHT_M) for box in boxes],
        rotation_axis_angles=[rr.RotationAxisAngle(axis=(0.0, 0.0, 1.0), radians=box.yaw_rad) for box in boxes],
        colors=[colour] * len(boxes),
        labels=[box.name for box in boxes],
    )


def _raised(points: np.ndarray[Any, np.dtype[np.float64]]) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.column_stack([points, np.full(len(points), 0.05)])
