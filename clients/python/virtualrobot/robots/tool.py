"""Tools: their states, such as open and closed, and the points that motions refer to."""

from __future__ import annotations

from typing import Unpack

from google.protobuf.field_mask_pb2 import FieldMask

from virtualrobot._wire.arguments import checked
from virtualrobot._wire.messages import pose_of
from virtualrobot._wire.services import Services
from virtualrobot.errors import UnknownNameError, WrongStateError
from virtualrobot.geometry import Matrix
from virtualrobot.motions import motion
from virtualrobot.motions.moves import Move
from virtualrobot.robots.description import described
from virtualrobot.scene.editor import Direct
from virtualrobot.v1 import motion_pb2, nodes_pb2, robot_pb2, scene_pb2


@checked
class Tool:
    """A tool of a robot by its name."""

    def __init__(self, services: Services, robot: str, name: str) -> None:
        """Handle the tool `name` of the robot `robot`."""
        self._services = services
        self.robot = robot
        self.name = name

    @staticmethod
    def of(services: Services, robot: str, name: str | None = None) -> Tool:
        """Return the tool of this name, or of this gripper; without a name the chosen one, or the only one.

        Raises:
            UnknownNameError: when the robot has no such tool.
            WrongStateError: when no name is given and none is chosen.
        """
        tools = list(described(services, robot).tools)
        has = f"its tools are {', '.join(map(repr, tools))}" if tools else "it has none"
        if name and name not in tools and len(own := [tool for tool in tools if tool.startswith(f"{name}.")]) == 1:
            name = own[0]
        if name and name not in tools:
            raise UnknownNameError(
                f"the robot {robot!r} has no tool named {name!r}; {has}", metadata={"valid": "\n".join(tools)}
            )
        if not name:
            name = _state(services, robot).tool or (tools[0] if len(tools) == 1 else "")
            if not name:
                raise WrongStateError(f"no tool of the robot {robot!r} is chosen; {has}")
        return Tool(services, robot, name)

    @property
    def state(self) -> str:
        """The state that it is in."""
        return _state(self._services, self.robot).tool_states[self.name]

    @property
    def states(self) -> dict[str, dict[str, float]]:
        """States that it can be told to take: the joint positions of each, radians or meters."""
        return {state.name: dict(state.joint_positions) for state in self._message.states}

    @property
    def widths(self) -> dict[float, dict[str, float]]:
        """Joint positions (rad or m) by how wide it is open (m), rising; empty for a tool that does not open."""
        return {one.width_meters: dict(one.joint_positions) for one in self._message.widths}

    @property
    def width(self) -> float:
        """Distance between its fingers now, in meters.

        Raises:
            WrongStateError: when it has no widths.
        """
        widths = _state(self._services, self.robot).tool_widths
        if self.name not in widths:
            raise WrongStateError(f"the tool {self.name!r} has no widths")
        return widths[self.name]

    @property
    def tool_center_points(self) -> dict[str, Matrix]:
        """`tool_t_tcp`, 4x4, by name."""
        return {point.name: pose_of(point.tool_t_tcp) for point in self._message.tool_center_points}

    def set(self, state: str, **options: Unpack[motion.StartOptions]) -> motion.Motion:
        """Move its joints to where a state has them; then it is in that state."""
        return motion.start(self._services, [self.state_move(state)], **options)

    def open(self, **options: Unpack[motion.StartOptions]) -> motion.Motion:
        """Move to the state `open`."""
        return self.set("open", **options)

    def close(self, **options: Unpack[motion.StartOptions]) -> motion.Motion:
        """Move to the state `closed`."""
        return self.set("closed", **options)

    def state_move(self, state: str) -> Move:
        """Return the move to a state, for `Client.move_together`."""
        return Move(motion_pb2.Move(robot=self.robot, tool_state=motion_pb2.ToolStateMove(tool=self.name, state=state)))

    def move_to_width(self, width: float, **options: Unpack[motion.StartOptions]) -> motion.Motion:
        """Open or close its fingers to a distance (m), between the least and greatest of `widths`.

        Its state is then that of this width, if one is, and otherwise what it was.

        Raises:
            LimitError: when it cannot be so wide.
            InvalidArgumentError: when it has no widths.

        Example:
            >>> arm.tool().move_to_width(0.03).wait()
        """
        return motion.start(self._services, [self.width_move(width)], **options)

    def width_move(self, width: float) -> Move:
        """Return the move to a width (m), for `Client.move_together`."""
        goal = motion_pb2.ToolStateMove(tool=self.name, width_meters=width)
        return Move(motion_pb2.Move(robot=self.robot, tool_state=goal))

    def select(self, tool_center_point: str | None = None) -> Tool:
        """Let the robot work with this tool and this point of it (by default its first); return the tool."""
        Direct(self._services).select_tool(self.robot, self.name, tool_center_point)
        return self

    @property
    def _message(self) -> nodes_pb2.Tool:
        request = scene_pb2.GetSceneRequest(names=[self.name], read_mask=FieldMask(paths=["name", "tool"]))
        read = self._services.descriptions.get(("tool", self.name), lambda: self._services.scene.GetScene(request))
        return read.nodes[0].tool

    def __repr__(self) -> str:
        """Return a line for people."""
        return f"<Tool {self.name!r} of {self.robot!r}>"


def _state(services: Services, robot: str) -> robot_pb2.RobotState:
    return services.robot.GetRobotStates(robot_pb2.GetRobotStatesRequest(names=[robot])).robots[0]
