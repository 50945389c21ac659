"""A kernel that replays what another one has written before it was killed: looked at, verified, and reported."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, InvalidArgumentError, WrongStateError
from virtualrobot.v1 import kernel_pb2
from virtualrobot_kernel.history.folder import read_project
from virtualrobot_kernel.history.store import Store

from tests.api.asking import IIWA
from tests.kernels import KernelProcess, StartKernel

pytestmark = pytest.mark.long

PAGE = Path(__file__).parents[2] / "docs" / "history.md"
SEEN = (0, 100, 150, 260, 400)
GOAL = (0.5, -0.5, 0.5, 0.1, 0.2, 0.3, 0.4)


@dataclass
class Past:
    """Past of a kernel: what it was seen to do, the folder that it has left, and the token that it wanted."""

    folder: Path
    token: str
    joints: dict[int, np.ndarray] = field(default_factory=dict)


@pytest.fixture(scope="module")
def past(start_kernel: StartKernel, tmp_path_factory: pytest.TempPathFactory) -> Past:
    """Return what a kernel did in 400 ticks, after which it was killed; the box was moved before."""
    folder = tmp_path_factory.mktemp("past") / "cell"
    kernel = start_kernel("--stepped", "--data", str(folder), token=True)
    seen = Past(folder, kernel.token)
    with virtualrobot.connect(kernel.address, token=kernel.token) as client:
        arm = client.load_robot(IIWA, name="arm")
        client.scene.add_object("crate", virtualrobot.box(0.2, 0.2, 0.2), pose=virtualrobot.pose(1.0, 0.0, 0.1))
        client.scene.add_range_sensor("lidar", virtualrobot.range_sensor(running=True), parent="crate")
        arm.move_joints(GOAL, wait=False)
        last = 0
        for tick in SEEN:
            if tick > last:
                client.clock.step(tick - last)
            last = tick
            seen.joints[tick] = np.array(arm.positions)
        client.scene.set_pose("crate", virtualrobot.pose(1.0, 0.5, 0.1))
    # Hashes of ticks are written once a second, and what it ends with as it ends.
    assert kernel.end() == 0
    return seen


@pytest.fixture(scope="module")
def replay(past: Past) -> Iterator[Client]:
    """Return a client of a kernel that replays it."""
    kernel = replaying(past.folder)
    with virtualrobot.connect(kernel.address) as client:
        yield client
    kernel.end()


def replaying(folder: Path) -> KernelProcess:
    """Return a kernel that replays a folder."""
    command = [sys.executable, "-m", "virtualrobot", "replay", str(folder), "--port", "0", "--headless", "--no-token"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    kernel = KernelProcess(process, kernel_pb2.CLOCK_MODE_STEPPED)
    threading.Thread(target=kernel.read, daemon=True).start()
    return kernel.await_start()


def told(*arguments: object) -> tuple[int, str]:
    """Return exit code and output of a command."""
    command = [sys.executable, "-m", "virtualrobot", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    return done.returncode, done.stdout + done.stderr


def test_it_is_at_each_moment_what_was(replay: Client, past: Past) -> None:
    """By seeking, back and forth, and by steps."""
    assert replay.clock.read().recorded == (0.0, 1.6)
    for tick in (260, 100, 400, 0, 150):
        state = replay.clock.seek(tick * 0.004)
        assert (state.stamp.tick, state.mode) == (tick, "stepped")
        np.testing.assert_array_equal(replay.robots["arm"].positions, past.joints[tick])
    seen = replay.clock.step(110)
    assert seen.stamp.tick == 260
    np.testing.assert_array_equal(replay.robots["arm"].positions, past.joints[260])
    replay.clock.seek(399 * 0.004)
    assert replay.scene.pose("crate")[1, 3] == 0.0
    replay.clock.step(1)
    assert replay.scene.pose("crate")[1, 3] == 0.5
    with pytest.raises(WrongStateError, match=r"the record ends 0 ticks from here, at 1\.6 s"):
        replay.clock.step(1)
    with pytest.raises(InvalidArgumentError, match=r"the record goes from 0 s to 1\.6 s, not to 2 s"):
        replay.clock.seek(2.0)


def test_its_sensors_are_cast_anew_and_pictures_taken(replay: Client) -> None:
    replay.clock.seek(0.4)
    reading = replay.sensors["lidar"].read()
    assert reading.range.distances.size
    assert replay.view.capture(size=(160, 120), format="raw").pixels.shape[:2] == (120, 160)
    before = replay.clock.read().stamp.tick
    code, text = told("clock", "--at", "0.6", "--address", replay.address)
    assert (code, text) == (0, "stepped: time goes on by steps; 0.600 s of 0.000 to 1.600 s, tick 150\n")
    assert before == 100


def test_the_page_shows_a_replay(replay: Client, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The page docs/history.md is run on it, within the times of this one and slowly enough not to reach its end."""
    code = (
        PAGE.read_text("utf-8").partition("<!-- not run: it needs a folder")[2].split("```")[1].removeprefix("python")
    )
    for said, here in (("seek(12.5)", "seek(0.4)"), ("set_realtime(2.0)", "set_realtime(0.01)"), ("250", "50")):
        assert said in code
        code = code.replace(said, here)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(virtualrobot, "connect", lambda: replay)
    names: dict[str, object] = {"virtualrobot": virtualrobot}
    exec(code, names)
    assert (names["first"], names["last"]) == (0.0, 1.6)
    assert (tmp_path / "then.png").read_bytes().startswith(b"\x89PNG")


def test_nothing_changes_it(replay: Client) -> None:
    replay.clock.seek(0.4)
    for change in (
        lambda: replay.scene.add_object("box", virtualrobot.box(0.1, 0.1, 0.1)),
        lambda: replay.scene.set_pose("crate", virtualrobot.pose(2.0)),
        lambda: replay.robots["arm"].stop(),
        lambda: replay.history.checkpoint("then"),
        lambda: replay.robots["arm"].move_joints(GOAL),
    ):
        with pytest.raises(WrongStateError, match="this is a replay, and what was can only be looked at"):
            change()


def test_a_kernel_that_runs_goes_forwards_only(kernel: KernelProcess) -> None:
    with (
        virtualrobot.connect(kernel.address) as client,
        pytest.raises(WrongStateError, match="time of a world that runs goes forwards only"),
    ):
        client.clock.seek(0.0)


def test_what_was_is_verified_and_a_difference_named(past: Past, tmp_path: Path) -> None:
    assert told("replay", past.folder, "--verify") == (0, "400 ticks are the same\n")
    project = read_project(past.folder)
    store = Store(past.folder / "journal.db", project.seed)
    # They are written once a second, in as many rows as seconds went by.
    first, hashes = next((first, hashes) for first, hashes in store.hashes() if first + len(hashes) // 8 > 200)
    planted = bytearray(hashes)
    planted[(200 - first) * 8] ^= 1
    planted[(200 - first) * 8 + 4] ^= 1
    store.add_hashes(first, bytes(planted))
    store.close()
    code, text = told("replay", past.folder, "--verify")
    assert code == 1 and text.startswith("tick 200 differs, by 'arm', after entry ")
    store = Store(past.folder / "journal.db", project.seed)
    store.add_hashes(first, hashes)
    store.close()
    for folder, why in ((tmp_path, "is no project folder, it has no project.json"), (tmp_path / "no", "is no project")):
        code, text = told("replay", folder, "--verify")
        assert code == 1 and why in text and "Traceback" not in text


def test_a_report_has_what_is_needed_and_no_token(past: Past, start_kernel: StartKernel, tmp_path: Path) -> None:
    """Of a folder and of a kernel with a token that runs; unpacked both are verified."""
    kernel = start_kernel("--stepped", token=True)
    archives = [tmp_path / "folder.zip", tmp_path / "kernel.zip"]
    assert told("report", archives[0], "--data", past.folder)[0] == 0
    with virtualrobot.connect(kernel.address, token=kernel.token) as client:
        client.load_robot(IIWA, name="arm").move_joints(GOAL, wait=False)
        client.clock.step(150)
        client.report(archives[1])
    kernel.end()
    for number, archive in enumerate(archives):
        unpacked = tmp_path / f"unpacked{number}"
        with zipfile.ZipFile(archive) as file:
            assert {"project.json", "journal.db", "scene.yaml", "kernel.log", "report.json"} <= set(file.namelist())
            file.extractall(unpacked)
        assert "name: arm" in (unpacked / "scene.yaml").read_text()
        assert number or "a kernel begins" in (unpacked / "kernel.log").read_text()  # long after it has ended
        about = json.loads((unpacked / "report.json").read_text())
        assert about["versions"]["virtualrobot"] and about["first_entry"] == 1
        for place in (file for file in unpacked.rglob("*") if file.is_file()):
            content = place.read_bytes()
            assert past.token.encode() not in content and kernel.token.encode() not in content, place
        code, text = told("replay", unpacked, "--verify")
        assert code == 0 and "ticks are the same" in text, text
    meshes = set(os.listdir(tmp_path / "unpacked0" / "assets"))
    assert meshes and meshes < set(os.listdir(past.folder / "assets"))  # all but the model's own file
