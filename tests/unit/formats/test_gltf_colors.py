"""Colours of glTF files, which are linear light (Khronos, glTF 2.0, 3.7.2.1 and 3.9.2): read, and written and read."""

from __future__ import annotations

import base64
import io
import json
from typing import Any

import numpy as np
import pytest
from PIL import Image
from virtualrobot_kernel.errors import MalformedFileError
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.export.model import export_model
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.meshes import parse_mesh
from virtualrobot_kernel.shapes.submesh import Submesh
from virtualrobot_kernel.world.figures import Box, Figure, Material, Mesh
from virtualrobot_plugins.importers.glb import Piece, write_glb

from tests.unit.formats.export.worlds import one, snapshot_of
from tests.unit.formats.models import TETRAHEDRON
from tests.unit.formats.test_meshes import BUFFER, gltf_tree

HALF = 0.21404114
"""Linear light of sRGB 0.5: ((0.5 + 0.055) / 1.055)^2.4 (IEC 61966-2-1)."""

COMPONENTS = {"u1": 5121, "u2": 5123, "f4": 5126}


def gltf(material: dict[str, Any] | None, light: np.ndarray | None = None, kind: str = "f4") -> bytes:
    """Return a tetrahedron with this material and these colours of its vertices, in linear light of 0 to 1."""
    stored = b""
    if light is not None:
        scale = 1.0 if kind == "f4" else np.iinfo(kind).max
        numbers = light * scale
        stored = (numbers if kind == "f4" else np.round(numbers)).astype(f"<{kind}").tobytes()
    buffer = BUFFER + stored
    uri: dict[str, object] = {"uri": "data:application/octet-stream;base64," + base64.b64encode(buffer).decode()}
    tree: dict[str, Any] = gltf_tree(uri)
    (primitive,) = tree["meshes"][0]["primitives"]
    if material is None:
        del primitive["material"], tree["materials"]
    else:
        tree["materials"] = [material]
    tree["buffers"][0]["byteLength"] = len(buffer)
    if light is not None:
        primitive["attributes"]["COLOR_0"] = 2
        tree["bufferViews"].append({"buffer": 0, "byteOffset": len(BUFFER), "byteLength": len(stored)})
        accessor = {"bufferView": 2, "componentType": COMPONENTS[kind], "count": 4, "type": f"VEC{light.shape[1]}"}
        tree["accessors"].append({**accessor, "normalized": kind != "f4"})
    return json.dumps(tree).encode()


def factor(*color: float) -> dict[str, Any]:
    return {"name": "paint", "pbrMetallicRoughness": {"baseColorFactor": list(color)}}


def color_of(data: bytes) -> tuple[float, ...]:
    (part,) = parse_mesh(data, "a.gltf")
    assert part.color is not None and part.vertex_colors is None
    return part.color


def test_half_of_srgb_comes_in_as_half() -> None:
    assert color_of(gltf(factor(HALF, HALF, HALF, 0.5))) == pytest.approx((0.5, 0.5, 0.5, 0.5), abs=1e-5)
    # Below 0.0031308 the curve is a line: 8-bit 1, 2 and 5.
    assert color_of(gltf(factor(1 / 255 / 12.92, 2 / 255 / 12.92, 5 / 255 / 12.92, 1.0))) == pytest.approx(
        (1 / 255, 2 / 255, 5 / 255, 1.0), abs=1e-5
    )


def test_a_material_without_a_factor_is_white_and_without_a_material_nothing_is_told() -> None:
    assert color_of(gltf({"pbrMetallicRoughness": {"roughnessFactor": 0.3}})) == (1.0, 1.0, 1.0, 1.0)  # 5.22.1: default
    (part,) = parse_mesh(gltf(None), "a.gltf")
    assert part.color is None and part.vertex_colors is None


@pytest.mark.parametrize("kind", COMPONENTS)
@pytest.mark.parametrize("width", [3, 4])
def test_vertex_colours_of_every_type_times_the_material(kind: str, width: int, rng: np.random.Generator) -> None:
    light = rng.uniform(0.0, 1.0, (4, width))
    light[0, :3] = HALF
    for material, by in ((None, 1.0), (factor(0.5, 0.5, 0.5, 1.0), 0.5)):
        (part,) = parse_mesh(gltf(material, light, kind), "a.gltf")
        assert part.vertex_colors is not None and part.color is None
        order = [int(np.argmin(np.abs(part.vertices - corner).sum(axis=1))) for corner in TETRAHEDRON]
        found = part.vertex_colors[order] / 255.0
        stored = light if kind == "f4" else np.round(light * np.iinfo(kind).max) / np.iinfo(kind).max
        assert ((found[:, :3] + 0.055) / 1.055) ** 2.4 == pytest.approx(by * stored[:, :3], abs=0.005)
        assert found[:, 3] == pytest.approx(stored[:, 3] if width == 4 else np.ones(4), abs=0.5001 / 255)
        if by == 1.0 and kind != "u1":
            assert found[0, :3] == pytest.approx([0.5] * 3, abs=1 / 255)


def test_the_colour_of_specular_materials_is_linear_light_too() -> None:
    """With the reflectance of plastic, 0.04, the diffuse colour is nearly the base colour of the core's model."""
    surface = {"diffuseFactor": [HALF, HALF, HALF, 1.0], "specularFactor": [0.04, 0.04, 0.04]}
    look = color_of(gltf({"extensions": {"KHR_materials_pbrSpecularGlossiness": surface}}))
    assert look[:3] == pytest.approx((0.5, 0.5, 0.5), abs=0.03)


@pytest.mark.parametrize("bad", [[1.0, 0.0], [1.0, None, 0.0, 1.0], "red", [float("nan")] * 4])
def test_a_factor_that_is_none_is_refused(bad: Any) -> None:  # noqa: ANN401  whatever JSON holds
    with pytest.raises(MalformedFileError, match=r"^a\.gltf: broken"):
        parse_mesh(gltf({"pbrMetallicRoughness": {"baseColorFactor": bad}}), "a.gltf")


def read_back(figures: list[Figure], library: MeshLibrary) -> list[Submesh]:
    ((name, sha256),) = export_model(snapshot_of([one(*figures)]), library, "", ".glb").files
    parts = parse_mesh(library.store.get(sha256), name)
    assert len(parts) == len(figures)
    return list(parts)


def test_what_is_exported_comes_back_in_the_same_colours(rng: np.random.Generator) -> None:
    colors = [(*rgb, 1.0) for rgb in rng.uniform(0.0, 1.0, (6, 3)).tolist()]
    colors += [(level / 255, 0.0, (level + 1) / 255, 0.5) for level in range(24)] + [(0.5, 0.5, 0.5, 1.0)]
    boxes = [Figure(Box((0.1, 0.1, 0.1)), material=Material(color)) for color in colors]
    found = np.array([part.color for part in read_back(boxes, MeshLibrary(AssetStore()))])
    apart = np.abs(found[:, None] - np.array(colors)).max(axis=2)  # the reader keeps no order
    assert sorted(apart.argmin(axis=0).tolist()) == list(range(len(colors)))
    assert apart.min(axis=0).max() < 1e-5


def test_colours_of_vertices_and_textures_come_back(rng: np.random.Generator) -> None:
    points, faces = rng.uniform(-1.0, 1.0, (300, 3)), np.arange(300).reshape(-1, 3)
    painted = rng.integers(0, 256, (300, 4), dtype=np.uint8)
    painted[:20, :3] = np.arange(20)[:, None]  # the dark ones
    image = io.BytesIO()
    Image.fromarray(rng.integers(0, 256, (4, 4, 3), dtype=np.uint8)).save(image, "PNG")
    tint = (0.2, 0.4, 0.03, 1.0)
    uv = rng.uniform(0.0, 1.0, (300, 2))
    library = MeshLibrary(AssetStore())
    figures = [
        Figure(Mesh(f"{name}.glb", library.store.put(write_glb([piece], "x"))))
        for name, piece in (
            ("painted", Piece(points, faces, vertex_colors=painted)),
            ("wood", Piece(points, faces, tint, uv=uv, texture=image.getvalue())),
        )
    ]
    first, second = sorted(read_back(figures, library), key=lambda part: part.texture is not None)
    assert first.vertex_colors is not None
    assert np.array_equal(first.vertex_colors[first.faces].reshape(-1, 4), painted)
    assert second.texture is not None and second.color == pytest.approx(tint, abs=1e-5)
    with Image.open(io.BytesIO(second.texture)) as theirs, Image.open(image) as ours:
        assert np.array_equal(np.asarray(theirs), np.asarray(ours))
