"""Bags of ROS 2 (a folder with metadata.yaml; SQLite or MCAP inside) by rosbags, without ROS.

The types that drives are recorded with, and messages as plain documents.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mcdas_opt.errors import of_extra
from mcdas_opt.interop.recordings.messages import Message, MessageRecording, message_of
from mcdas_opt.interop.recordings.recording import FOLDER, check_regular, understood

if TYPE_CHECKING:
    from rosbags.highlevel import AnyReader
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
    with of_extra("rosbags", "ros"):
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore
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


class Rosbag2Recording(MessageRecording):
    """A bag: its folder, or the .db3 in it. A topic whose type neither the bag nor we define is passed over.

    Raises `InputError` for another folder, `MissingExtraError` without rosbags.
    """

    suffixes = (FOLDER, ".db3")

    def __init__(self, path: str | Path) -> None:
        super().__init__(path)
        check_regular(self._folder)
        with self._open() as reader:
            known = reader.typestore.fielddefs
            self._types = {one.topic: str(one.msgtype) for one in reader.connections if one.msgtype in known}

    @property
    def _folder(self) -> Path:
        path = Path(self.path)
        return path if path.is_dir() else path.parent

    def messages(self, topics: Collection[str]) -> Iterator[Message]:
        if not topics:
            return
        with self._open() as reader:
            found = reader.messages([one for one in reader.connections if one.topic in topics])
            yield from (message_of(one.topic, t_ns, document_of(reader.deserialize(data, one.msgtype))) for one, t_ns, data in found)

    @contextmanager
    def _open(self) -> Iterator[AnyReader]:
        store = type_store()
        with of_extra("rosbags", "ros"):
            from rosbags.highlevel import AnyReader
        with understood(self.path, "a bag of ROS 2"), AnyReader([self._folder], default_typestore=store) as reader:
            yield reader
