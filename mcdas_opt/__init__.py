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
    from mcdas_opt.catalogue.trajectories import TrajectoryFile, load_trajectory
    from mcdas_opt.catalogue.vehicles import load_vehicle
    from mcdas_opt.domain.actuator_response import ActuatorResponse
    from mcdas_opt.domain.comfort import ComfortSettings
    from mcdas_opt.domain.destination import Destination
    from mcdas_opt.domain.doubt import Doubt, DoubtKind
    from mcdas_opt.domain.escapes import Closer, Escape, Escapes
    from mcdas_opt.domain.grid import TimeGrid
    from mcdas_opt.domain.host import HostState
    from mcdas_opt.domain.lane import Lane
    from mcdas_opt.domain.manners import MannersSettings
    from mcdas_opt.domain.measurement import BodyDetection, Mounting, RadarDetection, Scan
    from mcdas_opt.domain.parking import Parking, ParkingCase, ParkingTrajectory
    from mcdas_opt.domain.plan import Candidate, Plan, Refusal, Timing
    from mcdas_opt.domain.result import Result
    from mcdas_opt.domain.road import Road
    from mcdas_opt.domain.safe_end import EndKind, SafeEnd, SafeEndSettings
    from mcdas_opt.domain.sensor import Beam, Sensor
    from mcdas_opt.domain.settings import HeadwaySettings, PredictionSettings, SelectorSettings, Settings, SigmoidSettings, WarningSettings
    from mcdas_opt.domain.sigmoid_design import SigmoidDesign
    from mcdas_opt.domain.situation import Situation
    from mcdas_opt.domain.track import Coverage, Track
    from mcdas_opt.domain.trajectory import Command, Trajectory
    from mcdas_opt.domain.vehicle import DrivenAxle, Vehicle
    from mcdas_opt.domain.verdict import Verdict, Violation, ViolationKind
    from mcdas_opt.domain.vocabulary import Alert, BodyKind, Mode, Request, Role, Sector, Side, Status
    from mcdas_opt.errors import InputError, McdasError, MissingExtraError, ParameterError
    from mcdas_opt.evaluation.comparison import Comparison, benchmark
    from mcdas_opt.interop.replay import replay
    from mcdas_opt.interop.replay_record import Replay
    from mcdas_opt.interop.target_list import Columns
    from mcdas_opt.parking.case_file import load_parking_case
    from mcdas_opt.parking.closed_loop.follow import follow
    from mcdas_opt.parking.closed_loop.record import ParkingDrive
    from mcdas_opt.parking.closed_loop.settings import FollowSettings
    from mcdas_opt.parking.closed_loop.sight import Visitor
    from mcdas_opt.parking.park import park
    from mcdas_opt.parking.settings import ParkSettings
    from mcdas_opt.planning.method import Method
    from mcdas_opt.planning.planner import Planner
    from mcdas_opt.planning.stateless import plan, step
    from mcdas_opt.plotting.export import plot
    from mcdas_opt.simulation.controller import Controller
    from mcdas_opt.simulation.driver import Driver
    from mcdas_opt.simulation.first_situation import load_situation
    from mcdas_opt.simulation.judging import verify
    from mcdas_opt.simulation.loop import simulate
    from mcdas_opt.simulation.motion_sensors import MotionSensors
    from mcdas_opt.simulation.plant import Plant
    from mcdas_opt.simulation.record import Outcome, Simulation
    from mcdas_opt.simulation.sensor_faults import SensorFaults
    from mcdas_opt.time_to_react.escapes import escapes
    from mcdas_opt.time_to_react.library import EscapeSettings
    from mcdas_opt.tuning.design import Design
    from mcdas_opt.tuning.study_options import StudyOptions
    from mcdas_opt.tuning.tune import tune
    from mcdas_opt.tuning.tune_in_traffic import StudyReport

__version__ = "0.1.0"

_HOME = {
    name: f"mcdas_opt.{module}"
    for module, names in {
        "catalogue.scenes": "Scene load_scene",
        "catalogue.sensors": "load_sensor",
        "catalogue.trajectories": "load_trajectory TrajectoryFile",
        "catalogue.vehicles": "load_vehicle",
        "domain.actuator_response": "ActuatorResponse",
        "domain.comfort": "ComfortSettings",
        "domain.destination": "Destination",
        "domain.doubt": "Doubt DoubtKind",
        "domain.escapes": "Escapes Escape Closer",
        "domain.grid": "TimeGrid",
        "domain.host": "HostState",
        "domain.lane": "Lane",
        "domain.manners": "MannersSettings",
        "domain.measurement": "Scan RadarDetection Mounting BodyDetection",
        "domain.parking": "ParkingCase Parking ParkingTrajectory",
        "domain.plan": "Plan Refusal Candidate Timing",
        "domain.result": "Result",
        "domain.road": "Road",
        "domain.safe_end": "SafeEndSettings SafeEnd EndKind",
        "domain.sensor": "Beam Sensor",
        "domain.settings": "Settings SelectorSettings PredictionSettings SigmoidSettings HeadwaySettings WarningSettings",
        "domain.sigmoid_design": "SigmoidDesign",
        "domain.situation": "Situation",
        "domain.track": "Track Coverage",
        "domain.trajectory": "Trajectory Command",
        "domain.vehicle": "Vehicle DrivenAxle",
        "domain.verdict": "Verdict Violation ViolationKind",
        "domain.vocabulary": "BodyKind Mode Side Role Sector Status Request Alert",
        "errors": "McdasError InputError ParameterError MissingExtraError",
        "evaluation.comparison": "benchmark Comparison",
        "interop.replay": "replay",
        "interop.replay_record": "Replay",
        "interop.target_list": "Columns",
        "parking.case_file": "load_parking_case",
        "parking.closed_loop.follow": "follow",
        "parking.closed_loop.record": "ParkingDrive",
        "parking.closed_loop.settings": "FollowSettings",
        "parking.closed_loop.sight": "Visitor",
        "parking.park": "park",
        "parking.settings": "ParkSettings",
        "planning.method": "Method",
        "planning.planner": "Planner",
        "planning.stateless": "plan step",
        "plotting.export": "plot",
        "simulation.controller": "Controller",
        "simulation.driver": "Driver",
        "simulation.first_situation": "load_situation",
        "simulation.judging": "verify",
        "simulation.loop": "simulate",
        "simulation.motion_sensors": "MotionSensors",
        "simulation.plant": "Plant",
        "simulation.record": "Simulation Outcome",
        "simulation.sensor_faults": "SensorFaults",
        "time_to_react.escapes": "escapes",
        "time_to_react.library": "EscapeSettings",
        "tuning.design": "Design",
        "tuning.study_options": "StudyOptions",
        "tuning.tune": "tune",
        "tuning.tune_in_traffic": "StudyReport",
    }.items()
    for name in names.split()
}

__all__ = [
    "ActuatorResponse",
    "Alert",
    "Beam",
    "BodyDetection",
    "BodyKind",
    "Candidate",
    "Closer",
    "Columns",
    "ComfortSettings",
    "Command",
    "Comparison",
    "Controller",
    "Coverage",
    "Design",
    "Destination",
    "Doubt",
    "DoubtKind",
    "DrivenAxle",
    "Driver",
    "EndKind",
    "Escape",
    "EscapeSettings",
    "Escapes",
    "FollowSettings",
    "HeadwaySettings",
    "HostState",
    "InputError",
    "Lane",
    "MannersSettings",
    "McdasError",
    "Method",
    "MissingExtraError",
    "Mode",
    "MotionSensors",
    "Mounting",
    "Outcome",
    "ParameterError",
    "ParkSettings",
    "Parking",
    "ParkingCase",
    "ParkingDrive",
    "ParkingTrajectory",
    "Plan",
    "Planner",
    "Plant",
    "PredictionSettings",
    "RadarDetection",
    "Refusal",
    "Replay",
    "Request",
    "Result",
    "Road",
    "Role",
    "SafeEnd",
    "SafeEndSettings",
    "Scan",
    "Scene",
    "Sector",
    "SelectorSettings",
    "Sensor",
    "SensorFaults",
    "Settings",
    "Side",
    "SigmoidDesign",
    "SigmoidSettings",
    "Simulation",
    "Situation",
    "Status",
    "StudyOptions",
    "StudyReport",
    "TimeGrid",
    "Timing",
    "Track",
    "Trajectory",
    "TrajectoryFile",
    "Vehicle",
    "Verdict",
    "Violation",
    "ViolationKind",
    "Visitor",
    "WarningSettings",
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
