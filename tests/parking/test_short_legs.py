"""Legs of next to no length: counted nowhere, and taken out of the answer where it stays sound."""

import numpy as np
import pytest

from mcdas_opt.domain.parking import ParkingTrajectory
from mcdas_opt.parking.case_file import parking_case_from_document
from mcdas_opt.parking.cost import COSTS
from mcdas_opt.parking.path import Arc, ArcPath, drive
from mcdas_opt.parking.program.manoeuvre import from_path
from mcdas_opt.parking.run import Run, standing_instead
from mcdas_opt.parking.world import World
from mcdas_opt.verification.parking_judge import judge_parking

PATH = (Arc(0.1, -2.0), Arc(-0.1, 1.0))


def case_of(arcs, **more):
    """A plain whose goal is where the arcs lead."""
    start = np.zeros(3)
    x, y, heading = ArcPath(start, tuple(arcs)).poses[-1].tolist()
    ends = {"start": {"x_m": 0.0, "y_m": 0.0, "heading_rad": 0.0}, "goal": {"x_m": x, "y_m": y, "heading_rad": heading}}
    return parking_case_from_document({**ends, **more})


def driven_on(case, *arcs):
    return drive(case, ArcPath(case.start, arcs))


def straight(t_s, speed_mps):
    t, v = np.array(t_s, dtype=float), np.array(speed_mps, dtype=float)
    x = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t))])
    return ParkingTrajectory.from_controls(t, np.column_stack([x, 0.0 * x, 0.0 * x]), v, 0.0 * v)


@pytest.mark.parametrize(("length_m", "counted"), [(9.2e-6, 0), (0.9e-3, 0), (3e-3, 1)])
def test_legs_count_by_their_length(length_m, counted):
    case = case_of(PATH)
    first = driven_on(case, Arc(0.05, length_m), *PATH)
    amid = driven_on(case, PATH[0], Arc(0.05, length_m), Arc(0.0, -1.0))
    last = driven_on(case, *PATH, Arc(0.05, -length_m))
    assert [one.gear_changes for one in (first, amid, last)] == [1 + counted, 2 * counted, 1 + counted]
    assert [leg.length_m for leg in first.legs] == pytest.approx([length_m, -2.0, 1.0], rel=1e-6)
    for one in (first, amid, last):
        assert np.sum(np.diff(one.gears) != 0.0) == one.gear_changes
    put_before = from_path(case, ArcPath(case.start, (Arc(0.05, length_m), *PATH)))
    assert put_before.gear_changes == 1 + counted


def test_a_leg_counts_however_slow_it_is_and_between_two_samples_too():
    assert straight([0.0, 1.0, 2.0, 3.0, 53.0, 54.0], [0.0, 0.5, 0.0, -0.9e-3, -0.9e-3, 0.0]).gear_changes == 1
    assert straight([0.0, 0.05, 0.1, 0.15, 0.2], [0.0, 0.3, -0.3, 0.3, 0.0]).gear_changes == 2
    assert straight([0.0, 1.0, 2.0, 3.0], [0.0, 0.5, 0.0, 0.5]).gear_changes == 0
    still = straight([0.0, 1.0], [0.0, 0.0])
    assert (still.legs, still.gear_changes, still.gears.tolist()) == ((), 0, [1.0, 1.0])


@pytest.mark.parametrize(
    "arcs",
    [
        (Arc(0.08, 2e-5), *PATH),
        (Arc(0.1, -1.0), Arc(0.08, 2e-5), Arc(0.1, -1.0), PATH[1]),
        (*PATH, Arc(0.08, -2e-5)),
    ],
)
def test_the_car_stands_where_a_leg_was_taken_out(arcs):
    case = case_of(PATH)
    with_leg = driven_on(case, *arcs)
    stood = standing_instead(case, with_leg, 0.01)
    assert stood is not None
    assert judge_parking(case, stood).verdict.passed
    assert [leg.length_m for leg in stood.legs] == pytest.approx([-2.0, 1.0], abs=1e-6)
    assert stood.duration_s < with_leg.duration_s
    assert stood.poses[-1] == pytest.approx(case.goal, abs=1e-4)
    assert standing_instead(case, stood, 0.01) is None


def test_nothing_is_left_where_all_legs_are_short():
    case = case_of(PATH)
    assert standing_instead(case, driven_on(case, Arc(0.0, 0.005), Arc(0.0, -0.005)), 0.01) is None


def planned(case, *arcs):
    run = Run(case, World.of(case), COSTS["time"], None)
    assert run.offer("a path", driven_on(case, *arcs), "", 0.0)
    return run.planned("nlp")


def test_the_answer_has_no_leg_of_micrometres():
    case = case_of(PATH)
    answer = planned(case, Arc(0.0, 9.2e-6), *PATH)
    assert answer.verdict.passed
    assert answer.gear_changes == len(answer.trajectory.legs) - 1 == 1
    assert answer.attempts[-1].name == "the best, without legs shorter than 10 mm"
    assert answer.attempts[-1].duration_s == answer.duration_s
    plain = planned(case, *PATH)
    assert len(plain.attempts) == 1
    assert plain.trajectory == driven_on(case, *PATH)


def test_a_leg_that_the_answer_needs_stays_and_counts():
    """A wall 5 cm behind where the car gets to: without the 8 mm forwards first it would come too near."""
    rear = case_of(PATH).vehicle.rear_overhang_m
    arcs = (Arc(0.0, 0.008), Arc(0.0, -2.0), Arc(0.0, 1.0))
    wall = -1.992 - rear - 0.0501
    behind = [{"vertices_m": [[wall - 1.0, -3.0], [wall, -3.0], [wall, 3.0], [wall - 1.0, 3.0]]}]
    case = case_of(arcs, obstacle=behind)
    answer = planned(case, *arcs)
    assert answer.gear_changes == 2
    assert len(answer.attempts) == 1
    both = planned(case, Arc(0.0, -9e-6), *arcs)
    assert both.gear_changes == 2
    assert both.attempts[-1].name == "the best, without legs shorter than 1 mm"
    assert min(abs(leg.length_m) for leg in both.trajectory.legs) == pytest.approx(0.008, abs=1e-6)
