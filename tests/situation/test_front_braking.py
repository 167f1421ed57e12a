"""What stops the host behind the front car, and which of it is gentle."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mcdas_opt.domain.assessment import Assessment
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.situation.assess import assess
from mcdas_opt.situation.front_braking import brakes_gently, is_ordinary, stopping_mps2

CAR, SELECTOR = Vehicle(), Settings().selector
STANDSTILL_M = 2.0
speeds, gaps, rates = st.floats(1.0, 40.0), st.floats(3.0, 120.0), st.floats(0.0, 8.0)


def behind(host_mps: float, front_mps: float, gap_m: float, braking_mps2: float) -> tuple[Situation, Assessment]:
    front = Track(
        id="front",
        s_m=gap_m + 0.5 * (4.5 + CAR.length_m),
        d_m=0.0,
        length_m=4.5,
        speed_s_mps=front_mps,
        acceleration_s_mps2=-braking_mps2,
        acceleration_s_sd_mps2=0.2,
        covariance=np.diag([0.04, 0.04, 0.04, 0.01]),
    )
    situation = Situation(host=HostState(speed_mps=host_mps), tracks=(front,), road=Road(), coverage=Coverage())
    return situation, assess(situation, CAR, SELECTOR)


def nearest_m(host_mps: float, front_mps: float, gap_m: float, braking_mps2: float, own_mps2: float) -> float:
    """The least gap where both brake so from now on."""
    t = np.linspace(0.0, 60.0, 60001)

    def way(speed: float, rate: float) -> np.ndarray:
        until = np.minimum(t, speed / rate if rate > 0.0 else np.inf)
        return speed * until - 0.5 * rate * until**2

    return float((gap_m + way(front_mps, braking_mps2) - way(host_mps, own_mps2)).min())


@given(host_mps=speeds, front_mps=speeds, gap_m=gaps, braking_mps2=rates)
def test_so_much_braking_leaves_the_standstill_gap_and_less_does_not(
    host_mps: float, front_mps: float, gap_m: float, braking_mps2: float
) -> None:
    """Who brakes by 0.5 m/s^2 or less may as well hold his speed."""
    own = stopping_mps2(*behind(host_mps, front_mps, gap_m, braking_mps2))
    braking = braking_mps2 if braking_mps2 > 0.5 else 0.0
    assume(0.03 * host_mps < own < 20.0)  # it is over within a minute
    assert nearest_m(host_mps, front_mps, gap_m, braking, own) >= STANDSTILL_M - 1e-3
    assert nearest_m(host_mps, front_mps, gap_m, braking, 0.98 * own) < STANDSTILL_M + 1e-3


@given(host_mps=speeds, front_mps=speeds, gap_m=gaps, braking_mps2=rates, comfortable_mps2=st.floats(1.0, 5.0))
def test_gentle_is_what_is_comfortable(
    host_mps: float, front_mps: float, gap_m: float, braking_mps2: float, comfortable_mps2: float
) -> None:
    there = behind(host_mps, front_mps, gap_m, braking_mps2)
    gently = brakes_gently(*there, comfortable_mps2)
    assert not gently or stopping_mps2(*there) <= comfortable_mps2
    assert is_ordinary(*there, comfortable_mps2) == (gently or not there[1].threatened)
    assert brakes_gently(*there, comfortable_mps2 + 1.0) >= gently


@pytest.mark.parametrize("host_mps", [0.0, 20.0])
def test_nobody_ahead_asks_for_nothing(host_mps: float) -> None:
    situation = Situation(host=HostState(speed_mps=host_mps), road=Road(), coverage=Coverage())
    assert stopping_mps2(situation, assess(situation, CAR, SELECTOR)) == 0.0
