"""Interface of mobile kinematics: the motion of a craft's base by the commands of its drives, and back."""

from __future__ import annotations

from typing import Protocol

from virtualrobot_sdk.kinematics import Floats


class MobileKinematics(Protocol):
    """The kinematics of one craft with m drives (wheels, steering angles, thrusters); poses are 4x4 in the world.

    The frame of the base has x forward, y to the left and z up. Its twist is (vx, vy, omega): the velocity of its
    origin along its own x and y (m/s), and its turning to the left (rad/s). Calls depend on nothing but their
    arguments. All raise ArgumentError for other shapes, for values that are not finite and for a time that is not above
    0.
    """

    @property
    def drive_names(self) -> tuple[str, ...]:
        """Return the names of the m drives, in the order of all arrays."""
        ...

    @property
    def passive_names(self) -> tuple[str, ...]:
        """Return the names of the p passive wheels and steering angles, which turn as the craft rolls; may be none."""
        ...

    def step(
        self, world_t_base: Floats, drive_states: Floats, commands: Floats, seconds: float, /
    ) -> tuple[Floats, Floats]:
        """Return where base (4, 4) and drives (m,) are after `seconds`, the drives told `commands` (m,).

        A drive's state is its angle (rad) or position (m), its command the speed of it (per s), which it has for the
        whole step; a drive that cannot follow (a steering angle at its stop) moves less. Two steps of half the time
        come to the same as one, but for the error of integration that the component documents. A craft that is shifted
        or turned about the vertical moves alike, and rests when all commands are 0. Raises ArgumentError for a pose
        that is not rigid.
        """
        ...

    def passive_states(
        self, passive_states: Floats, drive_states: Floats, commands: Floats, seconds: float, /
    ) -> Floats:
        """Return where passive wheels and steering angles (p,) are after the step that `step` makes of the rest."""
        ...

    def base_twist(self, drive_states: Floats, commands: Floats, /) -> Floats:
        """Return the twist of the base (3,) at the begin of a step."""
        ...

    def drive_commands(self, twist: Floats, drive_states: Floats, seconds: float, /) -> Floats:
        """Return the commands (m,) by which the base gets a twist (3,), for a step of `seconds`.

        Where a steering angle has to turn first, its command leads there within `seconds`, or as fast as it may. Raises
        ArgumentError for a twist that the craft never has, such as one to the side on two driven wheels.
        """
        ...
