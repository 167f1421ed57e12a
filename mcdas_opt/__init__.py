"""Planner for the car in the middle: front and rear vehicles as constraints, every plan judged before it leaves.

    import mcdas_opt as mo

`dir(mo)` is the table of contents. Everything that a user needs is here, and loads when it is first used; so is every module whose name
does not start with an underscore, for those who go deeper.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mcdas_opt.catalogue.scenes import Scene, load_scene
    from mcdas_opt.catalogue.sensors import load_sensor
    from mcdas_opt.catalogue.trajectories import load_trajectory
    from mcdas_opt.catalogue.vehicles import load_vehicle
    from mcdas_opt.domain.escapes import Escapes
    from mcdas_opt.domain.host import HostState
    from mcdas_opt.domain.measurement import Mounting, RadarDetection, Scan
    from mcdas_opt.domain.plan import Plan, Refusal
    from mcdas_opt.domain.road import Road
    from mcdas_opt.domain.settings import Settings
    from mcdas_opt.domain.situation import Situation
    from mcdas_opt.domain.track import Coverage, Track
    from mcdas_opt.domain.trajectory import Trajectory
    from mcdas_opt.domain.vehicle import Vehicle
    from mcdas_opt.domain.verdict import Verdict, Violation
    from mcdas_opt.domain.vocabulary import Alert, Mode, Request, Role, Sector, Side, Status
    from mcdas_opt.errors import InputError, McdasError, ParameterError
    from mcdas_opt.evaluation.comparison import benchmark
    from mcdas_opt.interop.replay import replay
    from mcdas_opt.parking.case_file import load_parking_case
    from mcdas_opt.parking.closed_loop.follow import follow
    from mcdas_opt.parking.park import park
    from mcdas_opt.planning.planner import Planner
    from mcdas_opt.planning.stateless import plan, step
    from mcdas_opt.plotting.export import plot
    from mcdas_opt.simulation.first_situation import load_situation
    from mcdas_opt.simulation.judging import verify
    from mcdas_opt.simulation.loop import simulate
    from mcdas_opt.time_to_react.escapes import escapes
    from mcdas_opt.tuning.tune import tune

__version__ = "0.1.0"

_HOME = {
    # what a planner is told
    "HostState": "mcdas_opt.domain.host",
    "Track": "mcdas_opt.domain.track",
    "Coverage": "mcdas_opt.domain.track",
    "Road": "mcdas_opt.domain.road",
    "Situation": "mcdas_opt.domain.situation",
    "Vehicle": "mcdas_opt.domain.vehicle",
    "Settings": "mcdas_opt.domain.settings",
    "Scan": "mcdas_opt.domain.measurement",
    "RadarDetection": "mcdas_opt.domain.measurement",
    "Mounting": "mcdas_opt.domain.measurement",
    # what it answers
    "Plan": "mcdas_opt.domain.plan",
    "Refusal": "mcdas_opt.domain.plan",
    "Trajectory": "mcdas_opt.domain.trajectory",
    "Verdict": "mcdas_opt.domain.verdict",
    "Violation": "mcdas_opt.domain.verdict",
    "Escapes": "mcdas_opt.domain.escapes",
    "Mode": "mcdas_opt.domain.vocabulary",
    "Side": "mcdas_opt.domain.vocabulary",
    "Role": "mcdas_opt.domain.vocabulary",
    "Sector": "mcdas_opt.domain.vocabulary",
    "Status": "mcdas_opt.domain.vocabulary",
    "Request": "mcdas_opt.domain.vocabulary",
    "Alert": "mcdas_opt.domain.vocabulary",
    # files
    "Scene": "mcdas_opt.catalogue.scenes",
    "load_scene": "mcdas_opt.catalogue.scenes",
    "load_situation": "mcdas_opt.simulation.first_situation",
    "load_vehicle": "mcdas_opt.catalogue.vehicles",
    "load_sensor": "mcdas_opt.catalogue.sensors",
    "load_trajectory": "mcdas_opt.catalogue.trajectories",
    "load_parking_case": "mcdas_opt.parking.case_file",
    # what can be done
    "Planner": "mcdas_opt.planning.planner",
    "plan": "mcdas_opt.planning.stateless",
    "step": "mcdas_opt.planning.stateless",
    "simulate": "mcdas_opt.simulation.loop",
    "escapes": "mcdas_opt.time_to_react.escapes",
    "replay": "mcdas_opt.interop.replay",
    "verify": "mcdas_opt.simulation.judging",
    "park": "mcdas_opt.parking.park",
    "follow": "mcdas_opt.parking.closed_loop.follow",
    "tune": "mcdas_opt.tuning.tune",
    "plot": "mcdas_opt.plotting.export",
    "benchmark": "mcdas_opt.evaluation.comparison",
    # errors
    "McdasError": "mcdas_opt.errors",
    "InputError": "mcdas_opt.errors",
    "ParameterError": "mcdas_opt.errors",
}

__all__ = [
    "Alert",
    "Coverage",
    "Escapes",
    "HostState",
    "InputError",
    "McdasError",
    "Mode",
    "Mounting",
    "ParameterError",
    "Plan",
    "Planner",
    "RadarDetection",
    "Refusal",
    "Request",
    "Road",
    "Role",
    "Scan",
    "Scene",
    "Sector",
    "Settings",
    "Side",
    "Situation",
    "Status",
    "Track",
    "Trajectory",
    "Vehicle",
    "Verdict",
    "Violation",
    "__version__",
    "benchmark",
    "escapes",
    "follow",
    "load_parking_case",
    "load_scene",
    "load_sensor",
    "load_situation",
    "load_trajectory",
    "load_vehicle",
    "park",
    "plan",
    "plot",
    "replay",
    "simulate",
    "step",
    "tune",
    "verify",
]


if not TYPE_CHECKING:  # a type checker knows every name already, and that there are no others

    def __getattr__(name: str) -> object:
        """Public names load their module when first used, so that importing the package stays light (PEP 562)."""
        if name not in _HOME:
            raise AttributeError(f"module 'mcdas_opt' has no attribute {name!r}{_near(name)}")
        found = getattr(import_module(_HOME[name]), name)
        globals()[name] = found
        return found


def _near(name: str) -> str:
    """A wrong name is told the nearest one; the dunders that tools try are not."""
    if name.startswith("_"):
        return ""
    from mcdas_opt.errors import nearest

    return f"; {nearest(name, __all__)}"


def __dir__() -> list[str]:
    return sorted(__all__)
