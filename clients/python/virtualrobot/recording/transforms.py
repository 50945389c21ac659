"""The tree of nodes as transforms: those that move in one message, the rest in another.

Both are whole each time they are written, so that a reader that begins anywhere in a file knows where all is from the
last message of each.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from google.protobuf.timestamp_pb2 import Timestamp
from numpy.typing import NDArray

from virtualrobot.recording.frames import FrameGroup, Frames
from virtualrobot.v1 import scene_pb2


class Transforms:
    """The frames of a scene that is watched, as messages."""

    def __init__(self) -> None:
        """Begin with no frame."""
        self._frames = Frames()
        self._messages: dict[str, _Message] = {}

    def update(self, change: scene_pb2.WatchSceneResponse, time: Timestamp) -> Iterator[tuple[str, FrameTransforms]]:
        """Take a change of the scene; yield the messages that tell it by their topics, true until the next change."""
        for group in self._frames.update(change):
            message = self._messages.get(group.topic)
            if message is None or message.group is not group:
                message = self._messages[group.topic] = _Message(group)
            yield group.topic, message.at(self._frames.poses(group), time)


class _Message:
    """Message of some frames that is filled again and again: making it anew would cost several times as much."""

    def __init__(self, group: FrameGroup) -> None:
        self.group = group
        self._message = FrameTransforms()
        self._parts = []
        for child, parent in zip(group.children, group.parents, strict=True):
            one = self._message.transforms.add(parent_frame_id=parent, child_frame_id=child)
            self._parts.append((one.timestamp, one.translation, one.rotation))

    def at(self, poses: NDArray[np.float64], time: Timestamp) -> FrameTransforms:
        """Return the message with these poses (n, 7)."""
        seconds, nanos = time.seconds, time.nanos
        for (stamp, position, turn), values in zip(self._parts, poses.tolist(), strict=True):
            stamp.seconds, stamp.nanos = seconds, nanos
            position.x, position.y, position.z, turn.x, turn.y, turn.z, turn.w = values
        return self._message
