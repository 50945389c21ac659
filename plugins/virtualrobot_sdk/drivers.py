"""What a robot driver is: the connection to one real robot (or a stand-in of it), with the same states for all.

    UNCONFIGURED --configure--> INACTIVE --activate--> ACTIVE --deactivate--> INACTIVE; ERROR from anywhere

After a fault a driver starts again from the measured state and never from the old target. The states follow those of
ros2_control's hardware components (hardware_interface_types_userdoc.rst).
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Protocol

from virtualrobot_sdk.kinematics import Floats


class DriverState(Enum):
    """Where a driver is in its life."""

    UNCONFIGURED = "UNCONFIGURED"
    """It knows nothing of a robot."""
    INACTIVE = "INACTIVE"
    """It is connected and reads; the robot does not follow."""
    ACTIVE = "ACTIVE"
    """The robot follows what is written."""
    ERROR = "ERROR"
    """The robot stands still or the connection is gone; `configure` begins anew."""


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """What a robot's controller says of its k joints, in the order that `configure` was given."""

    positions: Floats
    """(k,) in rad and m."""
    velocities: Floats
    """(k,) in rad/s and m/s."""
    seconds: float
    """The controller's own time (s), which grows from one reading to the next."""


class RobotDriver(Protocol):
    """The connection to one robot. One thread calls it; a call returns within its deadline.

    Every method may raise: the driver is in ERROR then.
    """

    @property
    def state(self) -> DriverState:
        """Return where the driver is in its life."""
        ...

    def configure(self, joint_names: tuple[str, ...], /) -> None:
        """Connect to the robot with these k joints: UNCONFIGURED or ERROR -> INACTIVE.

        Raises ArgumentError when the robot has other joints, and in another state.
        """
        ...

    def activate(self) -> None:
        """Let the robot follow, from where it is: INACTIVE -> ACTIVE."""
        ...

    def read(self) -> Measured:
        """Return what the robot measures now; INACTIVE or ACTIVE."""
        ...

    def write(self, positions: Floats, velocities: Floats, /) -> None:
        """Tell the robot where to be at the next tick, (k,) each in rad, m and their rates; ACTIVE."""
        ...

    def stop(self) -> None:
        """Bring the robot to rest as fast as it safely can and let go: ACTIVE -> INACTIVE; harmless in other states."""
        ...

    def deactivate(self) -> None:
        """Let the robot no longer follow, at rest: ACTIVE -> INACTIVE."""
        ...
