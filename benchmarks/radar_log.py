"""Writes the shipped radar recording, models/logs/front_and_rear.*, with the project's own traffic, sensor model and CAN codec.

    python benchmarks/radar_log.py [FOLDER]

Front ESR on can0, rear ESR on can1, 20 scans a second: health, host speed, three target slots of which at least one is empty.
`.log` is what `mcdas-opt replay` reads, `.host.csv` the host's speed, `.truth.csv` what the radars would have said of the front and
the rear car without noise (azimuths clockwise positive, empty cells where the car is out of sight). Same bytes every time.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np

from mcdas_opt.catalogue.data_files import models_folder
from mcdas_opt.catalogue.neighbour_tables import MotionPart
from mcdas_opt.catalogue.scenes import Scene, load_scene
from mcdas_opt.catalogue.sensors import load_sensor
from mcdas_opt.domain.body import Body
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.interop.esr_can import write_esr
from mcdas_opt.interop.recordings.candump import write_candump
from mcdas_opt.simulation.neighbours import Traffic
from mcdas_opt.simulation.scripted import ScriptedMotion
from mcdas_opt.simulation.sensors import SensorSuite, mounting
from mcdas_opt.simulation.sight import View

NAME = "front_and_rear"
HOST = (
    MotionPart(start_s=3.8, acceleration_mps2=-2.5, until_speed_mps=10.0),
    MotionPart(start_s=7.5, acceleration_mps2=1.5, until_speed_mps=13.0),
)
PERIOD_S = 0.05
SLOTS = 3


def recording(scene: Scene) -> dict[str, str]:
    """The text of each file, by its suffix."""
    road, vehicle = scene.true_road, scene.vehicle
    traffic = Traffic(scene)
    suite = SensorSuite(scene.sensors, vehicle, road, scene.seed)
    drive = ScriptedMotion.from_script(s_m=0.0, d_m=0.0, speed_mps=scene.host.speed_mps, script=HOST, road=road)
    scans, speeds, said = [], [], []
    truth = ["t," + ",".join(f"{sector}_{name}" for sector in ("front", "rear") for name in ("range", "azimuth_deg", "range_rate"))]
    host_lines = ["t_s,speed_mps"]
    for k in range(round(scene.duration_s / PERIOD_S) + 1):
        t = round(k * PERIOD_S, 6)
        moment = drive(np.array(t))
        host = HostState(s_m=float(moment.s_m), speed_mps=float(moment.speed_s_mps))
        bodies = traffic.bodies(t)
        seen = suite.scans(t, host, bodies)
        scans += seen
        speeds += [host.speed_mps] * len(seen)
        host_lines.append(f"{t:g},{host.speed_mps:.4f}")
        said.append([f"{t:g}", *_truth(Sector.FRONT, 0, host, bodies, scene), *_truth(Sector.REAR, 1, host, bodies, scene)])
    frames = write_esr(scans, slots=SLOTS, speeds_mps=speeds)
    truth += [",".join(row) for row in said]
    return {
        ".log": write_candump(frames),
        ".host.csv": "\n".join(host_lines) + "\n",
        ".truth.csv": "\n".join(truth) + "\n",
    }


def _truth(sector: Sector, index: int, host: HostState, bodies: tuple[Body, ...], scene: Scene) -> list[str]:
    """Range [m], azimuth [deg, clockwise positive] and range rate [m/s] of one body without noise, or three empty cells."""
    place = mounting(sector, scene.vehicle)
    echoes = dict(View(host, bodies, scene.vehicle, scene.true_road).detections(load_sensor("delphi_esr"), place))
    if index not in echoes:
        return ["", "", ""]
    echo = echoes[index]
    return [f"{echo.range_m:.4f}", f"{-math.degrees(echo.azimuth_rad):.4f}", f"{echo.range_rate_mps:.4f}"]


def main() -> None:
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else models_folder() / "logs"
    scene = load_scene(models_folder() / "logs" / f"{NAME}.toml")
    for suffix, text in recording(scene).items():
        path = folder / f"{NAME}{suffix}"
        path.write_text(text, encoding="utf-8")
        print(f"{path}: {len(text)} bytes")


if __name__ == "__main__":
    main()
