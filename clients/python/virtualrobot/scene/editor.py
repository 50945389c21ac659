"""The changes that a scene can be told; the scene applies each at once, a batch all together."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TypedDict, Unpack

from google.protobuf.field_mask_pb2 import FieldMask

from virtualrobot._wire.arguments import ArrayLike, PoseLike, Text, checked
from virtualrobot._wire.messages import (
    array_message,
    joint_map,
    pose_message,
    settings_message,
    several,
    value_or_default,
    vector_message,
)
from virtualrobot._wire.options import check_options
from virtualrobot._wire.services import Services
from virtualrobot._wire.showing import listed
from virtualrobot._wire.signal_values import GivenValue, set_command, value_message
from virtualrobot.collisions.allowed_pairs import pairs_command
from virtualrobot.collisions.settings import CollisionOptions, collision_command
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.robots.values import JointGroup
from virtualrobot.scene.adding import Adding, Created, viewpoint_message
from virtualrobot.scene.figures import Figures, figure_list
from virtualrobot.v1 import nodes_pb2, robot_pb2, scene_pb2, sensor_pb2, signal_pb2

_DIRECTIONS = {
    "input": signal_pb2.SIGNAL_DIRECTION_INPUT,
    "output": signal_pb2.SIGNAL_DIRECTION_OUTPUT,
    "internal": signal_pb2.SIGNAL_DIRECTION_INTERNAL,
}


class SignalOptions(TypedDict, total=False):
    """Options of a new signal.

    Attributes:
        description: its purpose in words.
        unit: of a number.
        direction: `input`, `output` or `internal` (the default), seen from its owner.
        owner: the node that it belongs to; nobody by default.
    """

    description: Text | None
    unit: Text | None
    direction: str | None
    owner: str | None


def pick_command(robot: str, part: str | None, max_distance: float | None) -> scene_pb2.Command:
    """Return the command that fixes a part to a robot's tool."""
    distance = value_or_default(max_distance, "max_distance")
    return scene_pb2.Command(pick_part=scene_pb2.PickPart(robot=robot, part=part, max_distance_meters=distance))


@checked
class Editor(Adding[Created]):
    """Changes of the world, one method for each command of the contract."""

    def set_viewpoint(self, name: str, distance: float | None = None, field_of_view: float | None = None) -> None:
        """Change how far ahead of a viewpoint is what is looked at (m), and its field of view (rad), as it is added."""
        self._update(name, nodes_pb2.Node(viewpoint=viewpoint_message(distance, field_of_view)), "viewpoint")

    def _update(self, name: str, node: nodes_pb2.Node, *fields: str) -> None:
        """Change fields of a node to those of `node`."""
        mask = FieldMask(paths=fields)
        self._submit(scene_pb2.Command(update_node=scene_pb2.UpdateNode(name=name, node=node, update_mask=mask)))

    def rename(self, name: str, new_name: str) -> None:
        """Give a node another name."""
        self._update(name, nodes_pb2.Node(name=new_name), "name")

    def hide(self, name: str, hidden: bool = True) -> None:
        """Hide a node and what hangs below, or show it again."""
        self._update(name, nodes_pb2.Node(hidden=hidden), "hidden")

    def describe(
        self,
        name: str,
        description: Text | None = None,
        *,
        tags: Iterable[str] | None = None,
        icon: str | None = None,
    ) -> None:
        """Say what a node is for, by which words it is found, and which icon pages show for it; what is None stays.

        Args:
            name: the node.
            description: in at most 2000 characters.
            tags: at most 32, each once and of at most 64 characters.
            icon: a name of the library Lucide, such as `shield`; empty for that of its kind.
        """
        fields = {"description": description, "tags": None if tags is None else several(tags), "icon": icon}
        given = {field: value for field, value in fields.items() if value is not None}
        if not given:
            raise InvalidArgumentError("nothing is said of the node; give a description, tags or an icon")
        self._update(name, nodes_pb2.Node(**given), *given)  # pyright: ignore[reportArgumentType] fields by name

    def lock(self, name: str, locked: bool = True) -> None:
        """Keep a node's name, parent, pose and figures as they are, and it in the world, or let go of it again."""
        self._update(name, nodes_pb2.Node(locked=locked), "locked")

    def set_pose(self, name: str, parent_t_node: PoseLike) -> None:
        """Put a node somewhere else in its parent's frame, at once."""
        self._update(name, nodes_pb2.Node(parent_t_node=pose_message(parent_t_node)), "parent_t_node")

    def set_figures(self, name: str, figures: Figures) -> None:
        """Give a node other shapes."""
        self._update(name, nodes_pb2.Node(figures=figure_list(figures)), "figures")

    def remove(self, name: str) -> None:
        """Take a node and all below it out of the world."""
        self._submit(scene_pb2.Command(remove_node=scene_pb2.RemoveNode(name=name)))

    def attach(self, name: str, parent: str = "world", pose: PoseLike | None = None) -> None:
        """Give a node another parent; without `pose` (`parent_t_node`) it stays where it is in the world."""
        where = None if pose is None else pose_message(pose)
        command = scene_pb2.AttachNode(name=name, parent=parent, parent_t_node=where)
        self._submit(scene_pb2.Command(attach_node=command))

    def pick(self, robot: str, part: str | None = None, max_distance: float | None = None) -> None:
        """Fix a part to the robot's chosen tool; without a name the one nearest to the tool centre point.

        `max_distance` (m) is 0.2 by default when no part is named, and 1 when one is.
        """
        self._submit(pick_command(robot, part, max_distance))

    def place(self, robot: str, part: str | None = None, parent: str = "world") -> None:
        """Let a part of the robot's chosen tool go, or all parts; it stays where it is, fixed to `parent`."""
        self._submit(scene_pb2.Command(place_part=scene_pb2.PlacePart(robot=robot, part=part, parent=parent)))

    def set_joint_positions(self, robot: str, positions: Mapping[str, float] | ArrayLike) -> None:
        """Put joints somewhere at once: values by joint name, or all coordinates in order; radians and meters."""
        command = scene_pb2.SetJointPositions(robot=robot)
        if isinstance(positions, Mapping):
            command.joint_positions.update(joint_map(positions))
        else:
            command.coordinates.CopyFrom(array_message(positions))
        self._submit(scene_pb2.Command(set_joint_positions=command))

    def set_groups(self, robot: str, groups: Iterable[JointGroup]) -> None:
        """Give a robot these groups of joints, in place of those that it has."""
        command = scene_pb2.SetGroups(robot=robot, groups=[group._message for group in groups])
        self._submit(scene_pb2.Command(set_groups=command))

    def set_postures(
        self,
        robot: str,
        postures: Mapping[str, Mapping[str, float]] | None = None,
        *,
        removed: Iterable[str] = (),
    ) -> None:
        """Take postures of a robot away by name, then add others (rad or m by joint name); see `Robot.postures`."""
        added = [
            nodes_pb2.NamedPosture(name=name, joint_positions=joint_map(positions))
            for name, positions in (postures or {}).items()
        ]
        self._submit(
            scene_pb2.Command(set_postures=scene_pb2.SetPostures(robot=robot, postures=added, removed=removed))
        )

    def select_tool(self, robot: str, tool: str | None = None, tool_center_point: str | None = None) -> None:
        """Choose what a robot works with; no tool means the flange, no point the tool's first."""
        command = scene_pb2.SelectTool(robot=robot, tool=tool, tool_center_point=tool_center_point)
        self._submit(scene_pb2.Command(select_tool=command))

    def mount_tool(
        self,
        robot: str,
        node: str,
        parent: str | None = None,
        pose: PoseLike | None = None,
        tool_center_point: str | None = None,
    ) -> None:
        """Mount a tool, a gripper, or an adapter with one, on a robot, which works with it then.

        It goes to the flange, or to a link or adapter (`parent`) of the robot; without `pose` (`parent_t_node`) both
        frames coincide. Without a point it is the tool's first.
        """
        where = None if pose is None else pose_message(pose)
        command = scene_pb2.MountTool(
            robot=robot, node=node, parent=parent, parent_t_node=where, tool_center_point=tool_center_point
        )
        self._submit(scene_pb2.Command(mount_tool=command))

    def unmount_tool(
        self, robot: str, node: str | None = None, parent: str = "world", pose: PoseLike | None = None
    ) -> None:
        """Take a tool off a robot, by default the chosen one with its gripper, and fix it to `parent`, such as a rack.

        Without `pose` (`parent_t_node`) it stays where it is in the world.
        """
        where = None if pose is None else pose_message(pose)
        command = scene_pb2.UnmountTool(robot=robot, node=node, parent=parent, parent_t_node=where)
        self._submit(scene_pb2.Command(unmount_tool=command))

    def set_tool_state(self, tool: str, state: str) -> None:
        """Put a tool into a state at once, without a motion."""
        self._submit(scene_pb2.Command(set_tool_state=scene_pb2.SetToolState(tool=tool, state=state)))

    def create_signal(self, name: str, value: GivenValue = False, **options: Unpack[SignalOptions]) -> None:
        """Add a signal, whose type is that of `value`.

        Raises:
            NameTakenError: when there is one of this name.
            UnknownNameError: when there is no such owner.
        """
        check_options(options, SignalOptions, "a signal")
        direction = options.get("direction") or "internal"
        if direction not in _DIRECTIONS:
            raise InvalidArgumentError(f"a signal's direction is one of {', '.join(_DIRECTIONS)}, not {direction!r}")
        fields = {**options, "direction": _DIRECTIONS[direction]}
        signal = signal_pb2.Signal(name=name, value=value_message(value), **fields)
        self._submit(scene_pb2.Command(create_signal=scene_pb2.CreateSignal(signal=signal)))

    def remove_signal(self, name: str) -> None:
        """Take a signal out of the world."""
        self._submit(scene_pb2.Command(remove_signal=scene_pb2.RemoveSignal(name=name)))

    def set_signal(self, name: str, value: GivenValue) -> None:
        """Set a signal to a value of its type."""
        self._submit(set_command(name, value))

    def set_speed_factor(self, factor: float, robot: str | None = None) -> None:
        """Slow the motions of one robot, or with no name of all: above 0, up to 1; running ones change smoothly."""
        self._submit(scene_pb2.Command(set_speed_factor=scene_pb2.SetSpeedFactor(robot=robot, factor=factor)))

    def set_tcp_speed_limit(self, limit: float, robot: str) -> None:
        """Limit the speed of a robot's tool centre point (m/s), as for teaching (0.25); 0 lifts the limit."""
        command = scene_pb2.SetTcpSpeedLimit(robot=robot, meters_per_second=limit)
        self._submit(scene_pb2.Command(set_tcp_speed_limit=command))

    def set_kinematics(
        self, robot: str, kinematics: str | None = None, settings: Mapping[str, object] | None = None
    ) -> None:
        """Give a robot another kinematics component, tried at its first use; `Robot.set_kinematics` tries it now."""
        command = robot_pb2.KinematicsChoice(
            robot=robot, kinematics=kinematics, settings=settings_message(settings or {})
        )
        self._submit(scene_pb2.Command(set_kinematics=command))

    def set_craft(
        self,
        robot: str,
        kinematics: str,
        settings: Mapping[str, object] | None = None,
        drives: Mapping[str, str | tuple[str, float]] | None = None,
        *,
        base_joint: str | None = None,
        center: tuple[float, float] = (0.0, 0.0),
        heading: float = 0.0,
        current: Sequence[float] = (0.0, 0.0, 0.0),
        density: float | None = None,
        surface: float = 0.0,
    ) -> None:
        """Make a robot a craft: from now on its drives move its base.

        Args:
            robot: the robot; its base is planar or floating.
            kinematics: the component, such as `differential`, or `fossen` for a vehicle under water.
            settings: of the component.
            drives: the joint of each drive or passive wheel, or (joint, ratio) with joint = ratio * drive; what is not
                named is the joint of the same name.
            base_joint: by which the base moves; None means the first planar or floating joint.
            center: where the component has the origin of the base, in the frame of the link that this joint moves (m).
            heading: how far forward is turned to the left of that link's x axis (rad).
            current: velocity of the water about a vehicle in it, along the world's axes (m/s).
            density: of that water (kg/m^3); None means fresh water, 1000.
            surface: height of that water's surface (m).
        """
        named = {drive: (of, 1.0) if isinstance(of, str) else of for drive, of in (drives or {}).items()}
        craft = nodes_pb2.Craft(
            kinematics=kinematics,
            settings=settings_message(settings or {}),
            drives=[nodes_pb2.CraftDrive(drive=drive, joint=of, ratio=by) for drive, (of, by) in named.items()],
            base_joint=base_joint,
            center_x_meters=center[0],
            center_y_meters=center[1],
            heading_radians=heading,
            water=nodes_pb2.Water(
                current=vector_message(current, "a current"), density=density or 0.0, surface_height_meters=surface
            ),
        )
        self._submit(scene_pb2.Command(set_craft=scene_pb2.SetCraft(robot=robot, craft=craft)))

    def remove_craft(self, robot: str) -> None:
        """Make a robot no craft any more: its base is moved as other joints are."""
        self._submit(scene_pb2.Command(set_craft=scene_pb2.SetCraft(robot=robot)))

    def set_collisions(self, mode: str | None = None, **options: Unpack[CollisionOptions]) -> None:
        """Change what is done about collisions, as `client.collisions.set` does."""
        self._submit(collision_command(mode, options))

    def set_allowed_pairs(
        self, allow: Iterable[tuple[str, str, str]] = (), forbid: Iterable[tuple[str, str]] = ()
    ) -> None:
        """Let pairs touch no more, then let others (name, name, why) touch."""
        self._submit(pairs_command(allow, forbid))

    def start_sensors(self, *names: str) -> None:
        """Let sensors read at their rates (none named: all)."""
        self._submit(scene_pb2.Command(start_sensors=sensor_pb2.StartSensors(sensors=names)))

    def stop_sensors(self, *names: str) -> None:
        """Let sensors read no more (none named: all)."""
        self._submit(scene_pb2.Command(stop_sensors=sensor_pb2.StopSensors(sensors=names)))


class Batch(Editor[str]):
    """Commands that are collected and applied together; see `Scene.batch`."""

    def __init__(self) -> None:
        """Begin with no command."""
        self._commands: list[scene_pb2.Command] = []

    def _submit(self, command: scene_pb2.Command) -> None:
        self._commands.append(command)

    def _created(self, node: nodes_pb2.Node) -> str:
        self._submit(scene_pb2.Command(create_node=scene_pb2.CreateNode(node=node)))
        return node.name

    def __repr__(self) -> str:
        """Return a line for people."""
        kinds = [command.WhichOneof("command") or "" for command in self._commands]
        return f"<Batch of {len(kinds)} change{'s' * (len(kinds) != 1)}: {listed(kinds)}>"


class Direct(Editor[str]):
    """Applies each command at once; for handles that make single changes."""

    def __init__(self, services: Services) -> None:
        """Change the world of these services' kernel."""
        self._services = services

    def _submit(self, command: scene_pb2.Command) -> None:
        self._services.apply([command])

    def _created(self, node: nodes_pb2.Node) -> str:
        response = self._services.apply([scene_pb2.Command(create_node=scene_pb2.CreateNode(node=node))])
        return response.created[0].name

    def __repr__(self) -> str:
        """Return a line for people."""
        return f"<Direct changes of the kernel at {self._services.address}>"
