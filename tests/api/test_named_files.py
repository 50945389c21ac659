"""Files that calls name on the kernel's disk: those below its folders and in known packages, and no others."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from virtualrobot.v1 import nodes_pb2, scene_pb2
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.serve import _folders, _parser

from tests.api.asking import apply, create, load, refusal
from tests.kernels import Stubs

TRIANGLE = """solid one
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 1 0
endloop
endfacet
endsolid one
"""
SCENE = "schema_version: 1\nnodes:\n- name: plate\n  object: {}\n  figures: [{mesh: {uri: plate.stl}}]\n"


@pytest.fixture
def outside() -> Iterator[Path]:
    """Return a folder that the kernel was not given."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "plate.stl").write_text(TRIANGLE)
        yield Path(folder)


def plate(file: Path) -> scene_pb2.Command:
    mesh = nodes_pb2.Figure(mesh=nodes_pb2.Mesh(uri=str(file)))
    return create(nodes_pb2.Node(name="plate", object=nodes_pb2.SceneObject(), figures=[mesh]))


def scene(file: Path) -> scene_pb2.LoadSceneRequest:
    """Return a scene that says to be a file of this name."""
    return scene_pb2.LoadSceneRequest(text=SCENE, uri=str(file))


def test_no_call_reads_a_file_elsewhere(stubs: Stubs, outside: Path, tmp_path: Path) -> None:
    (tmp_path / "link.stl").symlink_to(outside / "plate.stl")
    calls = {
        "model": lambda: load(stubs, str(outside / "plate.stl")),
        "link": lambda: load(stubs, str(tmp_path / "link.stl")),
        "mesh": lambda: apply(stubs, plate(outside / "plate.stl")),
        "scene": lambda: stubs.scene.LoadScene(scene(outside / "cell.yaml")),
    }
    for name, call in calls.items():
        refused = refusal(call)
        assert refused.reason == "MISSING_FILE", name
        assert ("--files FOLDER" in refused.message) == (name != "scene"), name
    assert [node.name for node in stubs.scene.GetScene(scene_pb2.GetSceneRequest()).nodes] == ["world"]


def test_each_of_them_reads_a_file_of_a_given_folder(stubs: Stubs, tmp_path: Path) -> None:
    (tmp_path / "plate.stl").write_text(TRIANGLE)
    load(stubs, str(tmp_path / "plate.stl"), "model")
    apply(stubs, plate(tmp_path / "plate.stl"))
    stubs.scene.LoadScene(scene(tmp_path / "cell.yaml"))


def test_the_folders_of_a_kernel(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "cell").mkdir()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path / "cell"))
    monkeypatch.setenv("USERPROFILE", str(tmp_path / "cell"))

    def folders(*options: str) -> tuple[Path, ...]:
        return _folders(_parser().parse_args(options))

    assert folders() == ()  # above the user's own folder
    assert folders("cell/cell.yaml") == (tmp_path / "cell",)
    assert folders("--files", ".", "--files", "cell", "cell/cell.yaml") == (tmp_path, tmp_path / "cell")
    monkeypatch.chdir(tmp_path / "cell")
    assert folders() == (tmp_path / "cell",)
    with pytest.raises(KernelError, match="--files names no folder: nope") as error:
        folders("--files", "nope")
    assert error.value.reason is Reason.MISSING_FILE
