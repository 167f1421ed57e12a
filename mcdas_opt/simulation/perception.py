"""From the true world to the planner's tracker: sensors, their latency, and the pose that the host had when they looked."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.domain.body import Body
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import Scan
from mcdas_opt.simulation.driver import ScanReceiver
from mcdas_opt.simulation.idm import STEP_S, step_times
from mcdas_opt.simulation.neighbours import Traffic, host_before
from mcdas_opt.simulation.sensor_faults import SensorFaults
from mcdas_opt.simulation.sensors import SensorSuite

_ROUNDING_S = 1e-9


class Perception:
    """Looks at the world and hands scans on `latency_s` later, with the time stamps of the measurement.

    Scans of the very instant of a plan go into the planner's step. Its tracker takes in older ones when they arrive, each with the
    host's pose at its own time (a car knows where it was, and from its gyro how fast it turned). Without a tracker all scans go into
    the planner's step.
    """

    def __init__(self, scene: Scene, seed: int, tracker: ScanReceiver | None, faults: SensorFaults | None = None) -> None:
        beside = Path(scene.file).parent
        self._suite = SensorSuite(scene.sensors, scene.vehicle, scene.true_road, seed, beside, faults)
        self._road, self._wheelbase_m = scene.assumed_road, scene.vehicle.wheelbase_m
        self._faults = faults
        self._latency_s = scene.sensors.latency_s
        self._tracker = tracker
        self._pending: deque[tuple[Scan, HostState]] = deque()
        self._planned_s = -math.inf  # the latest time from which on a step plans; the tracker's clock does not run back behind it

    def warm_up(self, scene: Scene, traffic: Traffic, start: HostState) -> None:
        """What the sensors have seen by t = 0, when everybody had come at constant speed for `warmup_s`, the host to `start`."""
        steps = round(scene.sensors.warmup_s / STEP_S)
        times = step_times(-steps, steps + 1)
        host = host_before(scene, times)
        for t, s in zip(times.tolist(), host.s_m.tolist(), strict=True):
            if not self.is_due(t):
                continue
            then = replace(start, s_m=s, acceleration_mps2=0.0)
            self.look(t, then, then, traffic.bodies(t))

    def is_due(self, t_s: float) -> bool:
        """Whether any sensor scans at t_s."""
        return self._suite.is_due(t_s)

    def look(self, t_s: float, host: HostState, known: HostState, bodies: Sequence[Body]) -> None:
        """Takes the scans that are due at t_s; they arrive `latency_s` later, with what the host knows of its own state (`known`)."""
        self._pending.extend((scan, known) for scan in self._suite.scans(t_s, host, bodies))

    def arrived(self, now: float, before_s: float = 0.0) -> list[Scan]:
        """Scans for a planner's step that plans from `before_s` after `now` on; older ones have gone to its tracker."""
        fresh: list[Scan] = []
        while self._pending and self._pending[0][0].t_s + self._latency_s <= now + _ROUNDING_S:
            scan, host = self._pending.popleft()
            if self._tracker is None or scan.t_s > now + before_s - _ROUNDING_S:
                fresh.append(scan)
            else:
                self._tracker.update([scan], self._measured(host), self._road, max(scan.t_s + self._latency_s, self._planned_s))
        self._planned_s = now + before_s
        return fresh

    def _measured(self, host: HostState) -> HostState:
        """The host's pose then, with the steering of the no-slip bicycle that turned as fast."""
        measured = replace(host.without_slip(self._wheelbase_m), heading_rad=host.heading_rad)
        return measured if self._faults is None else self._faults.told(measured, self._wheelbase_m)
