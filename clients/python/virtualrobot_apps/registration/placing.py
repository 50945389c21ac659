"""Registrations in a world: the model's points as they stand there, and what a device or a robot is kept as."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from virtualrobot.connection import Client
from virtualrobot.errors import InvalidArgumentError, UnknownNameError, WrongStateError
from virtualrobot.geometry import Matrix, turn_between

from virtualrobot_apps.registration.levelled import levelled
from virtualrobot_apps.registration.marker_pose import EDGE, SeenMarker, camera_matrix, markers_in, posed
from virtualrobot_apps.registration.touched import LEAST_APART, Registration, register
from virtualrobot_apps.registration.touched_file import TouchedFile

Floats = NDArray[np.float64]

AWAY = 1.5
"""Distance (m) from the middle of the points, or beside the marker, at which an error is told, whatever is there."""

MOST_MOVED = 2.0
"""Distance (pixels) of a corner from where the first picture has it beyond which the camera has moved."""


def named(read: TouchedFile) -> list[str]:
    """Return the nodes that a file names."""
    return list(dict.fromkeys([read.relative_to, *(point for point in read.model if isinstance(point, str))]))


def registered(read: TouchedFile, poses: Mapping[str, Matrix], least_apart: float = LEAST_APART) -> Registration:
    """Return the registration by a file, in the world's frame, in which z is up.

    Args:
        read: the file.
        poses: `world_t_node` by name, of the nodes that it names.
        least_apart: as `register` has it.
    """
    frame = poses[read.relative_to]
    points = [
        poses[point][:3, 3] if isinstance(point, str) else frame[:3, :3] @ point + frame[:3, 3] for point in read.model
    ]
    return register(points, read.touched, up=read.up, noise=read.noise, tilt=read.tilt, least_apart=least_apart)


def touched_in(
    client: Client, read: TouchedFile, tools: Sequence[str], least_apart: float = LEAST_APART
) -> tuple[Registration, dict[str, float]]:
    """Return the registration by a file in a world, and how far nodes are off by it (m), by their names."""
    poses = client.scene.poses(list(dict.fromkeys([*named(read), *tools])))
    found = registered(read, poses, least_apart)
    return found, {name: found.error(poses[name][:3, 3]) for name in tools}


def camera_in(
    client: Client, seen: SeenMarker, sheet: str, tools: Sequence[str], camera_up: Sequence[float] | None
) -> tuple[SeenMarker, Matrix, dict[str, float]]:
    """Return a marker as `settled` has it, where the camera is in the world, and how far nodes are off by it (m).

    `sheet` is the node where the marker is; the nodes are told by their names.
    """
    poses = client.scene.poses(list(dict.fromkeys([sheet, *tools])))
    seen, sheet_t_world = settled(seen, poses[sheet], camera_up), np.linalg.inv(poses[sheet])
    errors = {name: seen.error((sheet_t_world @ poses[name])[:3, 3]) for name in tools}
    return seen, poses[sheet] @ np.linalg.inv(seen.camera_t_marker), errors


def mean_corners(pictures: Mapping[str, Sequence[SeenMarker]], number: int | None) -> tuple[int, Floats]:
    """Return the marker that pictures by their names show, and the mean of its corners (4, 2) in them.

    Raises:
        InvalidArgumentError: where a picture doesn't show it, where `number` is None and there are several, and where
            the camera has moved between pictures.
    """
    corners = list[Floats]()
    for name, seen in pictures.items():
        there = [one for one in seen if number is None or one.number == number]
        if len(there) != 1:
            wanted = "a marker" if number is None else f"marker {number}"
            shown = ", ".join(str(one.number) for one in seen) or "none"
            more = "; say which one is meant" if number is None and there else ""
            raise InvalidArgumentError(f"{name} doesn't show {wanted} once: it shows {shown}{more}")
        number = there[0].number
        corners.append(there[0].corners)
    if number is None:
        raise InvalidArgumentError("no picture was given; give one that shows the marker, or some from the same place")
    moved = [float(np.linalg.norm(one - corners[0], axis=1).max()) for one in corners]
    if max(moved) > MOST_MOVED:
        first, name = next(iter(pictures)), list(pictures)[int(np.argmax(moved))]
        raise InvalidArgumentError(
            f"the camera has moved: in {name} a corner of the marker is {max(moved):.1f} pixels from where {first} has "
            "it; give pictures from one place"
        )
    return number, np.mean(corners, axis=0)


def seen_in(
    pictures: Mapping[str, NDArray[np.uint8]],
    *,
    field: float | None = None,
    matrix: Sequence[float] | None = None,
    distortion: Sequence[float] = (),
    edge: float = EDGE,
    number: int | None = None,
) -> SeenMarker:
    """Return the marker in pictures by their names, which one camera has taken from one place.

    Args:
        pictures: (height, width) grey values.
        field: the camera's horizontal field of view, rad; or
        matrix: its focal lengths and middle, fx, fy, cx, cy, pixels.
        distortion: OpenCV's coefficients.
        edge: of the marker, m.
        number: which marker; None means the one that is there.

    Raises:
        InvalidArgumentError: as `mean_corners` and `markers_in` do, for pictures of several sizes, and where both or
            none of field and matrix are given.
    """
    if (field is None) == (matrix is None):
        raise InvalidArgumentError("the camera's field of view or its matrix is needed, one of them")
    shapes = {name: (one.shape[1], one.shape[0]) for name, one in pictures.items()}
    first = next(iter(shapes.values()), (0, 0))
    for name, shape in shapes.items():
        if shape != first:
            raise InvalidArgumentError(
                f"the pictures are of one camera, {first[0]} x {first[1]} pixels as the first; {name} has "
                f"{shape[0]} x {shape[1]}"
            )
    if matrix is not None:
        across, down, x, y = matrix
        camera = np.array([[across, 0.0, x], [0.0, down, y], [0.0, 0.0, 1.0]])
    else:
        camera = camera_matrix(*first, field or 0.0)
    seen = {name: markers_in(one, camera, edge=edge, distortion=distortion) for name, one in pictures.items()}
    found, corners = mean_corners(seen, number)
    return posed(corners, found, camera, edge=edge, distortion=distortion)


def settled(seen: SeenMarker, world_t_marker: Matrix, camera_up: Sequence[float] | None) -> SeenMarker:
    """Return a marker whose sheet is at `world_t_marker`, turned in the one way that it can be.

    `camera_up` (3,) is away from gravity in the camera's frame; None where nobody knows. Raises InvalidArgumentError
    where the square may be turned in two ways, and nothing tells in which, and as `levelled` does.
    """
    if camera_up is not None:
        return levelled(seen, world_t_marker[:3, :3].T @ [0.0, 0.0, 1.0], camera_up)
    if seen.second is not None:
        apart = np.degrees(turn_between(seen.camera_t_marker, seen.second))
        raise InvalidArgumentError(
            f"the marker may be turned in two ways, {apart:.0f} degrees apart, which look alike from here; tell what "
            "is up for the camera, or take the picture from nearer or more from the side"
        )
    return seen


def keep_frame(client: Client, name: str, world_t_frame: Matrix, parent: str) -> None:
    """Keep a device as a frame of reference below a node, which goes along with it: one that is there, or a new one.

    Raises:
        WrongStateError: where the name is that of something else.
    """
    parent_t_frame = np.linalg.inv(client.scene.pose(parent)) @ world_t_frame
    try:
        node = client.scene.node(name)
    except UnknownNameError:
        client.scene.add_frame(name, pose=parent_t_frame, parent=parent)
        return
    if node.kind != "object" or [one._message.WhichOneof("geometry") for one in node.figures] != ["frame"]:
        raise WrongStateError(f"{name!r} is there already, and no frame of reference; give the device another name")
    client.scene.attach(name, parent, parent_t_frame)


def move_robot(client: Client, name: str, found: Registration) -> None:
    """Put a robot where it really is, whose points were touched by what measures in the world's own frame."""
    node = client.scene.node(name)
    real = np.linalg.inv(found.model_t_device) @ node.pose
    client.scene.set_pose(name, np.linalg.inv(client.scene.pose(node.parent)) @ real)
