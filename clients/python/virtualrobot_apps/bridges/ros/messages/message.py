"""A message of ROS with its encodings: each is made once, and only when somebody wants it."""

from __future__ import annotations

from functools import cached_property
from typing import Any

from virtualrobot_apps.bridges.ros.messages.cbor import cbor_parts
from virtualrobot_apps.bridges.ros.messages.json_text import to_json
from virtualrobot_apps.bridges.ros.messages.types import STORE


class Message:
    """A message of ROS and what transports send of it; all of them share one.

    Attributes:
        type: its type, such as `sensor_msgs/msg/JointState`.
        value: the message.
        time: simulation time at which it was told (ns).
    """

    def __init__(self, type: str, value: object, time: int = 0) -> None:
        """Hold a message; nothing is encoded yet."""
        self.type, self.value, self.time = type, value, time

    @classmethod
    def from_cdr(cls, type: str, cdr: bytes) -> Message:
        """Return the message of these bytes; raises whatever rosbags does for those that are none."""
        message = cls(type, STORE.deserialize_cdr(cdr, type))
        message.__dict__["cdr"] = bytes(cdr)
        return message

    @cached_property
    def cdr(self) -> bytes:
        """Its bytes as ROS 2 has them: DDS, zenoh, MCAP, Foxglove and `cbor-raw`."""
        return bytes(STORE.serialize_cdr(self.value, self.type))

    @cached_property
    def ros1(self) -> bytes:
        """Its bytes as ROS 1 has them."""
        from virtualrobot_apps.bridges.ros.messages.ros1 import ros1_bytes  # its types take a while to make

        return ros1_bytes(self.type, self.value, self.__dict__.get("cdr"))

    @cached_property
    def json(self) -> str:
        """Its text in JSON."""
        return to_json(self.value)

    @cached_property
    def json_with_infinity(self) -> str:
        """Its text in JSON with `Infinity` and `NaN`, as Python writes them and reads them."""
        return to_json(self.value, null=False)

    @cached_property
    def cbor_parts(self) -> list[Any]:
        """Its bytes in CBOR, with typed arrays: parts, since what is large is copied where they are joined."""
        return cbor_parts(self.value)

    @property
    def size(self) -> int:
        """Bytes that it has in CDR."""
        return len(self.cdr)
