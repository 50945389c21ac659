"""Further motions of robots: curves through poses, and jogs, which are motions by hand."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Unpack

from numpy.typing import ArrayLike

from virtualrobot.motions import moves
from virtualrobot.motions.motion import GoingOptions, Motion
from virtualrobot.robots.mover import Mover
from virtualrobot.robots.redundancy import Lock, Prefer


class Jogger(Mover):
    """Splines and jogs of a robot; their options are those of `Mover`, but jogs don't wait for their end.

    A jog goes on until its distance, or until the robot can go no farther; cancel it when the key is released.
    """

    def move_spline(
        self,
        goals: Iterable[ArrayLike],
        *,
        reference: str | Sequence[str] = "",
        velocity: float = 0.0,
        acceleration: float = 0.0,
        speed_factor: float = 0.0,
        time_law: str = "",
        lock: Lock = (),
        prefer: Prefer = "",
        **options: Unpack[GoingOptions],
    ) -> Motion:
        """Move the tool centre point along a smooth curve through 4x4 poses; see `spline`.

        Example:
            >>> here = robot.tcp
            >>> robot.move_spline([here @ virtualrobot.pose(x=0.05 * k, y=0.02 * (-1) ** k) for k in range(1, 6)])
        """
        move = self.spline(
            goals,
            reference=reference,
            velocity=velocity,
            acceleration=acceleration,
            speed_factor=speed_factor,
            time_law=time_law,
            lock=lock,
            prefer=prefer,
        )
        return self.start(move, **options)

    def jog_joint(
        self,
        joint: str,
        velocity: float,
        distance: float | None = None,
        *,
        wait: bool = False,
        **options: Unpack[GoingOptions],
    ) -> Motion:
        """Move one joint at a velocity in rad/s or m/s, whose sign says which way, and return at once.

        It goes `distance` radians or meters; without one until the joint's limit, or a whole turn where it has none.

        Example:
            >>> motion = robot.jog_joint("lbr_iiwa_joint_1", -0.2)       # a key is pressed
            >>> motion.cancel()                                          # and released
        """
        return self.start(moves.joint_jog(self.name, joint, velocity, distance), wait=wait, **options)

    def jog(
        self,
        translation: ArrayLike | None = None,
        *,
        rotation: ArrayLike | None = None,
        frame: str = "",
        node: str = "",
        velocity: float = 0.0,
        distance: float | None = None,
        lock: Lock = (),
        prefer: Prefer = "",
        wait: bool = False,
        **options: Unpack[GoingOptions],
    ) -> Motion:
        """Move the tool centre point along `translation`, or turn it about the axis `rotation`, and return at once.

        The direction, of any length, is in the axes of `frame`: the robot's `base` (the default), the `tool` or the
        `world`; or in those of `node`. `velocity` in m/s or rad/s; 0 means 0.1 m/s or 0.25 rad/s. It goes `distance`
        meters or radians; without one as far as the arm can go, at most 2 m or a whole turn.

        Example:
            >>> motion = robot.jog([0, 0, 1], frame="tool", velocity=0.05)
            >>> motion.cancel()
            >>> robot.jog(rotation=[0, 0, 1], node="table", distance=0.5, wait=True)
        """
        move = moves.cartesian_jog(
            self.name,
            translation=translation,
            rotation=rotation,
            frame=frame,
            node=node,
            velocity=velocity,
            distance=distance,
        )
        return self.start(self._wished(move, lock, prefer), wait=wait, **options)
