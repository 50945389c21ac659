"""A craft in a folder: killed while it drives, it comes back where it was, drives on, and is undone and replayed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client
from virtualrobot.errors import WrongStateError

from tests.api.test_replay import replaying, told
from tests.kernels import StartKernel

pytestmark = pytest.mark.long

TWIST = (0.2, 0.0, 0.1)


def base(client: Client) -> np.ndarray:
    return client.scene.poses()["husky.base_footprint"]


def test_it_comes_back_and_is_replayed(start_kernel: StartKernel, tmp_path: Path) -> None:
    folder = str(tmp_path / "yard")
    seen: dict[int, np.ndarray] = {}
    kernel = start_kernel("--stepped", "--data", folder)
    with virtualrobot.connect(kernel.address) as client:
        husky = client.load_robot("model://husky", base="planar")
        with husky.stream_twist(timeout=1e6) as stream:
            stream.send(TWIST, wait=True)
            for _ in range(3):
                tick = client.clock.step(100).stamp.tick
                seen[tick] = base(client)
            kernel.process.kill()
            kernel.process.wait()
            stream.cancel()
    kernel = start_kernel("--stepped", "--data", folder)
    with virtualrobot.connect(kernel.address) as client:
        np.testing.assert_array_equal(base(client), seen[tick])
        with client.robot("husky").stream_twist(timeout=1e6) as stream:
            stream.send(TWIST, wait=True)
            client.clock.step(100)
            seen[400] = base(client)
            stream.cancel()
        client.clock.step(400)
        client.scene.remove_craft("husky")
        with pytest.raises(WrongStateError, match="is no craft"):
            client.robot("husky").stream_twist()
        client.history.undo()
        with client.robot("husky").stream_twist(timeout=1e6) as stream:
            stream.cancel()
        client.clock.step(10)
    assert kernel.end() == 0
    past = replaying(Path(folder))
    with virtualrobot.connect(past.address) as client:
        for tick in (200, 400, 100, 300):
            client.clock.seek(tick * 0.004)
            np.testing.assert_array_equal(base(client), seen[tick])
    past.end()
    code, text = told("replay", folder, "--verify")
    assert code == 0 and "ticks are the same" in text
