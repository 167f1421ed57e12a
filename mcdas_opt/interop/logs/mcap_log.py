"""MCAP for Foxglove: /scene (3D, foxglove.SceneUpdate), /host (numbers to plot) and /plan (what was decided, and why), as JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mcdas_opt.domain.document import to_document
from mcdas_opt.domain.rules import Array
from mcdas_opt.errors import of_extra, writing
from mcdas_opt.interop.logs.moments import HEIGHT_M, Box, Moment, lines, moments
from mcdas_opt.simulation.record import Simulation

FRAME = "road"
_NS = 1_000_000_000
_PLAN = ("planner", "mode", "side", "warning", "status", "reason", "verdict", "iterations", "candidates")
_COLOURS = {"host": (0.0, 0.447, 0.698, 1.0), "other": (0.902, 0.624, 0.0, 1.0), "track": (0.337, 0.706, 0.914, 0.4)}
_PATH, _ROAD, _BORDER = (0.0, 0.62, 0.451, 1.0), (0.33, 0.33, 0.35, 1.0), (0.7, 0.7, 0.7, 1.0)


def write_mcap(drive: Simulation, path: str | Path) -> Path:
    """The drive at `path`; time 0 is the drive's start, so that the same drive is the same file.

    Raises `MissingExtraError` without the package mcap, `InputError` where the file cannot be written.
    """
    with of_extra("mcap", "mcap"):
        from mcap.writer import CompressionType, Writer
    path = Path(path)
    with writing(path), path.open("wb") as file:
        writer = Writer(file, compression=CompressionType.NONE)
        writer.start(profile="", library="mcdas-opt")
        channels = {topic: _channel(writer, topic, schema) for topic, schema in _SCHEMAS.items()}
        for index, moment in enumerate(moments(drive)):
            time_ns = round(moment.t_s * _NS)
            messages = {"/scene": _scene(drive if index == 0 else None, moment, time_ns), "/host": {**moment.host, "t_s": moment.t_s}}
            if moment.plan is not None:
                whole = to_document(moment.plan)
                messages["/plan"] = {"t_s": moment.t_s, **{key: whole[key] for key in _PLAN}}
            for topic, message in messages.items():
                data = json.dumps(message, allow_nan=False).encode()
                writer.add_message(channel_id=channels[topic], log_time=time_ns, publish_time=time_ns, data=data, sequence=index)
        writer.finish()
    return path


def _object(**properties: Any) -> dict[str, Any]:
    return {"type": "object", "properties": properties}


def _list(items: dict[str, Any]) -> dict[str, Any]:
    return {"type": "array", "items": items}


_NUMBER, _TEXT, _WHOLE, _YES = {"type": "number"}, {"type": "string"}, {"type": "integer"}, {"type": "boolean"}
_TIME, _SPAN = _object(sec=_WHOLE, nsec=_WHOLE), _object(sec=_WHOLE, nsec=_WHOLE)
_POINT, _RGBA = _object(x=_NUMBER, y=_NUMBER, z=_NUMBER), _object(r=_NUMBER, g=_NUMBER, b=_NUMBER, a=_NUMBER)
_POSE = _object(position=_POINT, orientation=_object(x=_NUMBER, y=_NUMBER, z=_NUMBER, w=_NUMBER))
_CUBE = _object(pose=_POSE, size=_POINT, color=_RGBA)
_LINE = _object(
    type=_WHOLE, pose=_POSE, thickness=_NUMBER, scale_invariant=_YES, points=_list(_POINT), color=_RGBA, colors=_list(_RGBA),
    indices=_list(_WHOLE),
)  # fmt: skip
_LABEL = _object(pose=_POSE, billboard=_YES, font_size=_NUMBER, scale_invariant=_YES, color=_RGBA, text=_TEXT)
_ENTITY = _object(
    timestamp=_TIME, frame_id=_TEXT, id=_TEXT, lifetime=_SPAN, frame_locked=_YES, metadata=_list(_object(key=_TEXT, value=_TEXT)),
    cubes=_list(_CUBE), lines=_list(_LINE), texts=_list(_LABEL),
)  # fmt: skip
_VIOLATION = _object(name=_TEXT, t_s=_NUMBER, value=_NUMBER, limit=_NUMBER, unit=_TEXT, kind=_TEXT, body=_TEXT)
_HOST = ("t_s", "s_m", "d_m", "heading_rad", "speed_mps", "acceleration_mps2", "steering_rad", "jerk_mps3", "steering_rate_radps")
_SCHEMAS: dict[str, tuple[str, dict[str, Any]]] = {
    "/scene": ("foxglove.SceneUpdate", _object(deletions=_list(_object(timestamp=_TIME, type=_WHOLE, id=_TEXT)), entities=_list(_ENTITY))),
    "/host": ("mcdas.Host", _object(**dict.fromkeys(_HOST, _NUMBER))),
    "/plan": (
        "mcdas.Plan",
        _object(
            t_s=_NUMBER, planner=_TEXT, mode=_TEXT, side=_TEXT, warning=_YES, status=_TEXT, reason=_TEXT, iterations=_WHOLE,
            verdict=_object(violations=_list(_VIOLATION)),
            candidates=_list(_object(name=_TEXT, cost=_NUMBER, passed=_YES, refusal=_TEXT)),
        ),
    ),
}  # fmt: skip


def _channel(writer: Any, topic: str, schema: tuple[str, dict[str, Any]]) -> int:
    name, shape = schema
    text = json.dumps({"title": name, **shape}).encode()
    identifier = writer.register_schema(name=name, encoding="jsonschema", data=text)
    return int(writer.register_channel(topic=topic, message_encoding="json", schema_id=identifier))


def _scene(first: Simulation | None, moment: Moment, time_ns: int) -> dict[str, Any]:
    """Bodies that live until the next moment; the road (with the first moment) and the plan's path until the next of its kind."""
    stamp = _time(time_ns)
    entities = [] if first is None else [_road(first, stamp)]
    host, *others = moment.bodies
    bodies = [_body(box, "host" if box is host else "other") for box in (host, *others)]
    entities.append(_entity("bodies", stamp, cubes=bodies, texts=[_name(box) for box in others]))
    if moment.plan is not None:
        entities.append(_entity("plan", stamp, lines=[_line(moment.path, 0.25, _PATH)]))
        entities.append(_entity("tracks", stamp, cubes=[_body(box, "track") for box in moment.tracks]))
    return {"deletions": [], "entities": entities}


def _road(drive: Simulation, stamp: dict[str, int]) -> dict[str, Any]:
    drawn = [_line(points, 0.15, _ROAD if "edge" in name else _BORDER) for name, points in lines(drive).items()]
    return _entity("road", stamp, lines=drawn)


def _entity(name: str, stamp: dict[str, int], **parts: list[dict[str, Any]]) -> dict[str, Any]:
    empty: dict[str, list[dict[str, Any]]] = {"cubes": [], "lines": [], "texts": []}
    return {
        "timestamp": stamp, "frame_id": FRAME, "id": name, "lifetime": {"sec": 0, "nsec": 0}, "frame_locked": False, "metadata": [],
        **empty, **parts,
    }  # fmt: skip


def _body(box: Box, kind: str) -> dict[str, Any]:
    size = {"x": box.length_m, "y": box.width_m, "z": HEIGHT_M}
    return {"pose": _pose(box.x_m, box.y_m, 0.5 * HEIGHT_M, box.yaw_rad), "size": size, "color": _rgba(_COLOURS[kind])}


def _name(box: Box) -> dict[str, Any]:
    pose = _pose(box.x_m, box.y_m, HEIGHT_M + 1.0, 0.0)
    return {
        "pose": pose, "billboard": True, "font_size": 12.0, "scale_invariant": True, "color": _rgba((0.0, 0.0, 0.0, 1.0)), "text": box.name,
    }  # fmt: skip


def _line(points: Array, thickness_m: float, colour: Sequence[float]) -> dict[str, Any]:
    return {
        "type": 0, "pose": _pose(0.0, 0.0, 0.0, 0.0), "thickness": thickness_m, "scale_invariant": False,
        "points": [{"x": x, "y": y, "z": 0.05} for x, y in points.tolist()], "color": _rgba(colour), "colors": [], "indices": [],
    }  # fmt: skip


def _pose(x: float, y: float, z: float, yaw: float) -> dict[str, Any]:
    turn = {"x": 0.0, "y": 0.0, "z": math.sin(0.5 * yaw), "w": math.cos(0.5 * yaw)}
    return {"position": {"x": x, "y": y, "z": z}, "orientation": turn}


def _rgba(colour: Sequence[float]) -> dict[str, float]:
    return dict(zip("rgba", colour, strict=True))


def _time(time_ns: int) -> dict[str, int]:
    return {"sec": time_ns // _NS, "nsec": time_ns % _NS}
