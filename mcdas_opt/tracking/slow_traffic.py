"""Followers in slow traffic: who is slow behind the host, with somebody slow or a tight turn ahead of it, brakes when the host has to."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.tracking.follower_prediction import gap_to_host_m, with_braking

SLOW_MPS = 10.0  # whoever is faster is in no slow traffic
TOWARDS_A_TURN_MPS = 14.0  # nor, towards a tight turn, for which he brakes in any case, whoever is faster than this
BRAKING_MPS2, RESPONSE_S = 2.0, 1.0  # what a follower in slow traffic is predicted to brake with, and after how long
ATTENTIVE_MPS2 = 3.0  # ... and beside a lane of oncoming traffic
SEEN_MPS2, KNOWN_MPS2 = 1.0, 0.4  # who brakes by so much, known to such a standard deviation, is seen to brake
CLOSING_S = 2.5  # who would be there so soon does not look ahead
TURN_1PM = 0.05  # a road that bends so tightly, as at a crossing, is driven slowly
SIDEWAYS_MPS = 0.5  # a host that moves sideways faster does not keep its lane
_PASSABLE = 0.5  # of the usual lane's width: less is nothing to drive on
_AHEAD_S, _LEAST_AHEAD_M = 4.0, 10.0  # whatever is farther ahead of the host is no reason to slow down
_SHARES = np.linspace(0.0, 1.0, 21)


def with_followers_in_slow_traffic(prediction: Prediction, situation: Situation, rates_mps2: Mapping[str, float]) -> Prediction:
    """The prediction with followers in slow traffic braking gently after a while, each as long as gentle braking is enough for him.

    Nobody can come to a safe end in a queue, or before a tight turn, if the cars behind are predicted never to brake. As before, so not to
    brake, is predicted whoever is faster, or closes in so fast, or will by accelerating until then, that gentle braking would not be
    enough; and everybody where the host steers out, or somebody ahead in the lane clearly brakes: an emergency counts on nobody.
    `rates_mps2` holds, by track, the changes of speed that are clear. Whoever is seen to brake hard enough is predicted to go on so.

    Where there is nothing beside the host's lane but the lane of those who come towards it, everybody who follows so is predicted to brake,
    as an attentive driver does, also in an emergency: to keep his distance is his, and the host has nowhere else to go.
    """
    host, road, near_m = situation.host, situation.road, _near_m(situation)
    in_lane = [track for track in situation.tracks if track.speed_s_mps >= 0.0 and situation.shares_lane(track)]
    slow = [track for track in in_lane if track.speed_s_mps <= SLOW_MPS]
    ahead = [track for track in slow if track.s_m > host.s_m and gap_to_host_m(track, host.s_m) <= near_m]
    turns = not road.is_straight and float(np.abs(road.curvature_at(host.s_m + near_m * _SHARES)).max()) >= TURN_1PM
    fastest, braking = (TOWARDS_A_TURN_MPS if turns else SLOW_MPS), BRAKING_MPS2  # through a turn nobody drives fast
    if is_beside_oncoming(situation):
        fastest, braking = TOWARDS_A_TURN_MPS, ATTENTIVE_MPS2
    elif not (ahead or turns) or any(rates_mps2.get(track.id, 0.0) < 0.0 for track in ahead):
        return prediction
    if _steers_out(situation):
        return prediction
    answers = {}
    for track in in_lane:
        rate = rates_mps2.get(track.id, 0.0)
        if track.s_m < host.s_m and track.speed_s_mps <= fastest and _looks_ahead(track, situation, rate):
            answers[track.id] = (RESPONSE_S, braking)
        elif track.s_m < host.s_m and _brakes_enough(track, situation):
            answers[track.id] = (0.0, -track.acceleration_s_mps2)
    return with_braking(prediction, answers)


def is_in_a_queue(situation: Situation) -> bool:
    """Whether the host is slow, and somebody slow is near ahead in its lane."""
    host, near_m = situation.host, _near_m(situation)
    return host.speed_mps <= SLOW_MPS and any(
        track.s_m > host.s_m
        and 0.0 <= track.speed_s_mps <= SLOW_MPS
        and situation.shares_lane(track)
        and gap_to_host_m(track, host.s_m) <= near_m
        for track in situation.tracks
    )


def is_beside_oncoming(situation: Situation) -> bool:
    """Whether the host's lane has the lane of those who come towards it beside it, and nothing else that a car can drive on."""
    host, road = situation.host, situation.road
    if not any(lane.oncoming for lane in road.lanes):
        return False
    least_m, own = _PASSABLE * road.lane_width_m, situation.host_lane
    others = (lane for lane in range(-road.lanes_right, road.lanes_left + 1) if lane != own)
    beside = {lane for lane in others if road.lane_width_at(lane, host.s_m) >= least_m}
    return bool(beside) and beside <= {lane.lane for lane in road.lanes if lane.oncoming}


def _looks_ahead(track: Track, situation: Situation, rate_mps2: float) -> bool:
    """Whether gentle braking, begun late, keeps him behind a host that drives as it does now; of somebody who accelerates until then."""
    gained = max(rate_mps2, 0.0) * RESPONSE_S
    gap, closing = gap_to_host_m(track, situation.host.s_m), max(track.speed_s_mps + gained - situation.host.speed_mps, 0.0)
    return gap > CLOSING_S * closing and closing * closing <= 2.0 * BRAKING_MPS2 * (gap - RESPONSE_S * closing)


def _brakes_enough(track: Track, situation: Situation) -> bool:
    """Whether he is clearly seen to brake, and so hard that he stays behind a host that drives as it does now. How hard a radar's noise
    does not tell well enough: counted on in one moment and not in the next, he would have the host change its mind."""
    sd, seen = track.acceleration_s_sd_mps2, -track.acceleration_s_mps2
    if sd is None or sd > KNOWN_MPS2 or seen < SEEN_MPS2:
        return False
    closing = max(track.speed_s_mps - situation.host.speed_mps, 0.0)
    return closing * closing <= 2.0 * seen * gap_to_host_m(track, situation.host.s_m)


def _steers_out(situation: Situation) -> bool:
    """Whether the host's middle, taken to be that of its wheelbase, clearly moves sideways."""
    host = situation.host
    return abs(host.speed_mps * math.sin(host.heading_rad + 0.5 * math.tan(host.steering_rad))) > SIDEWAYS_MPS


def _near_m(situation: Situation) -> float:
    return max(_AHEAD_S * situation.host.speed_mps, _LEAST_AHEAD_M)
