"""What stops the host behind the front car, and which of it is gentle."""

from __future__ import annotations

from dataclasses import replace

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
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.front.front_braking import FrontBraking
from mcdas_opt.situation.assess import assess

CAR, SETTINGS = Vehicle(), Settings()
HEAVIER = replace(SETTINGS, comfort=replace(SETTINGS.comfort, braking_mps2=4.5, slow_braking_mps2=6.0))
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
    return situation, assess(situation, CAR, SETTINGS.selector)


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
    own = FrontBraking.of(*behind(host_mps, front_mps, gap_m, braking_mps2), CAR, SETTINGS).stopping_mps2
    braking = braking_mps2 if braking_mps2 > 0.5 else 0.0
    assume(0.03 * host_mps < own < 20.0)  # it is over within a minute
    assert nearest_m(host_mps, front_mps, gap_m, braking, own) >= STANDSTILL_M - 1e-3
    assert nearest_m(host_mps, front_mps, gap_m, braking, 0.98 * own) < STANDSTILL_M + 1e-3


@given(host_mps=speeds, front_mps=speeds, gap_m=gaps, braking_mps2=rates)
def test_gentle_is_what_is_comfortable(host_mps: float, front_mps: float, gap_m: float, braking_mps2: float) -> None:
    """With a heavier foot, more is."""
    there = behind(host_mps, front_mps, gap_m, braking_mps2)
    found = FrontBraking.of(*there, CAR, SETTINGS)
    assert not found.is_gentle or found.stopping_mps2 <= SETTINGS.comfort.limits(host_mps).braking_mps2
    assert FrontBraking.of(*there, CAR, HEAVIER).is_gentle >= found.is_gentle


@given(host_mps=speeds, front_mps=speeds, gap_m=gaps, braking_mps2=rates)
def test_what_is_gentle_is_ordinary_unless_somebody_closes_in_from_behind(
    host_mps: float, front_mps: float, gap_m: float, braking_mps2: float
) -> None:
    situation, _ = behind(host_mps, front_mps, gap_m, braking_mps2)
    cycle = Cycle.of(situation, CAR, SETTINGS)
    assert cycle.is_ordinary == (cycle.front_braking.is_gentle or not cycle.assessment.threatened)


@pytest.mark.parametrize("host_mps", [0.0, 20.0])
def test_nobody_ahead_asks_for_nothing(host_mps: float) -> None:
    situation = Situation(host=HostState(speed_mps=host_mps), road=Road(), coverage=Coverage())
    found = FrontBraking.of(situation, assess(situation, CAR, SETTINGS.selector), CAR, SETTINGS)
    assert found == FrontBraking(stopping_mps2=0.0, is_gentle=False, is_to_the_limit=False)
