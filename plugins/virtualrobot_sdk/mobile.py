"""What mobile kinematics is: how a craft's base moves by what its drives are told."""

from __future__ import annotations

from typing import Protocol

from virtualrobot_sdk.kinematics import Floats


class MobileKinematics(Protocol):
    """The kinematics of one craft with m drives (wheels, steering angles, thrusters); poses are 4x4 in the world."""

    def step(
        self, world_t_base: Floats, drive_states: Floats, commands: Floats, seconds: float, /
    ) -> tuple[Floats, Floats]:
        """Return where base (4, 4) and drives (m,) are after `seconds`, the drives told `commands` (m,).

        A drive's state is its angle (rad) or position (m), its command the speed of it (per s). Two steps of half the
        time come to the same as one, but for the error of integration that the component documents. Raises
        ArgumentError for values that are not finite and for a time that is not positive.
        """
        ...
