"""Who brakes or accelerates is told from who does neither, by noisy radar, and stands in the prediction a second time."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.catalogue.sensors import load_sensor
from mcdas_opt.domain.body import Body
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import Scan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import PredictionSettings
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.variant import Variant
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.errors import ParameterError
from mcdas_opt.manoeuvres.safe_end import ends
from mcdas_opt.simulation.sensors import ideal_detections
from mcdas_opt.tracking.acceleration import AccelerationFilter
from mcdas_opt.tracking.prediction import (
    ACCELERATING_MPS2,
    ACCELERATING_S,
    BRAKING_MPS2,
    BRAKING_SHARE,
    RATE_SIGMAS,
    predict,
    pulling_away,
    speed_change,
)
from mcdas_opt.tracking.tracker import Tracker
from tests.tracking.worlds import ESR, host_at, radar_scan

SETTINGS, ROAD = PredictionSettings(), Road(lanes_left=1, lanes_right=1)
SLIPPERY = replace(ROAD, friction=0.2)
PERIOD_S, BEGAN_S = 0.05, 1.0
SHORT = load_sensor("corner_radar")


def followed(speed_at: Callable[[float], float], gap_m: float, seed: int, until_s: float, sector: Sector = Sector.FRONT) -> list[Track]:
    """The track, scan by scan from `BEGAN_S` on, of a car ahead (or behind) whose speed is told, seen by a noisy radar."""
    random, tracker, s, tracks = np.random.default_rng(seed), Tracker(), gap_m, []
    sign = 1.0 if sector is Sector.FRONT else -1.0
    for k in range(round(until_s / PERIOD_S) + 1):
        t = k * PERIOD_S
        car = Body(name="a", s_m=sign * s, d_m=0.0, heading_rad=0.0, speed_mps=speed_at(t), length_m=4.5, width_m=1.8)
        tracker.update([radar_scan(t, [car], random=random, sector=sector)], host_at(t), ROAD, t)
        tracks += [track for track in tracker.tracks(t) if t >= BEGAN_S - 1e-9]
        s += sign * PERIOD_S * 0.5 * (speed_at(t) + speed_at(t + PERIOD_S))
    return tracks


@pytest.mark.parametrize("sector", [Sector.FRONT, Sector.REAR])
def test_noise_alone_brakes_nobody(sector: Sector) -> None:
    """Constant speeds, near and far: no hypothesis in 99.9 % of the cycles."""
    tracks = [track for seed in range(12) for track in followed(lambda t: 12.0, 12.0 + 8.0 * seed, seed, 16.0, sector)]
    assert len(tracks) > 3000
    for road in (ROAD, SLIPPERY):
        told = sum(speed_change(track, road) is not None for track in tracks)
        assert told <= 0.001 * len(tracks)
    rates = np.array([track.acceleration_s_mps2 for track in tracks])
    sds = np.array([track.acceleration_s_sd_mps2 for track in tracks])
    assert abs(float(rates.mean())) < 0.1
    assert float(np.mean(np.abs(rates) < 2.5 * sds)) > 0.998


@pytest.mark.parametrize("sensor", [ESR, SHORT], ids=["long", "short"])
def test_nor_does_the_noise_of_a_car_that_is_passed(sensor: object) -> None:
    """A car in the next lane, from ahead to behind at 5 m/s, by the flank's radar."""
    told = cycles = 0
    for seed in range(8):
        random, tracker = np.random.default_rng(seed), Tracker()
        for k in range(160):
            t = k * PERIOD_S
            car = Body(name="a", s_m=20.0 + 7.0 * t, d_m=3.7, heading_rad=0.0, speed_mps=7.0, length_m=4.5, width_m=1.8)
            scans = [radar_scan(t, [car], random=random, sector=sector, sensor=SHORT) for sector in (Sector.LEFT,)]
            if sensor is ESR:
                scans += [radar_scan(t, [car], random=random)]
            tracker.update(scans, host_at(t), ROAD, t)
            tracks = tracker.tracks(t) if t > BEGAN_S else ()
            cycles += len(tracks)
            told += sum(speed_change(track, ROAD) is not None for track in tracks)
    assert cycles > 700
    assert told <= 0.01 * cycles


@pytest.mark.parametrize("rate", [-8.0, -6.0, -4.5, 3.5, 5.0])
def test_a_constant_change_of_speed_is_followed(rate: float) -> None:
    """Told within 0.6 s of its beginning, in sign and to 1.5 m/s^2 after 0.8 s; and two seconds ahead it is foretold better than by
    constant speed."""
    lead_s, late, errors = 2.0, [], []
    sector = Sector.FRONT if rate < 0.0 else Sector.REAR
    for seed in range(8):
        tracks = followed(lambda t: max(20.0 + rate * max(t - BEGAN_S, 0.0), 0.0), 40.0, seed, BEGAN_S + 1.2, sector)
        told = [PERIOD_S * k for k, track in enumerate(tracks) if _told(track, rate)]
        late.append(told[0] if told else math.inf)
        last = tracks[-5]
        assert last.acceleration_s_mps2 == pytest.approx(rate, abs=1.5)
        steady, changing = predict([last], SETTINGS, ROAD).bodies
        assert changing.id == (Variant.BRAKING if rate < 0.0 else Variant.ACCELERATING).of(last.id)
        lasting = lead_s if rate < 0.0 else ACCELERATING_S
        moved = min(lasting, last.speed_s_mps / -rate) if rate < 0.0 else lasting
        true = last.s_m + last.speed_s_mps * lead_s + rate * moved * (lead_s - 0.5 * moved)
        errors.append([abs(float(body.at(lead_s).s_m) - true) for body in (steady, changing)])
    assert max(late) <= 0.6
    constant, changed = np.mean(errors, axis=0)
    assert changed < 0.4 * constant


def _told(track: Track, rate: float) -> bool:
    change = speed_change(track, ROAD)
    return change is not None and change[0] * rate > 0.0


@pytest.mark.parametrize("rate", [0.0, 2.5, 4.0])
def test_an_ideal_sensor_tells_who_pulls_away_across_the_road(rate: float) -> None:
    """Within 0.6 s, and of nobody who stands; a radar does not tell."""
    tracker, radar, late = Tracker(), Tracker(), math.inf
    host = host_at(0.0, speed=0.0)
    for k in range(50):
        t, for_s = k * PERIOD_S, max(k * PERIOD_S - 1.5, 0.0)
        car = Body(name="a", s_m=40.0, d_m=-6.0 + 0.5 * rate * for_s**2, heading_rad=0.5 * math.pi, speed_mps=rate * for_s)
        seen = ideal_detections(Sector.FRONT, host, [car], Vehicle())
        tracker.update([Scan(sensor="ideal", sector=Sector.FRONT, t_s=t, bodies=seen, period_s=PERIOD_S)], host, ROAD, t)
        radar.update([radar_scan(t, [car])], host, ROAD, t)
        assert all(track.acceleration_d_sd_mps2 is None for track in radar.tracks(t))
        if pulling_away(tracker.tracks(t)[0], ROAD) is not None:
            late = min(late, for_s)
    assert (0.0 < late <= 0.6) if rate else late == math.inf


def test_full_braking_on_ice_is_told() -> None:
    """2.4 m/s^2 are all that friction 0.25 gives: told within a second and a half, where the same on a dry road is hardly ever told."""
    drives = [followed(lambda t: 20.0 - 2.4 * max(t - BEGAN_S, 0.0), 30.0, seed, BEGAN_S + 1.5) for seed in range(8)]

    def told(road: Road) -> list[int]:
        return [sum(speed_change(track, road) is not None for track in tracks) for tracks in drives]

    on_ice, dry = told(replace(ROAD, friction=0.25)), told(ROAD)
    assert sum(count > 0 for count in on_ice) >= 7
    assert sum(on_ice) > 5 * sum(dry)


def test_after_it_has_ended_so_does_the_hypothesis() -> None:
    tracks = followed(lambda t: 20.0 - 6.0 * min(max(t - BEGAN_S, 0.0), 1.0), 40.0, 3, BEGAN_S + 2.5)
    assert any(_told(track, -1.0) for track in tracks[:20])
    assert not any(_told(track, -1.0) for track in tracks[30:])


def test_who_is_not_seen_is_soon_not_known_to_brake() -> None:
    """Half a second without a look, and nothing is left of it but doubt."""
    filter_ = AccelerationFilter()
    assert filter_.at(0.0) == (0.0, None)
    for k in range(40):
        filter_.take(0.05 * k, 20.0 - 6.0 * 0.05 * k, 0.0144)
    rate, sd = filter_.at(1.95)
    assert sd is not None
    assert rate == pytest.approx(-6.0, abs=0.2)
    later, doubt = filter_.at(3.5)
    assert later == rate
    assert doubt is not None
    assert doubt > 2.0 * sd
    assert abs(later) < RATE_SIGMAS * doubt


rates, deviations = st.floats(-12.0, 12.0), st.floats(0.0, 6.0)


def track_of(rate: float, sd: float | None, *, s: float = 20.0, speed: float = 15.0, d: float = 0.0) -> Track:
    return Track(id="7", s_m=s, d_m=d, speed_s_mps=speed, acceleration_s_mps2=rate, acceleration_s_sd_mps2=sd)


@given(rate=rates, sd=deviations, speed=st.floats(-5.0, 40.0), friction=st.floats(0.1, 1.2), d=st.floats(-4.0, 4.0))
def test_only_who_plainly_changes_speed_is_there_twice(rate: float, sd: float, speed: float, friction: float, d: float) -> None:
    road = Road(lanes_left=1, lanes_right=1, friction=friction)
    track = track_of(rate, sd, speed=speed, d=d)
    steady, *besides = predict([track], SETTINGS, road).bodies
    hard = min(BRAKING_MPS2, BRAKING_SHARE * friction * GRAVITY_MPS2) if rate < 0.0 else ACCELERATING_MPS2
    plain = abs(rate) >= max(hard, RATE_SIGMAS * sd)
    assert bool(besides) is (plain and speed > 0.0)
    t = np.linspace(0.0, 12.0, 601)
    np.testing.assert_array_equal(steady.at(t).s_m, 20.0 + speed * t)
    for body in besides:
        motion = body.at(t)
        assert (np.diff(motion.s_m) >= -1e-9).all()  # nobody drives backwards for having braked
        assert (motion.speed_s_mps >= -1e-9).all()
        slowing = np.diff(motion.speed_s_mps) / 0.02
        assert np.abs(slowing).max() <= min(abs(rate), friction * GRAVITY_MPS2) + 1e-6
        np.testing.assert_allclose(np.diff(motion.s_m), 0.01 * (motion.speed_s_mps[1:] + motion.speed_s_mps[:-1]), atol=1e-3)
        np.testing.assert_array_equal(motion.d_m, steady.at(t).d_m)
        behind = motion.s_m <= steady.at(t).s_m + 1e-9
        assert behind.all() if rate < 0.0 else (motion.s_m >= steady.at(t).s_m - 1e-9).all()
    assert len(predict([track_of(rate, None, speed=speed)], SETTINGS, road).bodies) == 1


@pytest.mark.parametrize(("follower_mps", "told"), [(10.0, False), (3.0, False), (10.5, True), (25.0, True)])
def test_in_a_queue_nobody_is_foretold_to_brake(follower_mps: float, told: bool) -> None:
    front = track_of(-5.0, 0.5)
    for d, there in ((0.1, told), (3.7, True)):
        follower = Track(id="8", s_m=-12.0, d_m=d, speed_s_mps=follower_mps)
        ids = [body.id for body in predict([front, follower], SETTINGS, ROAD, host_s_m=0.0).bodies]
        assert (Variant.BRAKING.of("7") in ids) is there


@given(rate=rates, s=st.floats(-60.0, 60.0))
def test_a_follower_is_never_foretold_to_brake(rate: float, s: float) -> None:
    bodies = predict([track_of(rate, 0.5, s=s)], SETTINGS, ROAD, host_s_m=0.0).bodies
    braking = [body for body in bodies if body.id.endswith(Variant.BRAKING)]
    assert not braking or (s > -4.5 and rate < 0.0)
    assert bodies[0].id == "7"


@given(
    rate=rates, sd=st.floats(0.0, 2.0), s=st.floats(-60.0, 60.0), d=st.floats(-4.0, 4.0), own=st.floats(0.0, 35.0), seed=st.integers(0, 99)
)
def test_a_safe_end_is_never_easier_to_come_by(rate: float, sd: float, s: float, d: float, own: float, seed: int) -> None:
    """With the rate known, no end counts as safe that does not without it."""
    random, n = np.random.default_rng(seed), 21
    t = np.linspace(0.0, 4.0, n)
    slowing = float(random.uniform(-6.0, 3.0))
    v = np.maximum(own + slowing * t, 0.0)
    zero = np.zeros(n)
    drive = Trajectory(
        t_s=t,
        s_m=np.concatenate([[0.0], np.cumsum(0.1 * (v[1:] + v[:-1]))]),
        d_m=zero,
        heading_rad=zero,
        speed_mps=v,
        acceleration_mps2=zero,
        steering_rad=zero,
        steering_rate_radps=zero,
        jerk_mps3=zero,
    )
    known, unknown = (
        ends(drive, 0, HostState(speed_mps=own), Vehicle(), ROAD, predict([track], SETTINGS, ROAD, 0.0))
        for track in (track_of(rate, sd, s=s, d=d), track_of(rate, None, s=s, d=d))
    )
    assert not (known.safe & ~unknown.safe).any()
    assert (known.front_margin_m <= unknown.front_margin_m).all()
    assert (known.follower_demand_mps2 >= unknown.follower_demand_mps2).all()


def test_a_rate_must_be_a_number() -> None:
    with pytest.raises(ParameterError, match="acceleration_s_mps2"):
        track_of(math.nan, 1.0)
    with pytest.raises(ParameterError, match="acceleration_s_sd_mps2"):
        track_of(1.0, -1.0)
