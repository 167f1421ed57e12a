"""Files of every kind, made unsound: read, or refused in one sentence that names the file."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.attack.mutators import mutated
from benchmarks.attack.tally import Tally
from mcdas_opt import load_parking_case, load_scene, load_sensor, load_situation, load_trajectory, load_vehicle, plan
from mcdas_opt.catalogue.data_files import find, models_folder
from mcdas_opt.catalogue.designs import load_parameters, load_schedule
from mcdas_opt.catalogue.motion import load_motion
from mcdas_opt.evaluation.suites import expand
from mcdas_opt.interop.esr_codec import EsrCodec
from mcdas_opt.interop.host_motion import HostMotion
from mcdas_opt.interop.recordings.candump import read_candump
from mcdas_opt.interop.recordings.csv_table import CsvTable
from mcdas_opt.interop.target_list import read_targets
from mcdas_opt.interop.truth import read_truth

Load = Callable[[str], object]
_LONGEST = 40_000  # of a sound file: of a recording its beginning
_TPCAP = b"0,0,0,9,1.3,0,2,4,4,2,1,4,1,4,3,2,3,5,-3,7,-3,7,-2,5,-2\n"
_RADAR = b"t_s,id,x_m,y_m,vx_mps,vy_mps\n0.0,1,30.0,0.1,-2.0,0.0\n0.05,1,29.9,0.1,-2.0,0.0\n0.1,1,29.8,0.1,-2.0,0.0\n"
_PARAMETERS = b'schema_version = 1\n[parameters]\n"cost.effort" = 1.0\n'


def attack(tally: Tally, count: int, seed: int) -> None:
    """As many files of each kind as of any other."""
    r = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as name:
        kinds = list(_kinds(Path(name)))
        for k in range(count):
            file, load, sound = kinds[k % len(kinds)]
            data = mutated(sound, r)
            path = Path(name) / file
            path.write_bytes(data)
            tally.ask(partial(load, str(path)), lambda file=file, data=data: f"{file}: {data!r}")


def _kinds(folder: Path) -> Iterator[tuple[str, Load, bytes]]:
    """(file name, what reads it, a sound file)."""

    def shipped(kind: str, load: Load, suffix: str = ".toml") -> Iterator[tuple[str, Load, bytes]]:
        for path in sorted((models_folder() / kind).glob(f"*{suffix}")):
            yield path.name, load, path.read_bytes()[:_LONGEST]

    yield from shipped("scenes", load_scene)
    yield from shipped("vehicles", load_vehicle)
    yield from shipped("sensors", load_sensor)
    yield from shipped("motion", load_motion)
    yield from shipped("cases", load_parking_case)
    yield from shipped("tuned", load_schedule)
    yield from shipped("logs", read_candump, ".log")
    yield from shipped("can", lambda name: EsrCodec(dbc=name), ".dbc")
    for path in sorted(find("scenes", "sandwich-60-40").parents[2].glob("benchmarks/suites/*.toml")):
        yield path.name, lambda name: expand(name, 1), path.read_bytes()
    situation = load_situation("sandwich-60-40")
    answer = plan(situation)
    columns = answer.trajectory.to_dict()
    rows = zip(*columns.values(), strict=True)
    table = "\n".join([",".join(columns), *(",".join(map(str, row)) for row in rows)])
    yield "situation.json", load_situation, situation.to_json().encode()
    yield "trajectory.csv", load_trajectory, table.encode()
    yield "tpcap.csv", load_parking_case, _TPCAP
    yield "radar.csv", lambda name: read_targets(CsvTable(name)), _RADAR
    yield "parameters.toml", lambda name: load_parameters(Path(name)), _PARAMETERS
    yield "host.csv", HostMotion.read, (models_folder() / "logs" / "front_and_rear.host.csv").read_bytes()[:_LONGEST]
    yield "truth.csv", read_truth, (models_folder() / "logs" / "front_and_rear.truth.csv").read_bytes()[:_LONGEST]
