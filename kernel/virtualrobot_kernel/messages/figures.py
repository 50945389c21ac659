"""Figures and materials: messages to frozen values and back."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from virtualrobot.v1 import geometry_pb2, nodes_pb2

from virtualrobot_kernel.errors import KernelError, LimitError
from virtualrobot_kernel.messages.values import (
    array,
    array_message,
    is_identity,
    not_negative,
    pose,
    pose_message,
    positive,
    vector,
    vector_message,
)
from virtualrobot_kernel.world.figures import (
    FEWEST_HULL_VERTICES,
    MOST_HULL_VERTICES,
    Box,
    Capsule,
    Cone,
    Cylinder,
    Figure,
    Frame,
    Geometry,
    Label,
    Lines,
    Material,
    Mesh,
    Points,
    Sphere,
)

VISUAL, COLLISION = nodes_pb2.FIGURE_ROLE_VISUAL, nodes_pb2.FIGURE_ROLE_COLLISION
ROUND = {"cylinder": Cylinder, "cone": Cone, "capsule": Capsule}
GREATEST_TEXT = 10_000
"""The longest label, in characters."""


def figure(message: nodes_pb2.Figure, what: str) -> Figure:
    """Return a figure; raise KernelError that says what is wrong with it."""
    kind = message.WhichOneof("geometry")
    if kind is None:
        names = ", ".join(field.name for field in message.DESCRIPTOR.oneofs_by_name["geometry"].fields)
        raise KernelError(f"{what} has no geometry; give one of {names}", field=what)
    roles = set(message.roles)
    if not roles <= {VISUAL, COLLISION}:
        raise KernelError(
            f"{what}.roles must be FIGURE_ROLE_VISUAL or FIGURE_ROLE_COLLISION, not {list(roles)}", field=what
        )
    return Figure(
        geometry=_geometry(kind, getattr(message, kind), f"{what}.{kind}"),
        node_t_figure=pose(message.node_t_figure, f"{what}.node_t_figure"),
        material=_material(message.material, f"{what}.material") if message.HasField("material") else None,
        visual=not roles or VISUAL in roles,
        collision=not roles or COLLISION in roles,
        tool_state=message.tool_state,
    )


def figure_message(figure: Figure) -> nodes_pb2.Figure:
    """Return a figure as a message, with nothing that is the default."""
    message = nodes_pb2.Figure(tool_state=figure.tool_state)
    if not is_identity(figure.node_t_figure):
        message.node_t_figure.CopyFrom(pose_message(figure.node_t_figure))
    if figure.material is not None:
        message.material.CopyFrom(_material_message(figure.material))
    if not (figure.visual and figure.collision):
        message.roles.extend([VISUAL] * figure.visual + [COLLISION] * figure.collision)
    MESSAGES[type(figure.geometry)](message, figure.geometry)
    return message


def _geometry(kind: str, message: Any, what: str) -> Geometry:  # noqa: ANN401 a message of the oneof's kind
    if kind == "box":
        x, y, z = vector(message.size, f"{what}.size")
        return Box((positive(x, f"{what}.size.x"), positive(y, f"{what}.size.y"), positive(z, f"{what}.size.z")))
    if kind == "sphere":
        return Sphere(positive(message.radius_meters, f"{what}.radius_meters"))
    if kind in ROUND:
        radius = positive(message.radius_meters, f"{what}.radius_meters")
        return ROUND[kind](radius, positive(message.length_meters, f"{what}.length_meters"))
    if kind == "mesh":
        return _mesh(message, what)
    if kind == "points":
        positions = array(message.positions, (None, 3), f"{what}.positions")
        colors = array(message.colors, (len(positions), 3), f"{what}.colors") if message.HasField("colors") else None
        size = not_negative(message.size_meters, f"{what}.size_meters") or 0.01
        return Points(positions.tobytes(), b"" if colors is None else colors.astype(np.uint8).tobytes(), size)
    if kind == "lines":
        segments = array(message.segments, (None, 2, 3), f"{what}.segments")
        return Lines(segments.tobytes(), not_negative(message.width_pixels, f"{what}.width_pixels") or 2.0)
    if kind == "frame":
        return Frame(not_negative(message.length_meters, f"{what}.length_meters") or 0.1)
    if len(message.text) > GREATEST_TEXT:
        raise KernelError(f"{what}.text may have {GREATEST_TEXT} characters, not {len(message.text)}", field=what)
    return Label(message.text)


def _mesh(message: nodes_pb2.Mesh, what: str) -> Mesh:
    if not message.uri:
        raise KernelError(f"{what}.uri must name the file; its ending tells the format", field=what)
    scale = vector(message.scale, f"{what}.scale") if message.HasField("scale") else (1.0, 1.0, 1.0)
    if 0.0 in scale:
        raise KernelError(f"{what}.scale may not be 0 along any axis, it is {scale}", field=what)
    most = message.collision_hull_vertices
    if most and not FEWEST_HULL_VERTICES <= most <= MOST_HULL_VERTICES:
        raise LimitError(
            f"{what}.collision_hull_vertices must be {FEWEST_HULL_VERTICES} to {MOST_HULL_VERTICES}, or 0, not {most}",
            field=f"{what}.collision_hull_vertices",
            value=most,
            lower=FEWEST_HULL_VERTICES,
            upper=MOST_HULL_VERTICES,
        )
    return Mesh(message.uri, message.sha256, scale, tuple((file.uri, file.sha256) for file in message.files), most)


def _material(message: nodes_pb2.Material, what: str) -> Material:
    shown = color(message.color, f"{what}.color") if message.HasField("color") else None
    reflectance = message.reflectance if message.HasField("reflectance") else 0.5
    friction = message.friction if message.HasField("friction") else 0.5
    if not 0.0 <= reflectance <= 1.0:
        raise KernelError(f"{what}.reflectance must be 0 to 1, not {reflectance:g}", field=what)
    if not 0.0 <= friction < np.inf:
        raise KernelError(f"{what}.friction must be 0 or more, not {friction:g}", field=what)
    return Material(shown, reflectance, friction)


def _material_message(material: Material) -> nodes_pb2.Material:
    message = nodes_pb2.Material()
    if material.color is not None:
        message.color.CopyFrom(color_message(material.color))
    if material.reflectance != 0.5:
        message.reflectance = material.reflectance
    if material.friction != 0.5:
        message.friction = material.friction
    return message


def color(message: geometry_pb2.Color, what: str) -> tuple[float, float, float, float]:
    """Return red, green, blue, alpha; raise KernelError unless all are from 0 to 1."""
    alpha = message.alpha if message.HasField("alpha") else 1.0
    parts = (message.red, message.green, message.blue, alpha)
    if not all(0.0 <= part <= 1.0 for part in parts):
        raise KernelError(f"{what} must have parts from 0 to 1, not {parts}", field=what)
    return parts


def color_message(color: tuple[float, ...]) -> geometry_pb2.Color:
    """Return red, green, blue, alpha as a message."""
    red, green, blue, alpha = color
    message = geometry_pb2.Color(red=red, green=green, blue=blue)
    if alpha != 1.0:
        message.alpha = alpha
    return message


def _set_mesh(message: nodes_pb2.Figure, mesh: Mesh) -> None:
    message.mesh.uri, message.mesh.sha256 = mesh.uri, mesh.sha256
    if mesh.scale != (1.0, 1.0, 1.0):
        message.mesh.scale.CopyFrom(vector_message(mesh.scale))
    for uri, sha256 in mesh.files:
        message.mesh.files.add(uri=uri, sha256=sha256)
    message.mesh.collision_hull_vertices = mesh.collision_hull_vertices


def _set_points(message: nodes_pb2.Figure, points: Points) -> None:
    message.points.positions.CopyFrom(array_message(np.frombuffer(points.positions).reshape(-1, 3)))
    if points.colors:
        colors = np.frombuffer(points.colors, np.uint8).reshape(-1, 3)
        message.points.colors.CopyFrom(array_message(colors, geometry_pb2.NUMERIC_TYPE_UINT8))
    message.points.size_meters = points.size


def _set_lines(message: nodes_pb2.Figure, lines: Lines) -> None:
    message.lines.segments.CopyFrom(array_message(np.frombuffer(lines.segments).reshape(-1, 2, 3)))
    message.lines.width_pixels = lines.width


def _set_round(name: str) -> Callable[[nodes_pb2.Figure, Cylinder | Cone | Capsule], None]:
    def fill(message: nodes_pb2.Figure, geometry: Cylinder | Cone | Capsule) -> None:
        part = getattr(message, name)
        part.radius_meters, part.length_meters = geometry.radius, geometry.length

    return fill


MESSAGES: dict[type, Callable[[nodes_pb2.Figure, Any], None]] = {
    Box: lambda message, box: message.box.size.CopyFrom(vector_message(box.size)),
    Sphere: lambda message, sphere: message.sphere.MergeFrom(nodes_pb2.Sphere(radius_meters=sphere.radius)),
    Cylinder: _set_round("cylinder"),
    Cone: _set_round("cone"),
    Capsule: _set_round("capsule"),
    Mesh: _set_mesh,
    Points: _set_points,
    Lines: _set_lines,
    Frame: lambda message, frame: message.frame.MergeFrom(nodes_pb2.Frame(length_meters=frame.length)),
    Label: lambda message, label: message.label.MergeFrom(nodes_pb2.Label(text=label.text)),
}
