"""Planted faults of sensors: each does what it says, and none is the sensors' own noise."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mcdas_opt.catalogue.scenes import load_scene
from mcdas_opt.domain.body import Body
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import Scan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.errors import ParameterError
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.sensor_faults import SensorFaults
from mcdas_opt.simulation.sensors import SensorSuite

CARS = [Body(name="a", s_m=40.0, speed_mps=20.0), Body(name="b", s_m=60.0, d_m=3.7, speed_mps=22.0)]


class Front:
    def of(self, sector: Sector) -> str:
        return "delphi_esr" if sector is Sector.FRONT else "none"


def scans(faults: SensorFaults | None, count: int = 200) -> list[Scan]:
    suite = SensorSuite(Front(), Vehicle(), Road(lanes_left=1), 5, faults=faults)
    return [scan for k in range(count) for scan in suite.scans(0.05 * k, HostState(speed_mps=20.0), CARS)]


def test_no_faults_leave_every_scan_as_it_is() -> None:
    assert scans(None) == scans(SensorFaults())


def test_rates_are_as_asked_for() -> None:
    points = sum(len(scan.radar) for scan in scans(None))
    assert len(scans(SensorFaults(dropouts=0.3))) == pytest.approx(140, abs=20)
    assert sum(len(scan.radar) for scan in scans(SensorFaults(missed=0.2))) == pytest.approx(0.8 * points, abs=25)
    assert sum(len(scan.radar) for scan in scans(SensorFaults(duplicates=0.5))) == pytest.approx(1.5 * points, abs=30)
    assert sum(len(scan.radar) for scan in scans(SensorFaults(false_alarms_per_scan=0.5))) == pytest.approx(points + 100, abs=30)
    assert sum(len(scan.radar) for scan in scans(SensorFaults(ghosts=1.0))) > 1.5 * points
    assert sum(len(scan.radar) for scan in scans(SensorFaults(reflections=4))) == 4 * points


def test_a_misaligned_sensor_is_off_by_its_angle_and_its_shift() -> None:
    for straight, off in zip(scans(None), scans(SensorFaults(yaw_rad=0.01, aside_m=0.3)), strict=True):
        for one, two in zip(straight.radar, off.radar, strict=True):
            assert one.azimuth_rad - two.azimuth_rad == pytest.approx(0.01 + math.atan2(0.3, one.range_m))
            assert one.range_m == two.range_m


def test_what_the_host_tells_of_itself() -> None:
    host = HostState(speed_mps=20.0, steering_rad=0.01)
    told = SensorFaults(host_speed_share=0.01, host_yaw_rate_radps=0.01).told(host, 2.7)
    assert told.speed_mps == pytest.approx(20.2)
    assert told.steering_rad - 0.01 == pytest.approx(2.7 * 0.01 / 20.0, rel=1e-3)
    assert SensorFaults().told(host, 2.7) is host


@pytest.mark.parametrize(("key", "value"), [("reflections", 0), ("dropouts", 1.5), ("false_alarms_per_scan", -1.0), ("yaw_rad", np.nan)])
def test_faults_that_cannot_be_are_refused(key: str, value: float) -> None:
    with pytest.raises(ParameterError, match=key):
        SensorFaults(**{key: value})


def test_a_drive_with_everything_at_fault_is_planned_all_along() -> None:
    faults = SensorFaults(
        reflections=3, duplicates=0.2, ghosts=0.5, false_alarms_per_scan=0.5, missed=0.1, dropouts=0.3, yaw_rad=0.009, aside_m=0.3,
        host_speed_share=0.01, host_yaw_rate_radps=0.003,
    )  # fmt: skip
    drive = simulate(load_scene("benign-following"), faults=faults)
    assert drive.outcome.value == "safe"
    assert drive.unverified_plans == 0
    assert simulate(load_scene("benign-following"), faults=faults).trajectory.table.tobytes() == drive.trajectory.table.tobytes()
