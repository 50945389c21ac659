"""IndexedFaceSet and ElevationGrid: polygons with colours, normals and texture coordinates of corners or faces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_plugins.importers.glb import Piece, unit
from virtualrobot_plugins.importers.polygons import triangulate
from virtualrobot_plugins.importers.vrml.fields import Bound

MAX_GRID = 20_000_000


@dataclass(frozen=True, slots=True)
class _Polygons:
    """Polygons of a node, before they are cut into triangles.

    Attributes:
        points: (n, 3).
        corners: (k,) rows of `points`, polygon after polygon.
        lengths: (p,) corners of each polygon.
        places: (k,) index of each corner in `coordIndex`, and so in the other index fields.
    """

    points: NDArray[np.float64]
    corners: NDArray[np.intp]
    lengths: NDArray[np.intp]
    places: NDArray[np.intp]


def indexed_face_set(node: Bound) -> Piece | None:
    """Return the triangles of an IndexedFaceSet (ISO/IEC 14772-1, 6.23); None for one without faces."""
    coordinate = node.child("coord", "Coordinate")
    points = None if coordinate is None else coordinate.rows("point", 3)
    index = node.indices("coordIndex")
    if points is None or index is None:
        return None
    places = np.flatnonzero(index >= 0)
    ends = np.flatnonzero(index < 0)
    lengths = np.diff(np.concatenate([[-1], ends, [len(index)]])) - 1
    corners = index[places]
    if len(corners) == 0:
        return None
    if corners.max() >= len(points):
        raise node.error(f"coordIndex names point {corners.max()}, but there are {len(points)}")
    # A face may have no corner (two -1 in a row); it counts all the same where faces are numbered.
    lengths = lengths[:-1] if lengths[-1] == 0 else lengths
    polygons = _Polygons(points, corners, lengths, places)
    return _dressed(node, polygons, "colorIndex", "normalIndex", "texCoordIndex")


def elevation_grid(node: Bound) -> Piece | None:
    """Return the triangles of an ElevationGrid (ISO/IEC 14772-1, 6.17); None for one without faces."""
    columns, rows = (node.number(name, 0) for name in ("xDimension", "zDimension"))
    heights = node.rows("height", 1)
    if columns < 2 or rows < 2 or heights is None:
        return None
    if columns * rows != len(heights) or columns * rows > MAX_GRID or columns != int(columns):
        raise node.error(f"xDimension {columns:g} and zDimension {rows:g} do not fit the {len(heights)} heights")
    nx, nz = int(columns), int(rows)
    x, z = np.meshgrid(np.arange(nx), np.arange(nz))
    spacing = node.number("xSpacing", 1.0), node.number("zSpacing", 1.0)
    points = np.column_stack([x.ravel() * spacing[0], heights[:, 0], z.ravel() * spacing[1]]).astype(np.float64)
    numbers = np.arange(nx * nz).reshape(nz, nx)
    quads = np.stack([numbers[:-1, :-1], numbers[1:, :-1], numbers[1:, 1:], numbers[:-1, 1:]], axis=-1).reshape(-1, 4)
    corners = quads.reshape(-1)
    polygons = _Polygons(points, corners, np.full(len(quads), 4), np.arange(len(corners)))
    own_uv = np.column_stack([x.ravel() / (nx - 1), z.ravel() / (nz - 1)])
    return _dressed(node, polygons, "", "", "", own_uv)


def _dressed(
    node: Bound,
    polygons: _Polygons,
    color_index: str,
    normal_index: str,
    uv_index: str,
    own_uv: NDArray[np.float64] | None = None,
) -> Piece:
    """Cut polygons into triangles, and give the corners what the node says of them."""
    triangles, owner = triangulate(polygons.points, polygons.corners, polygons.lengths)
    if not node.truth("ccw", True):
        triangles = triangles[:, ::-1]
    colors = _per_corner(node, polygons, triangles, owner, ("color", "Color", "color", color_index), 3)
    normals = _per_corner(node, polygons, triangles, owner, ("normal", "Normal", "vector", normal_index), 3)
    uv = _per_corner(node, polygons, triangles, owner, ("texCoord", "TextureCoordinate", "point", uv_index), 2)
    if uv is None and own_uv is not None:
        uv = own_uv[polygons.corners[triangles]]
    if colors is None and normals is None and uv is None:
        return Piece(polygons.points, polygons.corners[triangles])
    vertices = polygons.points[polygons.corners[triangles]].reshape(-1, 3)
    painted = None
    if colors is not None:
        opaque = np.full((len(vertices), 1), 255.0)
        painted = np.hstack([np.clip(colors.reshape(-1, 3), 0.0, 1.0) * 255.0, opaque]).round().astype(np.uint8)
    return Piece(
        vertices,
        np.arange(len(vertices)).reshape(-1, 3),
        None,
        None if normals is None else unit(normals.reshape(-1, 3)),
        painted,
        None if uv is None else uv.reshape(-1, 2),
    )


def _per_corner(
    node: Bound,
    polygons: _Polygons,
    triangles: NDArray[np.intp],
    owner: NDArray[np.intp],
    names: tuple[str, str, str, str],
    width: int,
) -> NDArray[np.float64] | None:
    """Return what the field `names` = (field, node type, its field, index field) says of corners (m, 3, width)."""
    field, kind, inner, index_field = names
    source = node.child(field, kind)
    values = None if source is None else source.rows(inner, width)
    if values is None or len(values) == 0:
        return None
    index = node.indices(index_field) if index_field else None
    per_vertex = field == "texCoord" or node.truth(f"{field}PerVertex", True)
    if per_vertex and index is None:
        chosen = polygons.corners[triangles]
    elif per_vertex:
        chosen = _looked_up(node, index_field, index, polygons.places[triangles])
    else:
        faces = np.broadcast_to(owner[:, None], triangles.shape)
        chosen = faces if index is None else _looked_up(node, index_field, index, faces)
    if chosen.size and not 0 <= chosen.min() <= chosen.max() < len(values):
        worst = chosen.max() if chosen.min() >= 0 else chosen.min()
        raise node.error(f"{index_field or field}: entry {worst} is wanted, but {kind} has {len(values)}")
    return values[chosen]


def _looked_up(node: Bound, name: str, index: NDArray[np.intp] | None, places: NDArray[np.intp]) -> NDArray[np.intp]:
    assert index is not None
    if places.size and places.max() >= len(index):
        raise node.error(f"{name} has {len(index)} entries, but {places.max() + 1} are wanted")
    return index[places]
