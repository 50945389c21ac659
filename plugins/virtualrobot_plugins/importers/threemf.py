"""The importer of `.3mf`: the core specification, and of the materials extension the colours.

3MF Consortium, "3D Manufacturing Format, Core Specification" 1.3 (sections named below) and "Materials and Properties
Extension" 1.2. trimesh reads 3MF too, but drops colours and units.
"""

from __future__ import annotations

import io
import struct
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.importers import Translation
from virtualrobot_sdk.xml import Element, line_of, local_name

from virtualrobot_plugins.importers.glb import MAX_TRIANGLES, Piece, placed, write_glb
from virtualrobot_plugins.importers.refusal import counted, described, refusal, short_name
from virtualrobot_plugins.importers.xml import children, parse_xml

UNITS = {"micron": 1e-6, "millimeter": 1e-3, "centimeter": 1e-2, "inch": 0.0254, "foot": 0.3048, "meter": 1.0}
"""Length in meters of each value of `<model unit>` (core, 3.4)."""

MAX_PART_BYTES = 512 * 2**20
MAX_DEPTH = 32
MAX_INSTANCES = 100_000

_MODEL = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
_UNPACKING_ERRORS = (
    *(zipfile.BadZipFile, zlib.error, struct.error),
    *(EOFError, IndexError, OSError, OverflowError, RuntimeError, ValueError),
)
"""Exceptions that zipfile raises on broken archives (NotImplementedError is a RuntimeError)."""
_NO_COLOR = (200, 200, 200, 255)


@dataclass(slots=True)
class _Model:
    """One model part of the package: objects and colours by their ids."""

    path: str
    objects: dict[str, Element] = field(default_factory=dict)
    colors: dict[str, list[tuple[int, ...]]] = field(default_factory=dict)


class ThreeMfImporter:
    """Reads 3MF packages: objects, components and the build, in any unit, with colours of triangles and corners."""

    def translate(self, data: bytes, uri: str, files: Mapping[str, bytes | None], /) -> Translation:
        """Return what the package builds as GLB, in meters and with the axes of the package (z up).

        Raises:
            ArgumentError: for a broken package; the message names part, line and element where known.
        """
        with np.errstate(all="ignore"):  # numbers out of range are told by what they yield
            return _Reader(data, uri).read()


class _Reader:
    """Reads one package."""

    def __init__(self, data: bytes, uri: str) -> None:
        self._uri = uri
        try:
            self._archive = zipfile.ZipFile(io.BytesIO(data))
        except _UNPACKING_ERRORS as error:
            raise refusal(uri, f"not a 3MF package ({described(error)})") from error
        self._parts = {name.lstrip("/").lower(): name for name in self._archive.namelist()}
        self._models: dict[str, _Model] = {}
        self._meshes: dict[tuple[str, str], Piece] = {}
        self._unread: dict[str, int] = {}
        self._pieces: list[Piece] = []
        self._triangles = 0
        self._instances = 0

    def read(self) -> Translation:
        path = self._main_part()
        root = self._root(path)
        unit = root.get("unit", "millimeter").strip()
        if unit not in UNITS:
            raise self._error(root, path, f"unit={unit!r}: expected one of {', '.join(UNITS)}")
        model = self._model(path, root)
        build = next(children(root, "build"), None)
        items = [] if build is None else list(children(build, "item"))
        to_meters = np.diag((UNITS[unit],) * 3 + (1.0,))
        for item in items:
            self._place(model, item, to_meters, 0)
        if not items:
            raise refusal(self._uri, f"{path} builds nothing: there is no <item> in <build>")
        texts = [] if not self._unread else [f"{short_name(self._uri)}: left out: {counted(self._unread)}"]
        return Translation(".glb", write_glb(self._pieces, self._uri), tuple(texts))

    def _main_part(self) -> str:
        """Return the name of the package's first model, as its relationships tell it."""
        if "_rels/.rels" in self._parts:
            for relation in children(self._root("_rels/.rels"), "Relationship"):
                if relation.get("Type") == _MODEL:
                    return relation.get("Target", "").lstrip("/")
        if "3d/3dmodel.model" in self._parts:
            return "3D/3dmodel.model"
        raise refusal(self._uri, "not a 3MF package: it holds no 3D model part (3D/3dmodel.model)")

    def _root(self, path: str) -> Element:
        name = self._parts.get(path.lstrip("/").lower())
        if name is None:
            raise refusal(self._uri, f"the package has no part {path!r}")
        try:
            with self._archive.open(name) as part:
                data = part.read(MAX_PART_BYTES + 1)
        except _UNPACKING_ERRORS as error:
            raise refusal(self._uri, f"the part {path} is broken ({described(error)})") from error
        if len(data) > MAX_PART_BYTES:
            raise refusal(self._uri, f"the part {path} is larger than {MAX_PART_BYTES >> 20} MiB when unpacked")
        return parse_xml(data, f"{self._uri}/{path}", ".3mf", "kernel", huge=True)

    def _model(self, path: str, root: Element | None = None) -> _Model:
        known = self._models.get(path.lower())
        if known is not None:
            return known
        model = self._models[path.lower()] = _Model(path)
        root = self._root(path) if root is None else root
        if local_name(root) != "model":
            raise self._error(root, path, f"the root element is <{local_name(root)}>, expected <model>")
        for resources in children(root, "resources"):
            for resource in resources.iterchildren("{*}*"):
                identifier, kind = resource.get("id", ""), local_name(resource)
                if kind == "object":
                    model.objects[identifier] = resource
                elif kind == "basematerials":
                    model.colors[identifier] = self._colors(resource, path, "base", "displaycolor")
                elif kind == "colorgroup":
                    model.colors[identifier] = self._colors(resource, path, "color", "color")
                else:
                    self._unread[f"<{kind}>"] = self._unread.get(f"<{kind}>", 0) + 1
        return model

    def _colors(self, group: Element, path: str, tag: str, attribute: str) -> list[tuple[int, ...]]:
        colors = []
        for entry in children(group, tag):
            text = entry.get(attribute, "").strip()
            try:
                value = bytes.fromhex(text.removeprefix("#"))
            except ValueError:
                value = b""
            if not text.startswith("#") or len(value) not in (3, 4):
                raise self._error(entry, path, f"{attribute}={text!r}: expected #RRGGBB or #RRGGBBAA")
            colors.append((*value, 255)[:4])
        return colors

    def _place(self, model: _Model, reference: Element, matrix: NDArray[np.float64], depth: int) -> None:
        """Collect the object that an <item> or a <component> names."""
        self._instances += 1
        if depth > MAX_DEPTH:
            raise self._error(reference, model.path, f"components are nested more than {MAX_DEPTH} deep")
        if self._instances > MAX_INSTANCES:
            raise self._error(reference, model.path, f"the package builds more than {MAX_INSTANCES} objects")
        # The production extension lets an object stand in another part.
        other = next((value for name, value in reference.attrib.items() if name.endswith("}path")), "")
        model = self._model(other.lstrip("/")) if other else model
        identifier = reference.get("objectid", "")
        element = model.objects.get(identifier)
        if element is None:
            raise self._error(reference, model.path, f"there is no object with id {identifier!r}")
        matrix = matrix @ self._transform(reference, model.path)
        for mesh in children(element, "mesh"):
            key = (model.path, identifier)
            if key not in self._meshes:
                self._meshes[key] = self._mesh(model, element, mesh)
            self._triangles += len(self._meshes[key].faces)
            if self._triangles > MAX_TRIANGLES:
                raise refusal(self._uri, f"the package makes more than {MAX_TRIANGLES} triangles")
            self._pieces.append(placed(self._meshes[key], matrix))
        for components in children(element, "components"):
            for component in children(components, "component"):
                self._place(model, component, matrix, depth + 1)

    def _transform(self, element: Element, path: str) -> NDArray[np.float64]:
        text = element.get("transform")
        matrix = np.eye(4)
        if text is None:
            return matrix
        numbers = self._numbers(element, path, "transform", text.split())
        if len(numbers) != 12:
            raise self._error(element, path, f"transform={text!r}: expected 12 numbers")
        matrix[:3] = numbers.reshape(4, 3).T  # the format multiplies rows (core, 3.3)
        return matrix

    def _numbers(self, element: Element, path: str, what: str, texts: list[str]) -> NDArray[np.float64]:
        try:
            numbers = np.array(texts, np.float64)
        except ValueError as error:
            raise self._error(element, path, f"{what}: {error}") from error
        if not np.isfinite(numbers).all():
            raise self._error(element, path, f"{what}: a number is not finite")
        return numbers

    def _mesh(self, model: _Model, owner: Element, mesh: Element) -> Piece:
        path = model.path
        vertices = [vertex for group in children(mesh, "vertices") for vertex in children(group, "vertex")]
        triangles = [triangle for group in children(mesh, "triangles") for triangle in children(group, "triangle")]
        texts = [vertex.get(axis, "") for vertex in vertices for axis in "xyz"]
        points = self._numbers(mesh, path, "<vertex>", texts).reshape(-1, 3)
        corners = [triangle.get(corner, "") for triangle in triangles for corner in ("v1", "v2", "v3")]
        numbers = self._numbers(mesh, path, "<triangle>", corners).reshape(-1, 3)
        if len(numbers) and not 0 <= numbers.min() <= numbers.max() < len(points):
            worst = int(numbers.max() if numbers.min() >= 0 else numbers.min())
            raise self._error(mesh, path, f"a triangle names vertex {worst}, but there are {len(points)}")
        faces = numbers.astype(np.intp)
        colors = self._corner_colors(model, owner, triangles)
        if colors is None:
            return Piece(points, faces)
        if (colors == colors[0, 0]).all():
            red, green, blue, alpha = (float(value) / 255.0 for value in colors[0, 0])
            return Piece(points, faces, (red, green, blue, alpha))
        loose = points[faces].reshape(-1, 3)
        return Piece(loose, np.arange(len(loose)).reshape(-1, 3), vertex_colors=colors.reshape(-1, 4))

    def _corner_colors(self, model: _Model, owner: Element, triangles: list[Element]) -> NDArray[np.uint8] | None:
        """Return the colours (m, 3, 4) of the corners; None when no triangle has one (core, 4.1.4 and 5.1)."""
        own_group, own_index = owner.get("pid", ""), owner.get("pindex", "0")
        colored = False
        rows = np.empty((len(triangles), 3, 4), np.uint8)
        rows[:] = _NO_COLOR
        for row, triangle in zip(rows, triangles, strict=True):
            first = triangle.get("p1")
            group = model.colors.get(triangle.get("pid", own_group))
            if group is None:
                continue
            first = own_index if first is None else first
            indices = (first, triangle.get("p2", first), triangle.get("p3", first))
            try:
                row[:] = [group[int(index)] for index in indices]
            except (ValueError, IndexError) as error:
                text = f"properties {', '.join(indices)}: expected numbers from 0 to {len(group) - 1}"
                raise self._error(triangle, model.path, text) from error
            colored = True
        return rows if colored else None

    def _error(self, element: Element, path: str, message: str) -> Exception:
        return refusal(f"{self._uri}/{path}", message, line_of(element))
