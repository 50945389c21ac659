"""View settings: messages to frozen settings and back; nodes by name outside, by uid inside."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from google.protobuf.field_mask_pb2 import FieldMask
from virtualrobot.v1 import geometry_pb2, view_pb2

from virtualrobot_kernel.api.convert.ghosts import ghost_messages, ghosts
from virtualrobot_kernel.collision.clearances import Clearance, is_there
from virtualrobot_kernel.drawing.view import Camera, ViewSettings
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.codecs import FINITE, EnumTable, OrDefault
from virtualrobot_kernel.messages.table import Table
from virtualrobot_kernel.messages.values import color, mask_fields, vector, vector_message
from virtualrobot_kernel.sensing.measuring import Measurement, NodePoint
from virtualrobot_kernel.sensing.overlays import PointColor, SensorOverlay
from virtualrobot_kernel.sensing.picture import BACKGROUND
from virtualrobot_kernel.world.apply_sensors import sensor_node
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import WORLD_UID, Kind, Structure


def changed_settings(view: view_pb2.View, mask: FieldMask, snapshot: Snapshot) -> dict[str, Any]:
    """Return the fields of ViewSettings that a mask names, with their new values."""
    structure = snapshot.structure
    fields = mask_fields(mask, view_pb2.View)
    if fields is None:
        names = ", ".join(field.name for field in view.DESCRIPTOR.fields)
        raise KernelError(f"update_mask must name the fields that change, some of {names}", field="update_mask")
    readers: dict[str, Callable[[], Any]] = {
        "background": lambda: color(view.background, "background")[:3] if view.HasField("background") else BACKGROUND,
        "grid_hidden": lambda: view.grid_hidden,
        "collisions_hidden": lambda: view.collisions_hidden,
        "joint_axes": lambda: tuple(structure.node(name, Kind.ROBOT).uid for name in view.joint_axes),
        "bounding_boxes": lambda: tuple(structure.node(name).uid for name in view.bounding_boxes),
        "camera": lambda: camera_of(view.camera, "camera", structure) if view.HasField("camera") else None,
        "sensors": lambda: tuple(_overlay(one, structure) for one in view.sensors),
        "measurements": lambda: tuple(_measurement(one, structure) for one in view.measurements),
        "clearances": lambda: tuple(_clearance(one, structure) for one in view.clearances),
        "ghosts": lambda: ghosts(view.ghosts, snapshot),
    }
    return {name: readers[name]() for name in sorted(fields)}


CAMERA = Table(Camera, view_pb2.Camera, field_of_view=OrDefault(FINITE), without=("node",))
COLORS = EnumTable(PointColor, view_pb2.PointColor, PointColor.DISTANCE)
OVERLAY = Table(SensorOverlay, view_pb2.SensorOverlay, color_by=COLORS, without=("uid", "sensor"))


def camera_of(message: view_pb2.Camera, what: str, structure: Structure) -> Camera:
    """Return a viewpoint of people; raise KernelError, which names the field, where it is none."""
    return CAMERA.read(message, what, node=structure.node(message.node).uid)


def node_point(message: view_pb2.NodePoint, what: str, structure: Structure) -> NodePoint:
    """Return a point that moves with a node; raise KernelError, naming `what`, where it is none."""
    return NodePoint(structure.node(message.node).uid, vector(message.point, f"{what}.point"))


def _overlay(message: view_pb2.SensorOverlay, structure: Structure) -> SensorOverlay:
    return OVERLAY.read(message, f"sensors[{message.sensor!r}]", uid=sensor_node(structure, message.sensor).uid)


def _measurement(message: view_pb2.Measurement, structure: Structure) -> Measurement:
    what = f"measurements[{message.name!r}]"
    return Measurement(
        message.name,
        node_point(message.first, f"{what}.first", structure),
        node_point(message.second, f"{what}.second", structure),
    )


def _clearance(message: view_pb2.Clearance, structure: Structure) -> Clearance:
    if not message.first:
        field = f"clearances[{message.name!r}].first"
        raise KernelError(f"{field} names no node; name at least one", field=field)
    first, second = (tuple(structure.node(name).uid for name in names) for names in (message.first, message.second))
    return Clearance(message.name, first, second)


def _node_point_message(place: NodePoint, structure: Structure) -> view_pb2.NodePoint:
    return view_pb2.NodePoint(node=structure.nodes[place.uid].name, point=vector_message(place.point))


def view_message(settings: ViewSettings, structure: Structure) -> view_pb2.View:
    """Return the settings as a message; nodes that are gone are left out."""
    red, green, blue = settings.background
    message = view_pb2.View(
        background=geometry_pb2.Color(red=red, green=green, blue=blue),
        grid_hidden=settings.grid_hidden,
        collisions_hidden=settings.collisions_hidden,
        joint_axes=[structure.nodes[uid].name for uid in settings.joint_axes if uid in structure.nodes],
        bounding_boxes=[structure.nodes[uid].name for uid in settings.bounding_boxes if uid in structure.nodes],
    )
    if settings.camera is not None and settings.camera.node in structure.nodes:
        node = structure.nodes[settings.camera.node].name if settings.camera.node != WORLD_UID else ""
        message.camera.CopyFrom(CAMERA.write(settings.camera, node=node))
    message.sensors.extend(
        OVERLAY.write(one, sensor=structure.nodes[one.uid].name)
        for one in settings.sensors
        if one.uid in structure.nodes
    )
    message.measurements.extend(
        view_pb2.Measurement(
            name=one.name,
            first=_node_point_message(one.first, structure),
            second=_node_point_message(one.second, structure),
        )
        for one in settings.measurements
        if one.first.uid in structure.nodes and one.second.uid in structure.nodes
    )
    nodes = structure.nodes
    message.clearances.extend(
        view_pb2.Clearance(
            name=one.name,
            first=[nodes[uid].name for uid in one.first if uid in nodes],
            second=[nodes[uid].name for uid in one.second if uid in nodes],
        )
        for one in settings.clearances
        if is_there(structure, one)
    )
    message.ghosts.extend(ghost_messages(settings.ghosts, structure))
    return message
