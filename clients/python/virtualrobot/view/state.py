"""State of the picture's set-up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.arguments import ArrayLike
from virtualrobot._wire.messages import value_or_default, vector_message, vector_of
from virtualrobot._wire.showing import shown
from virtualrobot.v1 import view_pb2
from virtualrobot.view.ghosts import Ghost, ghost_of
from virtualrobot.view.measuring import Place

POINT_COLORS = {"distance": view_pb2.POINT_COLOR_DISTANCE, "intensity": view_pb2.POINT_COLOR_INTENSITY}
_COLOR_NAMES = {number: name for name, number in POINT_COLORS.items()}


@shown
@dataclass(frozen=True, slots=True)
class SensorOverlay:
    """Overlay of a sensor; see `View.show_sensor`."""

    points: bool
    rays: bool
    color_by: str
    frustum: bool
    image: bool


@shown
@dataclass(frozen=True, slots=True, eq=False)
class ViewState:
    """State of the picture's set-up; the properties of `View` tell more of each.

    Attributes:
        background: (3,) red, green, blue, 0 to 1.
        grid: true where the grid on the floor is shown.
        collisions: true where what collides is shown.
        joint_axes: the robots whose joint axes are shown.
        bounding_boxes: the nodes whose bounding boxes are shown.
        measurements: the distances between two points that are shown, by name.
        clearances: the least distances that are shown, by name.
        ghosts: robots that are shown where they are not, by name.
        sensors: overlays of sensors, by the sensors' names.
        camera_position: (3,) where people look from, meters in the frame of `camera_node`.
        camera_target: (3,) what they look at.
        field_of_view: vertical, in radians; None means the default.
        camera_node: the node that the camera goes along with, in whose frame it is; empty means the world.
        camera_keeps_direction: true where it doesn't turn with that node; see `View.set_camera`.
    """

    background: NDArray[np.float64]
    grid: bool
    collisions: bool
    joint_axes: tuple[str, ...]
    bounding_boxes: tuple[str, ...]
    measurements: dict[str, tuple[Place, Place]]
    clearances: dict[str, tuple[list[str], list[str]]]
    ghosts: dict[str, Ghost]
    sensors: dict[str, SensorOverlay]
    camera_position: NDArray[np.float64]
    camera_target: NDArray[np.float64]
    field_of_view: float | None
    camera_node: str
    camera_keeps_direction: bool

    @staticmethod
    def of(message: view_pb2.View) -> ViewState:
        """Return what a message tells."""
        color = message.background
        return ViewState(
            np.array([color.red, color.green, color.blue]),
            not message.grid_hidden,
            not message.collisions_hidden,
            tuple(message.joint_axes),
            tuple(message.bounding_boxes),
            {one.name: (_place(one.first), _place(one.second)) for one in message.measurements},
            {one.name: (list(one.first), list(one.second)) for one in message.clearances},
            {one.name: ghost_of(one) for one in message.ghosts},
            {one.sensor: _overlay(one) for one in message.sensors},
            vector_of(message.camera.position),
            vector_of(message.camera.target),
            message.camera.field_of_view_radians or None,
            message.camera.node,
            message.camera.keeps_direction,
        )


def camera_message(position: ArrayLike, target: ArrayLike, field_of_view: float | None) -> view_pb2.Camera:
    """Return where people look from as a message."""
    return view_pb2.Camera(
        position=vector_message(position, "the camera's position"),
        target=vector_message(target, "the camera's target"),
        field_of_view_radians=value_or_default(field_of_view, "field_of_view"),
    )


def _place(message: view_pb2.NodePoint) -> Place:
    return message.node, vector_of(message.point)


def _overlay(message: view_pb2.SensorOverlay) -> SensorOverlay:
    color_by = _COLOR_NAMES.get(message.color_by, "distance")
    return SensorOverlay(message.points, message.rays, color_by, message.frustum, message.image)
