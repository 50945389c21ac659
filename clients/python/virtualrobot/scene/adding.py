"""The nodes that can be added to a scene, one function for each kind."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Generic, TypeVar

from virtualrobot._wire.arguments import ArrayLike, PoseLike, checked
from virtualrobot._wire.messages import M, Wrapped, joint_map, pose_message, value_or_default
from virtualrobot.robots.dynamics import Inertial
from virtualrobot.scene.figures import Figures, figure_list, frame
from virtualrobot.sensors.cameras import CameraSettings, LightSettings
from virtualrobot.sensors.contact_sensors import ContactSensorSettings
from virtualrobot.sensors.motion_sensors import MotionSensorSettings
from virtualrobot.sensors.range_sensors import RangeSensorSettings
from virtualrobot.v1 import nodes_pb2, scene_pb2, sensing_pb2

Created = TypeVar("Created")


def viewpoint_message(distance: float | None, field_of_view: float | None) -> nodes_pb2.Viewpoint:
    """Return how far ahead (m) a viewpoint looks, and with which field of view (rad)."""
    return nodes_pb2.Viewpoint(
        distance_meters=value_or_default(distance, "distance"),
        field_of_view_radians=value_or_default(field_of_view, "field_of_view"),
    )


def _unwrapped(value: Wrapped[M] | None) -> M | None:
    return None if value is None else value._message


@checked
class Adding(ABC, Generic[Created]):
    """Nodes that a scene can be given."""

    @abstractmethod
    def _submit(self, command: scene_pb2.Command) -> None:
        """Take a command."""

    @abstractmethod
    def _created(self, node: nodes_pb2.Node) -> Created:
        """Add a node as the contract describes it."""

    def _add(self, name: str, parent: str, pose: PoseLike | None, figures: Figures, **kind: object) -> Created:
        node = nodes_pb2.Node(name=name, parent=parent, figures=figure_list(figures), **kind)  # pyright: ignore[reportArgumentType] one field of the oneof
        if pose is not None:
            node.parent_t_node.CopyFrom(pose_message(pose))
        return self._created(node)

    def add_object(
        self, name: str, figures: Figures = (), *, pose: PoseLike | None = None, parent: str = "world"
    ) -> Created:
        """Add a piece of the environment: a table, a fence, or without figures a frame of reference.

        `pose` is `parent_t_node`, 4x4, meters; without it the node is at its parent's origin.
        """
        return self._add(name, parent, pose, figures, object=nodes_pb2.SceneObject())

    def add_part(
        self,
        name: str,
        figures: Figures,
        *,
        pose: PoseLike | None = None,
        parent: str = "world",
        mass: float | None = None,
        inertial: Inertial | None = None,
        dynamic: bool = False,
    ) -> Created:
        """Add a thing that robots handle.

        `mass` in kg, unknown by default; without `inertial` (see `virtualrobot.inertial`) it is a point at the part's
        origin. One that is `dynamic` moves by forces where physics are set (`client.physics`); it needs a mass, which
        is spread evenly in its figures then.

        Example:
            >>> scene.add_part("box-1", virtualrobot.box(0.1, 0.1, 0.1, color="red"), pose=virtualrobot.pose(0.5))
        """
        kilograms = value_or_default(mass, f"the mass of {name!r}")
        part = nodes_pb2.Part(mass_kilograms=kilograms, inertial=_unwrapped(inertial), dynamic=dynamic)
        return self._add(name, parent, pose, figures, part=part)

    def add_adapter(self, name: str, parent: str, figures: Figures = (), *, pose: PoseLike | None = None) -> Created:
        """Add what stands between a flange (the link `parent`) and a tool."""
        return self._add(name, parent, pose, figures, adapter=nodes_pb2.Adapter())

    def add_tool(
        self,
        name: str,
        parent: str,
        figures: Figures = (),
        *,
        pose: PoseLike | None = None,
        tool_center_points: Mapping[str, ArrayLike] | None = None,
        states: Mapping[str, Mapping[str, float]] | None = None,
        inertial: Inertial | None = None,
        widths: Mapping[float, Mapping[str, float]] | None = None,
    ) -> Created:
        """Mount a tool on a flange or adapter (`parent`).

        `tool_center_points` gives `tool_t_tcp` (4x4) by name, the first is chosen at the start. `states` gives the
        joint positions of each state by name, radians or meters; the first is the state at the start. `inertial` is the
        tool's mass, as `virtualrobot.inertial` makes it. `widths` gives joint positions by how wide it is open (m), two
        or more; between them it goes straight.
        """
        tool = nodes_pb2.Tool(
            tool_center_points=[
                nodes_pb2.ToolCenterPoint(name=point, tool_t_tcp=pose_message(tool_t_tcp))
                for point, tool_t_tcp in (tool_center_points or {}).items()
            ],
            states=[
                nodes_pb2.ToolState(name=state, joint_positions=joint_map(positions))
                for state, positions in (states or {}).items()
            ],
            widths=[
                nodes_pb2.ToolWidth(width_meters=width, joint_positions=joint_map(positions))
                for width, positions in sorted((widths or {}).items())
            ],
            inertial=_unwrapped(inertial),
        )
        return self._add(name, parent, pose, figures, tool=tool)

    def add_camera(
        self,
        name: str,
        settings: CameraSettings | None = None,
        figures: Figures = (),
        *,
        pose: PoseLike | None = None,
        parent: str = "world",
    ) -> Created:
        """Add a camera; it looks along z of its pose (`parent_t_camera`), x to the right of the picture and y down.

        `virtualrobot.camera` makes the settings, `virtualrobot.looking_at` the pose. It does not see its own figures.
        """
        return self._add(name, parent, pose, figures, camera_sensor=_unwrapped(settings) or sensing_pb2.CameraSensor())

    def add_range_sensor(
        self,
        name: str,
        settings: RangeSensorSettings | None = None,
        figures: Figures = (),
        *,
        pose: PoseLike | None = None,
        parent: str = "world",
    ) -> Created:
        """Add a range sensor; it looks along x of its pose (`parent_t_sensor`), z upwards.

        `virtualrobot.range_sensor` makes the settings. It does not see its own figures.
        """
        return self._add(name, parent, pose, figures, range_sensor=_unwrapped(settings) or sensing_pb2.RangeSensor())

    def add_light(
        self,
        name: str,
        settings: LightSettings | None = None,
        figures: Figures = (),
        *,
        pose: PoseLike | None = None,
        parent: str = "world",
    ) -> Created:
        """Add a light, as `virtualrobot.light` makes it; spots and directional ones shine along z of their pose.

        Its own figures cast shadows like all others: leave room between them and its origin, or give it none.
        """
        return self._add(name, parent, pose, figures, light=_unwrapped(settings) or sensing_pb2.Light())

    def add_motion_sensor(
        self,
        name: str,
        settings: MotionSensorSettings,
        figures: Figures = (),
        *,
        parent: str,
        pose: PoseLike | None = None,
    ) -> Created:
        """Fix a motion sensor to something that moves; `pose` is `parent_t_sensor`.

        `virtualrobot.imu`, `encoders`, `pose_sensor` and `force_torque_sensor` make the settings.
        """
        return self._add(name, parent, pose, figures, motion_sensor=settings._message)

    def add_contact_sensor(
        self,
        name: str,
        settings: ContactSensorSettings | None = None,
        figures: Figures = (),
        *,
        parent: str = "world",
        pose: PoseLike | None = None,
    ) -> Created:
        """Add a contact sensor, as `virtualrobot.contact_sensor` makes it; without a `watched` node its parent feels.

        `pose` (`parent_t_sensor`) says where the box of its region is.
        """
        return self._add(
            name, parent, pose, figures, contact_sensor=_unwrapped(settings) or sensing_pb2.ContactSensor()
        )

    def add_annotation(
        self, name: str, figures: Figures, *, pose: PoseLike | None = None, parent: str = "world"
    ) -> Created:
        """Add something that is drawn for people only."""
        return self._add(name, parent, pose, figures, annotation=nodes_pb2.Annotation())

    def add_frame(
        self, name: str, *, pose: PoseLike | None = None, parent: str = "world", size: float | None = None
    ) -> Created:
        """Add a frame of reference, drawn as arrows of `size` meters (0.1 by default): x red, y green, z blue.

        Goals are given in it by `reference`, targets are taught below it, and all that hangs on it moves with it.

        Example:
            >>> scene.add_frame("fixture", pose=virtualrobot.pose(0.5, 0.2, 0.1), parent="table")
        """
        return self.add_object(name, frame(size), pose=pose, parent=parent)

    def add_target(
        self,
        name: str,
        *,
        pose: PoseLike | None = None,
        parent: str = "world",
        robot: str = "",
        joint_positions: Mapping[str, float] | None = None,
    ) -> Created:
        """Add a target, a place where tools work, at a pose (`parent_t_target`); `Robot.teach` saves one.

        With `robot` and its `joint_positions` (radians or meters by joint name), point-to-point moves of this robot
        take the posture nearest to them.
        """
        target = nodes_pb2.Target(robot=robot, joint_positions=joint_map(joint_positions or {}))
        return self._add(name, parent, pose, (), target=target)

    def add_viewpoint(
        self,
        name: str,
        *,
        pose: PoseLike | None = None,
        parent: str = "world",
        distance: float | None = None,
        field_of_view: float | None = None,
    ) -> Created:
        """Add a viewpoint, a view of people under a name, at a pose (`parent_t_eye`); `client.view.save` saves one.

        The eye looks along z, x to the right (`virtualrobot.looking_at` makes such poses). What is looked at is
        `distance` ahead, 1 m by default; `field_of_view` is vertical, in radians, 0.9 by default.
        """
        return self._add(name, parent, pose, (), viewpoint=viewpoint_message(distance, field_of_view))
