"""Submeshs of primitives as triangles with smooth normals.

Boxes, spheres, cylinders and cones are made once at unit size and scaled per instance; a capsule is made at its size,
since scaling would bend its caps. Faces are counter-clockwise seen from outside. Lengths in meters.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.shapes.submesh import Submesh, stacked

SEGMENTS = 48
"""Around a circle; a cylinder's flat sides stand in by 0.2% of its radius."""

RINGS = 24
"""From pole to pole of a sphere."""

RED, GREEN, BLUE = (219, 46, 46, 255), (46, 168, 61, 255), (41, 97, 230, 255)


def box() -> Submesh:
    """Return a box about the origin with edges of 1 m."""
    parts = []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            normal = np.zeros(3)
            normal[axis] = sign
            along, across = np.roll(np.eye(3), -axis, axis=0)[1:]
            across = across * sign
            corners = 0.5 * np.array(
                [normal - along - across, normal + along - across, normal + along + across, normal - along + across]
            )
            parts.append(_surface(corners, np.tile(normal, (4, 1)), [[0, 1, 2], [0, 2, 3]]))
    return joined(*parts)


def sphere() -> Submesh:
    """Return a sphere about the origin with a radius of 1 m."""
    polar = np.linspace(0.0, np.pi, RINGS + 1)
    points = _turned(np.stack([np.sin(polar), np.cos(polar)], axis=1))
    return _surface(points, points, _strip(RINGS))


def cylinder() -> Submesh:
    """Return a cylinder about the origin along z, radius 1 m, length 1 m."""
    side = _side((1.0, 0.5), (1.0, -0.5), (1.0, 0.0))
    return joined(side, _disc(1.0, 0.5, 1.0), _disc(1.0, -0.5, -1.0))


def cone() -> Submesh:
    """Return a cone along z: radius 1 m at z = -0.5 m, tip at z = 0.5 m."""
    slope = np.array([1.0, 1.0]) / np.sqrt(2.0)
    return joined(_side((0.0, 0.5), (1.0, -0.5), (slope[0], slope[1])), _disc(1.0, -0.5, -1.0))


def capsule(radius: float, length: float) -> Submesh:
    """Return a cylinder of `length` along z about the origin with half spheres of `radius` on its ends."""
    polar = np.linspace(0.0, np.pi, RINGS + 1)
    upper, lower = polar[: RINGS // 2 + 1], polar[RINGS // 2 :]
    polar = np.concatenate([upper, lower])
    lift = np.concatenate([np.full(len(upper), 0.5 * length), np.full(len(lower), -0.5 * length)])
    normals = np.stack([np.sin(polar), np.cos(polar)], axis=1)
    profile = radius * normals
    profile[:, 1] += lift
    return _surface(_turned(profile), _turned(normals), _strip(len(polar) - 1))


def arrow() -> Submesh:
    """Return an arrow along z from the origin to 1 m: a thin shaft and a head."""
    head, shaft = 0.18, 0.014
    return joined(
        transformed(cylinder(), (shaft, shaft, 1.0 - head), (0.0, 0.0, 0.5 * (1.0 - head))),
        transformed(cone(), (0.05, 0.05, head), (0.0, 0.0, 1.0 - 0.5 * head)),
    )


def axis_arrow() -> Submesh:
    """Return an arrow along z from -1 m to 1 m: what shows the axis of a joint."""
    head, shaft = 0.14, 0.014
    return joined(
        transformed(cylinder(), (shaft, shaft, 2.0 - head), (0.0, 0.0, -0.5 * head)),
        transformed(cone(), (0.045, 0.045, head), (0.0, 0.0, 1.0 - 0.5 * head)),
    )


def frame() -> Submesh:
    """Return three arrows of 1 m: x red, y green, z blue."""
    up = arrow()
    parts = []
    for roll, color in ((1, RED), (2, GREEN), (3, BLUE)):
        # Rolling the coordinates turns z into x, then y, then z again, and keeps right-handed what is so.
        parts.append(
            Submesh(
                np.roll(up.vertices, roll, axis=1),
                up.faces,
                np.roll(_normals(up), roll, axis=1),
                vertex_colors=np.tile(np.asarray(color, np.uint8), (len(up.vertices), 1)),
            )
        )
    return joined(*parts)


def transformed(
    shape: Submesh, scale: tuple[float, float, float], shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> Submesh:
    """Return a shape without colours scaled along x, y, z by positive factors, then shifted."""
    factors = np.asarray(scale, np.float32)
    normals = _normals(shape) / factors
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Submesh(shape.vertices * factors + np.asarray(shift, np.float32), shape.faces, normals)


def joined(*parts: Submesh) -> Submesh:
    """Return all parts as one shape; all have colours or none has."""
    colors = [part.vertex_colors for part in parts if part.vertex_colors is not None]
    return Submesh(
        *stacked(parts),
        np.concatenate([_normals(part) for part in parts]),
        vertex_colors=np.concatenate(colors) if colors else None,
    )


def _normals(part: Submesh) -> NDArray[np.float32]:
    assert part.normals is not None  # everything here is made with normals
    return part.normals


def _surface(vertices: NDArray, normals: NDArray, faces: NDArray | list[list[int]]) -> Submesh:
    """Return the surface without those faces that have no area, as at the poles of a sphere."""
    corners = np.asarray(vertices, np.float64)[(index := np.asarray(faces, np.int32).reshape(-1, 3))]
    twice_area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return Submesh(np.asarray(vertices, np.float32), index[twice_area > 1e-12], np.asarray(normals, np.float32))


def _turned(profile: NDArray) -> NDArray:
    """Return (k * (SEGMENTS + 1), 3): each row (radius, z) of the profile turned about z, ring after ring."""
    angle = np.linspace(0.0, 2.0 * np.pi, SEGMENTS + 1)
    radius, height = profile[:, :1], profile[:, 1:]
    rings = np.stack(
        [radius * np.cos(angle), radius * np.sin(angle), np.broadcast_to(height, (len(profile), SEGMENTS + 1))], axis=2
    )
    return rings.reshape(-1, 3)


def _strip(count: int) -> NDArray:
    """Return the faces between `count` + 1 rings that follow each other downwards."""
    upper = np.arange(SEGMENTS) + np.arange(count)[:, None] * (SEGMENTS + 1)
    lower = upper + SEGMENTS + 1
    first = np.stack([upper, lower, lower + 1], axis=2)
    second = np.stack([upper, lower + 1, upper + 1], axis=2)
    return np.concatenate([first.reshape(-1, 3), second.reshape(-1, 3)])


def _side(top: tuple[float, float], bottom: tuple[float, float], normal: tuple[float, float]) -> Submesh:
    """Return the surface that the line from `top` to `bottom` (radius, z) makes when turned about z."""
    return _surface(_turned(np.array([top, bottom])), _turned(np.array([normal, normal], dtype=np.float64)), _strip(1))


def _disc(radius: float, height: float, up: float) -> Submesh:
    """Return a disc at `height` whose outside is up (1) or down (-1)."""
    rim = _turned(np.array([[radius, height]]))[:SEGMENTS]
    points = np.concatenate([[[0.0, 0.0, height]], rim])
    index = np.arange(SEGMENTS)
    following = (index + 1) % SEGMENTS
    order = (index, following) if up > 0.0 else (following, index)
    faces = np.stack([np.zeros(SEGMENTS, int), order[0] + 1, order[1] + 1], axis=1)
    return _surface(points, np.tile([0.0, 0.0, up], (len(points), 1)), faces)
