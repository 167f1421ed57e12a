"""A radar that is too near to see its target does not thereby know that it is gone."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.sensor import Beam
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.tracking.filtering import InterpretedFiltering
from mcdas_opt.tracking.tracker import Tracker
from tests.tracking.worlds import BEND, ESR, STRAIGHT, body_of, host_at, radar_scan

STEP_S = 0.05
TOUCHING_M = 4.5  # from centre to centre
Gap = Callable[[float], float]


def followed(
    gap_m: Gap,
    *,
    until_s: float,
    seed: int = 1,
    d_m: float = 0.0,
    speed: float = 12.0,
    road: Road = STRAIGHT,
    declared: bool = True,
    gone_s: float = np.inf,
    sector: Sector = Sector.REAR,
    tracker: Tracker | None = None,
) -> Iterator[tuple[float, HostState, Track | None]]:
    """(t, host, the one track there may be) with a car behind (or ahead) at that gap, bumper to bumper, until it is `gone_s`."""
    tracker, random = tracker or Tracker(), np.random.default_rng(seed)
    side = -1.0 if sector is Sector.REAR else 1.0
    for t in np.arange(0.0, until_s, STEP_S).tolist():
        host = host_at(t, road, speed)
        rate = (gap_m(t + 1e-4) - gap_m(t - 1e-4)) / 2e-4
        x = np.array([host.s_m + side * (TOUCHING_M + gap_m(t)), speed + side * rate, d_m, 0.0])
        bodies = [body_of(x, road)] if t < gone_s else []
        scan = radar_scan(t, bodies, sector=sector, road=road, host=host, random=random)
        tracker.update([scan if declared else replace(scan, blind=None)], host, road, t)
        found = tracker.tracks(t)
        assert len(found) <= 1
        yield t, host, found[0] if found else None


def closing(to_m: float, since_s: float = 1.0, rate_mps: float = 2.0) -> Gap:
    """From 4 m, down to a gap that is kept."""
    return lambda t: max(to_m, 4.0 - rate_mps * max(t - since_s, 0.0))


def test_the_blind_fan_lies_before_the_sensor_and_is_as_deep_as_its_least_range() -> None:
    assert ESR.blind == Beam(name="blind", range_max_m=1.0, half_angle_rad=ESR.beams[1].half_angle_rad)
    assert replace(ESR, range_min_m=0.0).blind is None
    for azimuth in (0.0, 0.5, -0.5):
        assert ESR.blind.holds(0.99, azimuth)
        assert not ESR.sees(0.99, azimuth)


@pytest.mark.parametrize("sector", [Sector.FRONT, Sector.REAR])
@pytest.mark.parametrize("to_m", [0.2, 0.5, 0.8])
@pytest.mark.parametrize("road", [STRAIGHT, BEND], ids=["straight", "bend"])
def test_who_came_too_near_is_kept_where_it_must_be(sector: Sector, to_m: float, road: Road) -> None:
    """Between the bumper and the least range, for as long as it can; its uncertainty says how little is known."""
    for t, host, track in followed(closing(to_m), until_s=6.0, sector=sector, road=road):
        if t < 3.0:
            continue
        assert track is not None
        gap = abs(track.s_m - host.s_m) - TOUCHING_M
        assert -0.3 < gap < 1.3
        sd = float(np.sqrt(track.covariance[0, 0]))
        assert abs(gap - to_m) < 3.0 * sd + 0.05
        assert sd < 0.7
        assert abs(track.d_m) < 1.0
        if t > 3.5:
            assert track.coasting
            assert abs(track.speed_s_mps - 12.0) < 1.5


def test_without_the_sensors_word_the_track_is_given_up() -> None:
    *_, (_, _, track) = followed(closing(0.5), until_s=5.0, declared=False)
    assert track is None


@pytest.mark.parametrize("seed", range(5))
def test_who_comes_into_sight_again_is_the_same(seed: int) -> None:
    """Three seconds in the dark, then the gap opens."""

    def gap(t: float) -> float:
        return closing(0.6)(t) + 2.0 * max(t - 5.5, 0.0)

    ids = {track.id for t, _, track in followed(gap, until_s=7.5, seed=seed) if t > 0.5 and track is not None}
    *_, (_, host, track) = followed(gap, until_s=7.5, seed=seed)
    assert ids == {"1"}
    assert track is not None
    assert not track.coasting
    assert host.s_m - track.s_m - TOUCHING_M == pytest.approx(gap(7.45), abs=0.3)


def test_who_vanishes_where_it_could_be_seen_is_given_up_as_ever() -> None:
    for away in (1.6, 3.0, 8.0):
        *_, (_, _, track) = followed(lambda t, away=away: away, until_s=3.6, gone_s=2.0)
        assert track is None


def test_a_ghost_does_not_live_for_ever_unless_it_stands() -> None:
    """Gone in the dark, unseen: five seconds on the way. In a standing queue one may stand so near for minutes."""
    lives = [track is not None for _, _, track in followed(closing(0.5), until_s=12.0, gone_s=3.5)]
    seen_s = 1.0 + (4.0 - 1.0) / 2.0
    alive_s = STEP_S * (len(lives) - lives[::-1].index(True))
    assert seen_s + 1.0 < alive_s < seen_s + 5.3
    *_, (_, _, track) = followed(closing(0.5, rate_mps=0.4), until_s=30.0, speed=0.0)
    assert track is not None


@pytest.mark.parametrize("elsewhere_m", [-3000.0, 3000.0])
def test_who_is_hidden_on_a_bend_may_be_far_off_when_the_host_is_said_to_be_elsewhere(elsewhere_m: float) -> None:
    """The host stands; then its place is a glitch. That raised: found by the attack."""
    tracker = Tracker()
    *_, (t, host, track) = followed(closing(0.5, rate_mps=0.4), until_s=12.0, speed=0.0, road=BEND, tracker=tracker)
    assert track is not None
    moved = replace(host, s_m=host.s_m + elsewhere_m)
    tracker.update([radar_scan(t + STEP_S, [], sector=Sector.REAR, road=BEND, host=moved)], moved, BEND, t + STEP_S)
    for life in tracker.tracks(t + STEP_S):
        assert np.isfinite([life.s_m, life.d_m, life.speed_s_mps]).all()


def test_nobody_is_kept_by_a_scan_that_does_not_look_there() -> None:
    """Alongside a bumper the radar is as near, but looks elsewhere."""
    for t, _, track in followed(closing(-2.0), until_s=6.0, d_m=2.6):
        if t > 5.0:
            assert track is None


@pytest.mark.parametrize("d_m", [0.3, 1.1])
def test_the_mirrored_world_has_the_mirrored_track(d_m: float) -> None:
    """Without noise; up to rounding."""
    sides = []
    for side in (1.0, -1.0):
        tracker = Tracker()
        for t in np.arange(0.0, 5.0, STEP_S).tolist():
            host = host_at(t)
            gap_m, rate_mps = closing(0.6)(t), (closing(0.6)(t + 1e-4) - closing(0.6)(t - 1e-4)) / 2e-4
            x = np.array([host.s_m - TOUCHING_M - gap_m, 12.0 - rate_mps, side * d_m, 0.0])
            tracker.update([radar_scan(t, [body_of(x)], sector=Sector.REAR)], host, STRAIGHT, t)
        sides.append(tracker.tracks(t))
    ((one,), (other,)) = sides
    assert one.s_m == pytest.approx(other.s_m, abs=1e-9)
    assert one.d_m == pytest.approx(-other.d_m, abs=1e-9)


def test_both_forms_of_the_filter_keep_the_same_track() -> None:
    plain = Tracker()
    plain._filtering = InterpretedFiltering()
    for (_, _, one), (_, _, other) in zip(
        followed(closing(0.5), until_s=4.5), followed(closing(0.5), until_s=4.5, tracker=plain), strict=True
    ):
        assert (one is None) == (other is None)
        if one is not None and other is not None:
            assert [one.s_m, one.d_m, one.speed_s_mps] == pytest.approx([other.s_m, other.d_m, other.speed_s_mps], abs=1e-6)
            np.testing.assert_allclose(one.covariance, other.covariance, atol=1e-6)
