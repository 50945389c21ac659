"""Physics in the journal: a replay needs no engine and is the same bit for bit, as is a kernel that goes on."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client

from tests.api.test_replay import replaying, told
from tests.kernels import StartKernel

pytestmark = pytest.mark.long


def pose(client: Client, name: str) -> bytes:
    return np.asarray(client.scene.pose(name)).tobytes()


def test_a_replay_is_the_same_bit_for_bit(start_kernel: StartKernel, tmp_path: Path) -> None:
    folder = tmp_path / "cell"
    kernel = start_kernel("--stepped", "--data", str(folder), no_token=True)
    with virtualrobot.connect(kernel.address) as client:
        client.scene.add_object("floor", virtualrobot.box(4.0, 4.0, 0.1), pose=virtualrobot.pose(z=-0.05))
        client.physics.set("mujoco")
        for i in range(3):
            figure = virtualrobot.box(0.1, 0.1, 0.1)
            at = virtualrobot.pose(0.03 * i, 0.0, 0.2 + 0.15 * i)
            client.scene.add_part(f"box {i}", figure, pose=at, mass=1.0, dynamic=True)
        client.clock.step(60)
        client.scene.set_pose("box 1", virtualrobot.pose(0.5, 0.0, 0.3))
        client.clock.step(140)
        seen = [pose(client, f"box {i}") for i in range(3)]
    assert kernel.end() == 0
    assert told("replay", folder, "--verify") == (0, "200 ticks are the same\n")
    again = start_kernel("--stepped", "--data", str(folder), no_token=True)
    with virtualrobot.connect(again.address) as client:
        assert [pose(client, f"box {i}") for i in range(3)] == seen
        assert client.physics.status.engine == "mujoco"
        client.clock.step(250)
        assert client.scene.pose("box 0")[2, 3] == pytest.approx(0.05, abs=0.15)
        assert client.physics.status.fault == ""


@pytest.mark.parametrize("engine", ["mujoco", "bullet"])
def test_a_robot_with_motors_is_replayed_bit_for_bit(start_kernel: StartKernel, tmp_path: Path, engine: str) -> None:
    """A craft on wheels that drives, and its encoders, at moments that are sought back and forth."""
    folder = tmp_path / "yard"
    kernel = start_kernel("--stepped", "--data", str(folder), no_token=True)

    def seen_of(client: Client) -> bytes:
        state, encoders = client.robot("ugv").state, client.sensors["ugv.encoders"].read().value
        return b"".join(np.asarray(one).tobytes() for one in (state.positions, state.velocities, encoders.positions))

    seen: dict[int, bytes] = {}
    with virtualrobot.connect(kernel.address) as client:
        client.scene.add_object("yard", virtualrobot.box(8.0, 8.0, 0.1), pose=virtualrobot.pose(z=-0.05))
        ugv = client.load_robot("model://ugv", base="floating")
        client.physics.set(engine)
        client.physics.enable("ugv")
        with ugv.stream_twist(timeout=1e6) as stream:
            stream.send((0.3, 0.0, 0.4), wait=True)
            for _ in range(4):
                tick = client.clock.step(25).stamp.tick
                seen[tick] = seen_of(client)
            stream.cancel()
        gone = np.linalg.norm(client.scene.pose("ugv.base")[:2, 3])
        assert gone > 0.05
    assert kernel.end() == 0
    assert told("replay", folder, "--verify") == (0, "100 ticks are the same\n")
    past = replaying(folder)
    with virtualrobot.connect(past.address) as client:
        for tick in (75, 25, 100, 50):
            client.clock.seek(tick * 0.004)
            assert seen_of(client) == seen[tick], tick
    past.end()
