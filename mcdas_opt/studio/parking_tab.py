"""The parking tab's state: a case under its sliders and its dragged slot."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from mcdas_opt.catalogue.data_files import read_toml, shipped
from mcdas_opt.catalogue.toml_text import toml_text
from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.errors import ParameterError, nearest
from mcdas_opt.geometry.clearance import Body, body_corners
from mcdas_opt.parking.case_file import parking_case_from_document
from mcdas_opt.parking.park import check_planner, park
from mcdas_opt.parking.settings import ParkSettings
from mcdas_opt.plotting.plane import rounded
from mcdas_opt.plotting.player import parking_document
from mcdas_opt.studio.folder import Folder, download_name, shipped_file
from mcdas_opt.studio.knobs import Knob

FIRST = "parallel"
LIVE = "two-arc"  # answers while the user still drags
_BUDGET_S = 6.0  # for the program, after which the best so far stands
_MARGIN_M = 0.8

KNOBS = (
    Knob(key="length_m", label="length", unit="m", low=4.5, high=12.0, step=0.05, group="slot"),
    Knob(key="depth_m", label="depth", unit="m", low=1.8, high=3.5, step=0.05, group="slot"),
    Knob(key="street_m", label="street beside it", unit="m", low=2.5, high=9.0, step=0.05, group="slot"),
    Knob(key="clearance_m", label="clearance asked for", unit="m", low=0.0, high=0.4, step=0.01, group="slot"),
    Knob(key="start_x_m", label="rear axle x", unit="m", low=-15.0, high=25.0, step=0.05, group="start"),
    Knob(key="start_y_m", label="rear axle y", unit="m", low=-15.0, high=15.0, step=0.05, group="start"),
    Knob(key="start_heading_rad", label="heading", unit="rad", low=-3.14, high=3.14, step=0.01, group="start", also="deg"),
)
_BY_KEY = {knob.key: knob for knob in KNOBS}
_SLOT = ("length_m", "depth_m", "street_m")


class ParkingTab:
    """A parking case as a document, and what the sliders make of it."""

    def __init__(self, folder: Folder) -> None:
        self.folder = folder
        self._path = shipped_file("cases", FIRST)
        self._document = read_toml(self._path)

    def data_files(self) -> list[dict[str, Any]]:
        return [
            {"label": "shipped cases", "kind": "shipped", "names": [FIRST, *(name for name in shipped("cases") if name != FIRST)]},
            {"label": "cases of the folder", "kind": "case", "names": self.folder.cases()},
        ]

    def open(self, kind: str, name: str) -> dict[str, Any]:
        """Opens a case of the data files. Raises `InputError` for what is not there, or lies outside of the folder."""
        if kind not in ("shipped", "case"):
            raise ParameterError("kind", kind, "must be shipped or case")
        path = shipped_file("cases", name) if kind == "shipped" else self.folder.file(name)
        document = read_toml(path)
        if kind == "case":
            self.folder.confine(document, path)
        parking_case_from_document(document, path)
        self._path, self._document = path, document
        return self.opened()

    def opened(self) -> dict[str, Any]:
        case = self.case({})
        return {"part": "opened", "name": case.name, **self.place(case)}

    def case(self, values: Mapping[str, object]) -> ParkingCase:
        """The case with the sliders' values. Raises `InputError` for one that cannot be, `ParameterError` for a bad value."""
        return parking_case_from_document(self._turned(values), self._path)

    def place(self, case: ParkingCase) -> dict[str, Any]:
        """Where the sliders stand (None: this case has no such thing), and the handles that can be dragged."""
        slot = case.slot
        stand: dict[str, float | None] = dict.fromkeys(_SLOT) if slot is None else asdict(slot)
        stand["clearance_m"] = case.limits.clearance_m
        stand |= dict(zip(("start_x_m", "start_y_m", "start_heading_rad"), (float(q) for q in case.start), strict=True))
        handles: list[dict[str, Any]] = [{"key": "start", "at": rounded(case.start, 3), "moves": ["start_x_m", "start_y_m"]}]
        if slot is not None:
            middle = 0.5 * slot.length_m
            handles += [
                {"key": "length", "at": [slot.length_m, -0.5 * slot.depth_m], "moves": ["length_m", None]},
                {"key": "depth", "at": [middle, -slot.depth_m], "moves": [None, "-depth_m"]},
                {"key": "street", "at": [middle, slot.street_m], "moves": [None, "street_m"]},
            ]
        return {"positions": stand, "handles": handles}

    def toml(self, values: Mapping[str, object]) -> tuple[str, str]:
        """File name and text of the case with the sliders' values."""
        case = self.case(values)
        return download_name(case.name, "case"), toml_text(self._turned(values))

    def _turned(self, values: Mapping[str, object]) -> dict[str, Any]:
        made = copy.deepcopy(self._document)
        for key, raw in values.items():
            if key not in _BY_KEY:
                raise ParameterError("knob", key, nearest(key, _BY_KEY))
            value = _BY_KEY[key].checked(raw)
            if key in _SLOT:
                if "slot" not in made:
                    raise ParameterError(key, raw, "this case has no slot of that kind")
                made["slot"][key] = value
            elif key == "clearance_m":
                made.setdefault("limits", {})[key] = value
            else:
                made.setdefault("start", {})[key.removeprefix("start_")] = value
        return made


def bounds(case: ParkingCase) -> list[float]:
    """x0, y0, x1, y1 of a window on the slot, the start and the goal; without a slot, on all obstacles that are near."""
    body = Body.of(case.vehicle)
    points = [body_corners(np.array([case.start, case.goal]), body).reshape(-1, 2)]
    if case.slot is not None:
        points.append(np.array([[-2.5, -case.slot.depth_m - 0.3], [case.slot.length_m + 2.5, case.slot.street_m + 0.3]]))
    corners = np.vstack(points)
    margin = _MARGIN_M if case.slot is not None else 4.0
    low, high = corners.min(axis=0) - margin, corners.max(axis=0) + margin
    return [float(q) for q in (*low, *high)]


def parked(case: ParkingCase, planner: str) -> dict[str, Any]:
    """A planner's answer to the case, as the script draws it."""
    check_planner(planner)
    answer = park(case, planner, settings=ParkSettings(time_budget_s=_BUDGET_S))
    document = parking_document(case, answer)
    document["yard"]["bounds"] = rounded(bounds(case))
    return {"part": "parking", "planner": planner, "parking": document, "seconds": round(answer.timing_ms.get("total", 0.0) / 1e3, 2)}
