"""Who drives in the closed loop."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from typing import Protocol, runtime_checkable

from mcdas_opt.domain.destination import Destination
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import Scan
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vocabulary import Request
from mcdas_opt.errors import ParameterError

_STEP = "must take (measurements, host, now, *, road, desired_speed_mps, request)"


class ScanReceiver(Protocol):
    """Takes in scans that arrive between two plans, as `tracking.tracker.Tracker`."""

    def update(self, scans: Sequence[Scan], host: HostState, road: Road, now: float) -> None: ...


@runtime_checkable
class Driver(Protocol):
    """Plans in the closed loop, as `planning.planner.Planner`. A class that derives from this one has to define `step` alone."""

    @property
    def name(self) -> str:
        """What the drive's record calls it."""
        return type(self).__name__

    @property
    def tracker(self) -> ScanReceiver | None:
        """Gets the scans that arrive between two plans. Without one, they all come with the next `step`."""
        return None

    @property
    def situation(self) -> Situation | None:
        """What the last plan was made for, where it is known; its tracks are drawn."""
        return None

    @property
    def takes_zero_sideslip_point(self) -> bool:
        """Whether it plans about the point that `set_zero_sideslip_point` tells. If not, it plans about the rear axle."""
        return False

    def set_zero_sideslip_point(self, point_m: float) -> None:
        """Called before every plan: where ahead of its rear axle the car moves along its own axis (`Vehicle.zero_sideslip_point_m`)."""

    def set_destination(self, destination: Destination | None) -> None:
        """Called before the drive, after `reset`: where to go, if anywhere. Who cannot be told drives on along the road."""

    def reset(self) -> None:
        """Called before the drive: forgets what came before."""

    def step(
        self,
        measurements: Sequence[Scan],
        host: HostState,
        now: float,
        *,
        road: Road | None = None,
        desired_speed_mps: float | None = None,
        request: Request = Request.DRIVE,
    ) -> Plan:
        """One plan at `now` [s] from the scans that have arrived and the measured state."""
        ...


def check_step(driver: Driver) -> None:
    """That its `step` can be asked as `Driver.step` is. Raises `ParameterError` that names the class."""
    told = inspect.signature(driver.step)
    try:
        told.bind((), None, 0.0, road=None, desired_speed_mps=None, request=Request.DRIVE)
    except TypeError:
        raise ParameterError(f"{type(driver).__name__}.step", str(told), _STEP) from None
