"""With what room, and how fast, somebody is passed within the lane: a car that stands half in it, people on foot or on bicycles, oncoming
traffic. Lengths are distances between the bodies."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vocabulary import BodyKind

_PEOPLE = (BodyKind.PEDESTRIAN, BodyKind.BICYCLE)
_ONCOMING_MPS = -5.0  # who comes faster is oncoming traffic
_SLOWEST_MPS = 3.0
_CAR_MPS_PER_M, _ONCOMING_MPS_PER_M = 10.0, 20.0
_PERSON_MPS_PER_M2 = 7.0  # 1.4 m at 50 km/h and 2.0 m at 100: the German traffic code (StVO, section 5 (4)) asks for 1.5 and 2
_STANDING_MPS, _STILL_STANDING_MPS = 0.4, 0.8  # the second of who was passed in the cycle before, here and below
_ALONG_MPS, _STILL_ALONG_MPS = 0.4, 0.6  # a person who moves across the lane faster is on his way into it
_FOLLOWED_MPS = 2.0  # a person who goes along so fast may as well be followed
_FAR_M, _CLOSE_M, _COMING_CLOSE_M = 1.0, 0.7, 0.4  # to people in the lane; where there is no lane beside; and they come towards the host
_STILL_M = 0.1  # less of all that, and of what a car leaves


class Room(NamedTuple):
    """What is asked for: at least, of somebody in the lane; wanted; and how near is near enough to be given room. [m]"""

    least_m: float
    wanted_m: float
    near_m: float


def is_person(track: Track) -> bool:
    """Whether it is somebody without a car around him."""
    return track.kind in _PEOPLE


def is_oncoming(track: Track) -> bool:
    """Whether it is traffic that comes towards the host along the road."""
    return track.speed_s_mps < _ONCOMING_MPS and not track.crosses and not is_person(track)


def stands(track: Track) -> bool:
    """Whether, of those who are passed, it is a car: that stands."""
    return not is_person(track) and not is_oncoming(track)


def may_be_passed(track: Track, *, again: bool) -> bool:
    """Whether it is oncoming, stands or is about to, or is a person who does not move across the lane; a little more freely of who was
    passed before."""
    if is_oncoming(track):
        return True
    if is_person(track):
        return abs(track.speed_d_mps) <= (_STILL_ALONG_MPS if again else _ALONG_MPS)
    standing_mps = _STILL_STANDING_MPS if again else _STANDING_MPS
    is_standing = track.is_about_to_stand or math.hypot(track.speed_s_mps, track.speed_d_mps) <= standing_mps
    return track.kind is not BodyKind.MOTORCYCLE and is_standing


def room_asked(track: Track, situation: Situation, *, again: bool) -> Room:
    """Of one who may be passed; a little less of who was passed before."""
    less_m = _STILL_M if again else 0.0
    if is_oncoming(track):
        return Room(0.25 - less_m, 1.0, 1.0)
    if not is_person(track):
        return Room(0.25 if again else 0.5, 1.0, math.inf)
    wanted_m = max(1.5, math.sqrt(situation.host.speed_mps / _PERSON_MPS_PER_M2))
    return Room(_least_beside_people_m(track, situation) - less_m, wanted_m, 2.5)


def _least_beside_people_m(person: Track, situation: Situation) -> float:
    """Where there is no lane beside to pass in, people are passed closely, and slowly, if they can hardly be followed; who comes towards
    the host cannot be at all."""
    road, lane, s_m = situation.road, situation.host_lane, situation.host.s_m
    if person.speed_s_mps > _FOLLOWED_MPS or any(road.has_lane(one, s_m) and not road.is_for_others(one) for one in (lane - 1, lane + 1)):
        return _FAR_M
    return _COMING_CLOSE_M if person.speed_s_mps < -_ALONG_MPS else _CLOSE_M


def most_mps(track: Track, gap_m: float) -> float:
    """How fast somebody is passed at that distance."""
    if is_person(track):
        return max(track.speed_s_mps, 0.0) + max(_SLOWEST_MPS, _PERSON_MPS_PER_M2 * max(gap_m, 0.0) ** 2)
    return max(_SLOWEST_MPS, (_ONCOMING_MPS_PER_M if is_oncoming(track) else _CAR_MPS_PER_M) * gap_m)


def passing_gap_m(speed_mps: Array, its_mps: Array) -> Array:
    """The distance that a speed asks for beside a person who goes along at his."""
    faster = np.maximum(speed_mps - np.maximum(its_mps, 0.0), 0.0)
    return np.asarray(np.sqrt(faster / _PERSON_MPS_PER_M2))
