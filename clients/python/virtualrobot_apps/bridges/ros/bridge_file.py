"""Files that say which streams are which topics, with the keys of ros_gz_bridge."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

from virtualrobot.errors import MalformedFileError
from virtualrobot.streams.table import IN, Stream

from virtualrobot_apps.bridges.ros.mapping.outputs import Output
from virtualrobot_apps.bridges.ros.messages.types import UnknownTypeError, known
from virtualrobot_apps.cell_io.yaml_file import Item, nearest, read_file

FIELDS = ("schema_version", "auto", "topics")
TOPIC_FIELDS = ("ros_topic_name", "ros_type_name", "stream", "direction", "lazy")
DIRECTIONS = {"OUT": "out", "IN": "in", "GZ_TO_ROS": "out", "ROS_TO_GZ": "in"}
"""Directions as the world has them; those of ros_gz_bridge are understood, too."""

TWISTS = ("geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped")


class Place(Protocol):
    """Place in a file."""

    @property
    def line(self) -> int:
        """Line of the file, from 1."""
        ...

    def error(self, text: str) -> MalformedFileError:
        """Return the error that says what is wrong there."""
        ...


@dataclass(frozen=True, eq=False)
class Entry:
    """A topic of a file.

    Attributes:
        topic: its name.
        type: its type; empty means the first one that the stream gives.
        stream: name of the stream.
        incoming: True where the world hears it.
        lazy: whether the stream is watched only while somebody reads the topic.
        place: where it stands.
    """

    topic: str
    type: str
    stream: str
    incoming: bool
    lazy: bool
    place: Place


@dataclass(frozen=True, eq=False)
class Choice:
    """Choice of streams that become topics: those of `entries`, and with `auto` all others by conventional names."""

    auto: bool = True
    entries: Sequence[Entry] = ()

    def check(self, streams: Iterable[Stream]) -> None:
        """Compare directions with the streams that there are.

        Raises:
            MalformedFileError: for a topic that goes where its stream doesn't, with its line.
        """
        named = {one.name: one for one in streams}
        for entry in self.entries:
            if (stream := named.get(entry.stream)) is None:
                continue
            if entry.incoming and stream.content != "twist":
                raise entry.place.error(f"of ROS the world hears /robots/NAME/command/twist, not {stream.name}")
            if not entry.incoming and stream.direction == IN:
                raise entry.place.error(f"the world hears {stream.name}: 'direction' is IN")

    def outputs(self, stream: Stream, outputs: Iterable[Output]) -> Iterator[Output]:
        """Yield the topics that come of a stream.

        Raises:
            MalformedFileError: for a type that the stream doesn't give, with its line.
        """
        outputs = list(outputs)
        entries = [one for one in self.entries if one.stream == stream.name and not one.incoming]
        for entry in entries:
            if not outputs:
                raise entry.place.error(f"nothing of ROS comes of the stream {stream.name}")
            found = [one for one in outputs if entry.type in ("", one.type)]
            if not found:
                types = ", ".join(dict.fromkeys(one.type for one in outputs))
                raise entry.place.error(f"the stream {stream.name} gives {types}, not {entry.type}")
            yield replace(found[0], topic=entry.topic, lazy=entry.lazy)
        taken = {entry.type or outputs[0].type for entry in entries}
        if self.auto:
            yield from (one for one in outputs if one.automatic and one.type not in taken)

    def heard(self, stream: Stream, name: str) -> str:
        """Return the topic by which the world hears a stream; empty where it doesn't."""
        entries = [one for one in self.entries if one.stream == stream.name and one.incoming]
        return entries[0].topic if entries else name if self.auto else ""

    def type_of(self, stream: str, type: str) -> str:
        """Return the type of what is heard: the file's, or else `type`."""
        return next((one.type for one in self.entries if one.stream == stream and one.incoming and one.type), type)

    def missing(self, streams: Sequence[str]) -> list[str]:
        """Return in words which streams of the file there are not, or not yet."""
        return [
            str(
                entry.place.error(
                    f"there is no stream {entry.stream!r} yet{nearest(entry.stream, streams)} it is waited for"
                )
            )
            for entry in self.entries
            if entry.stream not in streams
        ]


def read_choice(path: str | Path, *, auto: bool) -> Choice:
    """Return what a file chooses; `auto` counts where the file doesn't say it.

    Raises:
        MissingFileError, MalformedFileError: as `read_file`, and for fields and types that are not known.
    """
    fields = read_file(path).fields(FIELDS)
    entries = tuple(map(_entry, fields["topics"].items())) if "topics" in fields else ()
    seen: dict[str, Entry] = {}
    for entry in entries:
        if entry.topic in seen:
            raise entry.place.error(f"the topic {entry.topic} stands in line {seen[entry.topic].place.line} already")
        seen[entry.topic] = entry
    return Choice(fields["auto"].boolean() if "auto" in fields else auto, entries)


def _entry(item: Item) -> Entry:
    fields = item.fields(TOPIC_FIELDS, ("ros_topic_name", "stream"))
    topic = "/" + fields["ros_topic_name"].text().removeprefix("/")
    incoming = "direction" in fields and DIRECTIONS[fields["direction"].one_of([*DIRECTIONS])] == "in"
    type = ""
    if "ros_type_name" in fields:
        try:
            type = known(fields["ros_type_name"].text())
        except UnknownTypeError as error:
            raise fields["ros_type_name"].error(str(error)) from error
    if incoming and type and type not in TWISTS:
        raise fields["ros_type_name"].error(f"the world hears {' and '.join(TWISTS)}, not {type}")
    lazy = fields["lazy"].boolean() if "lazy" in fields else True
    return Entry(topic, type, fields["stream"].text(), incoming, lazy, item)
