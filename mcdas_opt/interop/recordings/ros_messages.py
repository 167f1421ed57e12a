"""ROS 2 messages by rosbags: the types that drives are recorded with, and messages as plain documents."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING

import numpy as np

from mcdas_opt.errors import MissingExtraError

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

_LONGEST = 64  # numbers of an array; longer ones are pictures and point clouds
_DEFINITIONS = {
    "can_msgs/msg/Frame": "std_msgs/Header header\nuint32 id\nbool is_rtr\nbool is_extended\nbool is_error\nuint8 dlc\nuint8[8] data",
    "radar_msgs/msg/RadarReturn": "float32 range\nfloat32 azimuth\nfloat32 elevation\nfloat32 doppler_velocity\nfloat32 amplitude",
    "radar_msgs/msg/RadarScan": "std_msgs/Header header\nradar_msgs/RadarReturn[] returns",
}
"""Types that ROS 2 itself does not have, for bags that do not bring their definitions."""


def type_store(brought: Mapping[str, str] | None = None) -> Typestore:
    """ROS 2's types, those above, and those that a file brings as `{type: definition}`. Raises `MissingExtraError` without rosbags."""
    try:
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore
    except ImportError:
        raise MissingExtraError("rosbags", "ros") from None
    store = get_typestore(Stores.ROS2_HUMBLE)
    for name, definition in {**_DEFINITIONS, **(brought or {})}.items():
        store.register({kind: found for kind, found in get_types_from_msg(definition, name).items() if kind not in store.fielddefs})
    return store


def document_of(message: object) -> dict[str, object]:
    """A message's fields as plain mappings, lists and numbers; long arrays are left out."""
    assert is_dataclass(message)
    return {field.name: _plain(message.__dict__[field.name]) for field in fields(message)}


def _plain(value: object) -> object:
    if is_dataclass(value):
        return document_of(value)
    if isinstance(value, np.ndarray):
        return value.tolist() if value.size <= _LONGEST else None
    if isinstance(value, list | tuple):
        return [_plain(part) for part in value]
    return value
