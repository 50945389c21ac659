"""Commands about robots: parts, joints, tools, speed."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np

from virtualrobot_kernel.errors import KernelError, Reason, UnknownNameError
from virtualrobot_kernel.world import index
from virtualrobot_kernel.world.actuators import check_actuators, coupled_joints
from virtualrobot_kernel.world.apply_nodes import attached
from virtualrobot_kernel.world.change import (
    Change,
    Forward,
    check_coordinates,
    refuse_measured,
    refuse_while_moving,
    single_joint,
    with_positions,
)
from virtualrobot_kernel.world.commands import (
    PickPart,
    PlacePart,
    SelectTool,
    SetGroups,
    SetJointPositions,
    SetKinematics,
    SetPostures,
    SetSpeedFactor,
    SetTcpSpeedLimit,
    SetToolState,
)
from virtualrobot_kernel.world.consistency import check_names
from virtualrobot_kernel.world.groups import named_group
from virtualrobot_kernel.world.motored import stood
from virtualrobot_kernel.world.state import Selection
from virtualrobot_kernel.world.structure import Kind, Node, RobotData, Structure, ToolData

REACH_OF_A_PICK = 0.2
"""Greatest distance (m) of a part's origin from the tool centre point where the part to pick is not named."""
REACH_OF_A_NAMED_PICK = 1.0
"""The same where it is named, and no distance is given."""


def pick_part(change: Change, command: PickPart, forward: Forward) -> Change:
    """Attach a part to the robot's chosen tool, where it is in the world."""
    tool, tcp = chosen_tool(change, command.robot)
    structure = change.structure
    world = forward(structure, change.state)
    point = (world[structure.rows[tool.uid]] @ tcp)[:3, 3]
    above = {node.uid for node in structure.ancestors(tool.uid)}  # what the robot stands on
    if command.part:
        part = structure.node(command.part, Kind.PART)
        if part.uid in above:
            raise KernelError(
                f"{command.robot!r} stands on the part {part.name!r} and cannot pick it",
                reason=Reason.WRONG_STATE,
                part=part.name,
                robot=command.robot,
            )
        if held := holder(structure, part.uid):
            raise KernelError(
                f"the part {part.name!r} is held by the tool {held.name!r}; let it go first",
                reason=Reason.WRONG_STATE,
                part=part.name,
                tool=held.name,
            )
        limit = command.max_distance or REACH_OF_A_NAMED_PICK
    else:
        free = [
            node
            for node in structure.nodes.values()
            if node.kind is Kind.PART and node.uid not in above and holder(structure, node.uid) is None
        ]
        if not free:
            raise KernelError("there is no part that could be picked", reason=Reason.WRONG_STATE, robot=command.robot)
        origins = world[[structure.rows[node.uid] for node in free], :3, 3]
        part = free[int(np.linalg.norm(origins - point, axis=1).argmin())]
        limit = command.max_distance or REACH_OF_A_PICK
    distance = float(np.linalg.norm(world[structure.rows[part.uid]][:3, 3] - point))
    if distance > limit:
        raise KernelError(
            f"the part {part.name!r} is {distance:.4f} m from the tool centre point of {command.robot!r}, "
            f"farther than {limit:g} m; move there, or give the distance that will do",
            reason=Reason.WRONG_STATE,
            part=part.name,
            distance_meters=distance,
            max_distance_meters=limit,
        )
    return attached(replace(change, picked=(*change.picked, part.uid)), part, tool, None, forward)


def place_part(change: Change, command: PlacePart, forward: Forward) -> Change:
    """Attach what the robot's chosen tool holds to another parent, where it is in the world."""
    tool, _ = chosen_tool(change, command.robot)
    structure = change.structure
    parent = structure.node(command.parent)
    held = [
        structure.nodes[uid] for uid in structure.children.get(tool.uid, ()) if structure.nodes[uid].kind is Kind.PART
    ]
    if command.part:
        part = structure.node(command.part, Kind.PART)
        held = [node for node in held if node.uid == part.uid]
    if not held:
        what = repr(command.part) if command.part else "no part"
        raise KernelError(
            f"the tool {tool.name!r} holds {'not ' if command.part else ''}{what}",
            reason=Reason.WRONG_STATE,
            tool=tool.name,
            part=command.part,
        )
    for part in held:
        change = attached(change, part, parent, None, forward)
    return change


def set_joint_positions(change: Change, command: SetJointPositions, forward: Forward) -> Change:
    """Put joints somewhere at once; refused while the robot moves."""
    node, robot = change.structure.robot(command.robot)
    refuse_while_moving(change, node, {(robot.uid, name) for name in robot.coordinates})
    refuse_measured(change, node)
    q = change.state.q.copy()
    if command.coordinates is not None:
        q[robot.q_slice] = check_coordinates(node, robot.joints, np.asarray(command.coordinates, float).reshape(-1))
    q = with_positions(change.structure, node, q, command.joint_positions)
    check_actuators(change.structure, node, q)
    state = replace(change.state, q=q)
    if node.uid in state.motored:
        state = stood(change.structure, state, (node.uid,))
    return replace(change, state=state)


def set_kinematics(change: Change, command: SetKinematics, forward: Forward) -> Change:
    """Choose the component that solves the kinematics of a robot or of one of its groups."""
    node, _ = change.structure.robot(command.robot)
    assert isinstance(node.data, RobotData)
    choice = {"kinematics": command.kinematics, "kinematics_settings": command.settings}
    if command.group:
        own = named_group(node, command.group)
        groups = (replace(group, **choice) if group is own else group for group in node.data.groups)
        data = replace(node.data, groups=tuple(groups))
    else:
        data = replace(node.data, **choice)
    return replace(change, structure=index.replaced(change.structure, replace(node, data=data)))


def set_groups(change: Change, command: SetGroups, forward: Forward) -> Change:
    """Give a robot other groups of joints; refused where they name what it has not, or are no chain between links."""
    node, _ = change.structure.robot(command.robot)
    assert isinstance(node.data, RobotData)
    node = replace(node, data=replace(node.data, groups=command.groups))
    structure = index.replaced(change.structure, node)
    check_names(structure, node)
    return replace(change, structure=structure)


def set_postures(change: Change, command: SetPostures, forward: Forward) -> Change:
    """Give a robot postures, after others are taken away; refused where they name joints that it has not."""
    node, _ = change.structure.robot(command.robot)
    assert isinstance(node.data, RobotData)
    for name in command.removed:
        if name not in node.data.postures:
            raise UnknownNameError(f"posture of {node.name!r}", name, node.data.postures)
    kept = {name: one for name, one in node.data.postures.items() if name not in command.removed}
    node = replace(node, data=replace(node.data, postures={**kept, **command.postures}))
    structure = index.replaced(change.structure, node)
    check_names(structure, node)
    return replace(change, structure=structure)


def select_tool(change: Change, command: SelectTool, forward: Forward) -> Change:
    """Choose the tool and tool centre point of a robot."""
    node, _ = change.structure.robot(command.robot)
    selection = Selection()
    if command.tool:
        tools = {tool.name: tool for tool in change.structure.tools_of(node.uid)}
        if command.tool not in tools:
            raise UnknownNameError(f"tool of {node.name!r}", command.tool, tools)
        tool = tools[command.tool]
        assert isinstance(tool.data, ToolData)
        points = tool.data.tool_center_points
        point = command.tool_center_point or next(iter(points))
        if point not in points:
            raise UnknownNameError(f"tool centre point of {tool.name!r}", point, points)
        selection = Selection(tool.uid, point)
    elif command.tool_center_point:
        raise KernelError(
            f"the tool centre point {command.tool_center_point!r} is of no tool; name its tool too",
            robot=node.name,
            tool_center_point=command.tool_center_point,
        )
    return replace(change, state=replace(change.state, selections={**change.state.selections, node.uid: selection}))


def set_tool_state(change: Change, command: SetToolState, forward: Forward) -> Change:
    """Put a tool's joints to where a state has them, at once."""
    tool, positions = tool_state(change.structure, command.tool, command.state)
    q = change.state.q.copy()
    robot = change.structure.robot_of(tool.uid)
    if robot is not None:
        needed = coupled_joints(change.structure, {(robot.uid, name) for name in positions})
        refuse_while_moving(change, robot, needed)
        refuse_measured(change, robot)
        for name, value in positions.items():
            q[single_joint(change.structure, robot, name)[1]] = value
        check_actuators(change.structure, robot, q)
    state = replace(change.state, q=q, tool_states={**change.state.tool_states, tool.uid: command.state})
    if robot is not None and robot.uid in state.motored:
        state = stood(change.structure, state, (robot.uid,))
    return replace(change, state=state)


def tool_state(structure: Structure, tool: str, state: str) -> tuple[Node, dict[str, float]]:
    """Return a tool and the joint positions of one of its states; raise UnknownNameError."""
    node = structure.node(tool, Kind.TOOL)
    assert isinstance(node.data, ToolData)
    if state not in node.data.states:
        raise UnknownNameError(f"state of the tool {tool!r}", state, node.data.states)
    return node, dict(node.data.states[state])


def set_speed_factor(change: Change, command: SetSpeedFactor, forward: Forward) -> Change:
    """Slow the motions of one robot, or of all."""
    if not 0.0 < command.factor <= 1.0:
        raise KernelError(
            f"a speed factor must be above 0 and at most 1, not {command.factor:g}", factor=command.factor
        )
    state = change.state
    if not command.robot:
        return replace(change, state=replace(state, speed_factor=command.factor))
    node, _ = change.structure.robot(command.robot)
    return replace(change, state=replace(state, speed_factors={**state.speed_factors, node.uid: command.factor}))


def set_tcp_speed_limit(change: Change, command: SetTcpSpeedLimit, forward: Forward) -> Change:
    """Limit the speed of a robot's tool centre point, or lift the limit; refused while it moves."""
    if not 0.0 <= command.limit < inf:
        raise KernelError(
            f"a speed limit is above 0 m/s, or 0, which lifts it, not {command.limit:g}", limit=command.limit
        )
    node, robot = change.structure.robot(command.robot)
    refuse_while_moving(change, node, {(node.uid, name) for name in robot.coordinates})
    limits = {uid: limit for uid, limit in change.state.tcp_speed_limits.items() if uid != node.uid}
    if command.limit > 0.0:
        limits[node.uid] = command.limit
    return replace(change, state=replace(change.state, tcp_speed_limits=limits))


def holder(structure: Structure, part: int) -> Node | None:
    """Return the tool that holds a part, or None."""
    return next((node for node in structure.ancestors(part) if node.kind is Kind.TOOL), None)


def chosen_tool(change: Change, robot: str) -> tuple[Node, np.ndarray]:
    """Return the tool that a robot works with, and tool_t_tcp (4, 4); raise KernelError (WRONG_STATE) without one."""
    node, _ = change.structure.robot(robot)
    selection = change.state.selections.get(node.uid, Selection())
    if not selection.tool:
        raise KernelError(
            f"the robot {robot!r} works with no tool; choose one with select_tool, or create one below its flange",
            reason=Reason.WRONG_STATE,
            robot=robot,
        )
    tool = change.structure.nodes[selection.tool]
    assert isinstance(tool.data, ToolData)
    return tool, tool.data.tool_center_points.get(selection.tool_center_point, np.eye(4))
