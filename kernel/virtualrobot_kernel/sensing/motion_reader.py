"""The reader of motion sensors: which meter measures, and what all of them have in common."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from virtualrobot_kernel.sensing.encoders import EncoderMeter
from virtualrobot_kernel.sensing.force_torque import ForceTorqueMeter
from virtualrobot_kernel.sensing.imu import ImuMeter
from virtualrobot_kernel.sensing.motion_content import MotionContent
from virtualrobot_kernel.sensing.pose_meter import PoseMeter
from virtualrobot_kernel.sensing.reading import Moment
from virtualrobot_kernel.sensing.settings import DEFAULT_MOTION_RATE_HERTZ
from virtualrobot_kernel.world import sensing
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Node

DEADLINE_SECONDS = 1.0

LONGEST_PERIOD_SECONDS = 1.0
"""The past is kept no longer."""

TICKS_BACK = 2.5
"""Number of ticks of the past that are kept: two, and half a one for rounding."""


class Meter(Protocol):
    """Measures one kind of thing; used by one thread."""

    def read(self, moment: Moment) -> MotionContent:
        """Return what is told; raise KernelError where nothing can be."""
        ...


METERS: dict[type, Callable[[int, Any, int, float], Meter]] = {
    sensing.Imu: lambda uid, settings, seed, rate: ImuMeter(uid, settings, seed),
    sensing.Encoders: EncoderMeter,
    sensing.PoseSensor: lambda uid, settings, seed, rate: PoseMeter(uid, settings, seed),
    sensing.ForceTorqueSensor: lambda uid, settings, seed, rate: ForceTorqueMeter(uid, settings, seed),
}
"""Makes the meter of a sensor from its uid, its settings, its seed and its rate in hertz."""


class MotionReader:
    """Reads one motion sensor; used by one thread."""

    deadline_seconds = DEADLINE_SECONDS
    takes_turns = True

    def __init__(self, snapshot: Snapshot, node: Node) -> None:
        """Make the meter of a sensor's node."""
        assert isinstance(node.data, sensing.MotionSensor)
        rate = node.data.rate_hertz or DEFAULT_MOTION_RATE_HERTZ
        self.history_seconds = TICKS_BACK * snapshot.tick_seconds
        if isinstance(node.data.kind, sensing.Encoders):
            self.history_seconds = min(max(self.history_seconds, 1.0 / rate), LONGEST_PERIOD_SECONDS)
        self._meter = METERS[type(node.data.kind)](node.uid, node.data.kind, node.data.seed, rate)

    def read(self, moment: Moment, kinds: object | None = None) -> MotionContent:
        """Return what the sensor says; raises KernelError where it cannot."""
        return self._meter.read(moment)

    def close(self) -> None:
        """Nothing was started."""
