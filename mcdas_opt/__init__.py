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
    # what a planner is told
    "HostState": "mcdas_opt.domain.host",
    "Track": "mcdas_opt.domain.track",
    "Coverage": "mcdas_opt.domain.track",
    "Road": "mcdas_opt.domain.road",
    "Situation": "mcdas_opt.domain.situation",
    "Vehicle": "mcdas_opt.domain.vehicle",
    "Scan": "mcdas_opt.domain.measurement",
    "RadarDetection": "mcdas_opt.domain.measurement",
    "Mounting": "mcdas_opt.domain.measurement",
    "Lane": "mcdas_opt.domain.lane",
    "Destination": "mcdas_opt.domain.destination",
    "BodyKind": "mcdas_opt.domain.vocabulary",
    "BodyDetection": "mcdas_opt.domain.measurement",
    "Beam": "mcdas_opt.domain.sensor",
    "ActuatorResponse": "mcdas_opt.domain.actuator_response",
    "DrivenAxle": "mcdas_opt.domain.vehicle",
    "Method": "mcdas_opt.planning.method",
    # how it plans
    "Settings": "mcdas_opt.domain.settings",
    "TimeGrid": "mcdas_opt.domain.grid",
    "SelectorSettings": "mcdas_opt.domain.settings",
    "PredictionSettings": "mcdas_opt.domain.settings",
    "SigmoidSettings": "mcdas_opt.domain.settings",
    "SigmoidDesign": "mcdas_opt.domain.sigmoid_design",
    "HeadwaySettings": "mcdas_opt.domain.settings",
    "ComfortSettings": "mcdas_opt.domain.comfort",
    "MannersSettings": "mcdas_opt.domain.manners",
    "SafeEndSettings": "mcdas_opt.domain.safe_end",
    "WarningSettings": "mcdas_opt.domain.settings",
    "EscapeSettings": "mcdas_opt.time_to_react.library",
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
    "Command": "mcdas_opt.domain.trajectory",
    "Candidate": "mcdas_opt.domain.plan",
    "Timing": "mcdas_opt.domain.plan",
    "Doubt": "mcdas_opt.domain.doubt",
    "DoubtKind": "mcdas_opt.domain.doubt",
    "SafeEnd": "mcdas_opt.domain.safe_end",
    "EndKind": "mcdas_opt.domain.safe_end",
    "ViolationKind": "mcdas_opt.domain.verdict",
    "Escape": "mcdas_opt.domain.escapes",
    "Closer": "mcdas_opt.domain.escapes",
    "Result": "mcdas_opt.domain.result",
    # files
    "Scene": "mcdas_opt.catalogue.scenes",
    "load_scene": "mcdas_opt.catalogue.scenes",
    "load_situation": "mcdas_opt.simulation.first_situation",
    "load_vehicle": "mcdas_opt.catalogue.vehicles",
    "load_sensor": "mcdas_opt.catalogue.sensors",
    "load_trajectory": "mcdas_opt.catalogue.trajectories",
    "load_parking_case": "mcdas_opt.parking.case_file",
    "Sensor": "mcdas_opt.domain.sensor",
    "TrajectoryFile": "mcdas_opt.catalogue.trajectories",
    "ParkingCase": "mcdas_opt.domain.parking",
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
    "Driver": "mcdas_opt.simulation.driver",
    "Plant": "mcdas_opt.simulation.plant",
    "Controller": "mcdas_opt.simulation.controller",
    "SensorFaults": "mcdas_opt.simulation.sensor_faults",
    "MotionSensors": "mcdas_opt.simulation.motion_sensors",
    "Simulation": "mcdas_opt.simulation.record",
    "Outcome": "mcdas_opt.simulation.record",
    "Columns": "mcdas_opt.interop.target_list",
    "Replay": "mcdas_opt.interop.replay_record",
    "ParkSettings": "mcdas_opt.parking.settings",
    "Parking": "mcdas_opt.domain.parking",
    "ParkingTrajectory": "mcdas_opt.domain.parking",
    "FollowSettings": "mcdas_opt.parking.closed_loop.settings",
    "Visitor": "mcdas_opt.parking.closed_loop.sight",
    "ParkingDrive": "mcdas_opt.parking.closed_loop.record",
    "Design": "mcdas_opt.tuning.design",
    "StudyOptions": "mcdas_opt.tuning.study_options",
    "StudyReport": "mcdas_opt.tuning.tune_in_traffic",
    "Comparison": "mcdas_opt.evaluation.comparison",
    # errors
    "McdasError": "mcdas_opt.errors",
    "InputError": "mcdas_opt.errors",
    "ParameterError": "mcdas_opt.errors",
    "MissingExtraError": "mcdas_opt.errors",
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
