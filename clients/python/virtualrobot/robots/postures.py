"""Postures of a robot with a name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Never

from virtualrobot._wire.arguments import checked
from virtualrobot._wire.names import unknown_name
from virtualrobot.errors import NameTakenError
from virtualrobot.robots.mechanism import JointPositions
from virtualrobot.robots.named_goals import names_target, postures_of
from virtualrobot.scene.editor import Direct

if TYPE_CHECKING:
    from virtualrobot.robots.robot import Robot


@checked
class Postures(Mapping[str, dict[str, float]]):
    """Postures of a robot by name, radians and meters by joint; `move_to` goes there. They are saved in scene files.

    Example:
        >>> arm.postures.add("home")                      # where it stands now
        >>> arm.postures.add("folded", [0, -1.5, 2.5, 0, 0, 0])
        >>> arm.move_to("home")
    """

    def __init__(self, robot: Robot) -> None:
        """Handle the postures of a robot; `Robot.postures` makes it."""
        self._robot = robot

    def __getitem__(self, name: str) -> dict[str, float]:
        """Return the joint values of a posture; raises UnknownNameError when the robot has none of this name."""
        postures = self._now()
        if name not in postures:
            raise unknown_name(f"no posture of {self._robot.name!r}", name, postures)
        return postures[name]

    def __iter__(self) -> Iterator[str]:
        """Yield the names."""
        return iter(self._now())

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self._now())

    def add(self, name: str, positions: JointPositions | None = None, *, replace: bool = False) -> None:
        """Give the robot a posture: joint values by name or in order, or its joints as they stand now.

        Without `positions` it has the joints of the robot's chain, or all where it has none: a gripper's fingers are
        left out, so that moving there does not open it. With `replace` it may take the place of another one.

        Raises:
            NameTakenError: when a posture of this robot, without `replace`, or a target has the name.
            UnknownNameError, LimitError: for a joint that there is not, or that cannot be there.
        """
        robot = self._robot
        if name in self._now() and not replace:
            raise NameTakenError(f"{robot.name!r} has a posture {name!r}; replace=True puts this one in its place")
        if names_target(robot._services, name):
            raise NameTakenError(f"{name!r} is a target, and a move there could mean both; choose another name")
        if positions is None:
            here = robot._joints_now()
            chosen = {joint: here[joint] for joint in robot.chain_joint_names or here}
        else:
            chosen = robot._named(positions)
        Direct(robot._services).set_postures(robot.name, {name: chosen})

    def remove(self, name: str) -> None:
        """Take a posture away; raises UnknownNameError when there is none of this name."""
        Direct(self._robot._services).set_postures(self._robot.name, removed=[name])

    def __setitem__(self, name: str, positions: object) -> Never:
        """Refuse: what was given would not say whether another one may be replaced."""
        raise TypeError(
            f"postures are given by add: postures.add({name!r}, positions), with replace=True for a new one"
        )

    def __delitem__(self, name: str) -> Never:
        """Refuse, as `__setitem__` does."""
        raise TypeError(f"postures are taken away by remove: postures.remove({name!r})")

    def _ipython_key_completions_(self) -> list[str]:
        """Return the names that IPython completes."""
        return list(self)

    def _now(self) -> dict[str, dict[str, float]]:
        return postures_of(self._robot._services, self._robot.name)

    def __repr__(self) -> str:
        """Return the names, for people."""
        return f"<Postures of {self._robot.name!r}: {', '.join(map(repr, self)) or 'none'}>"
