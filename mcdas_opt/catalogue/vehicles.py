"""Vehicle files."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated, ClassVar

from pydantic import Field

from mcdas_opt.catalogue.data_files import checked, find, read_toml
from mcdas_opt.catalogue.part import Part
from mcdas_opt.catalogue.toml_text import toml_text
from mcdas_opt.domain.actuator_response import ActuatorResponse
from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.vehicle import DrivenAxle, Vehicle
from mcdas_opt.errors import ParameterError, blaming

_WHERE_FROM = ("source", "sources")  # the keys that are no numbers of the car


class ActuatorsPart(Part):
    """The table [actuators]: dead time and lags [s]."""

    steering_delay_s: Annotated[float, Field(description="dead time of steering; acceleration commands wait as long")] = 0.0
    steering_lag_s: Annotated[float, Field(description="time constant of the wheels behind the commanded angle")] = 0.0
    brake_build_up_s: Annotated[float, Field(description="time constant of deceleration that grows")] = 0.0
    brake_release_s: Annotated[float, Field(description="time constant of deceleration that ends")] = 0.0
    engine_lag_s: Annotated[float, Field(description="time constant of acceleration")] = 0.0


class VehicleFile(Part):
    """The keys of a vehicle file; the limits are the contract's, the chassis is optional, the rest says where the numbers come from."""

    KIND: ClassVar[str] = "vehicle"

    wheelbase_m: Annotated[float, Field(description="between the axles")]
    front_overhang_m: Annotated[float, Field(description="front axle to front bumper")]
    rear_overhang_m: Annotated[float, Field(description="rear axle to rear bumper")]
    width_m: Annotated[float, Field(description="of the body")]
    steering_max_rad: Annotated[float, Field(description="largest steering angle, both ways")]
    steering_rate_max_radps: Annotated[float, Field(description="largest steering rate, both ways")]
    acceleration_min_mps2: Annotated[float, Field(description="hardest braking, negative")]
    acceleration_max_mps2: Annotated[float, Field(description="hardest acceleration")]
    jerk_min_mps3: Annotated[float, Field(description="fastest onset of braking, negative")]
    jerk_max_mps3: Annotated[float, Field(description="fastest onset of acceleration")]
    speed_max_mps: Annotated[float, Field(description="top speed")]
    source: Annotated[str, Field(description="where the numbers come from")] = ""
    sources: Annotated[dict[str, str], Field(description="the same, number by number")] = Field(default={})
    mass_kg: Annotated[float | None, Field(description="of the dynamic vehicle, as all that follows")] = None
    yaw_inertia_kgm2: Annotated[float | None, Field(description="about the vertical axis")] = None
    cog_to_front_axle_m: Annotated[float | None, Field(description="centre of gravity to front axle")] = None
    cog_height_m: Annotated[float | None, Field(description="centre of gravity above the road")] = None
    cornering_stiffness_front_nprad: Annotated[float | None, Field(description="of the front axle, at small slip")] = None
    cornering_stiffness_rear_nprad: Annotated[float | None, Field(description="of the rear axle, at small slip")] = None
    axle_load_front_kg: Annotated[float | None, Field(description="static; with the rear axle's, says mass and centre of gravity")] = None
    axle_load_rear_kg: Annotated[float | None, Field(description="static; with the front axle's")] = None
    driven_axle: Annotated[str, Field(description="front, rear or both: who gets the engine's force")] = DrivenAxle.BOTH
    brake_share_front: Annotated[float | None, Field(description="front axle's share of the braking force; by load where left out")] = None
    anti_lock: Annotated[bool, Field(description="no wheel locks: what an axle cannot brake, the other one does")] = True
    actuators: Annotated[ActuatorsPart, Field(description="how steering, brakes and engine answer")] = ActuatorsPart()


def load_vehicle(name: str | Path, beside: Path | None = None) -> Vehicle:
    """The vehicle behind a shipped name or a path. Raises `InputError` that names the file, the key and the known vehicles."""
    path = find("vehicles", str(name), beside=beside)
    entry = checked(VehicleFile, read_toml(path), path)
    limits = entry.model_dump(exclude=set(_WHERE_FROM))
    with blaming(path, "actuators."):
        limits["actuators"] = ActuatorResponse(**limits["actuators"])
    with blaming(path):
        vehicle = Vehicle(name=path.stem, **limits)
        Chassis.of(vehicle)
    return vehicle


def vehicle_text(vehicle: Vehicle) -> str:
    """The vehicle as the text of a vehicle file, which reads back the same but for its name, which is the file's.

    Raises `ParameterError` for a zero-sideslip point that is not the rear axle: it goes with the speed, and no file can say it.
    """
    if vehicle.zero_sideslip_point_m != 0.0:
        raise ParameterError(
            "zero_sideslip_point_m", vehicle.zero_sideslip_point_m, "must be 0 in a vehicle file: it goes with the speed", "m"
        )
    return toml_text({key: value for key, value in asdict(vehicle).items() if key in VehicleFile.model_fields})
