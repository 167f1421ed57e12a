"""Parking cases: the contract's TOML, with or without its parallel slot, and the one-line CSV of TPCAP."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from mcdas_opt.catalogue.data_files import checked, find, finite_cell, models_folder, read_text, read_toml
from mcdas_opt.catalogue.part import NonNegative, Part, Positive
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.arithmetic import usual_arithmetic
from mcdas_opt.domain.parking import LARGEST_SLOT_M, ParallelSlot, ParkingCase, ParkingLimits, ParkingTolerance
from mcdas_opt.domain.rules import FARTHEST_M, Array, require_type, require_type_if_given
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import InputError, ParameterError, blaming
from mcdas_opt.geometry.clearance import Body, body_corners, obstacle_field
from mcdas_opt.geometry.polygon import convex_hull, is_simple, signed_area

Stretch = Annotated[float, Field(gt=0.0, le=LARGEST_SLOT_M)]
_START_AHEAD_M, _START_LEFT_M = 1.0, 1.4  # the contract's default start beside the front car
_TPCAP_LIMITS = ParkingLimits(clearance_m=0.0, forward_mps=2.5, reverse_mps=2.5, acceleration_mps2=1.0)


class VehiclePart(Part):
    """A shipped name or a path, and keys that differ from it."""

    name: Annotated[str, Field(description="a shipped vehicle or a path")] = "sedan"
    wheelbase_m: Positive | None = None
    front_overhang_m: Positive | None = None
    rear_overhang_m: Positive | None = None
    width_m: Positive | None = None
    steering_max_rad: Positive | None = None
    steering_rate_max_radps: Positive | None = None
    acceleration_min_mps2: float | None = None
    acceleration_max_mps2: Positive | None = None
    jerk_min_mps3: float | None = None
    jerk_max_mps3: Positive | None = None
    speed_max_mps: Positive | None = None


class GoalPart(Part):
    x_m: Annotated[float | None, Field(description="rear axle's midpoint along the road; default in the slot")] = None
    y_m: Annotated[float | None, Field(description="rear axle's midpoint across, left positive")] = None
    heading_rad: Annotated[float | None, Field(description="counter-clockwise from x")] = None


class StartPart(GoalPart):
    steering_rad: Annotated[float, Field(description="at the start")] = 0.0


class SlotPart(Part):
    length_m: Annotated[Stretch, Field(description="the slot is 0 <= x <= length_m")]
    depth_m: Annotated[Stretch, Field(description="kerb at y = -depth_m; a car needs its width and twice the clearance")] = 2.1
    street_m: Annotated[Stretch, Field(description="the opposite side is at y = street_m")] = 4.5


class ObstaclePart(Part):
    vertices_m: Annotated[
        Annotated[list[Annotated[list[float], Field(min_length=2, max_length=2)]], Field(min_length=3)],
        Field(description="corners [x, y] of a simple polygon, of either turn"),
    ]
    name: Annotated[str, Field(description="in messages")] = ""


class LimitsPart(Part):
    clearance_m: Annotated[NonNegative, Field(description="body to every obstacle, at all times")] = 0.05
    forward_mps: Annotated[Positive, Field(description="fastest forwards")] = 2.5
    reverse_mps: Annotated[Positive, Field(description="fastest in reverse")] = 2.0
    acceleration_mps2: Annotated[Positive, Field(description="both signs, may step; no jerk limit")] = 1.5


class TolerancePart(Part):
    position_m: Annotated[Positive, Field(description="of the end against the goal, of the start too")] = 0.02
    heading_rad: Annotated[Positive, Field(description="of the end against the goal")] = 0.01


class ParkingFile(Part):
    """The keys of a parking case."""

    KIND: ClassVar[str] = "parking case"

    name: Annotated[str, Field(description="of the case")] = ""
    vehicle: Annotated[VehiclePart, Field(description="a shipped one, and keys that differ from it")] = VehiclePart()
    start: Annotated[StartPart, Field(description="where the car stands")] = StartPart()
    goal: Annotated[GoalPart, Field(description="where it shall stand")] = GoalPart()
    slot: Annotated[SlotPart | None, Field(description="a parallel slot, which builds its own obstacles")] = None
    obstacle: Annotated[list[ObstaclePart], Field(description="polygons")] = Field(default=[])
    limits: Annotated[LimitsPart, Field(description="what the judge enforces besides the vehicle's")] = LimitsPart()
    tolerance: Annotated[TolerancePart, Field(description="how near the end must be to the goal")] = TolerancePart()


@usual_arithmetic
def load_parking_case(name: str | Path, *, vehicle: str | Vehicle | None = None, clearance_m: float | None = None) -> ParkingCase:
    """The case behind a path (`.toml`, or a TPCAP `.csv`) or a shipped name; `vehicle` (a `Vehicle`, a shipped name or a path) and
    `clearance_m` override the file's.

    Raises `InputError` that names file, key (line and column of a CSV), value and rule. What could be repaired is in `notes`.
    """
    require_type_if_given("vehicle", vehicle, str, Vehicle)
    path = find("cases", str(name))
    with blaming(path):
        if path.suffix.lower() == ".csv":
            return _sound(_tpcap(path, vehicle, clearance_m), path)
        return parking_case_from_document(read_toml(path), path, vehicle=vehicle, clearance_m=clearance_m)


def the_case(case: str | Path | ParkingCase, vehicle: str | Vehicle | None = None) -> ParkingCase:
    """A case itself, or the one behind a path or a shipped name, there with another `vehicle` if one is given.

    Raises `InputError` as `load_parking_case` does, `ParameterError` for what is no case, and for a vehicle beside a case that has its own.
    """
    if isinstance(case, (str, Path)):
        return load_parking_case(case, vehicle=vehicle)
    require_type("case", case, ParkingCase)
    if vehicle is not None:
        raise ParameterError("vehicle", vehicle, "is the case's own where `case` is no name: load_parking_case(name, vehicle=...)")
    return case


def is_parking_case(name: str | Path) -> bool:
    """True for a CSV, and for a TOML document (or a shipped name) that has a parking case's keys and no host."""
    path = next((p for p in (Path(name), models_folder() / "cases" / f"{name}.toml") if os.path.isfile(p)), None)
    if path is None or path.suffix.lower() not in (".csv", ".toml"):
        return False
    return path.suffix.lower() == ".csv" or bool({"slot", "goal", "obstacle"} & set(read_toml(path)))


def parking_case_from_document(
    document: Any, path: Path = Path("case"), *, vehicle: str | Vehicle | None = None, clearance_m: float | None = None
) -> ParkingCase:
    """A case from its parsed TOML; a vehicle file that it names is sought beside `path`."""
    entry = checked(ParkingFile, document, path)
    car = _vehicle(entry.vehicle, path) if vehicle is None else _given(vehicle)
    slot = ParallelSlot(**entry.slot.model_dump()) if entry.slot is not None else None
    _slot_takes(slot, car, path)
    limits = ParkingLimits(**entry.limits.model_dump())
    obstacles = list(slot.obstacles) if slot is not None else []
    names = ["rear car", "front car", "kerb", "opposite side"] if slot is not None else []
    notes: list[str] = []
    for k, part in enumerate(entry.obstacle):
        label = part.name or f"obstacle[{k}]"
        obstacles.append(_outline(np.array(part.vertices_m), label, f"obstacle[{k}].vertices_m", path, notes))
        names.append(label)
    default_start: tuple[float | None, ...] = (None, None, None)
    default_goal = default_start
    if slot is not None:
        default_start = (slot.length_m + _START_AHEAD_M, _START_LEFT_M, 0.0)
        default_goal = (0.5 * slot.length_m - car.centre_m, -0.5 * slot.depth_m, 0.0)
    try:
        case = ParkingCase(
            name=entry.name or path.stem,
            vehicle=car,
            start=_pose("start", entry.start, default_start, path),
            goal=_pose("goal", entry.goal, default_goal, path),
            obstacles=tuple(obstacles),
            names=tuple(names),
            start_steering_rad=entry.start.steering_rad,
            limits=limits if clearance_m is None else replace(limits, clearance_m=clearance_m),
            tolerance=ParkingTolerance(**entry.tolerance.model_dump()),
            slot=slot,
            notes=tuple(notes),
        )
    except ParameterError as error:
        key = {"start_steering_rad": "start.steering_rad"}.get(error.name, error.name)
        raise InputError(path, key, error.value, error.rule) from None
    return _sound(case, path)


def slot_case(length_m: float) -> ParkingCase:
    """The contract's slot form with all defaults."""
    return parking_case_from_document({"slot": {"length_m": float(length_m)}})


def _given(vehicle: str | Vehicle) -> Vehicle:
    return load_vehicle(vehicle) if isinstance(vehicle, str) else vehicle


def _vehicle(part: VehiclePart, path: Path) -> Vehicle:
    base = load_vehicle(part.name, path.parent)
    given = part.model_dump(exclude={"name"}, exclude_none=True)
    with blaming(path, "vehicle."):
        return replace(base, **given)


def _pose(key: str, part: GoalPart, default: tuple[float | None, ...], path: Path) -> Array:
    values = []
    given_values = (part.x_m, part.y_m, part.heading_rad)
    for name, given, fallback in zip(("x_m", "y_m", "heading_rad"), given_values, default, strict=True):
        value = fallback if given is None else given
        if value is None:
            raise InputError(path, f"{key}.{name}", None, "missing key (only a [slot] has defaults)")
        values.append(value)
    return np.array(values)


def _outline(vertices: Array, label: str, key: str, path: Path, notes: list[str]) -> Array:
    """A simple counter-clockwise polygon; what had to be repaired goes into `notes`."""
    if not (np.abs(vertices) <= FARTHEST_M).all():
        raise InputError(path, key, None, f"{label} must lie within {FARTHEST_M:g} m")
    keep = np.linalg.norm(vertices - np.roll(vertices, 1, axis=0), axis=1) > 1e-9
    vertices = vertices[keep]
    if len(vertices) < 3 or abs(signed_area(convex_hull(vertices))) < 1e-9:
        raise InputError(path, key, None, f"{label} has no area")
    if not is_simple(vertices):
        notes.append(f"{label} crosses itself: its convex hull is used")
        return convex_hull(vertices)
    if signed_area(vertices) < 0.0:
        notes.append(f"{label} is clockwise: turned")
        vertices = vertices[::-1]
    return vertices


def _slot_takes(slot: ParallelSlot | None, car: Vehicle, path: Path) -> None:
    if slot is None:
        return
    if slot.length_m < car.length_m:
        raise InputError(path, "slot.length_m", slot.length_m, f"slot {slot.length_m:.2f} m, car {car.length_m:.2f} m")
    if slot.depth_m < car.width_m:
        raise InputError(path, "slot.depth_m", slot.depth_m, f"slot {slot.depth_m:.2f} m deep, car {car.width_m:.2f} m wide")


def _sound(case: ParkingCase, path: Path) -> ParkingCase:
    """Rules that need the whole case: nobody starts or ends inside an obstacle, and the goal lies in its slot."""
    body = Body.of(case.vehicle)
    if case.slot is not None and _out_of_slot(case.slot, body_corners(case.start[None], body)[0]) > 1e-6:  # else it is left
        out = _out_of_slot(case.slot, body_corners(case.goal[None], body)[0])
        if out > 1e-6:
            raise InputError(path, "goal", [float(q) for q in case.goal], f"the body stands out of the slot by {out:.2f} m")
    field, owner = obstacle_field(case.obstacles)
    for key, pose in (("start", case.start), ("goal", case.goal)):
        apart = field.separation(pose[None], body)[0]
        if apart.size and apart.min() < -1e-6:
            worst = int(np.argmin(apart))
            where = [float(q) for q in pose]
            raise InputError(path, key, where, f"the body overlaps {case.names[owner[worst]]} by {-apart[worst]:.2f} m")
    return case


def _out_of_slot(slot: ParallelSlot, corners: Array) -> float:
    """How far a body's corners stand out of the slot [m], negative inside."""
    x, y = corners.T
    return float(max(-x.min(), x.max() - slot.length_m, -slot.depth_m - y.min(), y.max()))


def _tpcap(path: Path, vehicle: str | Vehicle | None, clearance_m: float | None) -> ParkingCase:
    """x0, y0, th0, xf, yf, thf, number of obstacles, vertices of each, then the vertices; relative to the start."""
    lines = [(n, line) for n, line in enumerate(read_text(path).splitlines(), start=1) if line.strip()]
    if len(lines) != 1:
        raise InputError(path, f"line {lines[1][0] if lines else 1}", None, f"must hold exactly one line, has {len(lines)}")
    number, line = lines[0]
    tokens = [token.strip() for token in line.split(",")]
    while tokens and not tokens[-1]:
        tokens.pop()
    values = [finite_cell(token, path, f"line {number}, column {column}") for column, token in enumerate(tokens, start=1)]

    def whole(column: int, least: int) -> int:
        if column > len(values):
            raise InputError(path, f"line {number}, column {column}", None, f"is missing: the line ends after {len(values)} values")
        value = values[column - 1]
        if value != int(value) or not least <= value <= 10_000:
            raise InputError(path, f"line {number}, column {column}", value, f"must be a whole number of at least {least}")
        return int(value)

    count = whole(7, 0)
    sizes = [whole(8 + k, 3) for k in range(count)]
    expected = 7 + count + 2 * sum(sizes)
    if len(values) != expected:
        column = min(len(values), expected) + 1
        raise InputError(path, f"line {number}, column {column}", None, f"{len(values)} values, {expected} announced by the counts")
    origin = (values[0], values[1])
    flat = np.array(values[7 + count :]).reshape(-1, 2) - origin
    notes: list[str] = []
    outlines, names, first = [], [], 0
    for k, size in enumerate(sizes):
        key = f"line {number}, column {8 + count + 2 * first}"
        names.append(f"obstacle {k + 1}")
        outlines.append(_outline(flat[first : first + size], names[-1], key, path, notes))
        first += size
    return ParkingCase(
        name=path.stem,
        vehicle=_given(vehicle or "tpcap"),
        start=np.array([0.0, 0.0, values[2]]),
        goal=np.array([values[3] - origin[0], values[4] - origin[1], values[5]]),
        obstacles=tuple(outlines),
        names=tuple(names),
        limits=_TPCAP_LIMITS if clearance_m is None else replace(_TPCAP_LIMITS, clearance_m=clearance_m),
        origin_m=origin,
        notes=tuple(note for note in notes if "clockwise" not in note),  # either turn is the format's
    )
