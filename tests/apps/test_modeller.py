"""`virtualrobot model`: a node of a running cell gets the shape that a text describes, again and again."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh
import virtualrobot
from virtualrobot import Client
from virtualrobot_apps.modeller import modelling

from tests.kernels import KernelProcess
from tests.waiting import until

BRACKET = """\
solid:
  difference:
  - extrude: {profile: {rectangle: {size: [0.1, 0.06], corner: 0.01}}, height: 0.01}
  - row: {solid: {cylinder: {radius: 0.004, length: 0.05}}, count: 3, step: [0.02, 0, 0]}
"""
LONGER = BRACKET.replace("[0.1, 0.06]", "[0.2, 0.06]")

Model = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture
def bracket(tmp_path: Path) -> Path:
    """Return a file that describes a plate with three holes."""
    file = tmp_path / "bracket.solid"
    file.write_text(BRACKET)
    return file


@pytest.fixture
def model(kernel: KernelProcess) -> Model:
    """Return a function that runs the command."""

    def run(*arguments: object) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "virtualrobot", "model", *map(str, arguments)]
        environment = {**os.environ, "VIRTUALROBOT_ADDRESS": kernel.address}
        return subprocess.run(command, capture_output=True, text=True, env=environment, timeout=300)

    return run


def width(client: Client, name: str, folder: Path) -> float:
    """Return how wide a node is along x (m), as its export tells another reader."""
    file = folder / "width.glb"
    client.scene.export(name, file)
    return float(np.ptp(trimesh.load(file, file_type="glb", force="mesh").bounds[:, 0]))  # pyright: ignore


@pytest.mark.long
def test_a_node_is_modelled_and_changed_in_its_place(
    client: Client, bracket: Path, model: Model, tmp_path: Path
) -> None:
    made = model("bracket", bracket, "--part", "--at", "0.5,0,0.2")
    assert made.returncode == 0 and made.stdout.startswith("bracket: ") and "triangles" in made.stdout, made.stderr
    node = client.scene["bracket"]
    assert node.kind == "part" and node.pose[:3, 3].tolist() == [0.5, 0.0, 0.2]
    assert width(client, "bracket", tmp_path) == pytest.approx(0.1, abs=1e-6)
    assert model("bracket").stdout == BRACKET
    bracket.write_text(LONGER)
    assert model("bracket", bracket).returncode == 0
    assert client.scene["bracket"].uid == node.uid and node.pose[:3, 3].tolist() == [0.5, 0.0, 0.2]
    assert width(client, "bracket", tmp_path) == pytest.approx(0.2, abs=1e-6)
    client.undo()
    assert width(client, "bracket", tmp_path) == pytest.approx(0.1, abs=1e-6)


def test_a_scene_keeps_the_description(client: Client, bracket: Path, tmp_path: Path) -> None:
    modelling.shaped(client, "bracket", bracket, pose=virtualrobot.pose(x=1.0))
    client.scene.save(tmp_path / "cell.yaml", bundle=True)
    client.scene.clear()
    client.scene.load_scene(tmp_path / "cell.yaml")
    assert modelling.described(client, "bracket").decode() == BRACKET
    found = client.collisions.distance(
        "bracket", to=[client.scene.add_object("wall", virtualrobot.box(0.1, 1, 1)).name]
    )
    assert found is not None and found.distance == pytest.approx(1.0 - 0.05 - 0.05, abs=1e-4)


def test_what_makes_no_body_changes_nothing(client: Client, bracket: Path) -> None:
    modelling.shaped(client, "bracket", bracket)
    before = client.scene["bracket"].info
    bracket.write_text(BRACKET.replace("0.004", "-0.004"))
    with pytest.raises(
        virtualrobot.MalformedFileError, match=r"bracket\.solid: solid\.difference\[1\]\.row\.solid\.cylinder\.radius"
    ):
        modelling.shaped(client, "bracket", bracket)
    bracket.write_text("solid: {bocks: 1}")
    with pytest.raises(virtualrobot.MalformedFileError, match="'bocks' is no word for a body"):
        modelling.shaped(client, "other", bracket)
    assert client.scene["bracket"].info.figures[0] == before.figures[0] and "other" not in client.scene


def test_nodes_of_other_shapes_have_no_description(client: Client) -> None:
    client.scene.add_object("box", virtualrobot.box(1, 1, 1))
    with pytest.raises(virtualrobot.WrongStateError, match="the shape of 'box' comes of no file"):
        modelling.described(client, "box")
    with pytest.raises(virtualrobot.UnknownNameError, match="nothing"):
        modelling.described(client, "nothing")


@pytest.mark.long
def test_wrong_usage_is_a_line(client: Client, model: Model, tmp_path: Path) -> None:
    (tmp_path / "mesh.stl").write_text("solid x")
    for arguments, said in (
        (("bracket", tmp_path / "mesh.stl"), "its name ends with .solid"),
        (("bracket", "--watch"), "are for a FILE"),
    ):
        run = model(*arguments)
        assert run.returncode == 2 and said in run.stderr and len(run.stderr.strip().splitlines()) == 1


@pytest.mark.long
def test_a_watched_file_shapes_its_node_when_it_is_saved(
    client: Client, kernel: KernelProcess, bracket: Path, tmp_path: Path
) -> None:
    command = [sys.executable, "-m", "virtualrobot", "model", "bracket", str(bracket), "--watch"]
    environment = {**os.environ, "VIRTUALROBOT_ADDRESS": kernel.address}
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
    ) as program:
        try:
            assert program.stdout is not None and program.stderr is not None
            assert program.stdout.readline().startswith("bracket: ")
            bracket.write_text("solid: {box: {size: [1]}}")
            assert "solid.box.size: expected `array` of length 3" in program.stderr.readline()
            bracket.write_text(LONGER)
            until(lambda: width(client, "bracket", tmp_path) > 0.19)
            program.send_signal(signal.SIGINT)
            program.wait(60)
        finally:
            program.kill()
