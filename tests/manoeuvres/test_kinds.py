"""The best few of different kind."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mcdas_opt.domain.grid import TimeGrid
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.manoeuvres.kinds import Choice, best_of_kind
from mcdas_opt.tracking.prediction import predict

SEDAN = Vehicle()


def random_situation(seed: int) -> Situation:
    rng = np.random.default_rng(seed)
    v = rng.uniform(6.0, 33.0)
    tracks = [
        Track(id="front", s_m=4.5 + rng.uniform(8.0, 60.0), d_m=rng.uniform(-0.4, 0.4), speed_s_mps=max(v - rng.uniform(0.0, 12.0), 0.0)),
        Track(id="rear", s_m=-4.5 - rng.uniform(5.0, 40.0), d_m=0.0, speed_s_mps=v + rng.uniform(0.0, 8.0)),
        Track(id="side", s_m=rng.uniform(-30.0, 40.0), d_m=3.7, speed_s_mps=v * rng.uniform(0.7, 1.2)),
    ]
    road = Road(lanes_left=1, lanes_right=int(rng.integers(0, 2)), friction=float(rng.choice([0.9, 0.5, 0.25])))
    return Situation(host=HostState(speed_mps=v, d_m=rng.uniform(-0.2, 0.2)), tracks=tuple(tracks), road=road, coverage=Coverage())


def mirrored(situation: Situation) -> Situation:
    host, road = situation.host, situation.road
    return replace(
        situation,
        host=replace(host, d_m=-host.d_m),
        tracks=tuple(replace(track, d_m=-track.d_m) for track in situation.tracks),
        road=replace(road, lanes_left=road.lanes_right, lanes_right=road.lanes_left),
    )


@pytest.mark.parametrize("seed", range(12))
def test_choices_differ_in_kind_and_stand_in_order(seed: int) -> None:
    situation = random_situation(seed)
    choices = best_of_kind(situation, SEDAN, predict(situation.tracks), most=6)
    assert choices
    assert len({(choice.side, choice.early, choice.pace, choice.target_d_m) for choice in choices}) == len(choices)
    costs = [choice.member.cost for choice in choices if choice.member.feasible]
    assert not costs or len(costs) == len(choices)
    assert costs == sorted(costs)
    for choice in choices:
        assert choice.states.shape == (TimeGrid().nodes + 1, 6)
        assert np.allclose(choice.states[0], situation.host.to_vector(), atol=1e-9)
        assert choice.end_speed_mps == choice.states[-1, 3]
        assert (choice.member.contact_with == -1) == np.isinf(choice.member.contact_s)
        if choice.side is not Side.NONE:
            assert np.sign(choice.target_d_m - situation.host.d_m) == (1 if choice.side is Side.LEFT else -1)


@pytest.mark.parametrize("seed", range(12))
def test_the_mirrored_situation_has_the_mirrored_choices(seed: int) -> None:
    situation = random_situation(seed)
    other = mirrored(situation)
    mine = best_of_kind(situation, SEDAN, predict(situation.tracks), most=9)
    theirs = best_of_kind(other, SEDAN, predict(other.tracks), most=9)
    flip = {Side.LEFT: Side.RIGHT, Side.RIGHT: Side.LEFT, Side.NONE: Side.NONE}

    def seen(choice: Choice, side: Side, sign: float) -> tuple[object, ...]:
        kept = choice.early, choice.pace, round(choice.delay_s, 6), choice.member.phase
        return side, round(sign * choice.target_d_m, 6) + 0.0, kept, round(choice.member.cost, 6)

    assert sorted(map(str, (seen(c, c.side, 1.0) for c in mine))) == sorted(map(str, (seen(c, flip[c.side], -1.0) for c in theirs)))


def test_nothing_around_is_kept_as_it_is() -> None:
    choice = best_of_kind(Situation(host=HostState(speed_mps=20.0), coverage=Coverage()), SEDAN, predict(()))[0]
    assert (choice.side, choice.pace, choice.member.feasible) == (Side.NONE, "same", True)
    assert choice.member.cost == pytest.approx(0.0, abs=1e-9)


def test_a_slower_car_ahead_in_the_target_lane_calls_for_a_slower_member() -> None:
    """Front braking hard, somebody slower in the next lane: in behind him, and no faster than he is."""
    tracks = (
        Track(id="front", s_m=40.0, d_m=0.0, speed_s_mps=10.0),
        Track(id="rear", s_m=-17.0, d_m=0.0, speed_s_mps=32.0),
        Track(id="side", s_m=20.0, d_m=-3.7, speed_s_mps=23.0),
    )
    situation = Situation(host=HostState(speed_mps=28.0), tracks=tracks, road=Road(lanes_right=1, friction=0.5), coverage=Coverage())
    choices = best_of_kind(situation, SEDAN, predict(tracks))
    assert choices[0].member.feasible
    assert choices[0].side is Side.RIGHT
    assert choices[0].pace == "slower"


def test_states_are_given_on_the_grid_that_is_asked_for() -> None:
    situation = random_situation(3)
    grid = TimeGrid(steps_s=np.full(60, 0.05))
    prediction = predict(situation.tracks)
    for choice in best_of_kind(situation, SEDAN, prediction, grid=grid):
        assert choice.states.shape == (61, 6)


def test_a_dodge_is_offered_where_no_lane_change_is_clear() -> None:
    """A car far across in its lane, walls on both sides of the next one: past its flank, and no further."""
    tracks = (
        Track(id="front", s_m=45.0, d_m=-0.5, speed_s_mps=0.0),
        Track(id="wall-1", s_m=6.0, d_m=4.3, speed_s_mps=20.0),
        Track(id="wall-2", s_m=-2.0, d_m=4.3, speed_s_mps=20.0),
        Track(id="rear", s_m=-9.0, d_m=-0.5, speed_s_mps=20.0),
    )
    situation = Situation(host=HostState(speed_mps=20.0), tracks=tracks, road=Road(lanes_left=1, friction=0.9), coverage=Coverage())
    choices = best_of_kind(situation, SEDAN, predict(tracks))
    assert any(choice.member.feasible and choice.side is Side.LEFT and 1.0 < choice.target_d_m < 2.6 for choice in choices)
