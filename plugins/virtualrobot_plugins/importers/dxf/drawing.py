"""Walks through a drawing and its blocks and collects triangles with their colours."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from virtualrobot_plugins.importers.dxf.shapes import Surface, surface_of
from virtualrobot_plugins.importers.glb import MAX_TRIANGLES, Color, Piece, placed

Entity: TypeAlias = Any
"""One of ezdxf's entities: each kind is a class of its own, loaded from strings."""

MAX_DEPTH = 32
"""Blocks inside blocks inside blocks: deeper is a block that holds itself."""

MAX_ENTITIES = 1_000_000
"""More entities, each counted as often as its block is inserted, are refused."""

ACIS_BODIES = ("3DSOLID", "BODY", "REGION", "SURFACE", "EXTRUDEDSURFACE", "LOFTEDSURFACE", "REVOLVEDSURFACE")
ACIS_BODIES += ("SWEPTSURFACE", "PLANESURFACE", "NURBSURFACE")
"""Entities whose geometry is in the form of the ACIS kernel, which nothing free reads."""

_BY_BLOCK, _BY_LAYER = 0, 256  # values of group code 62 (Autodesk, DXF reference, "Common Group Codes")


@dataclass(slots=True)
class Drawn:
    """Visible surfaces of a drawing, in its own unit, and counts by kind of what it holds besides."""

    pieces: list[Piece] = field(default_factory=list)
    solids: dict[str, int] = field(default_factory=dict)
    flat: dict[str, int] = field(default_factory=dict)
    unknown: dict[str, int] = field(default_factory=dict)
    missing_blocks: set[str] = field(default_factory=set)
    hidden: int = 0
    refused: str = ""


@dataclass(frozen=True, slots=True)
class _Context:
    """Properties that entities of a block inherit from its insertion: transform (4, 4), layer, colour, depth."""

    matrix: NDArray[np.float64]
    layer: str = "0"
    color: Color = (1.0, 1.0, 1.0, 1.0)
    depth: int = 0


class _TooMuch(Exception):
    """The drawing is larger than any that is read."""


def draw(document: Any) -> Drawn:  # noqa: ANN401  ezdxf's document
    """Return what the model space of one of ezdxf's documents shows, with all blocks in their places."""
    walk = _Walk(document)
    try:
        walk.visit(document.modelspace(), _Context(np.eye(4)))
    except _TooMuch as error:
        walk.drawn.refused = str(error)
    return walk.drawn


class _Walk:
    """Remembers the surface of each entity, which a block shows as often as it is inserted."""

    def __init__(self, document: Any) -> None:  # noqa: ANN401  ezdxf's document
        self._document = document
        self._surfaces: dict[int, Surface | None] = {}
        self._visited = 0
        self._triangles = 0
        self.drawn = Drawn()

    def visit(self, entities: Iterable[Entity], context: _Context) -> None:
        for entity in entities:
            self._visited += 1
            if self._visited > MAX_ENTITIES:
                raise _TooMuch(f"the drawing shows more than {MAX_ENTITIES} entities, blocks written out")
            layer = str(entity.dxf.get("layer", "0"))
            layer = context.layer if layer == "0" else layer
            if self._hidden(entity, layer):
                self.drawn.hidden += 1
            elif entity.dxftype() == "INSERT":
                self._insert(entity, layer, context)
            else:
                self._show(entity, layer, context)

    def _show(self, entity: Entity, layer: str, context: _Context) -> None:
        kind = entity.dxftype()
        if kind in ACIS_BODIES:
            self.drawn.solids[kind] = self.drawn.solids.get(kind, 0) + 1
            return
        key = id(entity)
        if key not in self._surfaces:
            self._surfaces[key] = surface_of(entity)
        surface = self._surfaces[key]
        if surface is None or len(surface.faces) == 0:
            self.drawn.flat[kind] = self.drawn.flat.get(kind, 0) + 1
            return
        self._triangles += len(surface.faces)
        if self._triangles > MAX_TRIANGLES:
            raise _TooMuch(f"the drawing makes more than {MAX_TRIANGLES} triangles, blocks written out")
        color = self._color(entity, layer, context)
        self.drawn.pieces.append(placed(Piece(surface.vertices, surface.faces, color), context.matrix))

    def _insert(self, insert: Entity, layer: str, context: _Context) -> None:
        name = str(insert.dxf.get("name", ""))
        block = insert.block()
        if block is None:
            self.drawn.missing_blocks.add(name)
            return
        if context.depth >= MAX_DEPTH:
            raise _TooMuch(f"the block {name!r} is nested more than {MAX_DEPTH} deep; does it hold itself?")
        color = self._color(insert, layer, context)
        copies = insert.multi_insert() if insert.mcount > 1 else [insert]
        if insert.mcount > MAX_ENTITIES:
            raise _TooMuch(f"the block {name!r} is inserted {insert.mcount} times")
        for copy in copies:
            # ezdxf's matrices multiply rows; ours columns.
            matrix = np.array(list(copy.matrix44().rows())).T
            self.visit(block, _Context(context.matrix @ matrix, layer, color, context.depth + 1))

    def _hidden(self, entity: Entity, name: str) -> bool:
        if entity.dxf.get("invisible", 0):
            return True
        layer = self._layer(name)
        return layer is not None and (layer.is_off() or layer.is_frozen())

    def _layer(self, name: str) -> Entity | None:
        return self._document.layers.get(name) if self._document.layers.has_entry(name) else None

    def _color(self, entity: Entity, layer_name: str, context: _Context) -> Color:
        """Return the colour of an entity: its own, its layer's or its block's; its transparency likewise."""
        index = entity.dxf.get("color", _BY_LAYER)
        layer = self._layer(layer_name)
        if entity.dxf.hasattr("true_color"):
            red, green, blue = _of_number(entity.dxf.true_color)
        elif index == _BY_BLOCK:
            red, green, blue, _ = context.color
        elif index == _BY_LAYER or not 0 < abs(index) < _BY_LAYER:
            red, green, blue = _of_layer(layer)
        else:
            red, green, blue = _of_index(index)
        if getattr(entity, "is_transparency_by_block", False):
            return red, green, blue, context.color[3]
        by_layer = getattr(entity, "is_transparency_by_layer", True)
        transparency = (layer.transparency if layer is not None else 0.0) if by_layer else entity.transparency
        return red, green, blue, 1.0 - transparency


def _of_layer(layer: Entity | None) -> tuple[float, float, float]:
    if layer is None:
        return 1.0, 1.0, 1.0
    if layer.dxf.hasattr("true_color"):
        return _of_number(layer.dxf.true_color)
    return _of_index(layer.dxf.get("color", 7))


def _of_index(index: int) -> tuple[float, float, float]:
    """Return a colour of AutoCAD's table of 255; one of an off layer is negative there."""
    from ezdxf.colors import aci2rgb

    red, green, blue = aci2rgb(abs(index)) if 0 < abs(index) < _BY_LAYER else (255, 255, 255)
    return red / 255.0, green / 255.0, blue / 255.0


def _of_number(value: int) -> tuple[float, float, float]:
    return (value >> 16 & 255) / 255.0, (value >> 8 & 255) / 255.0, (value & 255) / 255.0
