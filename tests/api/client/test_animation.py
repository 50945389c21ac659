"""Animated scenes of a real kernel: places against the kernel's own, by the library's parser and by trimesh."""

from __future__ import annotations

import base64
import json
import re
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
import virtualrobot
from numpy.typing import NDArray
from virtualrobot import Client
from virtualrobot.recording import run_page

from tests.api.client.conftest import IIWA, Run
from tests.kernels import KernelProcess, StartKernel, Stubs
from tests.khronos import NEEDS_VALIDATOR, issues_of

Floats = NDArray[np.float64]
GOAL = [0.6, 0.5, 0.0, -1.2, 0.0, 0.8, 0.0]


@pytest.fixture
def cell(stepped_kernel: KernelProcess, stepped: Stubs) -> Iterator[Client]:
    """Return a client of a kernel in STEPPED mode with an arm and a table."""
    with virtualrobot.connect(stepped_kernel.address) as client:
        client.load_robot(IIWA, name="arm", pose=virtualrobot.pose(z=0.1))
        client.scene.add_object("table", virtualrobot.box(1.0, 1.0, 0.1, color="#336699"))
        yield client


class Played:
    """An animated scene as a player would have it: a small reader of our own, after glTF 2.0, appendix C."""

    def __init__(self, data: bytes) -> None:
        """Read a GLB file."""
        assert data[:4] == b"glTF"
        length = struct.unpack_from("<I", data, 12)[0]
        self.tree: dict[str, Any] = json.loads(data[20 : 20 + length])
        self._buffer = data[28 + length :]
        self.names = [node.get("name", "") for node in self.tree["nodes"]]

    def values(self, accessor: int) -> Floats:
        """Return the rows of an accessor."""
        about = self.tree["accessors"][accessor]
        view = self.tree["bufferViews"][about["bufferView"]]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[about["type"]]
        flat = np.frombuffer(self._buffer, np.float32, about["count"] * width, view["byteOffset"])
        return flat.reshape(-1, width).astype(float)

    def channel(self, node: int, path: str) -> tuple[Floats, Floats, str] | None:
        """Return times, values and law of what moves a node."""
        animation = self.tree["animations"][0]
        for one in animation["channels"]:
            if one["target"] == {"node": node, "path": path}:
                sampler = animation["samplers"][one["sampler"]]
                return self.values(sampler["input"])[:, 0], self.values(sampler["output"]), sampler["interpolation"]
        return None

    def places(self, name: str) -> list[int]:
        """Return the places of the nodes of a name."""
        return [place for place, one in enumerate(self.names) if one == name]

    def pose(self, name: str, seconds: float) -> Floats:
        """Return `world_t_node` of the one node of a name at a time; linear between keys, which these tests hit."""
        (place,) = self.places(name)
        node = self.tree["nodes"][place]
        found = []
        for path in ("translation", "rotation"):
            channel = self.channel(place, path)
            if channel is None:
                found.append(np.array(node[path]))
            else:
                times, values, _ = channel
                found.append(np.array([np.interp(seconds, times, column) for column in values.T]))
        return virtualrobot.pose_from_quaternion(found[0], found[1] / np.linalg.norm(found[1]))

    def is_shown(self, place: int, seconds: float) -> bool:
        """Return whether a node is there at a time: its size is not 0."""
        channel = self.channel(place, "scale")
        if channel is None:
            return True
        times, values, law = channel
        assert law == "STEP"
        return bool(values[max(np.searchsorted(times, seconds, side="right") - 1, 0), 0] == 1.0)


def test_places_are_the_kernel_s(cell: Client, tmp_path: Path) -> None:
    """At ends and in the middle of a move, each node that is drawn; single precision has 24 bits."""
    moments: list[tuple[float, dict[str, Floats]]] = []
    recording = cell.start_recording(tmp_path / "run.glb", rate=250.0)
    begin = cell.clock.simulation_time
    motion = cell.robots["arm"].move_joints(GOAL, wait=False)
    while not motion.phase.ended:
        moments.append((cell.clock.simulation_time - begin, cell.scene.poses()))
        recording.step(40)
    moments.append((cell.clock.simulation_time - begin, cell.scene.poses()))
    recorded = recording.finish()
    played = Played((tmp_path / "run.glb").read_bytes())
    drawn = [name for name in moments[0][1] if played.places(name) and name != "world"]
    assert "table" in drawn and sum(name.startswith("arm") for name in drawn) >= 8
    for seconds, poses in moments:
        for name in drawn:
            np.testing.assert_allclose(played.pose(name, seconds), poses[name], atol=2e-6, err_msg=f"{name} {seconds}")
    assert recorded.counts["nodes"] == len(drawn)
    assert played.tree["scenes"][0]["extras"]["duration"] == pytest.approx(moments[-1][0], abs=1e-6)
    (table,) = played.places("table")
    assert played.channel(table, "translation") is None, "what stands still has no keys"


def test_another_reader_sees_the_scene(cell: Client, tmp_path: Path) -> None:
    """Trimesh draws the begin: its places, after the turn from z upwards to y upwards, and its corners."""
    poses = cell.scene.poses()
    with cell.start_recording(tmp_path / "run.glb") as recording:
        recording.step(10)
    scene = trimesh.load(tmp_path / "run.glb", file_type="glb")
    assert isinstance(scene, trimesh.Scene)
    y_up = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]], float)
    np.testing.assert_allclose(scene.graph.get("table")[0], y_up @ poses["table"], atol=1e-6)
    low, high = scene.bounds
    assert high[1] > 1.3, "the arm stands upright"
    np.testing.assert_allclose([low[0], high[0], low[1]], [-0.5, 0.5, -0.05], atol=1e-6)


def test_what_comes_goes_and_changes_is_there_as_long_as_it_was(cell: Client, tmp_path: Path) -> None:
    scene = cell.scene
    recording = cell.start_recording(tmp_path / "run.glb", rate=250.0)
    tick = cell.clock.read().tick_length

    def at(ticks: int) -> float:
        return ticks * tick + 0.5 * tick

    recording.step(10)
    part = scene.add_part("part", virtualrobot.box(0.1, 0.1, 0.1), pose=virtualrobot.pose(y=0.7))
    recording.step(10)
    scene.set_figures("table", [virtualrobot.box(1.0, 1.0, 0.2, color="red")])
    recording.step(10)
    part.hide()
    recording.step(10)
    part.hide(False)
    recording.step(10)
    part.remove()
    recording.step(10)
    recording.finish()
    played = Played((tmp_path / "run.glb").read_bytes())

    def shown(name: str, ticks: int) -> int:
        return sum(played.is_shown(place, at(ticks)) for place in played.places(name))

    assert [shown("part", ticks) for ticks in (5, 15, 25, 35, 45, 55)] == [0, 1, 1, 0, 1, 0]
    assert len(played.places("table")) == 2
    assert [shown("table", ticks) for ticks in (5, 15, 25, 55)] == [1, 1, 1, 1]
    first, second = played.places("table")
    assert played.is_shown(first, at(5)) and played.is_shown(second, at(25))


@pytest.mark.long
@NEEDS_VALIDATOR
def test_files_are_valid(cell: Client, tmp_path: Path) -> None:
    """By the Khronos Group's own validator."""
    recording = cell.start_recording(tmp_path / "run.glb")
    motion = cell.robots["arm"].move_joints(GOAL, wait=False)
    recording.step(50)
    cell.scene.add_part("part", virtualrobot.sphere(0.1, color="green"))
    recording.step(50)
    motion.cancel()
    recording.finish()
    issues = issues_of(tmp_path / "run.glb")
    assert (issues["numErrors"], issues["numWarnings"]) == (0, 0), issues["messages"][:5]


def test_an_empty_world_is_a_file(stepped_kernel: KernelProcess, stepped: Stubs, tmp_path: Path) -> None:
    with virtualrobot.connect(stepped_kernel.address) as client:
        with client.start_recording(tmp_path / "run.glb") as recording:
            recording.step(3)
    played = Played((tmp_path / "run.glb").read_bytes())
    assert played.names == ["world"] and "animations" not in played.tree


def test_a_page_holds_the_run_and_its_player(cell: Client, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The player stands in for a built one, with what ends a script too early."""
    monkeypatch.setattr("virtualrobot.recording.start.player", lambda: "const end = '</script>';")
    for ending in ("glb", "html"):
        with cell.start_recording(tmp_path / f"run.{ending}") as recording:
            recording.step(5)
    page = (tmp_path / "run.html").read_text()
    assert len(re.findall("</script>", page)) == 2
    (run,) = re.findall(r'id="run">([^<]*)<', page)
    inside = Played(base64.b64decode(run))
    assert inside.names == Played((tmp_path / "run.glb").read_bytes()).names
    assert "http" not in page.replace("http-equiv", ""), "nothing is loaded from elsewhere"


def test_what_is_asked_wrongly_is_refused_before_a_file_is_there(
    cell: Client, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(virtualrobot.InvalidArgumentError, match=r"\.glb has the scene and how it moves, and no topics"):
        cell.start_recording(tmp_path / "run.glb", topics=["/robots/*"])
    monkeypatch.setattr(run_page, "PLAYER", "player/nowhere.js")
    with pytest.raises(virtualrobot.WrongStateError, match="make console"):
        cell.start_recording(tmp_path / "run.html")
    assert not list(tmp_path.iterdir())


@pytest.mark.long
def test_a_run_that_is_over_is_exported(start_kernel: StartKernel, tmp_path: Path, run: Run) -> None:
    folder = tmp_path / "cell"
    own = start_kernel("--stepped", "--data", str(folder))
    with virtualrobot.connect(own.address) as client:
        part = client.scene.add_part("part", virtualrobot.box(0.1, 0.1, 0.1))
        client.clock.step(20)
        part.parent_t_node = virtualrobot.pose(x=0.5)
        client.clock.step(20)
    own.end()
    assert "places" in run("export", str(folder), str(tmp_path / "run.glb"))
    played = Played((tmp_path / "run.glb").read_bytes())
    (place,) = played.places("part")
    channel = played.channel(place, "translation")
    assert channel is not None
    np.testing.assert_allclose(channel[1][[0, -1], 0], [0.0, 0.5], atol=1e-7)
    assert np.all(np.diff(channel[0]) > 0.0)
