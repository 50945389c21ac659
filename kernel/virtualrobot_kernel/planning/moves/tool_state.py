"""Changes of a tool's state as moves of its joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

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
from virtualrobot_kernel.world.tcp import chosen_tcp


@dataclass(frozen=True, slots=True, eq=False)
class ToolStateMove(Move):
    """Move of a tool's joints (empty: the chosen one, or the group's) to where one of its states has them."""

    tool: str
    state: str
    speed_factor: float = 1.0
    time_law: TimeLaw = TimeLaw.JERK_LIMITED

    other_joints: ClassVar[bool] = True
    not_joined: ClassVar[str] = "a tool changes its state while it stands still"

    def joint_names(self, snapshot: Snapshot) -> Sequence[str]:
        """Return the joints of the state; none for one without joints, such as a vacuum."""
        return tuple(self._positions(snapshot)[1])

    def tool_states(self, snapshot: Snapshot) -> tuple[tuple[str, str], ...]:
        """Return the tool and its state."""
        return ((self._positions(snapshot)[0], self.state),)

    def plan(self, snapshot: Snapshot, solver_of: SolverOf, near_of: NearOf | None = None) -> PlannedMove:
        """Return its plan; a state without joints is there with the next tick."""
        tool, positions = self._positions(snapshot)
        planned = move_to_joints(snapshot, self.node(snapshot), positions, self.speed_factor, self.time_law)
        return replace(planned, tool_states=((tool, self.state),))

    def _positions(self, snapshot: Snapshot) -> tuple[str, dict[str, float]]:
        """Return the tool's name, and its joints in the state; raise UnknownNameError."""
        structure, node = snapshot.structure, self.node(snapshot)
        tip = 0 if self.group == WHOLE else arm_of(snapshot, node, self.group).tip
        chosen, _ = chosen_tcp(structure, snapshot.state, node, tip)
        name = self.tool or (chosen.name if chosen else "")
        tools = [tool.name for tool in structure.tools_of(node.uid)]
        if name not in tools:
            raise UnknownNameError(f"tool of {node.name!r}", name, tools)
        return name, tool_state(structure, name, self.state)[1]
