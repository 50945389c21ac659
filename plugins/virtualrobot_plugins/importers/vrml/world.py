"""Walks through a VRML97 world and collects what it shows."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.errors import FilesNeeded

from virtualrobot_plugins.importers.glb import MAX_TRIANGLES, Color, Piece, placed
from virtualrobot_plugins.importers.images import drawable
from virtualrobot_plugins.importers.refusal import counted, short_name
from virtualrobot_plugins.importers.uris import join_uri
from virtualrobot_plugins.importers.vrml import solids
from virtualrobot_plugins.importers.vrml.faces import elevation_grid, indexed_face_set
from virtualrobot_plugins.importers.vrml.fields import Bound, expanded
from virtualrobot_plugins.importers.vrml.syntax import Node
from virtualrobot_plugins.importers.vrml.transforms import texture_matrix, transform_matrix

MAX_DEPTH = 200
MAX_INLINE_DEPTH = 16
MAX_NODES = 500_000

_GROUPS = ("Group", "Transform", "Anchor", "Billboard", "Collision")
_GEOMETRY: dict[str, Callable[[Bound], Piece | None]] = {
    "Box": solids.box,
    "Sphere": solids.sphere,
    "Cylinder": solids.cylinder,
    "Cone": solids.cone,
    "Extrusion": solids.extrusion,
    "ElevationGrid": elevation_grid,
    "IndexedFaceSet": indexed_face_set,
}
_UNSEEN = (
    *("Background", "Fog", "NavigationInfo", "Viewpoint", "WorldInfo", "Script", "Sound", "AudioClip"),
    *("DirectionalLight", "PointLight", "SpotLight"),
    *("CylinderSensor", "PlaneSensor", "ProximitySensor", "SphereSensor", "TimeSensor", "TouchSensor"),
    *("VisibilitySensor", "ColorInterpolator", "CoordinateInterpolator", "NormalInterpolator"),
    *("OrientationInterpolator", "PositionInterpolator", "ScalarInterpolator"),
)
"""Nodes that show nothing by themselves; nobody misses them in a mesh."""


@dataclass(frozen=True, slots=True)
class _Look:
    """Colour, texture and texture transform (3, 3) of an Appearance node."""

    color: Color | None = None
    texture: bytes | None = None
    uv_matrix: NDArray[np.float64] = field(default_factory=lambda: np.eye(3))


class World:
    """Collects the pieces of a world; `parse` reads a file that it inlines."""

    def __init__(self, files: Mapping[str, bytes | None], parse: Callable[[bytes, str], list[Node]]) -> None:
        """Take the files that have come with the world, by the names it asked for."""
        self._files, self._parse = files, parse
        self._needed: dict[str, None] = {}
        self._left_out: dict[str, int] = {}
        self._texts: dict[str, None] = {}
        self._looks: dict[tuple[int, int], _Look] = {}
        self._inlined: dict[str, list[Node]] = {}
        self._visited = self._triangles = 0
        self.pieces: list[Piece] = []

    def collect(self, nodes: list[Node], uri: str) -> tuple[str, ...]:
        """Collect what these root nodes show; return warnings.

        Raises:
            FilesNeeded: for all that is inlined and all textures, at once for each level of inlining.
            ArgumentError: for values that no node can have, and for a world too large to read.
        """
        for node in nodes:
            self._visit(expanded(Bound(node, {}, uri)), np.eye(4), 0, ())
        if self._needed:
            raise FilesNeeded(list(self._needed))
        left_out = [f"{short_name(uri)}: left out: {counted(self._left_out)}"] if self._left_out else []
        return (*left_out, *self._texts)

    def holds(self) -> str:
        """Return in words what the world holds that is not drawn; empty when there is nothing."""
        return f"; it holds {counted(self._left_out)}" if self._left_out else ""

    def _visit(self, node: Bound, matrix: NDArray[np.float64], depth: int, inlined: tuple[str, ...]) -> None:
        self._visited += 1
        if self._visited > MAX_NODES:
            raise node.error(f"the world shows more than {MAX_NODES} nodes, those used again (USE) counted each time")
        if depth > MAX_DEPTH:
            raise node.error(f"nodes are nested more than {MAX_DEPTH} deep, prototypes written out")
        kind = node.kind
        if kind == "Shape":
            self._shape(node, matrix)
        elif kind in _GROUPS:
            inner = matrix @ transform_matrix(node) if kind == "Transform" else matrix
            for child in node.nodes("children"):
                self._visit(child, inner, depth + 1, inlined)
        elif kind == "Switch":
            choices, chosen = node.nodes("choice"), int(node.number("whichChoice", -1.0))
            if 0 <= chosen < len(choices):
                self._visit(choices[chosen], matrix, depth + 1, inlined)
        elif kind == "LOD":
            for level in node.nodes("level")[:1]:
                self._visit(level, matrix, depth + 1, inlined)
        elif kind == "Inline":
            self._inline(node, matrix, depth, inlined)
        elif kind not in _UNSEEN:
            self._leave_out(kind)

    def _inline(self, node: Bound, matrix: NDArray[np.float64], depth: int, inlined: tuple[str, ...]) -> None:
        name = self._available(node.texts("url"), node.uri, inlined)
        if name is None:
            return
        data = self._files[name]
        if data is None:
            raise node.error(f"the file {name!r} is nowhere", missing=name)
        if name in inlined:
            raise node.error(f"{name} inlines itself")
        if len(inlined) >= MAX_INLINE_DEPTH:
            raise node.error(f"files inline files more than {MAX_INLINE_DEPTH} deep")
        if name not in self._inlined:
            self._inlined[name] = self._parse(data, name)
        for root in self._inlined[name]:
            self._visit(expanded(Bound(root, {}, name)), matrix, depth + 1, (*inlined, name))

    def _available(self, urls: list[str], uri: str, inlined: tuple[str, ...]) -> str | None:
        """Return the name of the first of these files that is there, else of the last; None: it is asked for."""
        name = None
        for url in urls:
            # What the world's own file names is asked for as written; what an inlined one names counts from there.
            name = join_uri(uri, url) if inlined else url.replace("\\", "/")
            if name not in self._files:
                self._needed[name] = None
                return None
            if self._files[name] is not None:
                return name
        return name

    def _shape(self, node: Bound, matrix: NDArray[np.float64]) -> None:
        found = node.nodes("geometry")
        if not found:
            return
        geometry = found[0]
        make = _GEOMETRY.get(geometry.kind)
        if make is None:
            self._leave_out(geometry.kind)
            return
        piece = make(geometry)
        if piece is None or len(piece.faces) == 0:
            return
        self._triangles += len(piece.faces)
        if self._triangles > MAX_TRIANGLES:
            raise geometry.error(f"the world makes more than {MAX_TRIANGLES} triangles")
        appearance = node.child("appearance", "Appearance")
        look = _Look() if appearance is None else self._look(appearance)
        self.pieces.append(placed(self._dressed(piece, look, geometry), matrix))

    def _look(self, appearance: Bound) -> _Look:
        key = id(appearance.node), id(appearance.scope)
        if key not in self._looks:
            material = appearance.child("material", "Material")
            color = None if material is None else _color(material)
            texture, uv_matrix = None, np.eye(3)
            for image in appearance.nodes("texture"):
                if image.kind == "ImageTexture":
                    texture = self._texture(image)
                else:
                    self._leave_out(image.kind)
            transform = appearance.child("textureTransform", "TextureTransform")
            if transform is not None:
                uv_matrix = texture_matrix(transform)
            self._looks[key] = _Look(color, texture, uv_matrix)
        return self._looks[key]

    def _texture(self, node: Bound) -> bytes | None:
        name = self._available(node.texts("url"), node.uri, () if node.uri not in self._inlined else (node.uri,))
        if name is None:
            return None
        image = drawable(self._files[name])
        if image is None:
            why = "is not there" if self._files[name] is None else "is no PNG or JPEG file"
            self._texts[f"{short_name(node.uri)}: the texture {name} {why}; drawn without it"] = None
        return image

    def _dressed(self, piece: Piece, look: _Look, geometry: Bound) -> Piece:
        if look.texture is not None and geometry.kind not in ("IndexedFaceSet", "ElevationGrid"):
            self._texts[f"{short_name(geometry.uri)}: the texture of a {geometry.kind} is left out"] = None
        elif look.texture is not None:
            uv = _default_uv(piece.vertices) if piece.uv is None else piece.uv
            uv = np.column_stack([uv, np.ones(len(uv))]) @ look.uv_matrix.T
            # A texture takes the place of the diffuse colour (ISO/IEC 14772-1, 4.14.3).
            alpha = 1.0 if look.color is None else look.color[3]
            white = (1.0, 1.0, 1.0, alpha)
            return replace(piece, color=white, vertex_colors=None, uv=uv[:, :2], texture=look.texture)
        if piece.vertex_colors is None:
            return replace(piece, color=look.color, uv=None)
        colors = piece.vertex_colors.copy()
        colors[:, 3] = round(255.0 * (1.0 if look.color is None else look.color[3]))
        return replace(piece, vertex_colors=colors, uv=None)

    def _leave_out(self, kind: str) -> None:
        self._left_out[kind] = self._left_out.get(kind, 0) + 1


def _color(material: Bound) -> Color:
    """Return the diffuse colour; the emissive one of a material that shines and reflects nothing."""
    diffuse = material.numbers("diffuseColor", (0.8, 0.8, 0.8), 3)
    emissive = material.numbers("emissiveColor", (0.0, 0.0, 0.0), 3)
    shown = np.clip(diffuse if diffuse.any() else emissive, 0.0, 1.0)
    alpha = 1.0 - min(max(material.number("transparency", 0.0), 0.0), 1.0)
    return float(shown[0]), float(shown[1]), float(shown[2]), alpha


def _default_uv(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return texture coordinates: s along the longest side of the bounding box, t along the second, both in its unit.

    ISO/IEC 14772-1, 6.23.
    """
    low, size = points.min(axis=0), np.ptp(points, axis=0)
    first, second = np.argsort(-size, kind="stable")[:2]
    unit = size[first] if size[first] > 0.0 else 1.0
    return (points[:, [first, second]] - low[[first, second]]) / unit
