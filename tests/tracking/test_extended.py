"""Bodies that show several reflections: one track, of the length that they show."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from mcdas_opt.domain.body import Body
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.simulation.sensor_faults import SensorFaults
from mcdas_opt.simulation.sensors import SensorSuite
from mcdas_opt.tracking.tracker import Tracker

ROAD, CAR = Road(lanes_left=1, lanes_right=1), Vehicle()


@dataclass(frozen=True)
class Radars:
    """Of a scene: front and rear alone."""

    def of(self, sector: Sector) -> str:
        return "delphi_esr" if sector in (Sector.FRONT, Sector.REAR) else "none"


def tracked(bodies: list[Body], reflections: int, seed: int = 1, seconds: float = 2.0) -> tuple[Track, ...]:
    """After so long behind (or before) bodies that keep their distance."""
    suite = SensorSuite(Radars(), CAR, ROAD, seed, faults=SensorFaults(reflections=reflections))
    tracker, t = Tracker(vehicle=CAR), 0.0
    while t < seconds:
        host = HostState(s_m=20.0 * t, speed_mps=20.0)
        moved = [Body(name=b.name, s_m=b.s_m + b.speed_mps * t, d_m=b.d_m, speed_mps=b.speed_mps, length_m=b.length_m) for b in bodies]
        tracker.update(suite.scans(t, host, moved), host, ROAD, t)
        t = round(t + 0.05, 9)
    return tracker.tracks(t)


@pytest.mark.parametrize("ahead", [True, False])
@pytest.mark.parametrize("length", [8.0, 12.0, 16.5])
def test_a_lorry_is_one_track_of_its_length(length: float, ahead: bool) -> None:
    s = 40.0 if ahead else -40.0
    for seed in range(3):
        (track,) = tracked([Body(name="lorry", s_m=s, speed_mps=20.0, length_m=length)], 5, seed)
        assert track.length_m == pytest.approx(length, abs=0.8)
        assert track.s_m - 40.0 == pytest.approx(s, abs=1.2)


@pytest.mark.parametrize("reflections", [1, 3])
def test_a_car_is_as_long_as_assumed(reflections: int) -> None:
    (track,) = tracked([Body(name="car", s_m=30.0, speed_mps=20.0)], reflections)
    assert track.length_m == 4.5


def test_two_cars_in_one_lane_are_two() -> None:
    """One of them seen past the other; each with several reflections."""
    cars = [Body(name="a", s_m=30.0, d_m=-1.2, speed_mps=20.0), Body(name="b", s_m=45.0, d_m=-0.4, speed_mps=20.0)]
    one, two = sorted(tracked(cars, 3), key=lambda track: track.s_m)
    assert (one.s_m - 40.0, two.s_m - 40.0) == (pytest.approx(30.0, abs=1.0), pytest.approx(45.0, abs=1.0))
    assert (one.length_m, two.length_m) == (4.5, 4.5)


def test_a_lorry_that_shows_one_point_is_as_long_as_assumed() -> None:
    (track,) = tracked([Body(name="lorry", s_m=40.0, speed_mps=20.0, length_m=16.5)], 1)
    assert track.length_m == 4.5
