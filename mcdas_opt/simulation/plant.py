"""What is driven in the closed loop: a plant, and how one is found by name."""

from __future__ import annotations

import functools
from collections.abc import Callable
from types import FunctionType
from typing import Literal, Protocol

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.registry import Registry
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import ParameterError
from mcdas_opt.simulation.actuators import Applied

PLANTS = Registry(
    group="mcdas_opt.plants",
    what="plant",
    own={
        "kinematic": "mcdas_opt.simulation.kinematic_plant:KinematicPlant",
        "dynamic": "mcdas_opt.simulation.dynamic_plant:DynamicPlant",
    },
)


class Plant(Protocol):
    """A car in motion. It is built as `Plant(vehicle, road, state)`: `road` has the friction there is, `state` is where the drive begins.

    What follows from its state (the no-slip state that plans are made with, the zero-sideslip point) is computed by `simulation.car.Car`.
    """

    @property
    def state(self) -> HostState:
        """Where the car is: the body centre; speed and acceleration of the rear axle, the angle of the front wheels. A car whose tyres slip
        gives a `SlidingState` from its first state on: it is tracked with feedback, and planned for with a reserve."""
        ...

    def step(self, jerk_mps3: float, steering_rate_radps: float) -> Applied:
        """Moves on by `STEP_S` under the commanded inputs, as far as the car can follow them. Says what it did: the plant, not its caller,
        knows its limits."""
        ...


PlantFactory = Callable[[Vehicle, Road, HostState], Plant]
PlantName = Literal["kinematic", "dynamic"]  # for editors; others come by entry point


def plant_name(plant: str | PlantFactory) -> str:
    """The name itself; of an object, that of its class or function."""
    if isinstance(plant, str):
        return plant
    inner = plant.func if isinstance(plant, functools.partial) else plant
    return inner.__name__ if isinstance(inner, (type, FunctionType)) else type(inner).__name__


def plant_factory(plant: str | PlantFactory) -> PlantFactory:
    """What builds the plant: the one registered under that name, or the object itself.

    Raises `ParameterError` that names the nearest known plant, or says what of an entry point cannot be imported.
    """
    if not isinstance(plant, str):
        if not callable(plant):
            raise ParameterError("plant", plant, "must be the name of a plant, or be called as plant(vehicle, road, state)")
        return plant
    factory: PlantFactory = PLANTS.load(plant)
    return factory


def make_plant(plant: str | PlantFactory, vehicle: Vehicle, road: Road, state: HostState) -> Plant:
    """A plant at the beginning of a drive. Raises as `plant_factory`."""
    return plant_factory(plant)(vehicle, road, state)
