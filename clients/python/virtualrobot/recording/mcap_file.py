"""MCAP files: messages by topic, in chunks, so that what a killed program has written can be read."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, BinaryIO

from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.message import Message
from mcap.writer import Writer

CHUNK_SECONDS = 1.0
"""Time (s) after which what was written is a chunk of its own: a killed program loses no more."""


@dataclass(frozen=True, slots=True)
class Schema:
    """Schema of messages that are bytes already.

    Attributes:
        name: name of their type.
        encoding: language of the definition, such as `ros2msg`.
        definition: text of it, with those of all that it holds.
        message_encoding: form of the messages, such as `cdr`.
    """

    name: str
    encoding: str
    definition: bytes
    message_encoding: str


class McapFile:
    """An MCAP file that is being written; each topic has the schema of its first message.

    Source of the format: Foxglove, MCAP Format Specification.
    """

    def __init__(self, stream: BinaryIO, about: Mapping[str, str], profile: str = "") -> None:
        """Begin a file in `stream`, which stays the caller's to close; `about` is kept as its metadata.

        `profile` is that of the format, such as `ros2`.
        """
        self._writer = Writer(stream)
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self.counts: Counter[str] = Counter()
        self._writer.start(profile, f"virtualrobot {about.get('version', '')}")
        self._writer.add_metadata("virtualrobot", dict(about))
        self._written_at = time.monotonic()

    def write(self, topic: str, message: Message, nanoseconds: int) -> None:
        """Add a message; its time is that of the simulation, for readers of either of a file's two times."""
        channel = self._channels.get(topic)
        if channel is None:
            schema = self._schema(message)
            channel = self._channels[topic] = self._writer.register_channel(topic, "protobuf", schema)
        self._add(channel, topic, message.SerializeToString(), nanoseconds)

    def write_encoded(self, topic: str, schema: Schema, data: bytes, nanoseconds: int) -> None:
        """Add a message that is bytes already; times as of `write`."""
        channel = self._channels.get(topic)
        if channel is None:
            if schema.name not in self._schemas:
                number = self._writer.register_schema(schema.name, schema.encoding, schema.definition)
                self._schemas[schema.name] = number
            number = self._schemas[schema.name]
            channel = self._channels[topic] = self._writer.register_channel(topic, schema.message_encoding, number)
        self._add(channel, topic, data, nanoseconds)

    def _add(self, channel: int, topic: str, data: bytes, nanoseconds: int) -> None:
        self.counts[topic] += 1
        self._writer.add_message(channel, nanoseconds, data, nanoseconds, self.counts[topic] & 0xFFFFFFFF)
        if time.monotonic() - self._written_at > CHUNK_SECONDS:
            self.flush()

    def flush(self) -> None:
        """Write all that was added as a chunk."""
        self._written_at = time.monotonic()
        self._writer.flush()

    def note(self, name: str, values: Mapping[str, str]) -> None:
        """Add metadata under a name."""
        self._writer.add_metadata(name, dict(values))

    def close(self) -> None:
        """Write the last chunk and the index."""
        self._writer.finish()

    def _schema(self, message: Message) -> int:
        name = message.DESCRIPTOR.full_name
        if name not in self._schemas:
            self._schemas[name] = self._writer.register_schema(name, "protobuf", schema_of(message))
        return self._schemas[name]


def schema_of(message: Message) -> bytes:
    """Return the schema of a message as MCAP wants it: its file and all that this names, dependencies first."""
    files: dict[str, Any] = {}

    def add(file: Any) -> None:  # noqa: ANN401 a FileDescriptor of either of protobuf's implementations
        if file.name not in files:
            for dependency in file.dependencies:
                add(dependency)
            files[file.name] = file

    add(message.DESCRIPTOR.file)
    schema = FileDescriptorSet()
    for file in files.values():
        file.CopyToProto(schema.file.add())
    return schema.SerializeToString()
