"""A drive with an emergency comes back to ordinary driving, or does not, and a calm one is not asked."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from mcdas_opt.catalogue.scenes import scene_from_document
from mcdas_opt.domain.vocabulary import Alert
from mcdas_opt.evaluation.row import ordinary_again
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.ordinary import Leader, instants_of
from mcdas_opt.simulation.record import Outcome, Simulation


@pytest.fixture(scope="module")
def calm() -> Simulation:
    document = {"duration_s": 4.0, "road": {"lanes_left": 1}, "host": {"speed_mps": 20.0}, "neighbour": []}
    return simulate(scene_from_document(document, Path("calm.toml")), "acc")


def alarmed(run: Simulation, *times_s: float) -> Simulation:
    cycles = [replace(one, plan=replace(one.plan, alert=Alert.ACT)) if one.time_s in times_s else one for one in run.cycles]
    return replace(run, cycles=tuple(cycles))


def test_only_a_drive_with_an_emergency_is_asked_and_calm_has_to_last(calm: Simulation) -> None:
    instants = instants_of(calm)
    assert ordinary_again(calm, instants) is None
    assert ordinary_again(alarmed(calm, 1.0), instants) is True
    assert ordinary_again(alarmed(calm, 1.0, 3.5), instants) is False
    assert ordinary_again(replace(alarmed(calm, 1.0), outcome=Outcome.COLLISION), instants) is False


def test_too_slow_too_near_or_between_lanes_is_not_ordinary(calm: Simulation) -> None:
    run, instants = alarmed(calm, 1.0), instants_of(calm)

    def ended(**changes: object) -> bool | None:
        return ordinary_again(run, (*instants[:-1], replace(instants[-1], **changes)))

    assert ended(speed_mps=12.0) is False
    assert ended(speed_mps=12.0, acceleration_mps2=1.0) is True
    assert ended(speed_mps=12.0, leader=Leader(id="x", gap_m=40.0, speed_mps=12.0)) is True
    assert ended(leader=Leader(id="x", gap_m=10.0, speed_mps=20.0)) is False
    assert ended(leader=Leader(id="x", gap_m=10.0, speed_mps=21.0)) is True
    aside = replace(run.trajectory, d_m=run.trajectory.d_m + 1.0)
    assert ordinary_again(replace(run, trajectory=aside), instants) is False
