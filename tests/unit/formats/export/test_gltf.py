"""Worlds written as glTF, taken apart by the specification and loaded by trimesh."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image
from scipy.spatial.transform import Rotation
from virtualrobot_kernel.errors import KernelError, UnknownNameError
from virtualrobot_kernel.formats.assets import AssetStore
from virtualrobot_kernel.formats.export.model import export_model
from virtualrobot_kernel.formats.mesh_library import MeshLibrary
from virtualrobot_kernel.formats.models import import_model
from virtualrobot_kernel.world.figures import (
    Box,
    Capsule,
    Cone,
    Cylinder,
    Figure,
    Frame,
    Geometry,
    Label,
    Lines,
    Material,
    Mesh,
    Points,
    Sphere,
)
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind, NodeSpec, ToolData

from tests.khronos import NEEDS_VALIDATOR, issues_of
from tests.unit.formats.export.glb_reading import Glb, checked
from tests.unit.formats.export.worlds import drawn, one, snapshot_of
from tests.unit.formats.models import DATA, ROBOTS, binary_stl, corner_positions, disk, load, structure_of, volume

UP = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]])
"""glTF is right-handed with y up (3.4): our x, y, z are its x, -z, y."""


def random_pose(rng: np.random.Generator) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.random(rng=rng).as_matrix()
    pose[:3, 3] = rng.uniform(-2.0, 2.0, 3)
    return pose


def glb_of(snapshot: Snapshot, library: MeshLibrary | None = None, name: str = "") -> Glb:
    library = library or MeshLibrary(AssetStore())
    ((path, sha256),) = export_model(snapshot, library, name, ".glb").files
    assert path == f"{name or 'world'}.glb"
    return checked(library.store.get(sha256))


def shown(glb: Glb, node: str = "thing", figure: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices (n, 3) and faces (m, 3) of a figure with one part, in its own frame."""
    (primitive,) = glb.primitives(f"{node} figure {figure}")
    return glb.array(primitive["attributes"]["POSITION"]), glb.array(primitive["indices"]).reshape(-1, 3)


# How much a figure of flat faces may lack of the true volume: corners lie on the surface, so it never has more.
@pytest.mark.parametrize(
    ("geometry", "true_volume", "size"),
    [
        (Box((0.3, 0.2, 0.5)), 0.03, (0.3, 0.2, 0.5)),
        (Sphere(0.4), 4 / 3 * np.pi * 0.4**3, (0.8, 0.8, 0.8)),
        (Cylinder(0.4, 0.7), np.pi * 0.4**2 * 0.7, (0.8, 0.8, 0.7)),
        (Cone(0.4, 0.7), np.pi * 0.4**2 * 0.7 / 3, (0.8, 0.8, 0.7)),
        (Capsule(0.4, 0.7), np.pi * 0.4**2 * 0.7 + 4 / 3 * np.pi * 0.4**3, (0.8, 0.8, 1.5)),
    ],
)
def test_primitives_have_their_size_and_volume(
    geometry: Geometry, true_volume: float, size: tuple[float, float, float]
) -> None:
    vertices, faces = shown(glb_of(snapshot_of([one(Figure(geometry))])))
    assert 0.98 * true_volume < volume(vertices, faces) <= true_volume * (1 + 1e-6)
    assert np.ptp(vertices, axis=0) == pytest.approx(size, rel=1e-3)
    assert vertices.mean(axis=0)[:2] == pytest.approx([0, 0], abs=0.05)


def test_a_cone_has_its_tip_above() -> None:
    vertices, _ = shown(glb_of(snapshot_of([one(Figure(Cone(0.4, 0.7)))])))
    assert np.linalg.norm(vertices[vertices[:, 2] > 0.349, :2], axis=1).max() < 1e-6


def test_every_node_is_where_the_world_has_it(rng: np.random.Generator) -> None:
    """Robots in random postures; poses by the forest pass, checked against other engines elsewhere."""
    model, library = load(ROBOTS["panda"], name="arm")
    nodes = [
        NodeSpec("table", Kind.OBJECT, parent_t_node=random_pose(rng), figures=(Figure(Box((1.0, 1.0, 0.1))),)),
        NodeSpec(model.nodes[0].name, Kind.ROBOT, "table", random_pose(rng), data=model.nodes[0].data),
        *model.nodes[1:],
        NodeSpec("box", Kind.PART, "arm.panda_hand", random_pose(rng), figures=(Figure(Box((0.1, 0.1, 0.1))),)),
    ]
    snapshot = snapshot_of(nodes, drawn(structure_of(tuple(nodes))[0], rng))
    glb = glb_of(snapshot, library)
    poses = glb.poses()
    for node in snapshot.structure.nodes.values():
        assert np.abs(poses[node.name] - UP @ snapshot.world_t(node.uid)).max() < 1e-9, node.name
    parents = {
        glb.json["nodes"][child]["name"]: node["name"]
        for node in glb.json["nodes"]
        for child in node.get("children", [])
    }
    for spec in nodes:
        assert parents[spec.name] == spec.parent
    # Below a node: its own frame becomes the file's.
    arm = glb_of(snapshot, library, "arm").poses()
    arm_t_world = np.linalg.inv(snapshot.world_t(snapshot.structure.uid_by_name["arm"]))
    hand = snapshot.structure.uid_by_name["arm.panda_hand"]
    assert np.abs(arm["arm.panda_hand"] - UP @ arm_t_world @ snapshot.world_t(hand)).max() < 1e-9
    assert "table" not in arm and "box" in arm


def test_trimesh_shows_a_mesh_where_its_file_and_poses_say(rng: np.random.Generator) -> None:
    """Corners of the file (its own format's rules), scaled, posed, turned y-up, must be corners that trimesh loads."""
    data = (DATA / "kuka_iiwa/meshes/link_3.stl").read_bytes()
    library = MeshLibrary(AssetStore())
    mesh = Mesh("link_3.stl", library.store.put(data), (0.5, -2.0, 1.5))
    world_t_node, node_t_figure = random_pose(rng), random_pose(rng)
    node = NodeSpec("thing", Kind.OBJECT, parent_t_node=world_t_node, figures=(Figure(mesh, node_t_figure),))
    ((_, sha256),) = export_model(snapshot_of([node]), library, "", ".glb").files
    scene = trimesh.load_scene(io.BytesIO(library.store.get(sha256)), file_type="glb")
    loaded = scene.to_mesh()
    corners = corner_positions(data, ".stl") * mesh.scale
    frame = UP @ world_t_node @ node_t_figure
    expected = corners @ frame[:3, :3].T + frame[:3, 3]
    assert loaded.bounds == pytest.approx(np.array([expected.min(axis=0), expected.max(axis=0)]), abs=1e-6)
    nearest = trimesh.proximity.ProximityQuery(loaded).vertex(expected[rng.integers(len(expected), size=200)])[0]
    assert nearest.max() < 1e-6
    # Mirrored, but inside out nowhere. The file has gaps, through which its volume depends on the origin a little.
    assert loaded.volume == pytest.approx(1.5 * trimesh.load_mesh(io.BytesIO(data), "stl").volume, rel=0.02)


def test_colours_are_linear_light() -> None:
    """IEC 61966-2-1: 8-bit 188 is half of the light."""
    color = (188 / 255, 0.0, 1.0, 0.25)
    glb = glb_of(snapshot_of([one(Figure(Box((1, 1, 1)), material=Material(color)), Figure(Sphere(1.0)))]))
    (primitive,) = glb.primitives("thing figure 1")
    material = glb.material(primitive)
    assert material["pbrMetallicRoughness"]["baseColorFactor"] == pytest.approx([0.5029, 0, 1, 0.25], abs=1e-4)
    assert material["alphaMode"] == "BLEND"
    assert "alphaMode" not in glb.material(glb.primitives("thing figure 2")[0])


def test_textures_and_their_places_come_along() -> None:
    model, library = load(DATA / "duck.obj", name="duck")
    (part,) = library.load(model.nodes[0].figures[0].geometry)  # pyright: ignore[reportArgumentType]  a mesh
    glb = glb_of(snapshot_of(model.nodes), library)
    (primitive,) = glb.primitives("duck figure 1")
    with Image.open(io.BytesIO(glb.image(primitive))) as ours, Image.open(DATA / "duckCM.png") as theirs:
        assert np.array_equal(np.asarray(ours.convert("RGB")), np.asarray(theirs.convert("RGB")))
    # glTF counts v from above (3.8.2), OBJ from below.
    texture_v = [float(line.split()[2]) for line in (DATA / "duck.obj").read_text().splitlines() if line[:3] == "vt "]
    v = glb.array(primitive["attributes"]["TEXCOORD_0"])[:, 1]
    assert v.min() == pytest.approx(1 - max(texture_v), abs=1e-6) and v.max() == pytest.approx(
        1 - min(texture_v), abs=1e-6
    )
    assert part.uv is not None


def test_colours_of_vertices_come_along(rng: np.random.Generator) -> None:
    colors = rng.integers(0, 256, (4, 4), dtype=np.uint8)
    colors[0, 3], colors[1] = 100, [128, 10, 255, 255]  # trimesh writes them as they are, which means linear light
    body = trimesh.Trimesh(np.eye(4)[:, :3], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], process=False)
    body.visual.vertex_colors = colors  # pyright: ignore
    library = MeshLibrary(AssetStore())
    mesh = Mesh("a.glb", library.store.put(body.export(file_type="glb")))  # pyright: ignore[reportArgumentType]
    plain, painted = Figure(mesh), Figure(mesh, material=Material((1.0, 0.0, 0.0, 1.0)))
    glb = glb_of(snapshot_of([one(plain, painted)]), library)
    (primitive,) = glb.primitives("thing figure 1")
    light = glb.array(primitive["attributes"]["COLOR_0"])
    rows = light[np.abs(light[:, 2] - 1.0) < 1e-9]
    # Between, they are 8 bits of sRGB; at the upper end a level of those is 2.3 levels of linear light.
    assert np.abs(rows - colors[1] / 255).max(axis=1).min() < 0.6 * 2.3 / 255
    assert glb.material(primitive)["alphaMode"] == "BLEND"
    (other,) = glb.primitives("thing figure 2")
    assert "COLOR_0" not in other["attributes"]
    assert other["attributes"]["POSITION"] == primitive["attributes"]["POSITION"], "the same places, in another look"


def test_equal_figures_share_one_mesh() -> None:
    model, library = load(ROBOTS["iiwa"], name="a")
    store = library.store

    def exported(count: int) -> tuple[Glb, int]:
        nodes = []
        for number in range(count):
            robot = load(ROBOTS["iiwa"], name=f"arm {number}")[0].nodes
            nodes.extend(robot)
        ((_, sha256),) = export_model(snapshot_of(nodes), library, "", ".glb").files
        return checked(store.get(sha256)), len(store.get(sha256))

    assert model.mesh_count == 14 + 2
    alone, size = exported(1)
    many, many_size = exported(5)
    assert len(many.json["meshes"]) == len(alone.json["meshes"])
    assert len(many.json["nodes"]) == 5 * (len(alone.json["nodes"]) - 1) + 1
    assert many.binary == alone.binary and many_size < 1.05 * size


def test_points_lines_and_frames_are_marks(rng: np.random.Generator) -> None:
    places, ends = rng.normal(size=(7, 3)), rng.normal(size=(3, 2, 3))
    colors = rng.integers(0, 256, (7, 3), dtype=np.uint8)
    colors[0] = 188, 10, 255
    figures = (
        Figure(Points(places.tobytes(), colors.tobytes())),
        Figure(Points(places.tobytes()), material=Material((1.0, 0.0, 0.0, 1.0))),
        Figure(Lines(ends.tobytes())),
        Figure(Frame(0.3)),
        Figure(Points(b"")),
        Figure(Label("here")),
    )
    library = MeshLibrary(AssetStore())
    exported = export_model(snapshot_of([one(*figures)]), library, "thing", ".glb")
    glb = checked(library.store.get(exported.files[0][1]))
    (points,), (red,), (lines,), (frame,) = (glb.primitives(f"thing figure {k}") for k in (1, 2, 3, 4))
    assert [one["mode"] for one in (points, red, lines, frame)] == [0, 0, 1, 1]
    assert np.array_equal(glb.array(points["attributes"]["POSITION"]), places.astype(np.float32))
    first = glb.array(points["attributes"]["COLOR_0"])[0]
    assert first == pytest.approx([0.5029, 10 / 255 / 12.92, 1.0, 1.0], abs=1e-4)
    assert glb.material(red)["pbrMetallicRoughness"]["baseColorFactor"] == [1.0, 0.0, 0.0, 1.0]
    assert np.array_equal(glb.array(lines["attributes"]["POSITION"]), ends.reshape(-1, 3).astype(np.float32))
    assert glb.array(frame["attributes"]["POSITION"])[1::2] == pytest.approx(0.3 * np.eye(3))
    assert glb.array(frame["attributes"]["COLOR_0"])[::2, :3].argmax(axis=1).tolist() == [0, 1, 2]
    assert len(glb.json["meshes"]) == 4
    assert [("labels" in text and "'thing'" in text, "sizes" in text) for text in exported.warnings] == [
        (True, False),
        (False, True),
    ]


def test_only_what_can_be_seen_is_written() -> None:
    box = Box((0.1, 0.1, 0.1))
    tool = NodeSpec(
        "gun",
        Kind.TOOL,
        figures=(Figure(Sphere(0.1), tool_state="open"), Figure(Sphere(0.2), tool_state="closed")),
        data=ToolData(states={"open": {}, "closed": {}}),
    )
    nodes = [
        one(Figure(box), Figure(Sphere(0.3), visual=False), name="seen"),
        one(Figure(box), name="unseen", hidden=True),
        NodeSpec("below", Kind.OBJECT, "unseen", figures=(Figure(box),)),
        tool,
    ]
    names = set(glb_of(snapshot_of(nodes)).poses())
    assert names == {"world", "seen", "seen figure 1", "gun", "gun figure 1"}
    first, second = (glb_of(snapshot_of(nodes, tool_states={"gun": state})) for state in ("open", "closed"))
    sizes = [np.ptp(shown(glb, "gun")[0], axis=0)[2] for glb in (first, second)]
    assert sizes == pytest.approx([0.2, 0.4])


def test_odd_meshes_become_valid(rng: np.random.Generator) -> None:
    """Normals of length 0 and 5, a texture coordinate that is no number, more than 65,535 vertices."""
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\nvn 0 0 5\nvt 0 0\nvt nan 1\nf 1/1/1 2/2/2 3/1/2\n"
    library = MeshLibrary(AssetStore())
    small = Mesh("a.obj", library.store.put(text.encode()))
    corners = rng.normal(size=(70_000, 3)).astype(np.float32)
    big = Mesh("b.stl", library.store.put(binary_stl(corners, np.arange(69_999).reshape(-1, 3))))
    glb = glb_of(snapshot_of([one(Figure(small), Figure(big))]), library)
    assert shown(glb, figure=1)[1].dtype == np.uint16
    vertices, faces = shown(glb, figure=2)
    assert faces.dtype == np.uint32
    assert np.array_equal(vertices[faces].reshape(-1, 3), corners[:69_999])


def test_the_same_world_gives_the_same_bytes() -> None:
    files = []
    for _ in range(2):
        model, library = load(ROBOTS["r2d2"], name="droid")
        files.append([export_model(snapshot_of(model.nodes), library, "", kind) for kind in (".glb",)])
    assert files[0] == files[1]


def test_refusals_say_what_would_be_right() -> None:
    library = MeshLibrary(AssetStore())
    hidden = snapshot_of([one(Figure(Box((1, 1, 1))), hidden=True), NodeSpec("empty", Kind.OBJECT)])
    with pytest.raises(UnknownNameError, match="thing") as unknown:
        export_model(hidden, library, "thin", ".glb")
    assert unknown.value.metadata["nearest"] == "thing"
    with pytest.raises(KernelError, match=r"'\.step'.*\.glb, \.urdf"):
        export_model(hidden, library, "thing", ".step")
    with pytest.raises(KernelError, match="'thing'; it is hidden"):
        export_model(hidden, library, "thing", ".glb")
    with pytest.raises(KernelError, match="'empty'; a visual figure"):
        export_model(hidden, library, "empty", ".glb")
    with pytest.raises(KernelError, match="'world'"):
        export_model(snapshot_of([one(Figure(Label("words")))]), library, "", ".glb")


@NEEDS_VALIDATOR
def test_the_validator_of_khronos_finds_nothing(tmp_path: Path, rng: np.random.Generator) -> None:
    nodes, library = [], MeshLibrary(AssetStore())
    for file in (ROBOTS["r2d2"], ROBOTS["xarm6"], DATA / "duck.obj"):
        nodes.extend(import_model(str(file), disk(library.store), library).nodes)  # pyright: ignore
    marks = (Figure(Points(rng.normal(size=(5, 3)).tobytes())), Figure(Frame()), Figure(Capsule(0.1, 0.3)))
    nodes.append(one(*marks, Figure(Cone(0.1, 0.3), material=Material((1.0, 0.5, 0.0, 0.5)))))
    exported = export_model(snapshot_of(nodes), library, "", ".glb")
    (tmp_path / "world.glb").write_bytes(library.store.get(exported.files[0][1]))
    issues = issues_of(tmp_path / "world.glb")
    assert (issues["numErrors"], issues["numWarnings"]) == (0, 0), issues["messages"][:5]


def test_what_is_too_large_for_the_format_stays_valid() -> None:
    places = np.array([[1e300, 0.0, 0.0], [-1e39, 1.0, 0.0]])
    glb = glb_of(snapshot_of([one(Figure(Points(places.tobytes())))]))
    (points,) = glb.primitives("thing figure 1")
    assert glb.array(points["attributes"]["POSITION"])[0, 0] == np.finfo(np.float32).max


def test_equal_bytes_of_other_places_are_one_mesh() -> None:
    library = MeshLibrary(AssetStore())
    sha256 = library.store.put((DATA / "kuka_iiwa/meshes/link_3.stl").read_bytes())
    figures = [
        Figure(Mesh(uri, sha256, scale)) for uri in ("a/b.stl", "c.stl") for scale in ((1.0, 1.0, 1.0), (2.0, 1.0, 1.0))
    ]
    glb = glb_of(snapshot_of([one(*figures)]), library)
    assert [mesh["name"] for mesh in glb.json["meshes"]] == ["b.stl", "b.stl"]


def test_each_surface_has_its_roughness_and_metalness() -> None:
    """By glTF 2.0, 3.9.2, `roughnessFactor` and `metallicFactor` of a material; what says neither has ours."""
    grey = (0.5, 0.5, 0.5, 1.0)
    steel = Figure(Box((1, 1, 1)), material=Material(grey, roughness=0.25, metalness=1.0))
    glb = glb_of(snapshot_of([one(steel, Figure(Box((1, 1, 1)), material=Material(grey)))]))
    for figure, expected in ((1, (0.25, 1.0)), (2, (0.62, 0.0))):
        surface = glb.material(glb.primitives(f"thing figure {figure}")[0])["pbrMetallicRoughness"]
        assert (surface["roughnessFactor"], surface["metallicFactor"]) == expected
