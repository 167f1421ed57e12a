"""Bad scans and bad detections are counted here and go no further."""

from __future__ import annotations

import math

from mcdas_opt.domain.measurement import BodyDetection, Mounting, RadarDetection, Scan
from mcdas_opt.domain.rules import FARTHEST_M
from mcdas_opt.domain.track import LONGEST_M
from mcdas_opt.domain.vocabulary import Sector

FUTURE_TOLERANCE_S = 0.05  # scans further ahead of the clock are refused; a clock that runs back by no more jitters
FAR_AHEAD_S = 1.0  # a scan further ahead is of another clock, or another unit: that is said
AGE_MAX_S = 1.0  # older scans are refused; nothing that was remembered is true after so long a time without a word
LAG_MAX_S = 0.2  # one sensor may report this much later than another
RANGE_MAX_M = 300.0  # beyond is no car
SPEED_MAX_MPS = 100.0  # no range rate, no speed exceeds this
SD_MIN, SD_MAX = 1e-6, 1e3  # [m, rad, m/s]: no radar claims to be better, none that is worse says anything
MOUNTED_WITHIN_M = 100.0  # of the body centre: the longest road train
MOST_SCANS = 40  # of an update: the latest
MOST_DETECTIONS = 256  # of a scan: the nearest; a radar of points has to group them before
SAME_TIME_S = 1e-6  # scans of one sensor closer than this are the same scan; and more than a clock of 1.7e9 s rounds off
ELSEWHERE_RAD = math.radians(135.0)  # of where a sector lies: no sensor of it sees there alone
Source = tuple[str, Sector, Mounting]  # one product may sit at several places

COUNTERS = (
    "scans",  # accepted scans
    "associated",  # detections that found their track
    "initiated",  # detections that began a track
    "gated",  # sound detections that fitted no track there was (they may begin one)
    "not_finite",  # NaN or infinite: detections, or scans with such a time or mounting
    "negative_range",
    "implausible",  # beyond the farthest range or the highest speed, no width, off any road
    "duplicate",  # a scan of the same time as the last, a detection said twice in one scan
    "too_many",  # scans of an update, detections of a scan, or tracks, beyond the most that are followed
    "out_of_order",  # scans older than the last of the same sensor, or too old beside another's
    "future",  # scans ahead of the clock
    "stale",  # scans far behind the clock
    "dead",  # scans that say that their sensor does not work
    "elsewhere",  # scans of a front or rear sensor, all of whose returns come from the other side
    "clock_back",  # times that the clock ran back: all that was remembered is forgotten
    "clock_ahead",  # times that it jumped ahead, likewise
    "clock_stands",  # cycles in which it had not gone on for ten, likewise
    "odometry",  # cycles in which the host's place had not moved as its speed and the clock say, likewise
    "range_rates",  # times that range rates, believed till then, did not fit how a radar's ranges change
    "unfollowed",  # scans with a return that has come again and again, and of which no track comes
)

_LIES_AT_RAD = {Sector.FRONT: 0.0, Sector.REAR: math.pi}


def source_of(scan: Scan) -> Source:
    return scan.sensor, scan.sector, scan.mounting


def clock_fault(now: float, last_s: float | None) -> str | None:
    """What is wrong with a clock that shows `now` after it has shown `last_s`, or None."""
    if last_s is None or -FUTURE_TOLERANCE_S <= now - last_s <= AGE_MAX_S + SAME_TIME_S:
        return None
    return "clock_back" if now < last_s else "clock_ahead"


def scan_fault(scan: Scan, now: float, last_s: float | None, clock_s: float | None) -> str | None:
    """Why a scan is refused, or None. `last_s` is the time of this sensor's last scan, `clock_s` the newest of all sensors'."""
    mounting = scan.mounting
    if not all(map(math.isfinite, (scan.t_s, mounting.x_m, mounting.y_m, mounting.yaw_rad))):
        return "not_finite"
    if max(abs(mounting.x_m), abs(mounting.y_m)) > MOUNTED_WITHIN_M:
        return "implausible"
    if scan.t_s > now + FUTURE_TOLERANCE_S:
        return "future"
    if last_s is not None and abs(scan.t_s - last_s) <= SAME_TIME_S:
        return "duplicate"
    if (last_s is not None and scan.t_s < last_s) or (clock_s is not None and scan.t_s < clock_s - LAG_MAX_S):
        return "out_of_order"
    if scan.t_s < now - AGE_MAX_S:
        return "stale"
    if not scan.working:
        return "dead"
    return "elsewhere" if _looks_elsewhere(scan) else None


def _looks_elsewhere(scan: Scan) -> bool:
    """Whether a front sensor looks back and every return of it comes from behind, or a rear one's from ahead: its yaw or its sector is
    wrong."""
    if scan.sector not in _LIES_AT_RAD or not scan.radar:
        return False
    turned = math.remainder(scan.mounting.yaw_rad - _LIES_AT_RAD[scan.sector], math.tau)
    return abs(turned) > 0.5 * math.pi and all(
        abs(point.azimuth_rad) <= math.pi and abs(math.remainder(turned + point.azimuth_rad, math.tau)) > ELSEWHERE_RAD
        for point in scan.radar
    )


def radar_fault(point: RadarDetection) -> str | None:
    """Why a radar point is refused, or None."""
    sds = (point.range_sd_m, point.azimuth_sd_rad, point.range_rate_sd_mps)
    if not all(map(math.isfinite, (point.range_m, point.azimuth_rad, point.range_rate_mps, *sds))):
        return "not_finite"
    if point.range_m < 0.0:
        return "negative_range"
    fast = abs(point.range_rate_mps) > SPEED_MAX_MPS
    if point.range_m > RANGE_MAX_M or fast or abs(point.azimuth_rad) > math.pi or not SD_MIN <= min(sds) <= max(sds) <= SD_MAX:
        return "implausible"
    return None


def body_fault(body: BodyDetection) -> str | None:
    """Why an ideal detection is refused, or None."""
    values = (body.s_m, body.d_m, body.speed_s_mps, body.speed_d_mps, body.length_m, body.width_m, body.heading_rad or 0.0)
    if not all(map(math.isfinite, values)):
        return "not_finite"
    fast = math.hypot(body.speed_s_mps, body.speed_d_mps) > SPEED_MAX_MPS
    none = min(body.length_m, body.width_m) <= 0.0 or max(body.length_m, body.width_m) > LONGEST_M
    return "implausible" if fast or none or max(abs(body.s_m), abs(body.d_m)) > FARTHEST_M else None
