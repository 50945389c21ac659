"""Robots of one kernel by name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from virtualrobot._wire.arguments import checked
from virtualrobot._wire.services import Services
from virtualrobot._wire.showing import listed, table_html, told
from virtualrobot.robots.description import described
from virtualrobot.robots.robot import Robot
from virtualrobot.v1 import robot_pb2


@checked
class Robots(Mapping[str, Robot]):
    """The robots of one kernel by name; called, it returns them all.

    Example:
        >>> client.robots["iiwa"].move_to("home")
        >>> [robot.name for robot in client.robots()]
        ['iiwa', 'conveyor']
    """

    def __init__(self, services: Services) -> None:
        """Handle the robots of one kernel."""
        self._services = services

    def __call__(self) -> list[Robot]:
        """Return all robots."""
        return list(self.values())

    def __getitem__(self, name: str) -> Robot:
        """Return a robot; raises UnknownNameError, a KeyError that lists the right names, when there is none."""
        described(self._services, name)  # raises when there is none
        return Robot(self._services, name)

    def __iter__(self) -> Iterator[str]:
        """Yield the names."""
        return iter([robot.name for robot in self._states()])

    def __len__(self) -> int:
        """Return the count of robots."""
        return len(self._states())

    def _states(self) -> list[robot_pb2.RobotState]:
        return list(self._services.robot.GetRobotStates(robot_pb2.GetRobotStatesRequest()).robots)

    def _ipython_key_completions_(self) -> list[str]:
        """Return the names that IPython completes."""
        return list(self)

    def __repr__(self) -> str:
        """Return a line for people."""
        return told("Robots", lambda: listed(map(repr, self), "none yet"))

    def _repr_html_(self) -> str:
        """Return a table for notebooks."""
        rows = [
            [state.name, str(len(state.positions)), state.tool, ", ".join(state.motion_ids)] for state in self._states()
        ]
        return table_html("Robots", [["robot", "coordinates", "tool", "moved by"], *rows])
