"""Interface of a robot driver: the connection to one real robot (or a stand-in of it), with the same states for all.

    UNCONFIGURED --configure--> INACTIVE --activate--> ACTIVE --deactivate--> INACTIVE --cleanup--> UNCONFIGURED

ERROR comes from anywhere, and `configure` or `cleanup` lead out of it. A call that is not allowed in a state, or has a
wrong argument, is refused by an ArgumentError and changes nothing; `TRANSITIONS` says which are allowed. Anything else
that a call raises means that the driver is in ERROR. After that it starts again from the measured state and never from
the old target. The states follow those of ros2_control's hardware components (hardware_interface_types_userdoc.rst).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType
from typing import Protocol

from virtualrobot_sdk.kinematics import Floats


class DriverState(Enum):
    """State of a driver in its life cycle."""

    UNCONFIGURED = "UNCONFIGURED"
    """It knows nothing of a robot."""
    INACTIVE = "INACTIVE"
    """It is connected and reads; the robot does not follow."""
    ACTIVE = "ACTIVE"
    """The robot follows what is written."""
    ERROR = "ERROR"
    """The robot stands still or the connection is gone; `configure` begins anew."""


TRANSITIONS: Mapping[DriverState, Mapping[str, DriverState]] = MappingProxyType(
    {
        DriverState.UNCONFIGURED: {
            "configure": DriverState.INACTIVE,
            "stop": DriverState.UNCONFIGURED,
            "cleanup": DriverState.UNCONFIGURED,
        },
        DriverState.INACTIVE: {
            "activate": DriverState.ACTIVE,
            "read": DriverState.INACTIVE,
            "stop": DriverState.INACTIVE,
            "cleanup": DriverState.UNCONFIGURED,
        },
        DriverState.ACTIVE: {
            "read": DriverState.ACTIVE,
            "write": DriverState.ACTIVE,
            "stop": DriverState.INACTIVE,
            "deactivate": DriverState.INACTIVE,
        },
        DriverState.ERROR: {
            "configure": DriverState.INACTIVE,
            "stop": DriverState.ERROR,
            "cleanup": DriverState.UNCONFIGURED,
        },
    }
)
"""State that each call leads to from each state, where it is allowed; any other is refused."""


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """Measured state of a robot's k joints from its controller, in the order that `configure` was given."""

    positions: Floats
    """(k,) in rad and m."""
    velocities: Floats
    """(k,) in rad/s and m/s."""
    seconds: float
    """The controller's own time (s): it never falls, and grows with each of the controller's cycles."""


class RobotDriver(Protocol):
    """The connection to one robot, in UNCONFIGURED when it is made. One thread calls it, each call with a deadline."""

    @property
    def state(self) -> DriverState:
        """Return where the driver is in its life."""
        ...

    def configure(self, joint_names: tuple[str, ...], /) -> None:
        """Connect to the robot with these k joints, in this order in all arrays: UNCONFIGURED or ERROR -> INACTIVE.

        Raises ArgumentError when the robot has other joints.
        """
        ...

    def activate(self) -> None:
        """Let the robot follow, and hold it where it is until something is written: INACTIVE -> ACTIVE."""
        ...

    def read(self) -> Measured:
        """Return what the robot measures now; INACTIVE or ACTIVE."""
        ...

    def write(self, positions: Floats, velocities: Floats, /) -> None:
        """Tell the robot where to be at the next tick, (k,) each in rad, m and their rates; ACTIVE.

        Raises ArgumentError for another shape, for values that are not finite and where the robot cannot be.
        """
        ...

    def stop(self) -> None:
        """Bring the robot to rest as fast as it safely can and let go: ACTIVE -> INACTIVE; harmless in other states."""
        ...

    def deactivate(self) -> None:
        """Let the robot no longer follow, at rest: ACTIVE -> INACTIVE."""
        ...

    def cleanup(self) -> None:
        """Give the connection back: INACTIVE or ERROR -> UNCONFIGURED; harmless in UNCONFIGURED."""
        ...
