"""Changes of a tool's state as moves of its joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, NamedTuple

from virtualrobot_kernel.errors import UnknownNameError
from virtualrobot_kernel.motion.bounds import TimeLaw
from virtualrobot_kernel.planning.moves.move import Move
from virtualrobot_kernel.planning.moves.point_to_point import move_to_joints
from virtualrobot_kernel.planning.planned_move import PlannedMove
from virtualrobot_kernel.planning.redundancy import NearOf
from virtualrobot_kernel.planning.robots import SolverOf, arm_of
from virtualrobot_kernel.world.apply_robots import tool_state
from virtualrobot_kernel.world.groups import WHOLE
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Node
from virtualrobot_kernel.world.tcp import chosen_tcp
from virtualrobot_kernel.world.widths import positions_at, state_at


class _Goal(NamedTuple):
    """Goal of a tool: its owner, itself, where its joints go, and the state that it is in then (empty: as before)."""

    owner: Node
    tool: Node
    positions: dict[str, float]
    state: str


@dataclass(frozen=True, slots=True, eq=False)
class ToolStateMove(Move):
    """Move of a tool's joints (empty: the chosen one, or the group's) to where a state or a width (m) has them."""

    tool: str
    state: str = ""
    width: float | None = None
    speed_factor: float = 1.0
    time_law: TimeLaw = TimeLaw.JERK_LIMITED

    other_joints: ClassVar[bool] = True
    not_joined: ClassVar[str] = "a tool changes its state while it stands still"

    def owner(self, snapshot: Snapshot) -> Node:
        """Return the robot that the tool's joints are of."""
        return self._goal(snapshot).owner

    def joint_names(self, snapshot: Snapshot) -> Sequence[str]:
        """Return the joints of the state or width; none for a state without joints, such as that of a vacuum."""
        return tuple(self._goal(snapshot).positions)

    def tool_states(self, snapshot: Snapshot) -> tuple[tuple[str, str], ...]:
        """Return the tool and its state, or no name for a width."""
        return ((self._goal(snapshot).tool.name, self.state),)

    def plan(self, snapshot: Snapshot, solver_of: SolverOf, near_of: NearOf | None = None) -> PlannedMove:
        """Return its plan; a state without joints is there with the next tick."""
        goal = self._goal(snapshot)
        planned = move_to_joints(snapshot, goal.owner, goal.positions, self.speed_factor, self.time_law)
        return replace(planned, tool_states=((goal.tool.name, goal.state),) if goal.state else ())

    def _goal(self, snapshot: Snapshot) -> _Goal:
        structure, node = snapshot.structure, self.node(snapshot)
        tip = 0 if self.group == WHOLE else arm_of(snapshot, node, self.group).tip
        chosen, _ = chosen_tcp(structure, snapshot.state, node, tip)
        name = self.tool or (chosen.name if chosen else "")
        tools = {tool.name: tool for tool in structure.tools_of(node.uid)}
        if name not in tools:
            raise UnknownNameError(f"tool of {node.name!r}", name, tools)
        tool = tools[name]
        owner = structure.robot_of(tool.uid)
        assert owner is not None
        if self.width is None:
            return _Goal(owner, tool, tool_state(structure, name, self.state)[1], self.state)
        positions = positions_at(tool, self.width)
        return _Goal(owner, tool, positions, state_at(tool, positions))
