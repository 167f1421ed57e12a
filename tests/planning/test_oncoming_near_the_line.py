"""Who comes towards the host near the line, or over it, is given room and passed; the host braked to a standstill in its lane for one that
drifted at 0.5 m/s within his own, and was hit by one that was a metre over the line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mcdas_opt import load_scene, simulate
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.lane import Lane
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import PredictionSettings, Settings, WarningSettings
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vocabulary import Status
from mcdas_opt.planning.planner import Planner
from mcdas_opt.tracking.prediction import lane_change

SPEED_MPS = 20.0
PLANNER = Planner(settings=Settings(warning=WarningSettings(escapes=False)))
CAR = PLANNER.vehicle
HALF_M = 0.5 * Road().lane_width_m


def road(side: int) -> Road:
    lanes = {"lanes_left": 1, "shoulder_right_m": 1.0} if side > 0 else {"lanes_right": 1, "shoulder_left_m": 1.0}
    return Road(**lanes, lanes=(Lane(lane=side, oncoming=True),), speed_limit_mps=28.0)


def met(over_m: float, drift_mps: float, side: int) -> tuple[list[HostState], list[Plan], float]:
    """From 200 m away at 20 m/s each, the other drifting towards the host until so much of him is over the line: the host, the plans, the
    least distance between the bodies."""
    PLANNER.reset()
    host, hosts, plans, nearest_m = HostState(speed_mps=SPEED_MPS), [], [], np.inf
    last_m = HALF_M + 0.5 * CAR.width_m - over_m
    for k in range(60):
        away_m = max(3.5 - 0.1 * k * drift_mps, last_m)
        across_mps = -side * drift_mps if away_m > last_m else 0.0
        body = Track(id="1", s_m=200.0 - 2.0 * k, d_m=side * away_m, speed_s_mps=-SPEED_MPS, speed_d_mps=across_mps)
        asked = Situation(time_s=round(0.1 * k, 1), host=host, road=road(side), tracks=(body,), coverage=Coverage())
        plans.append(PLANNER.plan(asked))
        later = int(np.searchsorted(plans[-1].trajectory.t_s, 0.1 - 1e-9))
        host = HostState.from_vector(plans[-1].trajectory.states[later])
        hosts.append(host)
        beside = abs(body.s_m - 2.0 - host.s_m) < 0.5 * (body.length_m + CAR.length_m)
        nearest_m = min(nearest_m, abs(body.d_m - host.d_m) - 0.5 * (body.width_m + CAR.width_m)) if beside else nearest_m
    return hosts, plans, nearest_m


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("drift_mps", [0.3, 0.5])
@pytest.mark.parametrize("over_m", [0.0, 0.4, 1.0])
def test_he_is_given_room_at_speed(over_m: float, drift_mps: float, side: int) -> None:
    hosts, plans, nearest_m = met(over_m, drift_mps, side)
    assert {plan.status for plan in plans} == {Status.PLANNED}
    assert nearest_m > 0.85
    assert min(host.speed_mps for host in hosts) > 0.9 * SPEED_MPS
    assert min(host.acceleration_mps2 for host in hosts) > -2.0
    assert max(abs(host.d_m) for host in hosts) + 0.5 * CAR.width_m < HALF_M + 0.6


def test_mirrored_he_is_passed_mirrored() -> None:
    left, right = (met(0.6, 0.5, side)[0] for side in (1, -1))
    assert [host.d_m for host in left] == [-host.d_m for host in right]


@pytest.mark.parametrize(("d_m", "changes"), [(3.0, False), (2.6, False), (2.5, True), (2.0, True)])
def test_he_is_predicted_to_change_lanes_only_once_he_is_over_the_line(d_m: float, changes: bool) -> None:
    coming = Track(id="1", s_m=100.0, d_m=d_m, speed_s_mps=-SPEED_MPS, speed_d_mps=-0.6)
    assert (lane_change(coming, PredictionSettings(), road(1)) is not None) == changes


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_by_radar_he_is_passed_without_weaving(tmp_path: Path, seed: int) -> None:
    path = tmp_path / "oncoming.toml"
    path.write_text(
        "duration_s = 8.0\n[road]\nlane_width_m = 3.5\nlanes_left = 1\nshoulder_right_m = 1.0\nspeed_limit_mps = 22.0\n"
        "[[road.lane]]\nlane = 1\noncoming = true\n[host]\nspeed_mps = 20.0\n"
        "[[neighbour]]\ns_m = 230.0\nd_m = 2.0\nheading_rad = 3.14159265\nspeed_mps = 20.0\n"
        '[sensors]\nfront = "delphi_esr"\nrear = "delphi_esr"\n',
        "utf-8",
    )
    drive = simulate(load_scene(path), seed=seed)
    assert (drive.outcome, drive.fallbacks) == ("safe", 0)
    assert drive.min_clearance_m > 0.9
    assert drive.max_lateral_acceleration_mps2 < 3.2
