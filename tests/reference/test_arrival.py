"""The speed that is driven towards for a destination: there in time, not before, and as fast as is asked for there."""

from __future__ import annotations

import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from mcdas_opt.domain.destination import Destination
from mcdas_opt.domain.host import HostState
from mcdas_opt.reference.arrival import arrival_speed_mps

RISING_MPS2, FALLING_MPS2, FASTEST_MPS, STEP_S = 1.5, 2.0, 40.0, 0.1


def driven(destination: Destination, speed_mps: float, desired_mps: float) -> list[HostState]:
    """Each step of a car that goes towards the speed at those rates, to the end of the window and a little beyond."""
    assert destination.time_s is not None
    host, time_s, been = HostState(speed_mps=speed_mps), 0.0, []
    while time_s <= destination.time_s[1] + STEP_S:
        been.append(host)
        aim = arrival_speed_mps(
            destination, host, time_s, desired_mps, fastest_mps=FASTEST_MPS, rising_mps2=RISING_MPS2, falling_mps2=FALLING_MPS2
        )
        v = min(max(aim, host.speed_mps - FALLING_MPS2 * STEP_S), host.speed_mps + RISING_MPS2 * STEP_S)
        host = HostState(s_m=host.s_m + 0.5 * (host.speed_mps + v) * STEP_S, speed_mps=v)
        time_s = round(time_s + STEP_S, 9)
    return been


@given(
    begun=st.floats(0.0, 30.0),
    cruise=st.floats(2.0, 30.0),
    early=st.floats(6.0, 40.0),
    lasting=st.floats(1.0, 10.0),
    length=st.floats(6.0, 40.0),
    wanted=st.floats(0.0, 40.0),
    asks=st.booleans(),
)
@example(begun=0.0, cruise=2.0, early=6.0, lasting=6.0, length=7.0, wanted=5.0, asks=True)  # out of the place before half its time
def test_who_drives_towards_it_is_there_in_its_window(
    begun: float, cruise: float, early: float, lasting: float, length: float, wanted: float, asks: bool
) -> None:
    changing_s = abs(cruise - begun) / RISING_MPS2
    assume(changing_s < early - 2.0)  # what some drive at these rates does: to a speed, held until the window's middle
    middle = early + 0.5 * lasting
    place = 0.5 * (begun + cruise) * changing_s + cruise * (middle - changing_s)
    speeds = (max(cruise - 2.0, 0.0), cruise + 2.0) if asks else None
    there = Destination(s_m=(place - 0.5 * length, place + 0.5 * length), time_s=(early, early + lasting), speed_mps=speeds)
    been = driven(there, begun, wanted)
    assert there.s_m is not None
    inside = [k for k, host in enumerate(been) if there.s_m[0] <= host.s_m <= there.s_m[1] and early <= k * STEP_S <= early + lasting]
    assert inside
    if speeds is not None:
        assert any(speeds[0] - 0.1 <= been[k].speed_mps <= speeds[1] + 0.1 for k in inside)


@pytest.mark.parametrize("speed", [(0.0, 2.0), (0.0, 0.5)])
def test_it_slows_down_for_a_place_without_a_time(speed: tuple[float, float]) -> None:
    there = Destination(s_m=(100.0, 110.0), speed_mps=speed, time_s=None)
    rates = {"fastest_mps": FASTEST_MPS, "rising_mps2": RISING_MPS2, "falling_mps2": FALLING_MPS2}
    assert arrival_speed_mps(there, HostState(speed_mps=15.0), 0.0, 15.0, **rates) == 15.0
    assert arrival_speed_mps(there, HostState(s_m=60.0, speed_mps=15.0), 0.0, 15.0, **rates) < speed[1]
    assert arrival_speed_mps(there, HostState(s_m=111.0, speed_mps=1.0), 0.0, 15.0, **rates) == 15.0


def test_nothing_that_is_asked_leaves_the_speed_as_desired() -> None:
    rates = {"fastest_mps": FASTEST_MPS, "rising_mps2": RISING_MPS2, "falling_mps2": FALLING_MPS2}
    for there in (Destination(lane=1), Destination(time_s=(1.0, 2.0)), Destination(s_m=(50.0, 60.0))):
        assert arrival_speed_mps(there, HostState(speed_mps=10.0), 0.0, 12.0, **rates) == 12.0


@pytest.mark.parametrize("ever", [1e12, 1e308])
def test_a_window_that_never_closes_is_as_one_of_years(ever: float) -> None:
    def at(late_s: float) -> float:
        there = Destination(s_m=(0.0, 185.0), lane=0, time_s=(22.0, late_s), speed_mps=(0.0, 5.3))
        return arrival_speed_mps(there, HostState(speed_mps=32.0), 0.0, 20.0, fastest_mps=50.0, rising_mps2=1.0, falling_mps2=2.0)

    assert at(ever) == at(1e9)
