"""Simulation time as recordings count it: whole nanoseconds, from the tick."""

from __future__ import annotations

from google.protobuf.timestamp_pb2 import Timestamp

from virtualrobot.v1 import geometry_pb2


def nanoseconds(stamp: geometry_pb2.Stamp) -> int:
    """Return the simulation time of a stamp (ns)."""
    return stamp.tick * stamp.tick_nanoseconds


def time_of(stamp: geometry_pb2.Stamp) -> Timestamp:
    """Return the simulation time of a stamp as a message: seconds and nanoseconds since the world began."""
    seconds, nanos = divmod(nanoseconds(stamp), 1_000_000_000)
    return Timestamp(seconds=seconds, nanos=nanos)
