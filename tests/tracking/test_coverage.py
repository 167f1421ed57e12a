"""Which sectors somebody vouches for."""

from __future__ import annotations

import numpy as np
import pytest

from mcdas_opt.domain.body import Body
from mcdas_opt.domain.track import Coverage
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.tracking.tracker import Tracker
from tests.tracking.worlds import STRAIGHT, dead_scan, host_at, ideal_scan, radar_scan

LEAD = [Body(name="lead", s_m=40.0, speed_mps=13.0)]


def test_a_blind_or_dead_sector_is_not_covered() -> None:
    tracker = Tracker()
    assert tracker.coverage(0.0) == Coverage(front=False, rear=False, left=False, right=False)
    tracker.update([radar_scan(0.0, LEAD), radar_scan(0.0, [], sector=Sector.REAR)], host_at(0.0), STRAIGHT, 0.0)
    assert tracker.coverage(0.0) == Coverage(front=True, rear=True, left=False, right=False)  # nothing there is not cannot see
    assert tracker.coverage(0.15).front
    assert not tracker.coverage(0.16).front  # three periods without a word
    tracker.update([radar_scan(0.05, LEAD), dead_scan(Sector.REAR, 0.05)], host_at(0.05), STRAIGHT, 0.05)
    assert tracker.coverage(0.05) == Coverage(front=True, rear=False, left=False, right=False)
    assert tracker.counters["dead"] == 1


def test_one_of_two_sensors_is_enough_for_a_sector() -> None:
    tracker = Tracker()
    tracker.update([radar_scan(0.0, []), ideal_scan(0.0, [])], host_at(0.0), STRAIGHT, 0.0)
    tracker.update([dead_scan(Sector.FRONT, 0.05), ideal_scan(0.05, [])], host_at(0.05), STRAIGHT, 0.05)
    assert tracker.coverage(0.05).front


@pytest.mark.parametrize("silent_s", [0.5, 0.95, 1.1, 3.0])
@pytest.mark.parametrize("says_so", [True, False])
def test_a_sensor_back_after_longer_than_tracks_live_covers_nothing_until_one_is_confirmed(silent_s: float, says_so: bool) -> None:
    tracker, back_s = Tracker(), 0.45 + silent_s

    def update(t: float, *, is_there: bool) -> None:
        seen = radar_scan(t, [Body(name="lead", s_m=40.0 + 13.0 * t, speed_mps=13.0)])
        scans = [seen] if is_there else [dead_scan(Sector.FRONT, t)] if says_so else []
        tracker.update(scans, host_at(t), STRAIGHT, t)

    for t in np.arange(0.0, 0.46, 0.05):
        update(t, is_there=True)
    for t in np.arange(0.5, back_s - 0.01, 0.05):
        update(t, is_there=False)
    covered, known = [], []
    for t in back_s + 0.05 * np.arange(4):
        update(t, is_there=True)
        covered.append(tracker.coverage(t).front)
        known.append(bool(tracker.tracks(t)))
    assert covered == ([False, False, True, True] if silent_s > 1.0 else [True] * 4)
    assert covered == known
