"""The predicted motion of tracked neighbours."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from mcdas_opt.domain.prediction import BodyMotion, CruisingBody, FreeBody, PredictedBody, Prediction
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.settings import PredictionSettings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.variant import Variant
from mcdas_opt.domain.vocabulary import BodyKind
from mcdas_opt.tracking.free_motion import straight_on, to_turn_rad, turning_in
from mcdas_opt.tracking.lane_path import along_lane, bends_gently, keeps_to_lane, leads_off
from mcdas_opt.tracking.slow_traffic import SLOW_MPS, TURN_1PM, is_in_a_queue, with_followers_in_slow_traffic

CONSTANT_VELOCITY = "constant-velocity"

# a track may be changing lanes that moves sideways so fast, by so many standard deviations, so far from the middle of its lane
CHANGE_MPS, CHANGE_SIGMAS, CHANGE_FROM_M = 0.5, 2.5, 0.2
ONCOMING_INTRUSION_M = 0.2  # who comes towards the host, beyond the line
CHANGE_FASTEST_S = 0.4  # no lane change fades faster (0.4: one lane in about 3 s), unless the track shows that it does
CHANGE_GROWTH, CHANGE_PEAK_MPS = 2.0, 3.0  # it may become so many times as fast, up to this speed
# a track may go on braking, until it stands, that brakes so hard (on a slippery road: by this share of what it gives); or accelerating
BRAKING_MPS2, BRAKING_SHARE = 3.0, 0.8
ACCELERATING_MPS2, ACCELERATING_S = 2.0, 1.0  # it goes on for so long
SLOWING_S = 1.0  # who crosses or turns, and clearly slows down, goes on to for so long
STEADY = 0.0, 0.0  # neither faster nor slower
PULLING_AWAY_MPS = 0.1, 4.0  # across the road: who is slower stands, who is faster drives
RATE_SIGMAS = 2.5  # standard deviations that a change of speed, or a turn, has to show
# a track may go straight on where our road turns as tightly as at a crossing, so soon: towards us, or too fast for the turn
TURN_WITHIN_S, TURN_MPS2 = 4.0, 4.0
TURN_FADE_S = 0.5  # who comes towards us through such a turn settles so soon, or goes straight on: both are predicted
TURNS_IN_S = 0.8  # who clearly turns, and so ends his turn so soon, does not go straight on before
SETTLES_LEAST_S = 0.2  # nobody who turns back into the road's direction settles sooner
# but not who clearly turns with a road that turns so much, at least at such a share of what it asks of him on average for the next moment,
# and at most at such one of the most that it asks of him then
LEAST_TURN_1PM, TURNS_LEAST, TURNS_MOST = 0.02, 0.5, 2.0
_AT_ONCE_S = np.linspace(0.0, 0.5, 6)
_TURN_TIMES_S = np.linspace(0.0, TURN_WITHIN_S, 21)
ACROSS_MPS, YOUNG_MPS = 1.0, 0.5  # what is usual across a lane; a speed across that is known no better is that of a young track
_MEETING_TIMES_S = np.linspace(0.0, 8.0, 41)
_ROUNDING_M = 1e-6  # what a shift of the origin may change
STRAYING_MPS = 0.5  # somebody on foot may at once go so much faster or elsewhere
# to stay behind another nobody needs more of the grip than this, to brake, or a higher speed across the road
SHIELDED_SHARE, SHIELDED_SIDEWAYS_MPS = 0.6, 0.5


def predict(
    tracks: Sequence[Track], settings: PredictionSettings | None = None, road: Road | None = None, host_s_m: float | None = None
) -> Prediction:
    """Every track keeps its speed along the road and settles across it; margins from the *present* covariance (see `CruisingBody`).

    On a `road`, a track that clearly moves sideways is predicted twice: it settles where it is, or it goes on to the next lane
    (`lane_change`). So is one that clearly brakes or accelerates: constant speed, or a lasting change (`speed_change`). Plans avoid all of
    them, so that no plan relies on anybody to make room. Nobody wholly behind a host at `host_s_m` is predicted to brake, which would
    make it less dangerous, nor anybody in a queue (`_queues`). Time zero is the situation's time.

    Nobody drives through anybody else: who follows somebody that is itself wholly behind the host, and can stay behind him by hard braking
    (`_is_shielded`), or whose lane leads him there (`_joins_behind`), does not come to the host, and is not in the prediction.

    Who does not follow the road, being turned off its direction, or on foot, is predicted in the plane alone: it follows its lane, where
    that is known, else it keeps its velocity and its heading, or ends its turn. Who clearly slows down there, to give way or to stop,
    goes on to for a second; who clearly pulls away is predicted once more. In the plane alone is, too, who comes
    towards the host in a lane that leads elsewhere, where he is slow enough for its bends, or keeps to such a lane where the road turns
    tightly (`_leaves_by_its_lane`); and, besides, who stands or creeps aslant;
    and whoever is known to head along a road that turns as tightly as at a crossing, and may go straight on there, unless its lane is
    known. Who comes towards the host there either goes straight on or keeps to his lane's turn, settling soon: his speed across the road
    is that of cutting the turn, not of changing lanes.

    Who clearly turns with the road (`turns_with`) does not go straight on; who clearly turns back into its direction settles as soon as
    that takes (`settling_s`).
    """
    settings = PredictionSettings() if settings is None else settings
    bodies: list[PredictedBody] = []
    following = [] if host_s_m is None else [track for track in tracks if _is_behind(track, host_s_m) and _keeps_to_its_line(track)]
    on = Road() if road is None else road
    hard_mps2 = SHIELDED_SHARE * on.grip_mps2
    shielded = {track.id for track in following if _is_shielded(track, following, hard_mps2)}
    for track in tracks:
        if track.id in shielded:
            continue
        slowing = slowing_down(track, road) if road is not None else STEADY
        is_behind = host_s_m is not None and _is_behind(track, host_s_m)
        goes_elsewhere = not track.follows_road or _leaves_by_its_lane(track, on)
        may_join = is_behind and bool(following)
        lane = along_lane(track, on, *slowing) if goes_elsewhere or may_join else None
        if may_join and lane is not None and host_s_m is not None and _joins_behind(track, lane, following, host_s_m, hard_mps2):
            continue
        if not track.follows_road or (goes_elsewhere and lane is not None):
            bodies.append(_free(track, settings, lane or _free_motion(track, on, *slowing), track.id))
            if road is not None and (rate := pulling_away(track, road)) is not None:
                faster = along_lane(track, road, *rate) or _free_motion(track, road, *rate)
                bodies.append(_free(track, settings, faster, Variant.ACCELERATING.of(track.id)))
            continue
        meets_a_turn = road is not None and _may_go_straight_on(track, road)
        comes_through_a_turn = meets_a_turn and track.speed_s_mps < 0.0
        is_too_fast = meets_a_turn and not turns_with(track, on) and along_lane(track, on, *slowing) is None
        if is_too_fast or track.lies_aslant:
            bodies.append(_free(track, settings, _free_motion(track, on), Variant.STRAIGHT_ON.of(track.id)))
        drifting = CruisingBody(
            id=track.id,
            length_m=track.length_m,
            width_m=track.width_m,
            s_m=track.s_m,
            d_m=track.d_m,
            speed_s_mps=track.speed_s_mps,
            speed_d_mps=_across_mps(track),
            covariance=track.covariance,
            lateral_fade_s=min(
                settings.lateral_fade_s, TURN_FADE_S if comes_through_a_turn else math.inf, settling_s(track, road) if road else math.inf
            ),
            sigmas=settings.sigmas,
            growth_s=settings.growth_s,
            cap_along_m=settings.cap_along_m,
            cap_across_m=settings.cap_across_m,
        )
        bodies.append(drifting)
        change = None if road is None or comes_through_a_turn else lane_change(track, settings, road)
        if change is not None:
            speed_d, fade_s, swell = change
            name = Variant.CHANGING.of(track.id)
            bodies.append(replace(drifting, id=name, speed_d_mps=speed_d, lateral_fade_s=fade_s, lateral_swell=swell))
        rate = None if road is None else speed_change(track, road)
        if rate is not None and rate[0] < 0.0 and host_s_m is not None:
            rate = None if is_behind or _queues(track, tracks, host_s_m, on) else rate
        if rate is not None:
            acceleration, lasting_s = rate
            variant = Variant.BRAKING if acceleration < 0.0 else Variant.ACCELERATING
            bodies.append(replace(drifting, id=variant.of(track.id), acceleration_mps2=acceleration, changing_s=lasting_s))
    return Prediction(name=CONSTANT_VELOCITY, bodies=tuple(bodies))


def predict_for(situation: Situation, settings: PredictionSettings | None = None) -> Prediction:
    """`predict` of a situation's tracks on its road, around its host, with followers that brake in slow traffic: what plans are made under,
    and have to be judged under. Nobody behind the host is predicted to change lanes into its queue."""
    prediction = predict(situation.tracks, settings, situation.road, situation.host.s_m)
    if is_in_a_queue(situation):
        late = {Variant.CHANGING.of(track.id) for track in situation.tracks if _comes_behind(track, situation)}
        prediction = Prediction(name=prediction.name, bodies=tuple(body for body in prediction.bodies if body.id not in late))
    rates = {track.id: change[0] for track in situation.tracks if (change := speed_change(track, situation.road)) is not None}
    return with_followers_in_slow_traffic(prediction, situation, rates)


def _free_motion(track: Track, road: Road, rate_mps2: float = 0.0, lasts_s: float = 0.0) -> Callable[[Array], BodyMotion]:
    """Straight on; but who clearly turns, and so ends his turn into the road's direction, or against it, at once, turns on until then."""
    sd, rate = track.turn_rate_sd_radps, track.turn_rate_radps
    if sd is None or abs(rate) <= RATE_SIGMAS * sd or track.kind is BodyKind.PEDESTRIAN:
        return straight_on(track, road, rate_mps2, lasts_s)
    is_at_once = to_turn_rad(track.heading_rad or 0.0, rate) <= abs(rate) * TURNS_IN_S
    return (turning_in if is_at_once else straight_on)(track, road, rate_mps2, lasts_s)


def _free(track: Track, settings: PredictionSettings, motion: Callable[[Array], BodyMotion], name: str) -> FreeBody:
    on_foot = track.kind is BodyKind.PEDESTRIAN
    return FreeBody(
        id=name,
        length_m=track.length_m,
        width_m=track.width_m,
        motion=motion,
        heading_rad=track.heading_rad or 0.0,
        covariance=track.covariance,
        unsure_mps=STRAYING_MPS if on_foot else 0.0,
        on_foot=on_foot,
        sigmas=settings.sigmas,
        growth_s=settings.growth_s,
        cap_along_m=settings.cap_along_m,
        cap_across_m=settings.cap_across_m,
    )


def _leaves_by_its_lane(track: Track, road: Road) -> bool:
    """Whether somebody who follows the road, but whose lane leads elsewhere, goes there: if he is slow enough for its bends, who comes
    towards the host, and who drives along with it, keeps to his lane, and has a tight turn of the road before him."""
    if track.lane_path_m is None or not leads_off(track.lane_path_m, track.d_m):
        return False
    if track.speed_s_mps >= 0.0 and (_tightest_1pm(track, road) < TURN_1PM or not keeps_to_lane(track, road)):
        return False
    return bends_gently(track, road)


def _tightest_1pm(track: Track, road: Road) -> float:
    """How tightly the road turns at most on the way of a track."""
    return 0.0 if road.is_straight else float(np.abs(road.curvature_at(track.s_m + track.speed_s_mps * _TURN_TIMES_S)).max())


def _may_go_straight_on(track: Track, road: Road) -> bool:
    """Whether the road turns tightly before a track of known heading that comes towards the host, or is too fast for the turn."""
    if track.heading_rad is None:
        return False
    turn = _tightest_1pm(track, road)
    return turn >= TURN_1PM and (track.speed_s_mps < 0.0 or turn * track.speed_s_mps**2 > TURN_MPS2)


def turns_with(track: Track, road: Road) -> bool:
    """Whether it clearly turns about as the road does where it is and will be at once: then it does not go straight on."""
    sd = track.turn_rate_sd_radps
    if sd is None or abs(track.turn_rate_radps) <= RATE_SIGMAS * sd:
        return False
    curvature = road.curvature_at(track.s_m + track.speed_s_mps * _AT_ONCE_S)
    mean, tightest = float(np.mean(curvature)), float(curvature[np.argmax(np.abs(curvature))])
    if abs(mean) < LEAST_TURN_1PM or track.speed_s_mps == 0.0 or mean * tightest < 0.0:
        return False
    turns_1pm = track.turn_rate_radps / track.speed_s_mps
    return turns_1pm / mean >= TURNS_LEAST and turns_1pm / tightest <= TURNS_MOST


def settling_s(track: Track, road: Road) -> float:
    """How long a track that clearly turns back into the road's direction goes on moving across it, at the least rate that it may turn with;
    infinite of any other."""
    sd, along = track.turn_rate_sd_radps, track.speed_s_mps
    if sd is None or not track.follows_road or abs(track.turn_rate_radps) <= RATE_SIGMAS * sd:
        return math.inf
    turning = track.turn_rate_radps - float(road.curvature_at(track.s_m)) * along
    surely = abs(turning) - RATE_SIGMAS * sd
    if surely <= 0.0 or turning * along * track.speed_d_mps >= 0.0:
        return math.inf
    return max(abs(track.speed_d_mps / (along * surely)), SETTLES_LEAST_S)


def _across_mps(track: Track) -> float:
    """How fast it moves across its lane, told of a young track in the light of what is usual (the mean of two normal distributions): after
    three noisy looks it may seem to leave its lane at 2 m/s. No faster than along it, unless that is clear: who stands does not slide."""
    across, variance = track.speed_d_mps, max(float(track.covariance[3, 3]), 0.0)
    unknown = max(variance - YOUNG_MPS**2, 0.0)
    across = across * ACROSS_MPS**2 / (ACROSS_MPS**2 + unknown) if unknown else across
    if abs(across) > CHANGE_SIGMAS * math.sqrt(variance):
        return across
    most = abs(track.speed_s_mps)
    return min(max(across, -most), most)


def lane_change(track: Track, settings: PredictionSettings, road: Road) -> tuple[float, float, float] | None:
    """(speed sideways [m/s], fade [s], swell) of a logistic lane change from where the track is to the middle of the next lane.

    None where the track does not clearly move sideways, has hardly left its lane's middle, has no lane to go to, or would settle in that
    lane anyway; and of one who comes towards the host and is not over the line yet: on roads with traffic either way such are met all day.

    The lane change begins `sigmas` standard deviations faster than the track (a filter lags behind a growing speed: by 0.6 m/s where a
    lane takes 2.3 s), or as fast as the track where that could not end in that lane. Its fade is at least `CHANGE_FASTEST_S`, and such that
    its speed grows at most `CHANGE_GROWTH` times, up to `CHANGE_PEAK_MPS`: a faster track counts as further on than it is.

    The distance left, r, shrinks as r' = -r (w - r) / (w fade), w the lane's width (Verhulst's equation), at most by w / (4 fade).
    """
    seen, sd = abs(track.speed_d_mps), math.sqrt(max(float(track.covariance[3, 3]), 0.0))
    if seen < max(CHANGE_MPS, CHANGE_SIGMAS * sd) or seen > abs(track.speed_s_mps):
        return None
    left, width = track.speed_d_mps > 0.0, road.lane_width_m
    across = track.d_m if left else -track.d_m  # towards where it goes
    lane = math.ceil((across + seen * settings.lateral_fade_s) / width)
    to_go = lane * width - across
    gone = width - to_go
    if gone < CHANGE_FROM_M or not road.has_lane(lane if left else -lane, track.s_m):
        return None
    if track.speed_s_mps < 0.0 and gone + 0.5 * track.across_m < 0.5 * width + ONCOMING_INTRUSION_M:
        return None
    for sideways in (seen + settings.sigmas * sd, seen):
        peak = min(CHANGE_GROWTH * sideways, CHANGE_PEAK_MPS)
        fastest = to_go / min(CHANGE_FASTEST_S, 0.25 * width / peak) - sideways
        if fastest > 0.0:
            gone = max(gone, sideways * to_go / fastest)
            return sideways if left else -sideways, to_go * gone / (sideways * (to_go + gone)), to_go / gone
    return None


def speed_change(track: Track, road: Road) -> tuple[float, float] | None:
    """(acceleration [m/s^2], constant until [s]) of a track that clearly brakes, until it stands, or clearly accelerates, for a while.

    Neither is harder than the road allows. None for any other track, and for one that does not drive forwards.
    """
    return _speed_change(track.acceleration_s_mps2, track.acceleration_s_sd_mps2, track.speed_s_mps, road)


def pulling_away(track: Track, road: Road) -> tuple[float, float] | None:
    """The same of a track that does not follow the road and clearly accelerates from standing, in the direction of its heading; None of
    people on foot. Of who crosses faster a second prediction closes more ways than it keeps clear."""
    ahead = track.along_heading
    if ahead is None or ahead.acceleration_mps2 <= 0.0 or not PULLING_AWAY_MPS[0] <= ahead.speed_mps <= PULLING_AWAY_MPS[1]:
        return None
    return _speed_change(*ahead, road)


def slowing_down(track: Track, road: Road) -> tuple[float, float]:
    """(acceleration [m/s^2], constant until [s]) of a vehicle that clearly slows down, wherever it goes; `STEADY` of any other."""
    rate, speed = min(track.slowing_mps2, road.grip_mps2), math.hypot(track.speed_s_mps, track.speed_d_mps)
    return (-rate, min(speed / rate, SLOWING_S)) if rate > 0.0 and speed > 0.0 else STEADY


def _speed_change(rate: float, sd: float | None, speed: float, road: Road) -> tuple[float, float] | None:
    grip = road.grip_mps2
    least = min(BRAKING_MPS2, BRAKING_SHARE * grip) if rate < 0.0 else ACCELERATING_MPS2
    if sd is None or speed <= 0.0 or abs(rate) < max(least, RATE_SIGMAS * sd):
        return None
    rate = min(max(rate, -grip), grip)
    return rate, -speed / rate if rate < 0.0 else ACCELERATING_S


def _comes_behind(track: Track, situation: Situation) -> bool:
    """Whether somebody behind the host moves from the next lane towards the host's."""
    host, aside = situation.host, situation.host.d_m - track.d_m
    return _is_behind(track, host.s_m) and abs(aside) < 1.5 * situation.road.lane_width_m and aside * track.speed_d_mps > 0.0


def _is_behind(track: Track, host_s_m: float) -> bool:
    """Wherever places are counted from: who is as far behind as he is long, but for rounding, is."""
    return host_s_m - track.s_m >= track.length_m - _ROUNDING_M


def _is_shielded(track: Track, following: Sequence[Track], braking_mps2: float) -> bool:
    """Whether one of those who follow the host, in its way, is between the two, and such braking is enough to stay behind that one."""
    for one in following:
        gap = one.s_m - track.s_m - 0.5 * (one.length_m + track.length_m)
        if gap <= 0.0:
            continue
        shared = 0.5 * (one.width_m + track.width_m) - abs(one.d_m - track.d_m)
        if shared < 0.5 * min(one.width_m, track.width_m):
            continue
        if max(track.speed_s_mps - max(one.speed_s_mps, 0.0), 0.0) ** 2 <= 2.0 * braking_mps2 * gap:
            return True
    return False


def _joins_behind(
    track: Track, along_lane: Callable[[Array], BodyMotion], following: Sequence[Track], host_s_m: float, braking_mps2: float
) -> bool:
    """Whether somebody's lane leads him to one of those who follow the host, before he is level with it, and such braking is enough to stop
    before he is there, at the first of them."""
    at = along_lane(_MEETING_TIMES_S)
    meets = np.zeros(_MEETING_TIMES_S.size, dtype=bool)
    for one in following:
        length, width = 0.5 * (one.length_m + track.length_m), 0.5 * (one.width_m + track.width_m)
        if one is not track:
            meets |= (np.abs(at.s_m - one.s_m - one.speed_s_mps * _MEETING_TIMES_S) < length) & (np.abs(at.d_m - one.d_m) < width)
    k = int(meets.argmax())
    if k == 0 or at.s_m[: k + 1].max() > host_s_m - track.length_m:  # he meets nobody, or is within somebody now
        return False
    speed = math.hypot(float(at.speed_s_mps[0]), float(at.speed_d_mps[0]))
    return speed <= 2.0 * braking_mps2 * float(_MEETING_TIMES_S[k])


def _keeps_to_its_line(track: Track) -> bool:
    return track.follows_road and abs(track.speed_d_mps) < SHIELDED_SIDEWAYS_MPS


def _queues(ahead: Track, tracks: Sequence[Track], host_s_m: float, road: Road) -> bool:
    """Whether somebody slow follows the host in the lane of that track.

    In a queue everybody brakes with the car ahead. To predict this of the front car and not of the follower would leave no candidate; the
    safe end has the front car brake fully in any case.
    """
    return any(
        _is_behind(one, host_s_m) and one.speed_s_mps <= SLOW_MPS and abs(one.d_m - ahead.d_m) < 0.5 * road.lane_width_m for one in tracks
    )
