"""Serial chains of robots as they stand in a snapshot: of a robot or one of its groups, tool included."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import EllipsisType

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.kinematics import Kinematics, SerialChain
from virtualrobot_sdk.poses import inverse

from virtualrobot_kernel.errors import KernelError, LimitError, Reason, UnknownNameError
from virtualrobot_kernel.motion.limits import TOLERANCE
from virtualrobot_kernel.numeric.forest import forward_forest, forward_tips
from virtualrobot_kernel.planning.extract import extract_chain, lock_coordinates
from virtualrobot_kernel.planning.redundancy import Redundancy
from virtualrobot_kernel.world.change import with_positions
from virtualrobot_kernel.world.figures import Pose
from virtualrobot_kernel.world.groups import WHOLE, Group, chain_links
from virtualrobot_kernel.world.state import Snapshot, State
from virtualrobot_kernel.world.structure import Node, RobotData, RobotIndex, Structure
from virtualrobot_kernel.world.tcp import world_t_tcp

REMEMBERED = 256
"""Number of arms kept ready."""


SolverOf = Callable[[Snapshot, "Arm"], Kinematics]
"""Lookup of an arm's kinematics component; raises KernelError when it has none, or one that has failed."""

Tips = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Forward kinematics of a robot: base_t_tip (m, 4, 4) at postures (m, k)."""


@dataclass(frozen=True, slots=True, eq=False)
class Arm:
    """Serial chain of a robot from `base` to `tip` (uids), and where its k coordinates are in q, shape (k,).

    It is that of `group`: the robot's own one ends at its flange. `path` holds the rows of the forest between them,
    base first; `chain` is None when no joint moves the tip. Joints that are `locked`, by their place in q, stand still
    at these values: they are no coordinates of the chain.
    """

    robot: Node
    group: Group
    base: int
    tip: int
    q_index: NDArray[np.int32]
    path: NDArray[np.int32]
    chain: SerialChain | None
    locked: Mapping[int, float] = field(default_factory=dict)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Return the names of the arm's joints, in order."""
        return self.chain.joint_names if self.chain else ()

    def serial(self) -> SerialChain:
        """Return the chain; raise KernelError when no joint moves its tip."""
        if self.chain is not None:
            return self.chain
        robot = self.robot.name
        if self.group != WHOLE:
            message = f"no joint moves the end of {robot!r}{self.group}; choose links that joints lie between"
        else:
            message = f"no joint of {robot!r} moves its flange; name its flange in the robot's `flange`"
            groups = self.robot.data.groups if isinstance(self.robot.data, RobotData) else ()
            if names := ", ".join(repr(group.name) for group in groups):
                message += f", or choose one of its groups ({names})"
            else:
                message += ", or choose a group of joints by its base and tip link"
        raise KernelError(message, reason=Reason.WRONG_STATE, robot=robot)

    @property
    def tool_tip(self) -> int:
        """Return the link (uid) that the arm's tools are fixed to; 0 where it is the robot's chosen tool, wherever."""
        return 0 if self.group == WHOLE else self.tip


def world_poses(structure: Structure, state: State) -> NDArray[np.float64]:
    """Return world_t_node (N, 4, 4) of every node: the one forward pass.

    The world's own node needs none: a kernel that begins empty answers before compiled code is loaded.
    """
    order, placed = structure.forest.order, state.parent_t_node
    result = poses_of_rows(structure, order, placed, state.q) if len(placed) > 1 else placed.copy()
    result.setflags(write=False)
    return result


def poses_of_rows(
    structure: Structure, order: NDArray[np.int32], parent_t_node: NDArray[np.float64], q: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return world_t_node (N, 4, 4), in which only the rows of `order`, parents before children, are written."""
    forest = structure.forest
    result = np.empty_like(parent_t_node)
    forward_forest(
        order,
        forest.parent,
        forest.joint_type,
        forest.axis,
        forest.q_index,
        forest.multiplier,
        forest.offset,
        parent_t_node,
        q,
        result,
    )
    return result


def standing_at(snapshot: Snapshot, q_index: NDArray[np.int32] | EllipsisType, q: NDArray[np.float64]) -> Snapshot:
    """Return the world with coordinates `q_index` (k,), or all (...), at q, and nothing else different."""
    everything = snapshot.state.q.copy()
    everything[q_index] = q
    return with_state(snapshot, replace(snapshot.state, q=everything))


def with_state(snapshot: Snapshot, state: State, structure: Structure | None = None) -> Snapshot:
    """Return the world in another state, and with another structure if one is given, all nodes where they are then."""
    structure = structure or snapshot.structure
    return replace(snapshot, structure=structure, state=state, world_t_node=world_poses(structure, state))


_arms: OrderedDict[tuple[RobotIndex, Group, int, bytes], Arm] = OrderedDict()


def arm_of(snapshot: Snapshot, robot: Node, group: Group = WHOLE) -> Arm:
    """Return the chain of a group; without one from the robot's base (or last floating or planar link) to its flange.

    Chains are remembered as long as the robot's joints and the places of its links stay as they are. Raises as
    `world.groups.chain_links` does.
    """
    structure = snapshot.structure
    index = structure.robots[robot.uid]
    base, path = chain_links(structure, robot, group)
    rows = [structure.rows[uid] for uid in path]
    key = (index, group, base, snapshot.state.parent_t_node[rows].tobytes())
    arm = _arms.get(key)
    if arm is None or arm.robot is not robot:
        arm = _arms[key] = _built(structure, snapshot.state, robot, group, base, path)
        while len(_arms) > REMEMBERED:
            _arms.popitem(last=False)
    return arm


def _built(structure: Structure, state: State, robot: Node, group: Group, base: int, path: list[int]) -> Arm:
    index, tip = structure.robots[robot.uid], path[0] if path else base
    moving = any(structure.nodes[uid].is_moved for uid in path)
    rows = np.array([structure.rows[uid] for uid in reversed(path)], np.int32)
    if not moving:
        return Arm(robot, group, base, tip, np.empty(0, np.int32), rows, None)
    lower, upper = np.full(structure.q_count, -np.inf), np.full(structure.q_count, np.inf)
    names: dict[int, str] = {}
    for joint, start in zip(index.joints, index.q_start, strict=True):
        lower[start], upper[start] = joint.limits.lower, joint.limits.upper
        names[start] = joint.name
    forest = structure.forest
    chain, q_index = extract_chain(
        structure.rows[base],
        structure.rows[tip],
        parent=forest.parent,
        joint_type=forest.joint_type,
        axis=forest.axis,
        q_index=forest.q_index,
        multiplier=forest.multiplier,
        offset=forest.offset,
        parent_t_node=state.parent_t_node,
        lower=lower,
        upper=upper,
        joint_names=names,
    )
    return Arm(robot, group, base, tip, q_index, rows, chain)


def locked_arm(arm: Arm, joints: Mapping[str, float]) -> Arm:
    """Return the arm with joints that stand still at these radians or metres; the arm itself without any.

    Raises UnknownNameError for a joint that isn't the arm's, LimitError for a value outside limits, and KernelError
    when no joint is left.
    """
    if not joints:
        return arm
    chain, robot = arm.serial(), arm.robot.name
    values: dict[int, float] = {}
    for name, value in joints.items():
        if name not in chain.joint_names:
            raise UnknownNameError(kind_of_joint(arm), name, chain.joint_names)
        place = chain.joint_names.index(name)
        lower, upper = float(chain.lower[place]), float(chain.upper[place])
        if not lower - TOLERANCE <= value <= upper + TOLERANCE:
            raise LimitError(
                f"the joint {name!r} of {robot!r} cannot be locked at {value:g}; its limits are {lower:g} to {upper:g}",
                robot=robot,
                joint=name,
                value=value,
                lower=lower,
                upper=upper,
            )
        values[place] = float(value)
    if len(values) == len(chain.joint_names):
        raise KernelError(
            f"all joints that move the flange of {robot!r} are locked ({', '.join(chain.joint_names)}); leave at least "
            "one free",
            robot=robot,
        )
    reduced, free = lock_coordinates(chain, values)
    locked = {int(arm.q_index[place]): value for place, value in values.items()}
    return replace(arm, q_index=arm.q_index[free], chain=reduced, locked=locked)


def arm_if_chain(snapshot: Snapshot, robot: Node, group: Group) -> Arm | None:
    """Return the arm of a group; None where it is no chain, whose joints can be moved all the same."""
    try:
        return arm_of(snapshot, robot, group)
    except KernelError as error:
        if error.reason is not Reason.WRONG_STATE:
            raise
        return None


def arms_of(snapshot: Snapshot, groups: Iterable[tuple[Node, Group]]) -> list[Arm]:
    """Return the arms of groups of robots, each chain once; what is no chain is left out."""
    found: dict[tuple[int, bytes], Arm] = {}
    for robot, group in dict.fromkeys(groups):
        arm = arm_if_chain(snapshot, robot, group)
        if arm is not None and arm.chain is not None:
            found.setdefault((arm.tip, arm.q_index.tobytes()), arm)
    return list(found.values())


def kind_of_joint(arm: Arm) -> str:
    """Return the name of an arm's joint for errors."""
    end = "flange" if arm.group == WHOLE else "end"
    return f"joint that moves the {end} of {arm.robot.name!r}{arm.group}"


def arm_on_path(snapshot: Snapshot, robot: Node, redundancy: Redundancy, group: Group = WHOLE) -> Arm:
    """Return the arm that leads the tool centre point along a path: without the joints that are locked.

    Raises KernelError when a locked joint is not where it is to stand, or an arm angle is asked for.
    """
    if redundancy.arm_angle is not None:
        raise KernelError(
            f"the arm angle {redundancy.arm_angle:g} is for goals of point-to-point moves; on a path of the tool "
            "centre point it follows from where the path starts and from the preference",
            robot=robot.name,
            field="arm_angle_radians",
        )
    whole = arm_of(snapshot, robot, group)
    arm = locked_arm(whole, redundancy.locked_joints)
    names = dict(zip(whole.q_index.tolist(), whole.joint_names, strict=True))
    for place, value in arm.locked.items():
        now = float(snapshot.state.q[place])
        if abs(now - value) > TOLERANCE:
            raise KernelError(
                f"the joint {names[place]!r} of {robot.name!r} is locked at {value:.9g}, but it is at {now:.9g}; a "
                f"path of the tool centre point can lock a joint only where it is at its start, to {TOLERANCE:g}",
                robot=robot.name,
                joint=names[place],
                value=value,
                current=now,
            )
    return arm


def tip_of(snapshot: Snapshot, arm: Arm) -> Callable[[NDArray[np.float64]], Pose]:
    """Return the function of base_t_tip (4, 4) of an arm by q (k,): the tree's forward pass, of the arm's rows only."""
    fixed, begin = _rows_of(snapshot, arm)

    def tip(q: NDArray[np.float64]) -> Pose:
        poses = begin.copy()
        forward_forest(*fixed, np.ascontiguousarray(q), poses)
        return poses[-1]

    return tip


def tips_of(snapshot: Snapshot, arm: Arm) -> Tips:
    """Return the function of base_t_tip (m, 4, 4) of an arm by postures (m, k): what `tip_of` gives for each."""
    fixed, begin = _rows_of(snapshot, arm)

    def tips(postures: NDArray[np.float64]) -> NDArray[np.float64]:
        found = np.tile(np.eye(4), (len(postures), 1, 1))
        forward_tips(*fixed, np.ascontiguousarray(postures), begin.copy(), found)
        return found

    return tips


def _rows_of(snapshot: Snapshot, arm: Arm) -> tuple[Sequence[NDArray], NDArray[np.float64]]:
    """Return an arm's rows as the forward pass takes them, below a first one for its base, and poses to begin with."""
    forest, rows = snapshot.structure.forest, arm.path
    coordinate = {int(place): i for i, place in enumerate(arm.q_index)}
    multiplier, offset = forest.multiplier[rows], forest.offset[rows]
    for place, value in arm.locked.items():
        still = forest.q_index[rows] == place
        offset = np.where(still, multiplier * value + offset, offset)
        multiplier = np.where(still, 0.0, multiplier)
    fixed = (
        np.arange(1, len(rows) + 1, dtype=np.int32),
        np.arange(-1, len(rows), dtype=np.int32),
        *(_below(np.zeros_like(column[:1]), column[rows]) for column in (forest.joint_type, forest.axis)),
        np.array([0, *(coordinate.get(int(place), 0) for place in forest.q_index[rows])], np.int32),
        *(_below(np.zeros_like(column[:1]), column) for column in (multiplier, offset)),
        _below(np.eye(4)[None], snapshot.state.parent_t_node[rows]),
    )
    return fixed, np.tile(np.eye(4), (len(rows) + 1, 1, 1))


def _below(first: NDArray, rest: NDArray) -> NDArray:
    return np.ascontiguousarray(np.concatenate([first, rest]))


def tcp_frame(snapshot: Snapshot, robot: Node, arm: Arm | None = None) -> Pose:
    """Return world_t_tcp (4, 4) of the chosen tool centre point, or an arm's; without a tool the flange or the tip."""
    tip = arm.tool_tip if arm else 0
    return world_t_tcp(snapshot.structure, snapshot.state, snapshot.world_t_node, robot, tip)


def tip_t_tcp(snapshot: Snapshot, arm: Arm) -> Pose:
    """Return the pose tip_t_tcp (4, 4) of the arm's tool centre point in the frame of its tip."""
    return inverse(snapshot.world_t(arm.tip)) @ tcp_frame(snapshot, arm.robot, arm)


def joint_vector(snapshot: Snapshot, arm: Arm, positions: Mapping[str, float]) -> NDArray[np.float64]:
    """Return the arm's joints (k,): those named in `positions`, the others as they are; raise for unknown names."""
    return with_positions(snapshot.structure, arm.robot, snapshot.state.q, positions)[arm.q_index]


def forward_links(
    snapshot: Snapshot, robot: Node, positions: Mapping[str, float], group: Group = WHOLE
) -> tuple[NDArray[np.float64], Pose]:
    """Return world_t_link (n, 4, 4) of the robot's links and a group's world_t_tcp (4, 4), some joints elsewhere."""
    structure = snapshot.structure
    q = with_positions(structure, robot, snapshot.state.q, positions)
    world = world_poses(structure, replace(snapshot.state, q=q))
    index = structure.robots[robot.uid]
    tip = 0 if group == WHOLE else arm_of(snapshot, robot, group).tip
    tcp = world_t_tcp(structure, snapshot.state, world, robot, tip)
    return world[[structure.rows[uid] for uid in index.links]], tcp
