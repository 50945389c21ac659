"""Viewpoints of pictures and hits under a pixel: messages to shots and back."""

from __future__ import annotations

import math

from virtualrobot.v1 import geometry_pb2, view_pb2

from virtualrobot_kernel.api.convert.view import camera_of
from virtualrobot_kernel.drawing.renderer import Picked
from virtualrobot_kernel.drawing.shots import HEIGHT, LARGEST, WIDTH, ImageFormat, Shot
from virtualrobot_kernel.drawing.view import Camera, check_camera
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.messages.values import GREATEST, check_enum, finite, not_negative, stamp, vector_message
from virtualrobot_kernel.sensing.lenses import size_of
from virtualrobot_kernel.world.sensing import CameraSensor
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind, Structure, ViewpointData

DEFAULT_RATE = 25.0
"""Default pictures a second of a film."""
LEAST_RATE = 1e-6
"""Least pictures a second of a film: one in 12 days."""


def shot_of(message: view_pb2.Shot, structure: Structure) -> Shot:
    """Return the shot of a picture; raise KernelError where it cannot be taken."""
    check_enum(message, "format")
    eye, sensor = _from(message, "shot", structure)
    return Shot(
        camera=eye,
        sensor=sensor,
        width=_size(message.width, "shot.width"),
        height=_size(message.height, "shot.height"),
        format=ImageFormat(message.format or ImageFormat.PNG.value),
        plain=message.plain,
    )


def picture_size(shot: Shot, snapshot: Snapshot) -> tuple[int, int]:
    """Return the width and height in pixels that a picture will have."""
    node = snapshot.structure.nodes.get(shot.sensor)
    own = size_of(node.data) if node is not None and isinstance(node.data, CameraSensor) else (WIDTH, HEIGHT)
    return shot.width or own[0], shot.height or own[1]


def film_of(message: view_pb2.RecordFilmRequest, snapshot: Snapshot) -> tuple[float, int | None]:
    """Return a film's pictures a second, and how many there are (None: no end)."""
    rate = not_negative(message.frames_per_second, "frames_per_second") or DEFAULT_RATE
    most = 1.0 / snapshot.tick_seconds
    if not LEAST_RATE <= rate <= most * (1.0 + 1e-9):
        raise KernelError(
            f"frames_per_second must be {LEAST_RATE:g} to {most:g}, one picture a tick, not {rate:g}",
            field="frames_per_second",
            value=rate,
        )
    duration = not_negative(message.duration_seconds, "duration_seconds")
    if duration > GREATEST:
        raise KernelError(
            f"duration_seconds must be at most {GREATEST:g}, not {duration:g}", field="duration_seconds", value=duration
        )
    return rate, max(1, round(duration * rate)) if duration else None


def pixel_of(message: view_pb2.PickPixelRequest, snapshot: Snapshot) -> tuple[Shot, float, float]:
    """Return the picture that a pixel is in, its column and its row; raise KernelError where there is none."""
    eye, sensor = _from(message, "", snapshot.structure)
    shot = Shot(eye, sensor, _size(message.width, "width"), _size(message.height, "height"))
    if sensor and (shot.width or shot.height):
        raise KernelError("width and height are those of the camera_sensor; leave them out", field="width")
    width, height = picture_size(shot, snapshot)
    for what, value, size in (("column", message.column, width), ("row", message.row, height)):
        if not -0.5 <= finite(value, what) <= size - 0.5:
            raise KernelError(
                f"{what} must be 0 to {size - 1} in a picture of {width} x {height} pixels, not {value:g}",
                field=what,
                value=value,
            )
    return shot, message.column, message.row


def pick_message(picked: Picked | None, snapshot: Snapshot) -> view_pb2.PickPixelResponse:
    """Return the hit under a pixel as a message."""
    response = view_pb2.PickPixelResponse(stamp=stamp(snapshot))
    if picked is None:
        response.distance_meters = math.inf
        return response
    world_t_node = snapshot.world_t(picked.uid)
    red, green, blue = picked.color
    response.MergeFrom(
        view_pb2.PickPixelResponse(
            node=snapshot.structure.nodes[picked.uid].name,
            world_point=vector_message(picked.point.tolist()),
            node_point=vector_message((world_t_node[:3, :3].T @ (picked.point - world_t_node[:3, 3])).tolist()),
            normal=vector_message(picked.normal.tolist()),
            distance_meters=picked.distance,
            color=geometry_pb2.Color(red=red, green=green, blue=blue, alpha=1.0),
        )
    )
    return response


def _from(
    message: view_pb2.Shot | view_pb2.PickPixelRequest, what: str, structure: Structure
) -> tuple[Camera | None, int]:
    """Return the camera, or the uid of the camera sensor, that a message looks from: neither means the view's."""
    if message.WhichOneof("from") == "camera_sensor":
        named = structure.nodes.get(structure.uid_by_name.get(message.camera_sensor, 0))
        if named is not None and isinstance(named.data, ViewpointData):
            ahead = (0.0, 0.0, named.data.distance)
            return Camera(target=ahead, field_of_view=named.data.field_of_view, node=named.uid), 0
        return None, structure.node(message.camera_sensor, Kind.CAMERA_SENSOR).uid
    if message.WhichOneof("from") is None:
        return None, 0
    eye = camera_of(message.camera, f"{what}.camera".lstrip("."), structure)
    check_camera(eye)
    return eye, 0


def _size(value: int, what: str) -> int:
    if value > LARGEST:
        raise KernelError(
            f"{what} must be at most {LARGEST} pixels (0: as it is without), not {value:,}", field=what, value=value
        )
    return value
