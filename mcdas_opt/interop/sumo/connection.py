"""What is asked of SUMO: libsumo as a module or a connection of traci, whichever the user has; and what is said when it ends."""

from __future__ import annotations

import importlib.util
import os
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Protocol

from mcdas_opt.errors import InputError, McdasError, MissingExtraError

Point = tuple[float, float]
# of traci.constants: what is subscribed to around the host
VEHICLES, PERSONS = 0xA4, 0xAE
LANE_ID, POSITION_3D, ANGLE, SPEED, LENGTH, WIDTH, ACCELERATION = 0x51, 0x39, 0x43, 0x40, 0x44, 0x4D, 0x72
SUBSCRIBED = (LANE_ID, POSITION_3D, ANGLE, SPEED, LENGTH, WIDTH, ACCELERATION)
ABOARD = 0xC3  # of a person: the vehicle that it sits in, else ""


class VehicleDomain(Protocol):
    """`traci.vehicle`, as far as it is used."""

    def getIDList(self) -> Sequence[str]: ...
    def getRoute(self, vehID: str) -> Sequence[str]: ...
    def getLaneID(self, vehID: str) -> str: ...
    def getRouteIndex(self, vehID: str) -> int: ...
    def getPosition3D(self, vehID: str) -> tuple[float, float, float]: ...
    def getAngle(self, vehID: str) -> float: ...
    def getSpeed(self, vehID: str) -> float: ...
    def getAcceleration(self, vehID: str) -> float: ...
    def getLength(self, vehID: str) -> float: ...
    def getWidth(self, vehID: str) -> float: ...
    def getAccel(self, vehID: str) -> float: ...
    def getEmergencyDecel(self, vehID: str) -> float: ...
    def getMaxSpeed(self, vehID: str) -> float: ...
    def getVehicleClass(self, vehID: str) -> str: ...
    def getSignals(self, vehID: str) -> int: ...
    def getLanePosition(self, vehID: str) -> float: ...
    def setSpeedMode(self, vehID: str, speedMode: int) -> None: ...
    def setLaneChangeMode(self, vehID: str, laneChangeMode: int) -> None: ...
    def subscribeContext(self, objectID: str, domain: int, dist: float, varIDs: Sequence[int]) -> None: ...
    def getContextSubscriptionResults(self, objectID: str) -> Mapping[str, Mapping[int, Any]]: ...
    def moveToXY(
        self, vehID: str, edgeID: str, laneIndex: int, x: float, y: float, angle: float, keepRoute: int, matchThreshold: float
    ) -> None: ...


class PersonDomain(Protocol):
    """`traci.person`, as far as it is used."""

    def getLaneID(self, personID: str) -> str: ...
    def getPosition3D(self, personID: str) -> tuple[float, float, float]: ...
    def getAngle(self, personID: str) -> float: ...
    def getSpeed(self, personID: str) -> float: ...
    def getLength(self, personID: str) -> float: ...
    def getWidth(self, personID: str) -> float: ...


class LaneDomain(Protocol):
    """`traci.lane`, as far as it is used."""

    def getIDList(self) -> Sequence[str]: ...
    def getShape(self, laneID: str) -> Sequence[Point]: ...
    def getWidth(self, laneID: str) -> float: ...
    def getMaxSpeed(self, laneID: str) -> float: ...
    def getAllowed(self, laneID: str) -> Sequence[str]: ...
    def getDisallowed(self, laneID: str) -> Sequence[str]: ...
    def getLinks(self, laneID: str) -> Sequence[tuple[Any, ...]]: ...
    def getInternalFoes(self, laneID: str) -> Sequence[str]: ...
    def getLastStepVehicleIDs(self, laneID: str) -> Sequence[str]: ...


class EdgeDomain(Protocol):
    """`traci.edge`, as far as it is used."""

    def getLaneNumber(self, edgeID: str) -> int: ...
    def getFromJunction(self, edgeID: str) -> str: ...
    def getToJunction(self, edgeID: str) -> str: ...


class SimulationDomain(Protocol):
    """`traci.simulation`, as far as it is used."""

    def getTime(self) -> float: ...
    def getDeltaT(self) -> float: ...
    def getEndTime(self) -> float: ...
    def getMinExpectedNumber(self) -> int: ...


class Connection(Protocol):
    """The module libsumo, or what `traci.getConnection()` returns."""

    @property
    def vehicle(self) -> VehicleDomain: ...
    @property
    def person(self) -> PersonDomain: ...
    @property
    def lane(self) -> LaneDomain: ...
    @property
    def edge(self) -> EdgeDomain: ...
    @property
    def simulation(self) -> SimulationDomain: ...
    def simulationStep(self) -> object: ...


class SumoError(McdasError, RuntimeError):
    """SUMO ended, or refused what it was asked."""


@contextmanager
def asking(what: str) -> Iterator[None]:
    """Turns whatever traci or libsumo raises into a `SumoError`: what was being done, and what SUMO said."""
    try:
        yield
    except Exception as error:
        if not _is_sumos(error):
            raise
        raise SumoError(f"SUMO ended or refused while {what}: {str(error).strip() or type(error).__name__}") from None


def _is_sumos(error: Exception) -> bool:
    """Both packages name their errors alike; a connection that breaks is an OSError of the socket."""
    return any(kind.__name__ in ("TraCIException", "FatalTraCIError") for kind in type(error).__mro__) or isinstance(error, OSError)


@contextmanager
def started(config: Path, seed: int) -> Iterator[Connection]:
    """libsumo with a configuration and a seed, in steps of 0.1 s; ended at the end. One at a time in a process.

    Raises `MissingExtraError` without libsumo, `InputError` for a configuration that is not there or that SUMO does not take.
    """
    require_libsumo()
    libsumo = _libsumo()
    if not os.path.isfile(config):
        raise InputError(config, "", None, "no such file")
    steps = ("--step-length", "0.1", "--no-step-log", "--collision.action", "warn")
    said: list[str] = []
    try:
        with _listening(said):
            libsumo.start(["sumo", "-c", str(config), "--seed", str(seed), *steps])
    except Exception as error:
        if not _is_sumos(error):
            raise
        told = next((line for line in said if line.startswith("Error")), str(error))
        raise InputError(config, "", None, f"SUMO does not take it: {' '.join(told.removeprefix('Error:').split())}") from None
    try:
        yield libsumo
    finally:
        with suppress(Exception):
            libsumo.close()


@contextmanager
def _listening(said: list[str]) -> Iterator[None]:
    """Gathers the lines that SUMO itself writes to stderr."""
    sys.stderr.flush()
    kept = os.dup(2)
    with tempfile.TemporaryFile() as file:
        os.dup2(file.fileno(), 2)
        try:
            yield
        finally:
            os.dup2(kept, 2)
            os.close(kept)
            file.seek(0)
            said += file.read().decode(errors="replace").splitlines()


def require_libsumo() -> None:
    """Raises `MissingExtraError` where libsumo is not installed; loads nothing."""
    if importlib.util.find_spec("libsumo") is None:
        raise MissingExtraError("libsumo", "sumo")


def _libsumo() -> Any:
    """The module. It would warn of another pyarrow than its own on stdout, which is the user's."""
    if "libsumo" not in sys.modules:
        before = os.environ.get("LIBSUMO_AS_TRACI")
        os.environ["LIBSUMO_AS_TRACI"] = "quiet"
        try:
            import libsumo
        finally:
            if before is None:
                del os.environ["LIBSUMO_AS_TRACI"]
            else:
                os.environ["LIBSUMO_AS_TRACI"] = before
    import libsumo

    return libsumo
