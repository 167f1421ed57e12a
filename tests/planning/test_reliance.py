"""On whom a plan relies: what is seen at once is what the judge says."""

from __future__ import annotations

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from mcdas_opt.domain.prediction import CruisingBody, Prediction
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.planning.reporting.reliance import _is_run_into
from mcdas_opt.verification.judge import judge

ROAD, VEHICLE, T_S = Road(lanes_left=1, lanes_right=1), Vehicle(), np.linspace(0.0, 4.0, 41)
SIZES = st.tuples(st.floats(2.0, 18.0), st.floats(1.0, 2.6))


def drive(speed_mps: float, heading_rad: float) -> Trajectory:
    """Straight on, at a heading, for 4 s."""
    way = speed_mps * T_S
    rest = np.zeros_like(T_S)
    states = np.column_stack([way * np.cos(heading_rad), way * np.sin(heading_rad), rest + heading_rad, rest + speed_mps, rest, rest])
    return Trajectory.from_states(T_S, states, np.zeros((len(T_S) - 1, 2)))


@given(
    gap=st.floats(0.0, 15.0), aside=st.floats(-3.0, 3.0), faster=st.floats(6.0, 15.0), across=st.floats(-0.3, 0.3), size=SIZES,
    heading=st.floats(-0.01, 0.01),
)  # fmt: skip
def test_who_is_seen_to_run_into_a_drive_does(
    gap: float, aside: float, faster: float, across: float, size: tuple[float, float], heading: float
) -> None:
    length_m, width_m = size
    s_m = -gap - 0.5 * (length_m + VEHICLE.length_m)
    body = CruisingBody(
        id="rear", length_m=length_m, width_m=width_m, s_m=s_m, d_m=aside, speed_s_mps=15.0 + faster, speed_d_mps=across,
        covariance=np.zeros((4, 4)),
    )  # fmt: skip
    its = drive(15.0, heading)
    assume(_is_run_into(its, [body], VEHICLE))
    verdict = judge(its, None, VEHICLE, ROAD, Prediction(name="unaided", bodies=(body,)))
    assert "rear" in {violation.body for violation in verdict.violations}


def test_who_runs_into_a_drive_is_seen_to() -> None:
    """Straight from behind, much faster: else the judge would be asked of everybody, and nothing saved."""
    body = CruisingBody(
        id="rear", length_m=4.5, width_m=1.8, s_m=-30.0, d_m=0.2, speed_s_mps=25.0, speed_d_mps=0.0, covariance=np.zeros((4, 4))
    )
    assert _is_run_into(drive(15.0, 0.0), [body], VEHICLE)
    assert not _is_run_into(drive(24.0, 0.0), [body], VEHICLE)
