"""Bags of ROS 2 (a folder with metadata.yaml; SQLite or MCAP inside) by rosbags, without ROS."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from mcdas_opt.errors import MissingExtraError
from mcdas_opt.interop.recordings.messages import Message, MessageRecording, counted, time_of
from mcdas_opt.interop.recordings.recording import FOLDER, understood
from mcdas_opt.interop.recordings.ros_messages import document_of, type_store

if TYPE_CHECKING:
    from rosbags.highlevel import AnyReader


class Rosbag2Recording(MessageRecording):
    """A bag: its folder, or the .db3 in it. A topic whose type neither the bag nor we define is passed over.

    Raises `InputError` for another folder, `MissingExtraError` without rosbags.
    """

    suffixes = (FOLDER, ".db3")

    def __init__(self, path: str | Path) -> None:
        super().__init__(path)
        with self._open() as reader:
            known = reader.typestore.fielddefs
            self._types = {one.topic: str(one.msgtype) for one in reader.connections if one.msgtype in known}

    def types(self) -> Mapping[str, str]:
        return self._types

    def messages(self, topics: Collection[str], at_most: int | None = None) -> Iterator[Message]:
        if not topics:
            return
        with self._open() as reader:
            found = reader.messages([one for one in reader.connections if one.topic in topics])
            yield from counted((_message(one.topic, t_ns, reader.deserialize(data, one.msgtype)) for one, t_ns, data in found), at_most)

    @contextmanager
    def _open(self) -> Iterator[AnyReader]:
        store = type_store()
        try:
            from rosbags.highlevel import AnyReader
        except ImportError:
            raise MissingExtraError("rosbags", "ros") from None
        path = Path(self.path)
        with understood(path, "a bag of ROS 2"), AnyReader([path.parent if path.is_file() else path], default_typestore=store) as reader:
            yield reader


def _message(topic: str, recorded_ns: int, message: object) -> Message:
    document = document_of(message)
    return Message(topic=topic, t_s=time_of(document, recorded_ns), document=document)
