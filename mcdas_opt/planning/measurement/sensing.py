"""From what is measured to a situation: the host's state that is believed, the tracker, and where the car was when each scan was taken."""

from __future__ import annotations

import math
from collections.abc import Sequence

from mcdas_opt.domain.destination import Destination
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import Scan
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Request
from mcdas_opt.planning.measurement.host_plausibility import HostPlausibility
from mcdas_opt.planning.measurement.odometry_check import OdometryCheck
from mcdas_opt.planning.measurement.pose_history import PoseHistory
from mcdas_opt.tracking.tracker import Tracker

_NOWHERE = Coverage(front=False, rear=False, left=False, right=False)


class Sensing:
    """Remembers tracks, poses and the host's last state between cycles. `road` is what the car drives on unless a cycle is told another,
    `destination` where it is to go; None: along the road."""

    def __init__(self, vehicle: Vehicle, road: Road) -> None:
        self.road = road
        self.destination: Destination | None = None
        self.tracker = Tracker(vehicle=vehicle)
        self._poses = PoseHistory()
        self._host_plausibility = HostPlausibility()
        self._odometry = OdometryCheck()

    def reset(self) -> None:
        """Forgets them."""
        self.tracker.reset()
        self._poses = PoseHistory()
        self._host_plausibility = HostPlausibility()
        self._odometry = OdometryCheck()

    def faulty_s(self, now: float) -> float:
        """For how long [s] no state of the host has been one that can be; 0 at the first such."""
        return self._host_plausibility.faulty_s(now)

    def believed(self, host: HostState, now: float, road: Road | None, previous: Plan | None) -> tuple[HostState, str]:
        """The host's state as measured and "", or what is believed instead and why (`HostPlausibility.plausible_state`)."""
        return self._host_plausibility.plausible_state(host, now, road or self.road, self.tracker.vehicle, previous)

    def situation(
        self,
        scans: Sequence[Scan],
        host: HostState,
        now: float,
        *,
        road: Road | None,
        desired_speed_mps: float | None,
        request: Request,
    ) -> Situation:
        """The situation at `now` [s], after these scans, each with its own time stamp, seen from where the car then was. Where the clock
        stands nobody can be tracked, and no sector is covered; neither where the host's place moves otherwise than its speed says."""
        on = road or self.road
        doubt = self._odometry.doubt(host, on, now)
        if doubt is not None:
            self.tracker.distrust(doubt.counter, doubt.why, is_anew=doubt.is_anew)
        if doubt is not None and doubt.is_anew:
            scans = ()
        self._poses.note(now, host)
        for scan in self.tracker.in_order(scans, now):
            seen_from = self._poses.at(scan.t_s) if math.isfinite(scan.t_s) else host
            self.tracker.update([scan], seen_from, on, now)
        if not scans:
            self.tracker.update([], host, on, now)
        return Situation(
            time_s=now,
            host=host,
            tracks=self.tracker.tracks(now),
            coverage=self.tracker.coverage(now) if doubt is None else _NOWHERE,
            road=on,
            vehicle=self.tracker.vehicle.name,
            desired_speed_mps=desired_speed_mps,
            request=request,
            destination=self.destination,
        )
