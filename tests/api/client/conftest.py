"""A client of a real kernel, with an empty world for each test."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pybullet_data
import pytest
import virtualrobot
from virtualrobot.v1 import scene_pb2

from tests.api.conftest import EMPTY_SCENE, KernelProcess, StartKernel

IIWA = "package://pybullet_data/kuka_iiwa/model.urdf"
PANDA = "package://pybullet_data/franka_panda/panda.urdf"
MODELS = Path(pybullet_data.getDataPath())


@pytest.fixture(scope="package")
def client_kernel(start_kernel: StartKernel) -> Iterator[KernelProcess]:
    """Return one kernel, with a token, for all tests of the client."""
    process = start_kernel(token=True)
    yield process
    process.end()


@pytest.fixture
def client(client_kernel: KernelProcess) -> Iterator[virtualrobot.Client]:
    """Return a client of a kernel with an empty world whose time follows the wall clock."""
    with virtualrobot.connect(client_kernel.address, client_kernel.token) as client:
        client.stop()
        client.services.scene.LoadScene(scene_pb2.LoadSceneRequest(text=EMPTY_SCENE))
        client.speed_factor = 1.0
        client.clock.set_realtime()
        yield client


@pytest.fixture
def iiwa(client: virtualrobot.Client) -> virtualrobot.Robot:
    """Return an arm with seven joints."""
    return client.load_robot(IIWA, name="iiwa")
