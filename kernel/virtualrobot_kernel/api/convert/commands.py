"""Commands of the contract: to the world's own commands."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from virtualrobot.v1 import nodes_pb2, robot_pb2, scene_pb2

from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.collision_settings import pairs_command, settings_command
from virtualrobot_kernel.messages.figures import check_lengths
from virtualrobot_kernel.messages.nodes import figures, node_data, node_spec, runs
from virtualrobot_kernel.messages.physics import physics_command
from virtualrobot_kernel.messages.robots import CRAFT, GROUPS, POSTURES
from virtualrobot_kernel.messages.sensing import SENSORS
from virtualrobot_kernel.messages.signals import created_signal, value_of
from virtualrobot_kernel.messages.structs import settings
from virtualrobot_kernel.messages.values import array, by_name, finite, mask_fields, not_negative, pose
from virtualrobot_kernel.world import commands
from virtualrobot_kernel.world.figures import Pose
from virtualrobot_kernel.world.structure import NodeSpec

KINDS = frozenset({"part", "robot", "link", "adapter", "tool", "target", "viewpoint"}) | SENSORS.keys()
"""Kinds of nodes whose own fields can be changed."""
SAID = frozenset({"description", "tags", "icon", "locked"})
"""Fields of what people say of a node, and its lock."""
UPDATABLE = frozenset({"name", "parent_t_node", "hidden", "figures"}) | SAID | KINDS


def world_commands(messages: Iterable[scene_pb2.Command]) -> list[commands.Command]:
    """Return the commands; nodes that are created one after the other become one command."""
    result: list[commands.Command] = []
    specs: list[NodeSpec] = []
    for place, message in enumerate(messages):
        try:
            kind = message.WhichOneof("command")
            if kind is None:
                raise KernelError(f"commands[{place}] says nothing to do", field=f"commands[{place}]")
            if kind == "create_node":
                specs.append(node_spec(message.create_node.node))
                check_lengths(specs[-1].figures, specs[-1].name)
                continue
            command = COMMANDS[kind](getattr(message, kind))
        except KernelError as error:
            error.metadata["command_index"] = str(place)
            raise
        if specs:
            result.append(commands.CreateNodes(tuple(specs)))
            specs.clear()
        result.append(command)
    return [*result, commands.CreateNodes(tuple(specs))] if specs else result


def _update(message: scene_pb2.UpdateNode) -> commands.UpdateNode:
    fields = mask_fields(message.update_mask, nodes_pb2.Node)
    if fields is None or not fields <= UPDATABLE:
        said = ", ".join(sorted(fields - UPDATABLE)) if fields else "nothing"
        raise KernelError(
            f"the update_mask of update_node for {message.name!r} names {said}; "
            f"it must name some of {', '.join(sorted(UPDATABLE))}",
            node=message.name,
        )
    node, what = message.node, message.name
    data = node_data(node, what)
    kinds = fields & KINDS
    if kinds and node.WhichOneof("kind") not in kinds:
        raise KernelError(
            f"the update_mask of update_node for {what!r} names {', '.join(sorted(kinds))}, but the node has none",
            node=what,
        )
    shapes = figures(node, what) if "figures" in fields else None
    check_lengths(shapes or (), what)
    return commands.UpdateNode(
        name=message.name,
        new_name=node.name if "name" in fields else None,
        parent_t_node=pose(node.parent_t_node, f"{what}.parent_t_node") if "parent_t_node" in fields else None,
        hidden=node.hidden if "hidden" in fields else None,
        figures=shapes,
        data=data if kinds else None,
        running=runs(node) if kinds & SENSORS.keys() else None,
        description=node.description if "description" in fields else None,
        tags=tuple(node.tags) if "tags" in fields else None,
        icon=node.icon if "icon" in fields else None,
        locked=node.locked if "locked" in fields else None,
    )


def _place(message: scene_pb2.AttachNode | scene_pb2.MountTool | scene_pb2.UnmountTool) -> Pose | None:
    return pose(message.parent_t_node, "parent_t_node") if message.HasField("parent_t_node") else None


def _joints(message: scene_pb2.SetJointPositions) -> commands.SetJointPositions:
    positions = by_name(message.joint_positions, "joint_positions")
    if not message.HasField("coordinates"):
        return commands.SetJointPositions(message.robot, positions)
    if positions:
        raise KernelError("give joint_positions or coordinates, not both", robot=message.robot)
    return commands.SetJointPositions(message.robot, coordinates=array(message.coordinates, (None,), "coordinates"))


def kinematics_command(message: robot_pb2.KinematicsChoice) -> commands.SetKinematics:
    """Return the command of a message; raise KernelError for settings that are none."""
    return commands.SetKinematics(
        message.robot, message.kinematics, settings(message.settings, "settings"), message.group
    )


COMMANDS: dict[str, Callable[[Any], commands.Command]] = {
    "update_node": _update,
    "remove_node": lambda message: commands.RemoveNode(message.name),
    "attach_node": lambda message: commands.AttachNode(message.name, message.parent, _place(message)),
    "pick_part": lambda message: commands.PickPart(
        message.robot, message.part, not_negative(message.max_distance_meters, "max_distance_meters")
    ),
    "place_part": lambda message: commands.PlacePart(message.robot, message.part, message.parent),
    "set_joint_positions": _joints,
    "set_joint_efforts": lambda message: commands.SetJointEfforts(message.robot, by_name(message.efforts, "efforts")),
    "set_groups": lambda message: commands.SetGroups(message.robot, GROUPS.read(message.groups, "groups")),
    "set_postures": lambda message: commands.SetPostures(
        message.robot, POSTURES.read(message.postures, "postures"), tuple(message.removed)
    ),
    "select_tool": lambda message: commands.SelectTool(message.robot, message.tool, message.tool_center_point),
    "mount_tool": lambda message: commands.MountTool(
        message.robot, message.node, message.parent, _place(message), message.tool_center_point
    ),
    "unmount_tool": lambda message: commands.UnmountTool(message.robot, message.node, message.parent, _place(message)),
    "set_tool_state": lambda message: commands.SetToolState(message.tool, message.state),
    "create_signal": lambda message: created_signal(message.signal),
    "remove_signal": lambda message: commands.RemoveSignal(message.name),
    "set_signal": lambda message: commands.SetSignal(message.name, value_of(message.value, "set_signal.value")),
    "set_collision_settings": settings_command,
    "set_physics": physics_command,
    "set_allowed_pairs": pairs_command,
    "set_kinematics": kinematics_command,
    "set_craft": lambda message: commands.SetCraft(
        message.robot, CRAFT.read(message.craft, "craft") if message.HasField("craft") else None
    ),
    "start_sensors": lambda message: commands.RunSensors(tuple(message.sensors), True),
    "stop_sensors": lambda message: commands.RunSensors(tuple(message.sensors), False),
    "set_tcp_speed_limit": lambda message: commands.SetTcpSpeedLimit(
        message.robot, finite(message.meters_per_second, "meters_per_second")
    ),
    "set_speed_factor": lambda message: commands.SetSpeedFactor(message.robot, finite(message.factor, "factor")),
}
