"""Protocol of a kind of move: its joints, frames and assumptions, its plan, and what it can be joined with."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.signals import Condition
from virtualrobot_kernel.planning.moving_base import MovingBase
from virtualrobot_kernel.planning.planned_move import PlannedMove
from virtualrobot_kernel.planning.redundancy import NearOf
from virtualrobot_kernel.planning.robots import SolverOf
from virtualrobot_kernel.world.groups import WHOLE, Group
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind, Node


@dataclass(frozen=True, slots=True, eq=False)
class Move(ABC):
    """Move of a robot, or of a group of its joints, as data; a kind overrides what differs from joints by name."""

    robot: str
    group: Group = field(default=WHOLE, kw_only=True)
    acceleration_factor: float = field(default=1.0, kw_only=True)
    jerk_factor: float = field(default=1.0, kw_only=True)
    fixed_tool: str = field(default="", kw_only=True)

    not_joined: ClassVar[str] = ""
    """Reason for which zones join it with no other move; empty where they can."""

    other_joints: ClassVar[bool] = False
    """True if it may move joints outside its group."""

    timed: ClassVar[bool] = False
    """True if it brings times of its own, so that no law can be chosen for it."""

    @abstractmethod
    def joint_names(self, snapshot: Snapshot) -> Sequence[str]:
        """Return the joints that it moves."""

    @abstractmethod
    def plan(self, snapshot: Snapshot, solver_of: SolverOf, near_of: NearOf | None = None) -> PlannedMove:
        """Return its plan from where the joints are; raise KernelError with place and reason.

        near_of: measures how far an arm is from everything else, for arms that prefer distance.
        """

    @property
    def gentle(self) -> tuple[float, float]:
        """Shares of acceleration and jerk that it uses."""
        return self.acceleration_factor, self.jerk_factor

    @property
    def solved(self) -> bool:
        """True if it needs the kinematics component of its robot."""
        return False

    @property
    def references(self) -> tuple[str, ...]:
        """Nodes in whose frames its goals are; none for the robot's own frame."""
        return ()

    @property
    def frames(self) -> tuple[str, ...]:
        """Nodes whose places its path is made of: the references of its goals, and a tool that stands apart."""
        return (*self.references, self.fixed_tool) if self.fixed_tool else self.references

    @property
    def moving_reference(self) -> str | None:
        """Node that its goal goes along with when other moves of the step move it; None: with none."""
        return None

    @property
    def posture(self) -> str:
        """Posture of the robot that is its goal; empty for another goal."""
        return ""

    @property
    def search(self) -> Condition | None:
        """Condition with which it ends before its goal; None where it doesn't search."""
        return None

    def tool_states(self, snapshot: Snapshot) -> tuple[tuple[str, str], ...]:
        """Return (tool, state) that are its goals; the state is empty for a width."""
        return ()

    def plan_on(self, base: MovingBase, solver_of: SolverOf, near_of: NearOf | None = None) -> PlannedMove:
        """Return its plan where other moves of the same step move its robot's base or its reference."""
        carrying = " and ".join(repr(one.robot.name) for one in base.moves)
        raise KernelError(
            f"{self.robot!r} is carried by the move of {carrying}; only a line, an arc, a spline or a move to a pose "
            "can go along",
            robot=self.robot,
        )

    def node(self, snapshot: Snapshot) -> Node:
        """Return its robot."""
        return snapshot.structure.node(self.robot, Kind.ROBOT)

    def owner(self, snapshot: Snapshot) -> Node:
        """Return the robot whose joints it moves: another one for the tool of a gripper."""
        return self.node(snapshot)
