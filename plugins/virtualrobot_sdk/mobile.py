"""Interface of mobile kinematics: the motion of a craft's base by the commands of its drives."""

from __future__ import annotations

from typing import Protocol

from virtualrobot_sdk.kinematics import Floats


class MobileKinematics(Protocol):
    """The kinematics of one craft with m drives (wheels, steering angles, thrusters); poses are 4x4 in the world.

    The frame of the base has x forward, y to the left and z up. Calls depend on nothing but their arguments.
    """

    @property
    def drive_names(self) -> tuple[str, ...]:
        """Return the names of the m drives, in the order of all arrays."""
        ...

    def step(
        self, world_t_base: Floats, drive_states: Floats, commands: Floats, seconds: float, /
    ) -> tuple[Floats, Floats]:
        """Return where base (4, 4) and drives (m,) are after `seconds`, the drives told `commands` (m,).

        A drive's state is its angle (rad) or position (m), its command the speed of it (per s), which it has for the
        whole step; a drive that cannot follow (a steering angle at its stop) moves less. Two steps of half the time
        come to the same as one, but for the error of integration that the component documents. A craft that is shifted
        or turned about the vertical moves alike, and rests when all commands are 0. Raises ArgumentError for other
        shapes, for values that are not finite, for a pose that is not rigid and for a time that is not above 0.
        """
        ...
