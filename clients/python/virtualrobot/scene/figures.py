"""Shapes for nodes: `box(0.1, 0.1, 0.2, color="red")`. Lengths in meters; `pose` is `node_t_figure`, a 4x4 array."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypeAlias

import numpy as np

from virtualrobot._wire.arguments import ArrayLike, PoseLike, Text, checked
from virtualrobot._wire.messages import (
    Wrapped,
    array_message,
    color_message,
    pose_message,
    value_or_default,
    vector_message,
)
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.geometry import pose as at
from virtualrobot.v1 import nodes_pb2


class Figure(Wrapped[nodes_pb2.Figure]):
    """Shape of a node, with its colour, pose and role: a box, a mesh, points, ..."""

    __slots__ = ()
    _called = "a figure, such as virtualrobot.box(0.1, 0.1, 0.2)"

    @checked
    def with_surface(
        self,
        *,
        friction: float | None = None,
        restitution: float | None = None,
        rolling_friction: float | None = None,
        spinning_friction: float | None = None,
        stiffness: float | None = None,
        damping: float | None = None,
        roughness: float | None = None,
        metalness: float | None = None,
    ) -> Figure:
        """Return the same figure with another surface; what is not given stays. It counts under physics.

        Args:
            friction: coefficient of sliding friction; 0.5 unless it is said.
            restitution: speed after a normal impact as a part of that before, 0 to 1.
            rolling_friction: torque against rolling, per normal force (m).
            spinning_friction: torque against spinning about the normal, per normal force (m).
            stiffness: of a contact, N/m; 0 means as stiff as the engine likes.
            damping: of a contact, N s/m; counts with a stiffness alone.
            roughness: 0 (a mirror) to 1 (matt), as the console's page and exports as glTF show it; 0.62 unless it is
                said.
            metalness: 0 to 1, for these, too.

        Example:
            >>> ball = virtualrobot.sphere(0.05).with_surface(friction=0.8, restitution=0.7)
        """
        message = nodes_pb2.Figure()
        message.CopyFrom(self._message)
        given = {
            "friction": friction,
            "restitution": restitution,
            "rolling_friction_meters": rolling_friction,
            "spinning_friction_meters": spinning_friction,
            "stiffness": stiffness,
            "damping": damping,
            "roughness": roughness,
            "metalness": metalness,
        }
        for field, value in given.items():
            if value is not None:
                setattr(message.material, field, value)
        return Figure(message)


Figures: TypeAlias = Figure | Iterable[Figure]
_ROLES = {"visual": nodes_pb2.FIGURE_ROLE_VISUAL, "collision": nodes_pb2.FIGURE_ROLE_COLLISION}


def figure_list(figures: Figures) -> list[nodes_pb2.Figure]:
    """Return one figure or several as messages."""
    return [figure._message for figure in ([figures] if isinstance(figures, Figure) else figures)]


def styled(
    figure: nodes_pb2.Figure,
    color: str | ArrayLike | None,
    pose: PoseLike | None,
    roles: Sequence[str] = (),
) -> Figure:
    """Return `figure` with a colour, a pose and roles (`visual`, `collision`; none: both) where they are given."""
    if color is not None:
        figure.material.color.CopyFrom(color_message(color))
    if pose is not None:
        figure.node_t_figure.CopyFrom(pose_message(pose))
    for role in roles:
        if role not in _ROLES:
            raise InvalidArgumentError(f"{role!r} is no role of a figure: use {', '.join(_ROLES)}")
        figure.roles.append(_ROLES[role])
    return Figure(figure)


@checked
def box(
    x: float,
    y: float,
    z: float,
    *,
    color: str | ArrayLike | None = None,
    pose: PoseLike | None = None,
    roles: Sequence[str] = (),
) -> Figure:
    """Return a box about its origin with edges of `x`, `y`, `z` meters."""
    size = vector_message((x, y, z), "the size of a box")
    return styled(nodes_pb2.Figure(box=nodes_pb2.Box(size=size)), color, pose, roles)


@checked
def sphere(
    radius: float,
    *,
    color: str | ArrayLike | None = None,
    pose: PoseLike | None = None,
    roles: Sequence[str] = (),
) -> Figure:
    """Return a sphere about its origin."""
    return styled(nodes_pb2.Figure(sphere=nodes_pb2.Sphere(radius_meters=radius)), color, pose, roles)


@checked
def cylinder(
    radius: float,
    length: float,
    *,
    color: str | ArrayLike | None = None,
    pose: PoseLike | None = None,
    roles: Sequence[str] = (),
) -> Figure:
    """Return a cylinder about its origin, along z."""
    shape = nodes_pb2.Cylinder(radius_meters=radius, length_meters=length)
    return styled(nodes_pb2.Figure(cylinder=shape), color, pose, roles)


@checked
def cone(
    radius: float,
    length: float,
    *,
    color: str | ArrayLike | None = None,
    pose: PoseLike | None = None,
    roles: Sequence[str] = (),
) -> Figure:
    """Return a cone along z: its base half a length below its origin, its tip half a length above."""
    shape = nodes_pb2.Cone(radius_meters=radius, length_meters=length)
    return styled(nodes_pb2.Figure(cone=shape), color, pose, roles)


@checked
def capsule(
    radius: float,
    length: float,
    *,
    color: str | ArrayLike | None = None,
    pose: PoseLike | None = None,
    roles: Sequence[str] = (),
) -> Figure:
    """Return a cylinder of `length` along z with half spheres on both ends."""
    shape = nodes_pb2.Capsule(radius_meters=radius, length_meters=length)
    return styled(nodes_pb2.Figure(capsule=shape), color, pose, roles)


@checked
def table(
    x: float,
    y: float,
    height: float,
    *,
    thickness: float = 0.04,
    leg: float = 0.06,
    color: str | ArrayLike | None = None,
) -> tuple[Figure, ...]:
    """Return a table that stands about its origin: a top of `x` by `y` meters on four legs, its top at `height`.

    thickness: of the top. leg: the edge of a leg; a table that has no room for legs is a block.
    """
    if not min(x, y) > 2.0 * leg or not height > thickness:
        return (box(x, y, height, color=color, pose=at(z=height / 2.0)),)
    below = height - thickness
    places = ((a * (x - leg) / 2.0, b * (y - leg) / 2.0) for a in (-1.0, 1.0) for b in (-1.0, 1.0))
    legs = (box(leg, leg, below, color=color, pose=at(*place, below / 2.0)) for place in places)
    return (box(x, y, thickness, color=color, pose=at(z=height - thickness / 2.0)), *legs)


@checked
def points(
    positions: ArrayLike,
    *,
    color: str | ArrayLike | None = None,
    colors: ArrayLike | None = None,
    size: float | None = None,
) -> Figure:
    """Return points at `positions` (n, 3) with one colour or `colors` (n, 3), 0 to 255; `size` is 0.01 m by default."""
    array = np.asarray(positions, dtype=float)
    if array.ndim != 2 or array.shape[1] != 3:
        raise InvalidArgumentError(f"points have the shape (n, 3), not {array.shape}")
    shape = nodes_pb2.Points(positions=array_message(array, "<f4"), size_meters=value_or_default(size, "size"))
    if colors is not None:
        shades = np.asarray(colors)
        if shades.shape != array.shape or shades.min(initial=0) < 0 or shades.max(initial=0) > 255:
            raise InvalidArgumentError(f"colours have the shape {array.shape} and values 0 to 255")
        shape.colors.CopyFrom(array_message(shades, "u1"))
    return styled(nodes_pb2.Figure(points=shape), color, None)


@checked
def lines(segments: ArrayLike, *, color: str | ArrayLike | None = None, width: float | None = None) -> Figure:
    """Return line segments of shape (n, 2, 3), or a line through points (n, 3), `width` pixels wide, 2 by default."""
    array = np.asarray(segments, dtype=float)
    if array.ndim == 2 and array.shape[1] == 3 and len(array) > 1:
        array = np.stack([array[:-1], array[1:]], axis=1)
    if array.ndim != 3 or array.shape[1:] != (2, 3):
        raise InvalidArgumentError(f"lines have the shape (n, 2, 3) or (n, 3), not {array.shape}")
    shape = nodes_pb2.Lines(segments=array_message(array, "<f4"), width_pixels=value_or_default(width, "width"))
    return styled(nodes_pb2.Figure(lines=shape), color, None)


@checked
def frame(length: float | None = None) -> Figure:
    """Return three arrows, x red, y green, z blue, of `length` meters, 0.1 by default."""
    return Figure(nodes_pb2.Figure(frame=nodes_pb2.Frame(length_meters=value_or_default(length, "length"))))


@checked
def label(text: Text) -> Figure:
    """Return words."""
    return Figure(nodes_pb2.Figure(label=nodes_pb2.Label(text=text)))
