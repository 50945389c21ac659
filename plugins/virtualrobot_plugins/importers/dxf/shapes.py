"""The surface of one entity of a drawing, in world coordinates of its block and in the drawing's unit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from virtualrobot_plugins.importers.polygons import newell_normal, triangulate, triangulate_one

Entity: TypeAlias = Any
"""One of ezdxf's entities."""

CHORD_TOLERANCE = 5e-4
"""Greatest distance of a chord from its arc, in parts of the outline's greatest extent: 70 sides for a full circle."""

_TRIANGLE, _TWO_TRIANGLES = np.array([[0, 1, 2]]), np.array([[0, 1, 2], [0, 2, 3]])
_OUTLINES = ("LWPOLYLINE", "POLYLINE", "CIRCLE", "ARC", "LINE")


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """Triangles: vertices (n, 3) and faces (m, 3)."""

    vertices: NDArray[np.float64]
    faces: NDArray[np.intp]


def surface_of(entity: Entity) -> Surface | None:
    """Return the triangles of an entity; None for one without a surface, such as a line."""
    kind = entity.dxftype()
    if kind == "3DFACE":
        return _face(np.array([corner.xyz for corner in entity.wcs_vertices()]))
    if kind in ("SOLID", "TRACE"):
        corners = np.array([corner.xyz for corner in entity.wcs_vertices()])
        return _extruded(corners, _thickness(entity), closed=True) if len(corners) >= 3 else None
    if kind == "MESH":
        return _mesh(entity)
    if kind == "POLYLINE" and entity.is_poly_face_mesh:
        return _of_polygons([np.array([p.xyz for p in face.points()]) for face in entity.indexed_faces()[1]])
    if kind == "POLYLINE" and entity.is_polygon_mesh:
        return _grid(entity)
    if kind in _OUTLINES:
        return _outline(entity)
    return None


def _face(points: NDArray[np.float64]) -> Surface:
    """Return a 3DFACE, which is cut between its first and third corner; a triangle has its last corner twice."""
    if len(points) == 4 and (points[2] == points[3]).all():
        points = points[:3]
    return Surface(points, _TRIANGLE if len(points) == 3 else _TWO_TRIANGLES)


def _of_polygons(polygons: list[NDArray[np.float64]]) -> Surface | None:
    polygons = [_without_repeats(points) for points in polygons if len(points)]
    if not polygons:
        return None
    points = np.concatenate(polygons)
    lengths = np.array([len(polygon) for polygon in polygons])
    return Surface(points, triangulate(points, np.arange(len(points)), lengths)[0])


def _without_repeats(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a polygon without corners that repeat the one before."""
    keep = (points != np.roll(points, 1, axis=0)).any(axis=1)
    return points[keep]


def _mesh(entity: Entity) -> Surface | None:
    points = np.array([tuple(vertex) for vertex in entity.vertices], np.float64).reshape(-1, 3)
    faces = [np.array(face, np.intp) for face in entity.faces if len(face)]
    if not faces:
        return None
    corners = np.concatenate(faces)
    if corners.min() < 0 or corners.max() >= len(points):
        raise ValueError(f"a MESH names vertex {corners.max()}, but it has {len(points)}")
    places = triangulate(points, corners, np.array([len(face) for face in faces]))[0]
    return Surface(points, corners[places])


def _grid(entity: Entity) -> Surface | None:
    """Return a polygon mesh of m by n vertices, which may be closed in both directions."""
    rows, columns = entity.dxf.m_count, entity.dxf.n_count
    vertices = np.array([vertex.dxf.location.xyz for vertex in entity.vertices], np.float64)
    if rows < 2 or columns < 2 or len(vertices) < rows * columns:
        return None
    numbers = np.arange(rows * columns).reshape(rows, columns)
    if entity.is_m_closed:
        numbers = np.vstack([numbers, numbers[:1]])
    if entity.is_n_closed:
        numbers = np.hstack([numbers, numbers[:, :1]])
    quads = np.stack([numbers[:-1, :-1], numbers[:-1, 1:], numbers[1:, 1:], numbers[1:, :-1]], axis=-1).reshape(-1, 4)
    return Surface(vertices, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))


def _outline(entity: Entity) -> Surface | None:
    """Return the walls above an outline with a thickness, and when it is closed its floor and top."""
    from ezdxf.path import make_path

    height = _thickness(entity)
    if not height.any() or (entity.dxftype() == "POLYLINE" and not entity.is_2d_polyline):
        return None
    path = make_path(entity)
    control = np.array([point.xyz for point in path.control_vertices()])
    if len(control) < 2:
        return None
    extent = float(np.ptp(control, axis=0).max())
    points = np.array([point.xyz for point in path.flattening(max(CHORD_TOLERANCE * extent, 1e-12))])
    closed = entity.dxftype() == "CIRCLE" or bool(getattr(entity, "is_closed", False))
    points = _without_repeats(points) if closed else points
    return _extruded(points, height, closed and len(points) >= 3)


def _thickness(entity: Entity) -> NDArray[np.float64]:
    """Return how far and where to an entity is extruded; 0 for one that is not."""
    thickness = float(entity.dxf.get("thickness", 0.0))
    extrusion = entity.dxf.get("extrusion", (0.0, 0.0, 1.0))
    direction = np.array(tuple(extrusion), np.float64)
    length = float(np.linalg.norm(direction))
    return thickness * direction / length if length > 0.0 else np.zeros(3)


def _extruded(points: NDArray[np.float64], height: NDArray[np.float64], closed: bool) -> Surface:
    """Return the prism over a polygon (closed) or the walls over a line; a flat polygon without height."""
    count = len(points)
    if closed and not height.any():
        return Surface(points, triangulate_one(points))
    vertices = np.concatenate([points, points + height])
    start = np.arange(count if closed else count - 1)
    end = (start + 1) % count
    # Seen from outside of an outline that turns counter-clockwise about its height.
    walls = np.concatenate(
        [np.column_stack([start, end, end + count]), np.column_stack([start, end + count, start + count])]
    )
    if not closed:
        return Surface(vertices, walls)
    floor = triangulate_one(points)
    faces = np.concatenate([walls, floor[:, ::-1], floor + count])
    inside_out = float(newell_normal(points) @ height) < 0.0
    return Surface(vertices, faces[:, ::-1] if inside_out else faces)
