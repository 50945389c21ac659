"""ExportModel: a world as glTF, a robot as URDF, by the stubs; what is written is read by others and by the kernel."""

from __future__ import annotations

import io

import grpc
import numpy as np
import pytest
import trimesh
from virtualrobot.v1 import nodes_pb2, scene_pb2

from tests.api.asking import IIWA, MODELS, PANDA, apply, box, create, load, refusal
from tests.api.reading import matrix, pose, random_matrix, scene, unchanged
from tests.api.test_asset import download
from tests.api.test_robot import drawn, put, robot
from tests.api.test_scene import update
from tests.api.test_tool import pick, select, tool
from tests.kernels import StartKernel, Stubs
from tests.unit.formats.export.glb_reading import Glb, checked

UP = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1.0]])
"""glTF is right-handed with y up (glTF 2.0, 3.4): our x, y, z are its x, -z, y."""


def export(stubs: Stubs, node: str = "", format: str = ".glb") -> scene_pb2.ExportModelResponse:
    return stubs.scene.ExportModel(scene_pb2.ExportModelRequest(node=node, format=format))


def content(stubs: Stubs, file: nodes_pb2.AssetFile) -> bytes:
    return b"".join(download(stubs, file.sha256))


def glb_of(stubs: Stubs, node: str = "") -> Glb:
    (file,) = export(stubs, node).files
    assert file.uri == f"{node or 'world'}.glb"
    return checked(content(stubs, file))


def cell(stubs: Stubs, rng: np.random.Generator) -> None:
    """Build a cell: two arms in random postures, one with a tool and a part, and a table with a note."""
    load(stubs, IIWA, "kuka", parent_t_node=pose(random_matrix(rng)))
    load(stubs, PANDA, "panda", parent_t_node=pose(random_matrix(rng)))
    label = nodes_pb2.Figure(label=nodes_pb2.Label(text="here"))
    apply(
        stubs,
        create(box("table", x=1.0)),
        create(tool("gun", "kuka.lbr_iiwa_link_7", random_matrix(rng, 0.1), tip=random_matrix(rng, 0.1))),
        select("kuka", "gun", "tip"),
        create(box("carried", z=0.5)),
        pick("kuka", "carried", 9.0),
        create(nodes_pb2.Node(name="note", annotation=nodes_pb2.Annotation(), figures=[label])),
    )
    for name in ("kuka", "panda"):
        put(stubs, name, drawn(stubs, name, rng))


@pytest.mark.long
def test_a_world_as_it_stands_is_one_gltf_file(stepped: Stubs, rng: np.random.Generator) -> None:
    cell(stepped, rng)
    with unchanged(stepped):
        answer = export(stepped)
    assert (
        answer.stamp.structure_revision == stepped.scene.GetScene(scene_pb2.GetSceneRequest()).stamp.structure_revision
    )
    (warning,) = answer.warnings
    assert "label" in warning and "'note'" in warning
    data = content(stepped, answer.files[0])
    poses, world = checked(data).poses(), scene(stepped)
    assert set(world) < set(poses)
    for name, world_t_node in world.items():
        assert np.abs(poses[name] - UP @ world_t_node).max() < 1e-6, name
    loaded = trimesh.load_scene(io.BytesIO(data), file_type="glb")
    assert len(loaded.graph.nodes_geometry) > 20
    del world["world"]  # what trimesh calls its own root
    for name, world_t_node in world.items():
        assert np.abs(loaded.graph.get(name)[0] - UP @ world_t_node).max() < 1e-6, name


def test_below_a_node_its_own_frame_counts(stepped: Stubs, rng: np.random.Generator) -> None:
    cell(stepped, rng)
    poses, world = glb_of(stepped, "kuka").poses(), scene(stepped)
    assert "carried" in poses and "table" not in poses
    for name in ("kuka.lbr_iiwa_link_7", "gun", "carried"):
        assert np.abs(poses[name] - UP @ np.linalg.inv(world["kuka"]) @ world[name]).max() < 1e-6


def test_hidden_nodes_are_left_out(stepped: Stubs) -> None:
    apply(stepped, create(box("seen")), create(box("unseen")), create(box("below", parent="unseen")))
    apply(stepped, update("unseen", "hidden", hidden=True))
    assert set(glb_of(stepped).poses()) == {"world", "seen", "seen figure 1"}


@pytest.mark.parametrize("model", [IIWA, PANDA, str(MODELS / "r2d2.urdf")])
def test_a_robot_comes_back_from_its_urdf(stepped: Stubs, model: str, rng: np.random.Generator) -> None:
    """The export's own files are what the import is given; nothing of them is on a disk."""
    load(stepped, model, "arm", parent_t_node=pose(random_matrix(rng)))
    positions = drawn(stepped, "arm", rng)
    put(stepped, "arm", positions)
    answer = export(stepped, "arm", ".urdf")
    assert not answer.warnings and answer.files[0].uri == "arm.urdf"
    assert all(file.uri.startswith("meshes/") for file in answer.files[1:])
    place = random_matrix(rng)
    load(stepped, "arm.urdf", "copy", files=answer.files, parent_t_node=pose(place))
    first, second = robot(stepped, "arm"), robot(stepped, "copy")
    assert second.joints == first.joints
    assert [link.removeprefix("copy.") for link in second.links] == [link.removeprefix("arm.") for link in first.links]
    put(stepped, "copy", positions)
    world = scene(stepped)
    arm_t_world, copy_t_world = np.linalg.inv(world["arm"]), np.linalg.inv(place)
    for link in first.links:
        again = copy_t_world @ world[f"copy.{link.removeprefix('arm.')}"]
        assert np.abs(again - arm_t_world @ world[link]).max() < 1e-9, link
    assert shapes(stepped, "copy") == shapes(stepped, "arm")


def shapes(stubs: Stubs, robot: str) -> list[tuple]:
    """Return all shapes of a robot's links, meshes by content, and the links' inertia."""
    found = []
    for node in stubs.scene.GetScene(scene_pb2.GetSceneRequest()).nodes:
        if node.name.startswith(f"{robot}."):
            for figure in node.figures:
                figure.mesh.ClearField("uri") if figure.HasField("mesh") else None
                figure.mesh.ClearField("files") if figure.HasField("mesh") else None
                place = matrix(figure.node_t_figure).round(9).tolist()
                figure.ClearField("node_t_figure")
                found.append((node.name.removeprefix(f"{robot}."), str(figure), place))
            found.append((node.link.inertial.mass_kilograms, str(node.link.inertial.diagonal)))
    return found


def test_refused_exports_say_what_would_be_right(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    apply(stepped, create(box("table")), create(nodes_pb2.Node(name="bare", annotation=nodes_pb2.Annotation())))
    with unchanged(stepped):
        unknown = refusal(lambda: export(stepped, "tabel"))
        assert (unknown.code, unknown.reason) == (grpc.StatusCode.NOT_FOUND, "UNKNOWN_NAME")
        assert unknown.metadata["nearest"] == "table"
        format = refusal(lambda: export(stepped, "table", ".step"))
        assert (format.code, format.metadata["valid"]) == (grpc.StatusCode.INVALID_ARGUMENT, ".glb, .urdf")
        link = refusal(lambda: export(stepped, "arm.lbr_iiwa_link_3", ".urdf"))
        assert link.metadata["nearest"] == "arm" and "its robot is 'arm'" in link.message
        assert "robots: 'arm'" in refusal(lambda: export(stepped, "table", ".urdf")).message
        assert "the world is none" in refusal(lambda: export(stepped, "", ".urdf")).message
        assert "nothing to be seen at or below 'bare'" in refusal(lambda: export(stepped, "bare")).message


@pytest.mark.long
def test_the_same_world_gives_the_same_bytes_in_another_kernel(
    stepped: Stubs, start_kernel: StartKernel, seed: int
) -> None:
    fresh = start_kernel("--stepped")
    stubs = fresh.stubs()
    told = []
    for one in (stepped, stubs):
        cell(one, np.random.default_rng(seed))
        files = [[(file.uri, file.sha256) for file in export(one, "kuka", kind).files] for kind in (".glb", ".urdf")]
        told.append([*files, export(one).files[0].sha256])
    assert told[0] == told[1]
    stubs.channel.close()
    assert fresh.end() == 0
