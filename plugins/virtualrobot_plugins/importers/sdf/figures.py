"""Visuals and collisions of a link as figures of a scene file."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from virtualrobot_sdk.xml import Element, local_name

from virtualrobot_plugins.importers.sdf.elements import (
    Matrix,
    Notes,
    Place,
    child,
    flag,
    number,
    numbers,
    pose_matrix,
    pose_message,
    text,
    vector_message,
)
from virtualrobot_plugins.importers.sdf.materials import color_of
from virtualrobot_plugins.importers.sdf.scopes import LinkElement
from virtualrobot_plugins.importers.uris import join_uri
from virtualrobot_plugins.importers.xml import children

PLANE_THICKNESS = 0.001
"""Planes become boxes of this thickness in meters, below the plane."""

ENDLESS_PLANE = 100.0
"""The sides in meters of the box for a plane of a collision, which is endless in SDFormat."""

_LINK_DETAILS = (
    *("pose", "visual", "collision", "inertial", "gravity", "self_collide", "kinematic", "enable_wind"),
    *("velocity_decay", "must_be_base_link", "sensor"),
)


def link_figures(link: LinkElement, node_t_link: Matrix, main: str, notes: Notes) -> list[dict[str, Any]]:
    """Return the shapes of a link in the order of the file, in the frame of its node.

    `main` is the file that is translated: names of meshes in it stay as they are, those in included ones count from
    there.
    """
    place = link.place.inside(f"link {link.name!r}")
    figures = []
    for element in link.element.iterchildren("{*}*"):
        kind = local_name(element)
        if kind in ("visual", "collision"):
            figure = _figure(place, element, node_t_link, main, notes)
            if figure is not None:
                figures.append(figure)
        elif kind not in _LINK_DETAILS:
            notes.leave_out(place, element)
    return figures


def inertial_of(link: LinkElement, node_t_link: Matrix) -> dict[str, Any] | None:
    """Return mass and inertia of a link as scene files have them; None when the file tells none."""
    element = child(link.element, "inertial")
    if element is None:
        return None
    place = link.place.inside(f"link {link.name!r}")
    mass = number(place, element, "mass", 1.0)
    if not 0.0 <= mass < np.inf:
        raise place.error(element, f"<mass> is {mass:g} kg; it must not be below 0")
    inertia = child(element, "inertia")
    moments = {
        tag: 0.0 if inertia is None else number(place, inertia, tag, 0.0)
        for tag in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    }
    values = np.array(list(moments.values()))
    if not np.isfinite(values).all():
        raise place.error(element, "<inertia>: a number is not finite")
    return {
        "mass_kilograms": mass,
        "link_t_inertial": pose_message(node_t_link @ pose_matrix(place, child(element, "pose"))),
        "diagonal": vector_message(values[:3]),
        "products": vector_message(values[3:]),
    }


def _figure(place: Place, element: Element, node_t_link: Matrix, main: str, notes: Notes) -> dict[str, Any] | None:
    kind = local_name(element)
    pose = child(element, "pose")
    if pose is not None and pose.get("relative_to", "").strip():
        raise place.error(pose, f"<pose relative_to> of a <{kind}> is not read; give its pose in the link's frame")
    matrix = node_t_link @ pose_matrix(place, pose)
    geometry = child(element, "geometry")
    shapes = [] if geometry is None else list(geometry.iterchildren("{*}*"))
    if not shapes or local_name(shapes[0]) == "empty":
        return None
    shape = local_name(shapes[0])
    if shape == "plane":
        matrix, body = _plane(place, shapes[0], matrix, kind, notes)
    elif shape == "mesh":
        body = _mesh(place, shapes[0], main, notes)
    elif shape in _SHAPES:
        body = _SHAPES[shape](place, shapes[0])
    else:
        notes.warn(place, shapes[0], f"a <{shape}> is left out; known: mesh, plane, {', '.join(_SHAPES)}")
        return None
    if body is None:
        notes.warn(place, shapes[0], f"this <{shape}> has no extent and is left out")
        return None
    figure = {
        "node_t_figure": pose_message(matrix),
        "roles": ["FIGURE_ROLE_VISUAL" if kind == "visual" else "FIGURE_ROLE_COLLISION"],
        **body,
    }
    color = color_of(place, element, notes) if kind == "visual" else None
    if color is not None:
        figure["material"] = {"color": color}
    return figure


def _extent(place: Place, element: Element, tag: str) -> float:
    value = number(place, element, tag)
    if not 0.0 <= value < np.inf:
        raise place.error(element, f"<{tag}> is {value:g}; it must not be below 0")
    return value


def _box(place: Place, element: Element) -> dict[str, Any] | None:
    size = numbers(place, element, "size", 3)
    if (size < 0.0).any():
        raise place.error(element, "<size> must not be below 0")
    return {"box": {"size": vector_message(size)}} if size.all() else None


def _sphere(place: Place, element: Element) -> dict[str, Any] | None:
    radius = _extent(place, element, "radius")
    return {"sphere": {"radius_meters": radius}} if radius else None


def _round(kind: str) -> Callable[[Place, Element], dict[str, Any] | None]:
    def read(place: Place, element: Element) -> dict[str, Any] | None:
        radius, length = _extent(place, element, "radius"), _extent(place, element, "length")
        return {kind: {"radius_meters": radius, "length_meters": length}} if radius and length else None

    return read


_SHAPES: dict[str, Callable[[Place, Element], dict[str, Any] | None]] = {
    "box": _box,
    "sphere": _sphere,
    "cylinder": _round("cylinder"),
    "capsule": _round("capsule"),
    "cone": _round("cone"),
}


def _plane(
    place: Place, element: Element, matrix: Matrix, kind: str, notes: Notes
) -> tuple[Matrix, dict[str, Any] | None]:
    """Return a thin box whose upper side is the plane, and where it goes."""
    normal = numbers(place, element, "normal", 3, (0.0, 0.0, 1.0))
    length = float(np.linalg.norm(normal))
    if length == 0.0:
        raise place.error(element, "<normal> is 0 0 0, which is no direction")
    x, y = numbers(place, element, "size", 2, (1.0, 1.0))
    if kind == "collision":
        x, y = max(x, ENDLESS_PLANE), max(y, ENDLESS_PLANE)
        notes.warn(place, element, f"an endless <plane> collides as a plate of {x:g} m by {y:g} m")
    plane = np.eye(4)
    plane[:3, :3] = _z_onto(normal / length)
    below = np.eye(4)
    below[2, 3] = -PLANE_THICKNESS / 2.0
    size = np.array([x, y, PLANE_THICKNESS])
    return matrix @ plane @ below, {"box": {"size": vector_message(size)}} if (size > 0.0).all() else None


def _z_onto(normal: np.ndarray) -> np.ndarray:
    """Return the rotation (3, 3) of least angle that takes z to a unit vector."""
    x, y, z = normal
    if z < -1.0 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    cross = np.array([[0.0, 0.0, x], [0.0, 0.0, y], [-x, -y, 0.0]])
    return np.eye(3) + cross + cross @ cross / (1.0 + z)


def _mesh(place: Place, element: Element, main: str, notes: Notes) -> dict[str, Any] | None:
    uri = text(element, "uri")
    if not uri:
        raise place.error(element, "<mesh> needs a <uri>")
    for part in children(element, "submesh"):
        centered = flag(place, part, "center")
        name = text(part, "name")
        notes.warn(place, part, f"the whole mesh is shown, not only {name!r}" + (", and not centred" * centered))
    scale = numbers(place, element, "scale", 3, (1.0, 1.0, 1.0))
    if not scale.all():
        return None
    mesh: dict[str, Any] = {"uri": uri if place.uri == main else join_uri(place.uri, uri)}
    if (scale != 1.0).any():
        mesh["scale"] = vector_message(scale)
    return {"mesh": mesh}
