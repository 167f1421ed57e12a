"""MCAP files by mcap: messages as JSON, or as ROS 2 writes them (with rosbags)."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from mcdas_opt.errors import InputError, of_extra
from mcdas_opt.interop.recordings.messages import Document, Message, MessageRecording, message_of
from mcdas_opt.interop.recordings.recording import check_regular, understood
from mcdas_opt.interop.recordings.rosbag2 import document_of, type_store

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

Decoder = Callable[[bytes], Document]


LARGEST_CHUNK = 100_000_000  # bytes; writers make chunks of some megabytes


class McapRecording(MessageRecording):
    """An MCAP file. Topics in other encodings than JSON and ROS 2's (`cdr` with `ros2msg`) are passed over.

    Raises `InputError` for another file, `MissingExtraError` without mcap, and without rosbags where a topic is ROS 2's.
    """

    suffixes = (".mcap",)

    def __init__(self, path: str | Path) -> None:
        super().__init__(path)
        check_regular(path)
        with of_extra("mcap", "mcap"):
            from mcap.reader import make_reader
        with understood(path, "MCAP"), Path(path).open("rb") as file:
            summary = make_reader(file).get_summary()
        if summary is None:
            raise InputError(path, "", None, "is cut short: it has no summary at its end (`mcap recover` mends that)")
        unpacked = [chunk.uncompressed_size for chunk in summary.chunk_indexes]
        if max(unpacked, default=0) > LARGEST_CHUNK:
            raise InputError(path, "chunk", max(unpacked), f"must be at most {LARGEST_CHUNK} bytes, unpacked")
        self._types = {}
        self._decoders: dict[str, Decoder] = {}
        ros: dict[str, tuple[str, str]] = {}
        for channel in summary.channels.values():
            schema = summary.schemas.get(channel.schema_id)
            name = "" if schema is None else str(schema.name)
            if channel.message_encoding == "json":
                self._types[channel.topic], self._decoders[channel.topic] = name, _json
            elif channel.message_encoding == "cdr" and schema is not None and schema.encoding == "ros2msg":
                ros[channel.topic] = (name, schema.data.decode("utf-8", errors="replace"))
        if ros:
            with understood(path, "ROS 2 messages"):
                store = type_store(dict(ros.values()))
            for topic, (name, _) in ros.items():
                self._types[topic] = name
                self._decoders[topic] = partial(_cdr, store, name)

    def messages(self, topics: Collection[str]) -> Iterator[Message]:
        if not topics:
            return
        from mcap.reader import make_reader

        with understood(self.path, "MCAP"), Path(self.path).open("rb") as file:
            found = make_reader(file).iter_messages(topics=list(topics))
            yield from (message_of(at.topic, one.log_time, self._decoders[at.topic](one.data)) for _, at, one in found)


def _cdr(store: Typestore, name: str, data: bytes) -> Document:
    return document_of(store.deserialize_cdr(data, name))


def _json(data: bytes) -> Document:
    found = json.loads(data)
    return found if isinstance(found, dict) else {}
