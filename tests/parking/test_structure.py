"""Manoeuvres changed: phases, finer grids, guesses, what a cost buys, and refusals that say how near they came."""

from dataclasses import replace

import numpy as np
import pytest

from mcdas_opt.domain.verdict import ViolationKind
from mcdas_opt.errors import ParameterError
from mcdas_opt.parking.case_file import slot_case
from mcdas_opt.parking.closed_form import two_arc
from mcdas_opt.parking.cost import COSTS, trajectory_cost
from mcdas_opt.parking.park import park
from mcdas_opt.parking.path import Arc, ArcPath
from mcdas_opt.parking.program.exchange import ExchangeSettings, exchange
from mcdas_opt.parking.program.guesses import GUESSES, guesses, one_more
from mcdas_opt.parking.program.manoeuvre import from_path, node_poses
from mcdas_opt.parking.program.stages import Stages
from mcdas_opt.parking.program.structure import finer, finer_places, from_trajectory, in_pieces, phase_lengths, phases, without
from mcdas_opt.parking.program.windows import WindowSettings, improve
from mcdas_opt.parking.search.arc_search import Resolution, search
from mcdas_opt.parking.search.path_cost import PathCost
from mcdas_opt.parking.settings import ParkSettings
from mcdas_opt.parking.world import World
from mcdas_opt.verification.parking_judge import judge_parking

CASE = slot_case(7.2)
ZIGZAG = ArcPath(CASE.start, (Arc(0.1, -2.0), Arc(0.0, -1.0), Arc(-0.2, 0.5), Arc(0.2, -1.0)))


def test_phases_and_their_lengths():
    manoeuvre = from_path(CASE, ZIGZAG)
    assert len(phases(manoeuvre)) == 3
    assert phase_lengths(manoeuvre) == pytest.approx([3.0, 0.5, 1.0], rel=0.05)
    assert manoeuvre.gear_changes == 2


@pytest.mark.parametrize(("phase", "left"), [(0, 1), (1, 0), (2, 1)])
def test_a_phase_left_out_keeps_both_ends(phase, left):
    manoeuvre = from_path(CASE, ZIGZAG)
    shorter = without(manoeuvre, phase)
    assert shorter.gear_changes == left
    assert len(shorter.nodes) == len(shorter.steps) + 1 == len(shorter.gears) + 1 == len(shorter.segments) + 1
    assert shorter.nodes[0] == pytest.approx(manoeuvre.nodes[0])
    assert shorter.nodes[-1] == pytest.approx(manoeuvre.nodes[-1])


def test_a_finer_grid_drives_the_same():
    manoeuvre = from_path(CASE, ZIGZAG)
    halved = finer(CASE, manoeuvre)
    assert halved.duration_s == pytest.approx(manoeuvre.duration_s)
    assert halved.trajectory(CASE).poses[-1] == pytest.approx(manoeuvre.trajectory(CASE).poses[-1], abs=1e-9)
    pieces = in_pieces(manoeuvre, 4)
    assert np.bincount(pieces.segments.astype(int)).max() == 4
    assert np.all(np.diff(pieces.segments)[np.diff(manoeuvre.segments) != 0] == 1)


def test_checks_stay_where_they_are_on_a_finer_grid():
    manoeuvre = from_path(CASE, ZIGZAG)
    halved = finer(CASE, manoeuvre)
    coarse, at = node_poses(CASE, manoeuvre, 96)
    fine, _ = node_poses(CASE, halved, 96)
    assert at[-1] == 1.0
    for k, point in ((1, 0), (3, 10), (3, 47), (5, 48), (7, 95)):
        ((there, polygon, beside),) = finer_places(frozenset({(k, 2, point)}))
        assert polygon == 2
        assert fine[there, beside] == pytest.approx(coarse[k, point], abs=1e-6)


@pytest.mark.parametrize("answers", [True, False])
def test_fatrop_or_whoever_answers_for_it(monkeypatch, answers):
    path = search(CASE, World.of(CASE), Resolution(), PathCost.of(CASE)).paths[0]
    guess = from_path(CASE, path)
    if not answers:
        plain = Stages.solve
        monkeypatch.setattr(Stages, "solve", lambda self: replace(plain(self), violation=np.inf))
    solve = ExchangeSettings(solver="fatrop", rounds=2, rounds_unsound=6)
    found = exchange(CASE, World.of(CASE), guess, COSTS["time"], solve)
    assert found.best is not None
    assert judge_parking(CASE, found.best.trajectory(CASE)).verdict.passed
    if not answers:
        ours = exchange(CASE, World.of(CASE), guess, COSTS["time"], replace(solve, solver="ipopt"))
        assert ours.best is not None
        assert found.best.nodes == pytest.approx(ours.best.nodes)
        assert found.iterations > ours.iterations
    with pytest.raises(ParameterError, match="did you mean 'fatrop'"):
        ExchangeSettings(solver="fatrob")


def test_a_driven_trajectory_is_a_guess():
    driven = two_arc(slot_case(9.0))
    guess = from_trajectory(slot_case(9.0), driven)
    assert guess.duration_s == pytest.approx(driven.duration_s, abs=0.05)
    assert guess.nodes[-1, :3] == pytest.approx(driven.poses[-1], abs=1e-6)
    assert guess.gear_changes == driven.gear_changes


def test_one_more_gear_leads_to_the_same_place():
    longer = one_more(ZIGZAG)
    assert longer.gear_changes == ZIGZAG.gear_changes + 1
    assert longer.poses[-1] == pytest.approx(ZIGZAG.poses[-1], abs=1e-9)


def test_closed_forms_and_longer_slots_start_the_program_too():
    case = slot_case(9.5)
    world = World.of(case)
    path = ArcPath(case.start, tuple(Arc(a.curvature, a.length) for a in ZIGZAG.arcs))
    made = {guess.name: guess.make for guess in guesses(case, [path], GUESSES, COSTS["time"], ExchangeSettings())}
    assert len(made) == len(GUESSES)
    for name in ("two arcs", "reverse sigmoid"):
        first = made[name]()
        assert first is not None
        done = exchange(case, world, first, COSTS["time"], ExchangeSettings())
        assert done.best is not None
        assert judge_parking(case, done.best.trajectory(case)).verdict.passed
    with pytest.raises(ParameterError, match="did you mean 'two-arc'"):
        ParkSettings(guesses=("two-arcs",))
    with pytest.raises(ParameterError, match="did you mean 'duals'"):
        ExchangeSettings(form="dual")


@pytest.mark.parametrize("name", ["gear-changes", "clearance"])
def test_what_a_cost_asks_for_is_had(name):
    """The answer under a cost costs at most as much in it as the quickest answer does."""
    case = slot_case(7.2)
    world = World.of(case)
    plain, wanted = (park(case, settings=ParkSettings(starts=1, polish_up_to=0, costs=COSTS[cost])) for cost in ("time", name))
    assert plain.trajectory is not None
    assert wanted.trajectory is not None
    values = [trajectory_cost(a.trajectory, COSTS[name], world, case.limits.clearance_m) for a in (plain, wanted)]
    assert values[1] <= values[0] + 0.05
    assert trajectory_cost(plain.trajectory, COSTS["time"], world, 0.05) == plain.duration_s


def test_both_forms_of_the_checks_park():
    case = slot_case(6.75)
    path = park(case, "search")
    assert path.trajectory is not None
    guess = from_trajectory(case, path.trajectory)
    found = [exchange(case, World.of(case), guess, COSTS["time"], ExchangeSettings(form=form)).best for form in ("half-planes", "duals")]
    for best in found:
        assert best is not None
        assert judge_parking(case, best.trajectory(case)).verdict.passed


def test_a_search_that_fails_says_how_near_it_came_and_what_would_do():
    short = ParkSettings(resolutions=(Resolution(cell_m=0.03, max_nodes=300, contacts_only=True),), starts=1)
    refused = park(slot_case(6.3), "search", settings=short)
    assert refused.status == "refused"
    assert "more length would do" in refused.reason
    assert "lacks" in refused.reason
    assert refused.verdict.violations[0].value < refused.verdict.violations[0].limit


def test_guesses_of_a_path_come_first():
    names = [guess.name for guess in guesses(CASE, [ZIGZAG], ("search", "one-more"), COSTS["time"], ExchangeSettings())]
    assert names == ["3 gear changes, one put before", "2 gear changes"]


@pytest.mark.parametrize("interval_s", [0.28, 0.8, 1.6])
def test_what_the_loop_calls_sound_ends_where_it_was_asked(interval_s):
    """Also where one Runge-Kutta step of the program spans so long an interval that the roll-out ends elsewhere."""
    case = slot_case(7.2)
    done = exchange(case, World.of(case), from_path(case, from_search(case), interval_s), COSTS["time"], ExchangeSettings())
    assert done.best is not None
    verdict = judge_parking(case, done.best.trajectory(case)).verdict
    ends = {ViolationKind.END_POSITION, ViolationKind.END_HEADING, ViolationKind.END_SPEED}
    assert not ends & {v.kind for v in verdict.violations}


def from_search(case):
    return search(case, World.of(case), Resolution(max_nodes=6000), PathCost.of(case)).paths[0]


def test_windows_go_through_once_more_on_a_finer_grid_and_gain():
    case = slot_case(1.35 * 4.5)
    guess = from_path(case, from_search(case))
    assert guess.gear_changes > 1
    windows = WindowSettings(whole_up_to=1, phases=3, stride=2, fine_stride=2, rounds=2)
    coarse, fine = (
        improve(case, World.of(case), guess, COSTS["time"], ExchangeSettings(), replace(windows, fine_up_to=most)).best for most in (0, 60)
    )
    assert coarse is not None
    assert fine is not None
    assert fine.duration_s < coarse.duration_s
    assert judge_parking(case, fine.trajectory(case)).verdict.passed
