"""One plan without memory: of any settings, of a car's file as it is, by a planner that is kept."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mcdas_opt as mo
from mcdas_opt.catalogue.vehicles import vehicle_text
from mcdas_opt.domain.grid import TimeGrid
from mcdas_opt.domain.settings import HeadwaySettings
from mcdas_opt.planning import stateless

PLANNER = "closed-form-corrected"


def situation() -> mo.Situation:
    front = mo.Track(id="front", s_m=30.0, d_m=0.0, speed_s_mps=10.0)
    return mo.Situation(host=mo.HostState(speed_mps=11.0), tracks=(front,), coverage=mo.Coverage(), road=mo.Road(lanes_left=1))


@pytest.fixture
def built(monkeypatch: pytest.MonkeyPatch) -> list[mo.Planner]:
    """The planners that are built from here on."""
    made = list[mo.Planner]()

    class Counted(mo.Planner):
        def __init__(self, *given: object, **named: object) -> None:
            super().__init__(*given, **named)  # type: ignore[arg-type]
            made.append(self)

    monkeypatch.setattr(stateless, "_WARM", stateless._Warm())
    monkeypatch.setattr(stateless, "Planner", Counted)
    return made


def test_equal_settings_are_asked_of_one_planner(built: list[mo.Planner]) -> None:
    plans = [
        mo.plan(situation(), planner=PLANNER),
        mo.plan(situation(), planner=PLANNER, settings=mo.Settings()),
        mo.plan(situation(), planner=PLANNER, settings=mo.Settings(grid=TimeGrid(steps_s=np.full(40, 0.1)))),
    ]
    assert len(built) == 1
    assert all(np.array_equal(plan.trajectory.s_m, plans[0].trajectory.s_m) for plan in plans)
    mo.plan(situation(), planner=PLANNER, settings=mo.Settings(headway=HeadwaySettings(time_gap_s=2.0)))
    mo.plan(situation(), planner=PLANNER, settings=mo.Settings(grid=TimeGrid(steps_s=np.full(30, 0.1))))
    assert len(built) == 3


def test_a_step_takes_settings(built: list[mo.Planner]) -> None:
    for _ in range(2):
        mo.step([], mo.HostState(speed_mps=11.0), 0.0, planner=PLANNER, settings=mo.Settings())
    assert len(built) == 1


def test_a_drive_takes_settings() -> None:
    drive = mo.simulate("benign-following", planner=PLANNER, settings=mo.Settings())
    assert drive.outcome == "safe"


def test_grids_of_the_same_steps_are_equal_and_so_are_their_hashes() -> None:
    same, other = TimeGrid(steps_s=np.full(40, 0.1)), TimeGrid(steps_s=np.full(41, 0.1))
    assert TimeGrid() == same != other
    assert hash(TimeGrid()) == hash(same)
    assert TimeGrid() != 40
    assert mo.Settings(grid=same) == mo.Settings() != mo.Settings(grid=other)
    assert hash(mo.Settings(grid=same)) == hash(mo.Settings())


def test_a_vehicle_file_that_was_changed_is_read_again(tmp_path: Path, built: list[mo.Planner]) -> None:
    file, text = tmp_path / "own.toml", vehicle_text(mo.load_vehicle("sedan"))
    file.write_text(text)
    for _ in range(2):
        assert mo.plan(situation(), vehicle=str(file), planner=PLANNER).vehicle.width_m == 1.8
    assert len(built) == 1
    file.write_text(text.replace("width_m = 1.8", "width_m = 2.1"))
    assert mo.plan(situation(), vehicle=str(file), planner=PLANNER).vehicle.width_m == 2.1
