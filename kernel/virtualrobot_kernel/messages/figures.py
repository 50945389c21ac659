"""Figures and materials: messages to frozen values and back."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from virtualrobot.v1 import geometry_pb2, nodes_pb2

from virtualrobot_kernel.errors import KernelError, LimitError
from virtualrobot_kernel.messages.codecs import NOT_NEGATIVE, POSITIVE, OrDefault, Pair, rows
from virtualrobot_kernel.messages.table import OneOf, Table
from virtualrobot_kernel.messages.values import array, array_message, positive, vector, vector_message
from virtualrobot_kernel.units import MOST_LENGTH, millimetres_question
from virtualrobot_kernel.world.figures import (
    FEWEST_HULL_VERTICES,
    MOST_HULL_VERTICES,
    Box,
    Capsule,
    Cone,
    Cylinder,
    Figure,
    Frame,
    Label,
    Lines,
    Material,
    Mesh,
    Points,
    Sphere,
)

VISUAL, COLLISION = nodes_pb2.FIGURE_ROLE_VISUAL, nodes_pb2.FIGURE_ROLE_COLLISION
GREATEST_TEXT = 10_000
"""The longest label, in characters."""


def _size(message: geometry_pb2.Vector3, what: str) -> tuple[float, float, float]:
    x, y, z = vector(message, what)
    return positive(x, f"{what}.x"), positive(y, f"{what}.y"), positive(z, f"{what}.z")


def _check_mesh(mesh: Mesh, what: str) -> None:
    if not mesh.uri:
        raise KernelError(f"{what}.uri must name the file; its ending tells the format", field=what)
    if 0.0 in mesh.scale:
        raise KernelError(f"{what}.scale may not be 0 along any axis, it is {mesh.scale}", field=what)
    most = mesh.collision_hull_vertices
    if most and not FEWEST_HULL_VERTICES <= most <= MOST_HULL_VERTICES:
        raise LimitError(
            f"{what}.collision_hull_vertices must be {FEWEST_HULL_VERTICES} to {MOST_HULL_VERTICES}, or 0, not {most}",
            field=f"{what}.collision_hull_vertices",
            value=most,
            lower=FEWEST_HULL_VERTICES,
            upper=MOST_HULL_VERTICES,
        )


def _check_points(points: Points, what: str) -> None:
    count, colors = len(points.positions) // 24, len(points.colors) // 3
    if colors not in (0, count):
        raise KernelError(f"{what}.colors must have the shape ({count}, 3), not ({colors}, 3)", field=f"{what}.colors")


def _check_label(label: Label, what: str) -> None:
    if len(label.text) > GREATEST_TEXT:
        raise KernelError(f"{what}.text may have {GREATEST_TEXT} characters, not {len(label.text)}", field=what)


def _check_material(material: Material, what: str) -> None:
    if not 0.0 <= material.reflectance <= 1.0:
        raise KernelError(f"{what}.reflectance must be 0 to 1, not {material.reflectance:g}", field=what)
    for name, value in (("roughness", material.roughness), ("metalness", material.metalness)):
        if not 0.0 <= value <= 1.0:
            raise KernelError(f"{what}.{name} must be 0 to 1, not {value:g}", field=f"{what}.{name}")
    if not 0.0 <= material.friction < math.inf:
        raise KernelError(f"{what}.friction must be 0 or more, not {material.friction:g}", field=what)
    if not 0.0 <= material.restitution <= 1.0:
        raise KernelError(f"{what}.restitution must be 0 to 1, not {material.restitution:g}", field=what)
    if material.damping and not material.stiffness:
        raise KernelError(
            f"{what} has a damping of {material.damping:g} N s/m and no stiffness, beside which it counts; give both",
            field=what,
        )


def _bytes(*shape: int) -> Pair:
    """Return the codec of the bytes of a float64 array (n, *shape)."""
    codec = rows(None, *shape)
    return Pair(
        lambda message, what: codec.read(message, what).tobytes(),
        lambda data: array_message(np.frombuffer(data).reshape(-1, *shape)),
    )


SIZE = Pair(_size, vector_message)
FILE = Pair(lambda file, what: (file.uri, file.sha256), lambda file: nodes_pb2.AssetFile(uri=file[0], sha256=file[1]))
COLORS = Pair(
    lambda message, what: array(message, (None, 3), what).astype(np.uint8).tobytes(),
    lambda data: array_message(np.frombuffer(data, np.uint8).reshape(-1, 3), geometry_pb2.NUMERIC_TYPE_UINT8),
)

GEOMETRY = OneOf(
    "geometry",
    box=Table(Box, nodes_pb2.Box, size=SIZE),
    sphere=Table(Sphere, nodes_pb2.Sphere, numbers=POSITIVE),
    cylinder=Table(Cylinder, nodes_pb2.Cylinder, numbers=POSITIVE),
    cone=Table(Cone, nodes_pb2.Cone, numbers=POSITIVE),
    capsule=Table(Capsule, nodes_pb2.Capsule, numbers=POSITIVE),
    mesh=Table(Mesh, nodes_pb2.Mesh, files=FILE, check=_check_mesh),
    points=Table(
        Points, nodes_pb2.Points, positions=_bytes(3), colors=COLORS, size=OrDefault(NOT_NEGATIVE), check=_check_points
    ),
    lines=Table(Lines, nodes_pb2.Lines, segments=_bytes(2, 3), width=OrDefault(NOT_NEGATIVE)),
    frame=Table(Frame, nodes_pb2.Frame, length=OrDefault(NOT_NEGATIVE)),
    label=Table(Label, nodes_pb2.Label, check=_check_label),
)
MATERIAL = Table(
    Material,
    nodes_pb2.Material,
    rolling_friction=NOT_NEGATIVE,
    spinning_friction=NOT_NEGATIVE,
    stiffness=NOT_NEGATIVE,
    damping=NOT_NEGATIVE,
    check=_check_material,
)
FIGURE = Table(
    Figure,
    nodes_pb2.Figure,
    geometry=GEOMETRY,
    material=MATERIAL,
    without=("visual", "collision", "roles"),
)


def figure(message: nodes_pb2.Figure, what: str) -> Figure:
    """Return a figure; raise KernelError that says what is wrong with it."""
    roles = set(message.roles)
    if not roles <= {VISUAL, COLLISION}:
        raise KernelError(
            f"{what}.roles must be FIGURE_ROLE_VISUAL or FIGURE_ROLE_COLLISION, not {list(roles)}", field=what
        )
    visual, collision = not roles or VISUAL in roles, not roles or COLLISION in roles
    return FIGURE.read(message, what, visual=visual, collision=collision)


def check_lengths(figures: Iterable[Figure], what: str) -> None:
    """Raise LimitError for a primitive shape of a call that is as long as one in millimetres.

    Files may have such shapes: what they say was seen before, and a world that was saved is loaded again.
    """
    for place, one in enumerate(figures):
        match one.geometry:
            case Box(lengths):
                pass
            case Sphere(radius):
                lengths = (radius,)
            case Cylinder(radius, length) | Cone(radius, length) | Capsule(radius, length):
                lengths = (radius, length)
            case _:
                continue
        if (longest := max(lengths)) > MOST_LENGTH:
            raise LimitError(
                f"{what}.figures[{place}]: a length must be at most {MOST_LENGTH:g} m"
                f"{millimetres_question(longest)}; a mesh may be larger, and so may shapes that come from files",
                field=f"{what}.figures[{place}]",
                value=longest,
                limit=MOST_LENGTH,
            )


def figure_message(figure: Figure) -> nodes_pb2.Figure:
    """Return a figure as a message, with nothing that is the default."""
    said = not (figure.visual and figure.collision)
    roles = [VISUAL] * figure.visual + [COLLISION] * figure.collision
    return FIGURE.write(figure, roles=roles if said else ())
