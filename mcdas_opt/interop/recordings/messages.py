"""Recordings of messages on topics (MCAP, rosbag2): their fields as tables, their CAN frames as a log.

A field is called by its topic and its path, `/radar.returns.range`; the elements of a list are rows of their own, which share what their
message says once. A message's time is that of its header where it has one, else when it was recorded.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import Counter, defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from mcdas_opt.interop.recordings.recording import TIME, CanLog, Frame, Row, Tally, no_such_channel, position

Document = Mapping[str, object]
_FRAME_TYPES = ("can_msgs/msg/Frame", "can_msgs/Frame")
_LOOKED_AT = 200  # messages of a topic at least, to know its fields: until each of its lists has had an element
_NS = 1_000_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Message:
    """One message, decoded to plain mappings, lists and numbers. `t_s` is its time."""

    topic: str
    t_s: float
    document: Document


@dataclass(frozen=True, slots=True, kw_only=True)
class Field:
    """Where a channel stands: its topic, the list that it is an element's field of (empty: none), and its name there."""

    topic: str
    of: str
    name: str

    @property
    def channel(self) -> str:
        return ".".join(part for part in (self.topic, self.of, self.name) if part)


class MessageRecording(ABC):
    """A file of messages. `path` is the file or folder."""

    _types: dict[str, str]  # of each topic

    def __init__(self, path: str | Path) -> None:
        self.path = path

    def types(self) -> Mapping[str, str]:
        """The type of every topic that can be decoded, as ROS or the schema calls it."""
        return self._types

    @abstractmethod
    def messages(self, topics: Collection[str]) -> Iterator[Message]:
        """Those of these topics by recorded time."""

    @cached_property
    def _fields(self) -> dict[str, Field]:
        topics = {topic for topic, kind in self.types().items() if kind not in _FRAME_TYPES}
        found: dict[str, Field] = {}
        looked, filled, empty = Counter[str](), set[tuple[str, str]](), defaultdict[str, set[tuple[str, str]]](set)
        for message in self.messages(tuple(topics)):
            topic = message.topic
            if topic not in topics:
                continue
            numbers, lists = flattened(message.document)
            fields = [Field(topic=topic, of="", name=name) for name in numbers]
            fields += [Field(topic=topic, of=of, name=name) for of, rows in lists.items() for row in rows for name in row]
            found |= {field.channel: field for field in fields}
            looked[topic] += 1
            filled |= {(topic, of) for of, rows in lists.items() if rows}
            empty[topic] = (empty[topic] | {(topic, of) for of in lists}) - filled
            if looked[topic] >= _LOOKED_AT and not empty[topic]:
                topics.remove(topic)
            if not topics:
                break
        return found

    @property
    def _buses(self) -> tuple[str, ...]:
        return tuple(sorted(topic for topic, kind in self.types().items() if kind in _FRAME_TYPES))

    @property
    def channels(self) -> tuple[str, ...]:
        """The fields that are numbers, and the topics of CAN frames."""
        return (*self._fields, *self._buses)

    def can_log(self) -> CanLog | None:
        """Frames on topics of type can_msgs/Frame; a topic is a bus."""
        if not self._buses:
            return None
        frames, other = [], 0
        for line, message in enumerate(self.messages(self._buses), start=1):
            frame = _frame(message, line)
            frames += [] if frame is None else [frame]
            other += frame is None
        return CanLog(frames=tuple(frames), other=other)

    def table(self, *names: str) -> MessageTable:
        """The fields that share a row with the first of these names that there is."""
        fields = self._fields
        if not fields:
            raise no_such_channel(self.path, names, self.channels)
        anchor = list(fields.values())[position(self.path, names, tuple(fields))]
        return MessageTable(self, anchor, tuple(f for f in fields.values() if f.topic == anchor.topic and f.of in ("", anchor.of)))


class MessageTable:
    """A row for every element of a list in the messages of a topic, or for every message."""

    def __init__(self, recording: MessageRecording, anchor: Field, fields: tuple[Field, ...]) -> None:
        self._recording, self._anchor, self._fields = recording, anchor, fields
        self.header = (*(field.channel for field in fields), TIME)

    def column(self, *names: str) -> int:
        return position(self._recording.path, names, self.header)

    def rows(self, columns: Sequence[int], bad: Tally) -> Iterator[Row]:
        """A message whose list is empty is a row without its fields: something was sent, and it saw nothing."""
        line = 0
        for message in self._recording.messages([self._anchor.topic]):
            numbers, lists = flattened(message.document)
            for element in (lists.get(self._anchor.of) or [{}]) if self._anchor.of else [{}]:
                line += 1
                known = [element.get(field.name, math.nan) if field.of else numbers.get(field.name, math.nan) for field in self._fields]
                values = [*known, message.t_s]
                yield Row(line=line, values=tuple(values[column] for column in columns))


def flattened(document: Document) -> tuple[dict[str, float], dict[str, list[dict[str, float]]]]:
    """The numbers of a message by their paths, and its lists of parts, each part's numbers in the same way."""
    numbers: dict[str, float] = {}
    lists: dict[str, list[dict[str, float]]] = {}
    for key, value in document.items():
        if isinstance(value, bool | int | float):
            numbers[key] = _as_float(value)
        elif isinstance(value, Mapping):
            inner, more = flattened(value)
            numbers |= {f"{key}.{name}": number for name, number in inner.items()}
            lists |= {f"{key}.{name}": rows for name, rows in more.items()}
        elif isinstance(value, list | tuple) and all(isinstance(part, Mapping) for part in value):
            lists[key] = [flattened(part)[0] for part in value]
    return numbers, lists


def _as_float(value: float) -> float:
    """An integer of hundreds of digits, as JSON may hold it, is infinite."""
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def time_of(document: Document, recorded_ns: int) -> float:
    """The time in a message's header [s], or when it was recorded where that is missing or zero."""
    header = document.get("header")
    stamp = header.get("stamp") if isinstance(header, Mapping) else None
    if isinstance(stamp, Mapping):
        parts = [stamp.get("sec"), stamp.get("nanosec", stamp.get("nsec"))]
        whole = [part for part in parts if isinstance(part, int) and not isinstance(part, bool)]
        if len(whole) == 2 and any(whole):
            return (whole[0] * _NS + whole[1]) / _NS
    return recorded_ns / _NS


def message_of(topic: str, recorded_ns: int, document: Document) -> Message:
    return Message(topic=topic, t_s=time_of(document, recorded_ns), document=document)


def _frame(message: Message, line: int) -> Frame | None:
    """None for a remote or an error frame, and for one that is none."""
    found = message.document
    identifier, data, length = found.get("id"), found.get("data"), found.get("dlc")
    if found.get("is_rtr") or found.get("is_error") or not isinstance(identifier, int) or not isinstance(data, list | tuple):
        return None
    used = data[: length if isinstance(length, int) else None]
    if len(used) > 8 or not all(isinstance(byte, int) and 0 <= byte < 256 for byte in used):
        return None
    return Frame(t_s=message.t_s, channel=message.topic, identifier=identifier & 0x1FFFFFFF, data=bytes(used), line=line)
