"""A file of one kind where another is wanted is told as what it is."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from mcdas_opt.catalogue.data_files import models_folder
from mcdas_opt.catalogue.scenes import load_scene
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.errors import InputError
from mcdas_opt.evaluation.families import suites_folder
from mcdas_opt.evaluation.suites import expand
from mcdas_opt.parking.case_file import load_parking_case

FILES = {
    "scene": models_folder() / "scenes" / "sandwich-60-40.toml",
    "vehicle": models_folder() / "vehicles" / "tpcap.toml",
    "parking case": models_folder() / "cases" / "parallel.toml",
    "suite": suites_folder() / "sandwich.toml",
}
READERS: dict[str, Callable[[Path], Any]] = {
    "scene": load_scene,
    "vehicle": load_vehicle,
    "parking case": load_parking_case,
    "suite": lambda path: expand(path, 1),
}


@pytest.mark.parametrize("wanted", READERS)
@pytest.mark.parametrize("given", FILES)
def test_a_file_of_another_kind_is_told_as_what_it_is(given: str, wanted: str) -> None:
    if given == wanted:
        READERS[wanted](FILES[given])
        return
    with pytest.raises(InputError, match=rf"toml: is a {given} \(.*\), where a {wanted} is wanted$"):
        READERS[wanted](FILES[given])


def test_a_file_of_the_right_kind_with_a_fault_is_told_the_fault(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(FILES["scene"].read_text("utf-8") + "\n[slot]\nlength_m = 5.0\n", "utf-8")
    with pytest.raises(InputError, match=r"slot: unknown key"):
        load_scene(path)
