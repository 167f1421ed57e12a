"""From scans to tracks: screen, predict, gate, associate, update, live on or die."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from mcdas_opt.catalogue.motion import load_motion
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import BodyDetection, RadarDetection, Scan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import finite, positive
from mcdas_opt.domain.situation import MOST_TRACKS
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import ParameterError
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.geometry.window import frame_near
from mcdas_opt.tracking import notices
from mcdas_opt.tracking.association import assign
from mcdas_opt.tracking.blind_range import unseen_near
from mcdas_opt.tracking.coverage import SectorWatch
from mcdas_opt.tracking.filtering import TargetFix, build_filtering
from mcdas_opt.tracking.fix import Viewpoint
from mcdas_opt.tracking.heard import Heard
from mcdas_opt.tracking.intake import Intake
from mcdas_opt.tracking.placed import PlacedBodies, Size, overlap
from mcdas_opt.tracking.screening import (
    AGE_MAX_S,
    FAR_AHEAD_S,
    MOST_DETECTIONS,
    Source,
    clock_fault,
    scan_fault,
    source_of,
)
from mcdas_opt.tracking.track_life import ALIKE_MPS, MOST_SOURCES, TrackLife
from mcdas_opt.tracking.unfollowed import SCANS

REFLECTIONS = ("face", "centre")
BODY_GATE_M = 5.0  # a body of known name may be off its track by this much
BODY_POSITION_SD_M = BODY_SPEED_SD_MPS = 1e-3  # of an ideal sensor


@dataclass(frozen=True, slots=True)
class _Look:
    """One sound scan while it is taken in: from where, when, and which tracks it has hit so far."""

    scan: Scan
    host: HostState
    frame: FrenetFrame
    now: float
    hit: set[TrackLife] = field(default_factory=set)


class Tracker:
    """Any number of neighbours, from any number of radars and ideal sensors.

    `body` is the (length, width) assumed of a car that only a radar has seen; `vehicle` is the host (its sensors turn with it). `motion` is
    a file in models/motion, or a path. `reflection` is where on a body radar points lie: on the near "face", or at its "centre" (point
    targets, antenna to antenna).
    What nobody can be tracked by is counted (`counters`) and said, by a `MeasurementWarning`, each kind once until `reset` (`notices`).
    """

    def __init__(self, body: Size = (4.5, 1.8), vehicle: Vehicle | None = None, *, motion: str = "car", reflection: str = "face") -> None:
        if reflection not in REFLECTIONS:
            raise ParameterError("reflection", reflection, "must be one of " + ", ".join(REFLECTIONS))
        self._at_face = reflection == "face"
        self._body = (positive("body length", body[0], "m"), positive("body width", body[1], "m"))
        self.vehicle = Vehicle() if vehicle is None else vehicle
        self._motion = load_motion(motion)
        self._filtering = build_filtering()
        self.reset()

    @property
    def counters(self) -> dict[str, int]:
        """What became of scans and detections (`screening.COUNTERS`)."""
        return self._intake.counters

    def reset(self) -> None:
        """Forget everything, the counters and the numbering too."""
        self._intake = Intake()
        self._numbered = 0
        self._notices = notices.Notices()
        self._jumped = False  # whether the clock jumped ahead in the last update
        self._now_s: float | None = None
        self._forget(is_anew=False)

    def _forget(self, *, is_anew: bool) -> None:
        """No tracks, and no sensor that was heard of; `is_anew` where those that there were are forgotten."""
        self._lives: list[TrackLife] = []
        self._heard: dict[Source, Heard] = {}
        self._clock_s: float | None = None
        self._watch = SectorWatch(is_anew)

    def distrust(self, counter: str, why: str, *, is_anew: bool) -> None:
        """Tracks are not to be relied on in this cycle: that is said, once. `is_anew`: they are forgotten."""
        self.counters[counter] += 1
        self._notices.say(counter, why)
        if is_anew:
            self._forget(is_anew=True)

    def in_order(self, scans: Sequence[Scan], now: float) -> list[Scan]:
        """Those that `update` would take in, in the order of their times."""
        return self._intake.in_order(scans, now)

    def update(self, scans: Sequence[Scan], host: HostState, road: Road, now: float) -> None:
        """Take in what has arrived at `now`; `host` is its pose at the scans' time. Scans are handled in the order of their times.

        Where the clock has been set back, or has jumped ahead, the tracks are of another time: they are forgotten, and no sector is covered
        until its sensor has answered so often that a track can be confirmed again. Where it jumps ahead in one update after another,
        nobody is ever known: that is said, once.
        """
        now = finite("now", now, "s")
        jump = clock_fault(now, self._now_s)
        if jump is not None:
            self.counters[jump] += 1
            self._forget(is_anew=True)
        if jump == "clock_ahead" and self._jumped and self._now_s is not None:
            self._notices.say(jump, notices.long_cycles(now - self._now_s))
        if now != self._now_s:  # one cycle's scans may come in several updates
            self._jumped, self._now_s = jump == "clock_ahead", now
        frame = frame_near(road, host.s_m)
        for scan in self.in_order(scans, now):
            heard = self._heard.get(source_of(scan))
            last = None if heard is None else heard.last
            fault = scan_fault(scan, now, None if last is None else last.t_s, self._clock_s)
            if fault is None:
                self._take(_Look(scan, host, frame, now))
            else:
                self.counters[fault] += 1
                self._refuse(scan, fault, last, now)
        self._bury(now)
        self._number(now)

    def tracks(self, now: float) -> tuple[Track, ...]:
        """Confirmed tracks, predicted to `now` from the time of their last detection; oldest first. None of them where the clock is set
        back to before the last update."""
        if clock_fault(now, self._now_s) == "clock_back":
            return ()
        return tuple(life.track(now) for life in self._lives if life.confirmed and not life.is_over(now))

    def coverage(self, now: float) -> Coverage:
        """Which sectors a working sensor has watched of late; none where the clock is set back to before the last update."""
        if clock_fault(now, self._now_s) == "clock_back":
            return Coverage(front=False, rear=False, left=False, right=False)
        return self._watch.coverage(now)

    def _refuse(self, scan: Scan, fault: str, last: Scan | None, now: float) -> None:
        """Nothing of it is taken in: whether its sector is still covered by what came before, and whether the user is told."""
        if fault == "dead":
            self._watch.lost(scan)
        elif fault == "duplicate":
            if last is not None and (scan.radar, scan.bodies) != (last.radar, last.bodies):
                self._watch.lost(scan)
                self._notices.say(fault, notices.two_scans_at_once(scan))
        elif fault == "elsewhere":
            self._watch.lost(scan)
            self._notices.say(fault, notices.elsewhere(scan))
        elif fault == "future" and scan.t_s > now + FAR_AHEAD_S:
            self._notices.say(fault, notices.another_clock(scan, now))
        elif (refused := self._intake.refused(scan)) >= SCANS:
            self._notices.say(fault, notices.refused(scan, fault, refused, now))

    def _take(self, look: _Look) -> None:
        scan = look.scan
        self.counters["scans"] += 1
        if len(self._heard) > MOST_SOURCES:
            self._heard = {source: heard for source, heard in self._heard.items() if scan.t_s - heard.last.t_s <= AGE_MAX_S}
        heard = self._heard.setdefault(source_of(scan), Heard(scan))
        heard.last = scan
        self._clock_s = scan.t_s if self._clock_s is None else max(self._clock_s, scan.t_s)
        points, bodies, fault = self._intake.take(scan, look.host)
        if fault is None:
            self._intake.accepted(scan)
        else:
            self._refuse(scan, fault, None, look.now)
        is_sound = fault is None
        if len(scan.radar) > len(points) == MOST_DETECTIONS:
            is_sound = False
            self._notices.say("too_many", notices.too_many_detections(scan, len(scan.radar)))
        self._take_bodies(bodies, look)
        followers = self._take_points(points, look)
        for life in self._lives:
            if life not in look.hit and not (scan.blind is not None and self._hides(life, look)):
                life.miss(scan)
        self._tell_apart(look)
        self._merge(scan.t_s, look.now)
        for counter, why in heard.doubts(followers, self._lives, look.hit, look.frame.road, look.now).items():
            is_sound = False
            self.counters[counter] += 1
            self._notices.say(counter, why)
        if is_sound:
            self._watch.heard(scan, look.now)
        else:
            self._watch.lost(scan)  # the sensor covers nothing
        self._keep(
            self._intake.most(self._lives, MOST_TRACKS, lambda life: (not life.confirmed, abs(life.place(scan.t_s)[0] - look.host.s_m)))
        )

    def _take_bodies(self, bodies: list[BodyDetection], look: _Look) -> None:
        """Ideal detections: by name, else by overlap with a track that no name is known of, else a new track."""
        if not bodies:
            return
        time_s = look.scan.t_s
        named = {life.name: life for life in self._lives if life.name is not None}
        strangers: list[tuple[BodyDetection, TargetFix, float]] = []
        headings: list[float] = look.frame.road_heading(np.array([body.s_m for body in bodies])).tolist()
        for body, road_heading in zip(bodies, headings, strict=True):
            fix: TargetFix = self._filtering.body_fix(body, look.frame, BODY_POSITION_SD_M, BODY_SPEED_SD_MPS)
            if body.name not in named:
                strangers.append((body, fix, road_heading))
                continue
            life = named[body.name]
            s, d = life.place(time_s)
            if math.hypot(body.s_m - s, body.d_m - d) > BODY_GATE_M:
                self.counters["gated"] += 1
                continue
            self._hit(life, fix, look)
            life.know(body, road_heading, time_s)
        if not strangers:
            return
        nameless = [life for life in self._lives if life.name is None]
        costs = np.full((len(nameless), len(strangers)), np.inf)
        for i, life in enumerate(nameless):
            s, d = life.place(time_s)
            for j, (body, _, _) in enumerate(strangers):
                if overlap((s, d), life.size, (body.s_m, body.d_m), (body.length_m, body.width_m), 1.0):
                    costs[i, j] = (body.s_m - s) ** 2 + (body.d_m - d) ** 2
        owners = {j: nameless[i] for i, j in assign(costs)}
        for j, (body, fix, road_heading) in enumerate(strangers):
            if j in owners:
                life = owners[j]
                self._hit(life, fix, look)
            else:
                life = self._begin(fix, look)
            life.know(body, road_heading, time_s)

    def _take_points(self, points: list[RadarDetection], look: _Look) -> dict[RadarDetection, TrackLife]:
        """Radar points: confirmed tracks choose first, then tentative ones; what is left begins new tracks. Whose each is."""
        followers: dict[RadarDetection, TrackLife] = {}
        if not points:
            return followers
        time_s = look.scan.t_s
        view = Viewpoint.of(look.scan.mounting, look.host, self.vehicle, look.frame)
        rated = self._heard[source_of(look.scan)].rates.as_believed(points, time_s)
        reads: dict[Size | None, Sequence[TargetFix | None]] = {}

        def read(size: Size) -> Sequence[TargetFix | None]:
            key = size if self._at_face else None
            if key not in reads:
                reads[key] = self._filtering.radar_fixes(rated, view, look.frame, key)
            return reads[key]

        left = [j for j, fix in enumerate(read(self._body)) if fix is not None]
        self.counters["implausible"] += len(points) - len(left)
        fitted: set[int] = set()
        rates: dict[TrackLife, float] = {}  # range rate of the point that each life was hit by
        for confirmed in (True, False):
            lives = [life for life in self._lives if life.confirmed is confirmed and life not in look.hit]
            rows = [[fixes[j] for j in left] for fixes in (read(life.size) for life in lives)]
            costs = [life.costs(time_s, row) for life, row in zip(lives, rows, strict=True)]
            fitted.update(left[j] for row in costs for j, cost in enumerate(row) if cost < math.inf)
            pairs = assign(np.array(costs)) if costs and left else []
            for i, j in pairs:
                fix = rows[i][j]
                assert fix is not None
                self._hit(lives[i], fix, look)
                followers[points[left[j]]] = lives[i]
                rates[lives[i]] = points[left[j]].range_rate_mps
            taken = {left[j] for _, j in pairs}
            left = [j for j in left if j not in taken]
        self.counters["gated"] += sum(j not in fitted for j in left) if self._lives else 0
        grown: set[TrackLife] = set()
        seen = PlacedBodies[TrackLife](1.0)
        for life in look.hit:
            seen.add(life, life.place(time_s), life.size)
        for j in sorted(left, key=lambda j: points[j].range_m):
            fix = read(self._body)[j]
            assert fix is not None
            # a second point of a car that has just been seen is no other car
            if next(seen.meeting(fix.place, self._body), None) is not None:
                continue
            owner = self._whose(fix.place, points[j].range_rate_mps, rates, look)
            if owner is not None:
                owner.show(fix.place, look.host.s_m, time_s, again=owner in grown)
                grown.add(owner)
            else:
                followers[points[j]] = life = self._begin(fix, look)
                rates[life] = points[j].range_rate_mps
                seen.add(life, life.place(time_s), life.size)
        return followers

    def _whose(self, place: tuple[float, float], rate_mps: float, rates: dict[TrackLife, float], look: _Look) -> TrackLife | None:
        """The body of this scan that a point is a farther reflection of: along it, and as fast."""
        for life, its_mps in rates.items():
            if abs(rate_mps - its_mps) < ALIKE_MPS and life.goes_on(place, look.host.s_m, look.scan.t_s):
                return life
        return None

    def _hides(self, life: TrackLife, look: _Look) -> bool:
        """Whether this target is too near for the scan to see it. If so, its track takes that in."""
        scan = look.scan
        if not life.may_hide_from(scan, look.now):
            return False
        view = Viewpoint.of(scan.mounting, look.host, self.vehicle, look.frame)
        size = life.size if self._at_face else None
        unseen = unseen_near(life.place(scan.t_s), life.spread(scan.t_s), size, scan, view, look.frame)
        (fix,) = self._filtering.radar_fixes([unseen], view, look.frame, size) if unseen is not None else (None,)
        if fix is None:
            return False
        life.hide(fix, scan, look.now)
        return True

    def _hit(self, life: TrackLife, fix: TargetFix, look: _Look) -> None:
        life.hit(fix, look.scan, look.now)
        look.hit.add(life)
        self.counters["associated"] += 1

    def _begin(self, fix: TargetFix, look: _Look) -> TrackLife:
        life = TrackLife.begin(fix, look.scan, look.host, look.now, self._body, self._motion, self._filtering)
        self._lives.append(life)
        look.hit.add(life)
        self.counters["initiated"] += 1
        return life

    def _tell_apart(self, look: _Look) -> None:
        """Confirmed tracks that one scan shows a body's size apart are two cars from then on."""
        seen = [life for life in self._lives if life.confirmed and life in look.hit]
        for i, life in enumerate(seen):
            for other in seen[:i]:
                if other in life.others:
                    continue
                if not overlap(life.place(look.scan.t_s), life.size, other.place(look.scan.t_s), other.size, 1.0):
                    life.others.add(other)
                    other.others.add(life)

    def _merge(self, time_s: float, now: float) -> None:
        """Of two tracks in one place one stays: the named one, else the latest heard, else the sharper one.

        Both stay if one scan has ever shown them side by side: then they are two cars, and not one car tracked twice. A tentative one stays
        where a confirmed one goes on unseen: a longer body than was thought is seen elsewhere than expected, and is taken up anew.
        """
        if len(self._lives) < 2:
            return
        there = PlacedBodies[TrackLife](0.5)
        for life in self._lives:
            if next(there.meeting(life.place(time_s), life.size), None) is not None:
                break
            there.add(life, life.place(time_s), life.size)
        else:
            return
        ranked = sorted(self._lives, key=lambda life: (life.name is None, not life.confirmed, -life.heard_s, life.vagueness()))
        kept, staying = PlacedBodies[TrackLife](0.5), set[TrackLife]()
        for life in ranked:
            place = life.place(time_s)
            if not any(
                (life.name is None or other.name is None) and other not in life.others and (life.confirmed or not other.goes_on_unseen(now))
                for other in kept.meeting(place, life.size)
            ):
                kept.add(life, place, life.size)
                staying.add(life)
        if len(staying) < len(self._lives):
            self._keep([life for life in self._lives if life in staying])

    def _bury(self, now: float) -> None:
        self._keep([life for life in self._lives if not life.is_over(now)])

    def _keep(self, staying: list[TrackLife]) -> None:
        """These alone; nobody knows of the others any more."""
        if len(staying) < len(self._lives):
            gone = set(self._lives).difference(staying)
            for life in staying:
                life.others -= gone
        self._lives = staying

    def _number(self, now: float) -> None:
        """Names for the tracks begun in this update, from behind to ahead, so that a mirrored world has the same names."""
        old = [life for life in self._lives if life.number]
        new = [life for life in self._lives if not life.number]

        def order(life: TrackLife) -> tuple[float, float]:
            s, d = life.place(now)
            return round(s, 6), round(abs(d), 6)

        for life in sorted(new, key=order):
            self._numbered += 1
            life.number = self._numbered
            old.append(life)
        self._lives = old
