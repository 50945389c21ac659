"""Setpoints of a tool centre point: what leads it, and the frame in which they are given."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.poses import from_quaternion, inverse, quaternion

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.motion.limits import CartesianLimits
from virtualrobot_kernel.motion.resolved_rate import lever_arm
from virtualrobot_kernel.motion.setpoint_motion import SetpointMode
from virtualrobot_kernel.motion.tool_lead import BEYOND, ToolLead
from virtualrobot_kernel.motion.tool_setpoints import ToolSetpointMotion
from virtualrobot_kernel.planning.moves import JogFrame
from virtualrobot_kernel.planning.planned_move import cartesian_limits
from virtualrobot_kernel.planning.robots import arm_of, tip_t_tcp
from virtualrobot_kernel.world.commands import StartSetpointMotion
from virtualrobot_kernel.world.groups import WHOLE, Group
from virtualrobot_kernel.world.preconditions import TcpPath, preconditions_of
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.tcp import refuse_limited

ROTATION_VELOCITY = 1.0
"""Default greatest angular velocity of a tool that follows setpoints, in rad/s."""

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class ToolFrame:
    """Frame of setpoints, for a chain that begins at the link `base` (a uid); node: its name where it is a node's."""

    base: int
    frame: JogFrame
    node: str = ""

    def in_lead(self, snapshot: Snapshot, mode: SetpointMode, values: Sequence[float]) -> tuple[float, ...]:
        """Return a setpoint in this frame, where it is now, as the motion takes it: in that of the base, or the tool's.

        Raises UnknownNameError when the node has gone.
        """
        if self.frame is not JogFrame.NODE:
            return tuple(values)
        base_t_node = self._base_t_node(snapshot)
        given = np.array(values)
        if mode is SetpointMode.TOOL_TWIST:
            return tuple((given.reshape(2, 3) @ base_t_node[:3, :3].T).ravel().tolist())
        if not np.linalg.norm(given[3:]):
            return tuple(values)  # which the motion refuses
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = from_quaternion(given[3:] / np.linalg.norm(given[3:])), given[:3]
        length = float(np.linalg.norm(given[3:]))  # the motion checks it
        pose = base_t_node @ pose
        return (*pose[:3, 3].tolist(), *(length * one for one in quaternion(pose[:3, :3])))

    def seen(self, snapshot: Snapshot, running: ToolSetpointMotion) -> tuple[Floats, Floats]:
        """Return pose (7,) and twist (6,) of the tool centre point in this frame.

        The pose is in the base's where the frame is TOOL, and both are where the node has gone.
        """
        pose, twist = running.lead.at(np.array(running.now.q)).pose, running.base_twist
        rotation = np.eye(3)
        if self.frame is JogFrame.TOOL:
            rotation = pose[:3, :3].T
        elif self.frame is JogFrame.NODE and self.is_there(snapshot):
            node_t_base = inverse(self._base_t_node(snapshot))
            pose, rotation = node_t_base @ pose, node_t_base[:3, :3]
        place = np.array([*pose[:3, 3], *quaternion(pose[:3, :3])])
        return place, (twist.reshape(2, 3) @ rotation.T).ravel()

    def is_there(self, snapshot: Snapshot) -> bool:
        """Return whether base and node are in the world."""
        structure = snapshot.structure
        return self.base in structure.nodes and (not self.node or self.node in structure.uid_by_name)

    def _base_t_node(self, snapshot: Snapshot) -> Floats:
        node = snapshot.structure.node(self.node).uid
        return inverse(snapshot.world_t(self.base)) @ snapshot.world_t(node)


def tool_start(
    snapshot: Snapshot,
    robot: str,
    mode: SetpointMode,
    timeout: float,
    frame: JogFrame = JogFrame.BASE,
    node: str = "",
    group: Group = WHOLE,
    max_velocity: float = 0.0,
    max_rotation_velocity: float = 0.0,
) -> tuple[StartSetpointMotion, ToolFrame]:
    """Return the command that starts a motion by setpoints of a robot's tool centre point, and their frame.

    Speeds are in m/s and rad/s; 0 stands for the defaults. A robot's own speed limit counts, too, less `BEYOND`. Raises
    KernelError for a robot whose flange no joint moves, for poses in the axes of the tool, for a node that isn't there,
    and for a group of a robot with a speed limit, which is one of the chosen tool centre point.
    """
    if mode is SetpointMode.TOOL_POSE and frame is JogFrame.TOOL:
        raise KernelError(
            "poses of a tool centre point cannot be in the frame TOOL, which goes along with them; give BASE, or NODE "
            "with a node",
            field="target.frame",
        )
    structure, (robot_node, _) = snapshot.structure, snapshot.structure.robot(robot)
    arm = arm_of(snapshot, robot_node, group)
    chain = arm.serial()
    if frame is JogFrame.NODE:
        node = structure.node(node or "world").name
    linear = cartesian_limits(max_velocity, 0.0)
    turning = max_rotation_velocity or ROTATION_VELOCITY
    if group != WHOLE:
        refuse_limited(structure, snapshot.state, [robot_node.uid])
    own = snapshot.state.tcp_speed_limits.get(robot_node.uid, math.inf)
    limits = CartesianLimits(min(linear.velocity, own / (1.0 + BEYOND)), linear.acceleration, linear.jerk, turning)
    chain = chain._replace(post=np.ascontiguousarray(chain.post @ tip_t_tcp(snapshot, arm)))
    lead = ToolLead(chain, 1.0, frame is JogFrame.TOOL, limits)
    lever = lever_arm(lead.at(snapshot.state.q[arm.q_index]).jacobian)
    lead = ToolLead(chain, 1.0 / lever, frame is JogFrame.TOOL, limits)
    joints = [(robot_node.uid, name) for name in arm.joint_names]
    facts = preconditions_of(structure, snapshot.state, joints, [TcpPath(robot_node.uid, (), group)])
    start = StartSetpointMotion(robot, arm.joint_names, mode, timeout, lead, facts)
    return start, ToolFrame(arm.base, frame, node)
