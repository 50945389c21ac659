"""Still scenes as USDZ, which phones and headsets of Apple show in a room: made of what the kernel exports as GLB.

Sources: Pixar, USDZ File Format Specification 1.3 (files one after the other, uncompressed, their data at multiples of
64 bytes); UsdPreviewSurface Specification 2.6; Khronos Group, glTF 2.0.
"""

from __future__ import annotations

import io
import struct
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from virtualrobot.geometry import pose_from_quaternion
from virtualrobot.recording.gltf import unpack

ALIGNMENT = 64
"""Bytes of which the beginning of each file's data is a multiple."""
_PADDING_TAG = 0x1986
_LOCAL_HEADER_BYTES = 30
_EPOCH = 1980, 1, 1, 0, 0, 0
_TRIANGLES = 4
_KINDS = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}

HEAD = """#usda 1.0
(
    defaultPrim = "Cell"
    metersPerUnit = 1
    upAxis = "Y"
)

"""


def usdz_of(glb: bytes) -> bytes:
    """Return the scene of a GLB file as USDZ, y upwards, in meters; points and lines are left out."""
    scene = _Scene(*unpack(glb))
    return packed({"cell.usda": scene.text().encode(), **scene.images})


def packed(files: Mapping[str, bytes]) -> bytes:
    """Return an archive of files that are neither compressed nor encrypted, each aligned; the first is the scene."""
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_STORED) as written:
        for name, data in files.items():
            begin = archive.tell() + _LOCAL_HEADER_BYTES + len(name.encode()) + 4
            padding = -begin % ALIGNMENT
            entry = zipfile.ZipInfo(name, _EPOCH)
            entry.extra = struct.pack("<HH", _PADDING_TAG, padding) + b"\0" * padding
            written.writestr(entry, data)
    return archive.getvalue()


class _Scene:
    """A glTF tree as text of USD: each mesh and each look is written once, and named where it is seen."""

    def __init__(self, tree: dict[str, Any], buffer: memoryview) -> None:
        self._tree, self._buffer = tree, buffer
        self.images = {f"textures/{place}.png": self._image(one) for place, one in enumerate(tree.get("images", ()))}

    def text(self) -> str:
        meshes, looks = self._tree.get("meshes", ()), self._tree.get("materials", ())
        (root,) = self._tree["scenes"][0]["nodes"]
        lines = [HEAD, 'def Xform "Cell" (\n    kind = "component"\n)\n{\n', 'def Scope "Looks"\n{\n']
        for place, look in enumerate(looks):
            lines += self._look(place, look)
        lines += ["}\n", *self._node(root), "}\n\n", 'class "Shapes"\n{\n']
        for place, mesh in enumerate(meshes):
            lines += self._mesh(place, mesh)
        return "".join([*lines, "}\n"])

    def _node(self, place: int) -> Iterable[str]:
        node = self._tree["nodes"][place]
        mesh = node.get("mesh")
        shape = "" if mesh is None else f" (\n    prepend references = </Shapes/shape_{mesh}>\n)"
        yield f'def Xform "node_{place}"{shape}\n{{\n'
        yield f"matrix4d xformOp:transform = {_matrix(_pose(node))}\n"
        yield 'uniform token[] xformOpOrder = ["xformOp:transform"]\n'
        for child in node.get("children", ()):
            yield from self._node(child)
        yield "}\n"

    def _mesh(self, place: int, mesh: dict[str, Any]) -> Iterable[str]:
        yield f'def Xform "shape_{place}"\n{{\n'
        for number, part in enumerate(mesh["primitives"]):
            if part.get("mode", _TRIANGLES) == _TRIANGLES:
                yield from self._part(number, part)
        yield "}\n"

    def _part(self, number: int, part: dict[str, Any]) -> Iterable[str]:
        attributes = part["attributes"]
        points = self._values(attributes["POSITION"])
        faces = self._values(part["indices"]).ravel() if "indices" in part else np.arange(len(points))
        yield f'def Mesh "part_{number}" (\n    prepend apiSchemas = ["MaterialBindingAPI"]\n)\n{{\n'
        yield 'uniform token subdivisionScheme = "none"\nuniform bool doubleSided = 1\n'
        yield f"float3[] extent = [{_row(points.min(axis=0))}, {_row(points.max(axis=0))}]\n"
        yield f"int[] faceVertexCounts = {_whole(np.full(len(faces) // 3, 3))}\n"
        yield f"int[] faceVertexIndices = {_whole(faces)}\n"
        yield f"point3f[] points = {_rows(points)}\n"
        if "NORMAL" in attributes:
            normals = _rows(self._values(attributes["NORMAL"]))
            yield f'normal3f[] normals = {normals} (\n    interpolation = "vertex"\n)\n'
        if "TEXCOORD_0" in attributes:
            # From the upper left corner of the image there, from the lower left one here.
            corners = self._values(attributes["TEXCOORD_0"]) * [1.0, -1.0] + [0.0, 1.0]
            yield f'texCoord2f[] primvars:st = {_rows(corners)} (\n    interpolation = "vertex"\n)\n'
        if "COLOR_0" in attributes:
            colors = self._values(attributes["COLOR_0"])[:, :3]
            yield f'color3f[] primvars:displayColor = {_rows(colors)} (\n    interpolation = "vertex"\n)\n'
        colored = "_colored" if "COLOR_0" in attributes else ""
        yield f"rel material:binding = </Cell/Looks/look_{part['material']}{colored}>\n}}\n"

    def _look(self, place: int, look: dict[str, Any]) -> Iterable[str]:
        """Write a look; where vertices have colours of their own, once more with these."""
        parts = [part for mesh in self._tree.get("meshes", ()) for part in mesh["primitives"]]
        used = {"COLOR_0" in part["attributes"] for part in parts if part.get("material") == place}
        for colored in sorted(used):
            yield from self._material(f"look_{place}{'_colored' if colored else ''}", look, colored)

    def _material(self, name: str, look: dict[str, Any], colored: bool) -> Iterable[str]:
        surface = look["pbrMetallicRoughness"]
        *color, opacity = surface.get("baseColorFactor", (1.0, 1.0, 1.0, 1.0))
        texture, path = surface.get("baseColorTexture"), f"/Cell/Looks/{name}"
        source = f"{path}/Texture.outputs:rgb" if texture else f"{path}/Colors.outputs:result" if colored else ""
        yield f'def Material "{name}"\n{{\n'
        yield f"token outputs:surface.connect = <{path}/Surface.outputs:surface>\n"
        yield 'def Shader "Surface"\n{\nuniform token info:id = "UsdPreviewSurface"\n'
        yield (
            f"color3f inputs:diffuseColor.connect = <{source}>\n"
            if source
            else (f"color3f inputs:diffuseColor = {_row(color)}\n")
        )
        yield f"float inputs:opacity = {opacity:.6g}\n"
        yield f"float inputs:roughness = {surface.get('roughnessFactor', 1.0):.6g}\n"
        yield f"float inputs:metallic = {surface.get('metallicFactor', 1.0):.6g}\n"
        yield "token outputs:surface\n}\n"
        if texture:
            image = self._tree["textures"][texture["index"]]["source"]
            yield 'def Shader "Texture"\n{\nuniform token info:id = "UsdUVTexture"\n'
            yield f"asset inputs:file = @textures/{image}.png@\n"
            yield f"float2 inputs:st.connect = <{path}/Corners.outputs:result>\n"
            yield f"float4 inputs:scale = {_row([*color, 1.0])}\n"
            yield 'token inputs:wrapS = "repeat"\ntoken inputs:wrapT = "repeat"\n'
            yield 'token inputs:sourceColorSpace = "sRGB"\nfloat3 outputs:rgb\n}\n'
            yield from _reader("Corners", "float2", "st")
        elif colored:
            yield from _reader("Colors", "float3", "displayColor")
        yield "}\n"

    def _values(self, place: int) -> NDArray[np.float64]:
        """Return the numbers (n, k) of an accessor."""
        accessor = self._tree["accessors"][place]
        view = self._tree["bufferViews"][accessor["bufferView"]]
        kind, width = _KINDS[accessor["componentType"]], _WIDTHS[accessor["type"]]
        begin = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        flat = np.frombuffer(self._buffer, kind, accessor["count"] * width, begin).reshape(-1, width)
        return flat / np.iinfo(kind).max if accessor.get("normalized") else flat.astype(float)

    def _image(self, image: dict[str, Any]) -> bytes:
        view = self._tree["bufferViews"][image["bufferView"]]
        begin = view.get("byteOffset", 0)
        return bytes(self._buffer[begin : begin + view["byteLength"]])


def _reader(name: str, kind: str, primvar: str) -> Iterable[str]:
    yield f'def Shader "{name}"\n{{\nuniform token info:id = "UsdPrimvarReader_{kind}"\n'
    yield f'string inputs:varname = "{primvar}"\n{kind} outputs:result\n}}\n'


def _pose(node: Mapping[str, Any]) -> NDArray[np.float64]:
    """Return the pose (4, 4) of a glTF node in its parent."""
    if "matrix" in node:
        return np.asarray(node["matrix"], float).reshape(4, 4).T
    pose = pose_from_quaternion(node.get("translation", (0.0, 0.0, 0.0)), node.get("rotation", (0.0, 0.0, 0.0, 1.0)))
    pose[:3, :3] *= node.get("scale", (1.0, 1.0, 1.0))
    return pose


def _matrix(pose: NDArray[np.float64]) -> str:
    """Return a pose as USD has it, for rows from the left."""
    return f"({', '.join(f'({_numbers(row)})' for row in pose.T)})"


def _numbers(values: Iterable[float]) -> str:
    return ", ".join(f"{value:.7g}" for value in values)


def _row(values: Sequence[float] | NDArray[np.float64]) -> str:
    return f"({_numbers(values)})"


def _rows(values: NDArray[np.float64]) -> str:
    pattern = f"({', '.join(['%.6g'] * values.shape[1])})"
    return f"[{', '.join([pattern] * len(values)) % tuple(values.ravel())}]"


def _whole(values: NDArray[Any]) -> str:
    return f"[{', '.join(map(str, values.astype(int).tolist()))}]"
