"""Streams of setpoints, as a client without the library sends them."""

from __future__ import annotations

import queue
from collections.abc import Iterator, Sequence
from typing import Any

from virtualrobot.v1 import motion_pb2

from tests.kernels import Stubs

POSITION, VELOCITY = motion_pb2.SETPOINT_MODE_POSITION, motion_pb2.SETPOINT_MODE_VELOCITY
FIRST, SECOND = "lbr_iiwa_joint_1", "lbr_iiwa_joint_2"


class Sender:
    """A stream whose setpoints a test sends one by one."""

    def __init__(
        self,
        stubs: Stubs,
        robot: str = "arm",
        joints: Sequence[str] = (FIRST,),
        mode: motion_pb2.SetpointMode = VELOCITY,
        metadata: Sequence[tuple[str, str]] = (),
        **target: Any,  # noqa: ANN401 fields of the target
    ) -> None:
        """Begin, and wait until the motion runs."""
        self._waiting: queue.SimpleQueue[motion_pb2.StreamSetpointsRequest | None] = queue.SimpleQueue()
        wanted = motion_pb2.SetpointTarget(robot=robot, joint_names=joints, mode=mode, **target)
        self._waiting.put(motion_pb2.StreamSetpointsRequest(target=wanted))
        self.call: Any = stubs.motion.StreamSetpoints(self._requests(), metadata=metadata, timeout=60)
        self.told: motion_pb2.StreamSetpointsResponse = next(self.call)
        self.id = self.told.motion.id
        self._sent = 0

    def send(self, *values: float) -> None:
        """Send a setpoint."""
        self._waiting.put(motion_pb2.StreamSetpointsRequest(values=values))
        self._sent += 1

    def give(self, *values: float) -> motion_pb2.StreamSetpointsResponse:
        """Send a setpoint and wait until the motion has it; raise what the call raises."""
        self.send(*values)
        while self.told.setpoint_count < self._sent:
            self.told = next(self.call)
        return self.told

    def end(self) -> None:
        """End this side of the stream."""
        self._waiting.put(None)

    def rest(self) -> motion_pb2.StreamSetpointsResponse:
        """Read to the end and return the last message; raise what the call raises."""
        for told in self.call:
            self.told = told
        return self.told

    def _requests(self) -> Iterator[motion_pb2.StreamSetpointsRequest]:
        while (request := self._waiting.get()) is not None:
            yield request
