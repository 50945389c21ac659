"""Fixtures of pytest for programs that command robots: a kernel for the whole run, an empty world for each test.

pytest finds them by itself where VirtualRobot is installed. Time is stepped: it goes on only as the test lets it, so
that a run is the same each time and takes no longer than it computes.

Example:
    >>> def test_it_reaches_its_goal(virtualrobot_client):
    ...     arm = virtualrobot_client.load_robot("package://pybullet_data/kuka_iiwa/model.urdf", name="arm")
    ...     virtualrobot_client.clock.run(arm.move_joints([0.5] * 7, wait=False))
    ...     assert arm.positions.tolist() == [0.5] * 7
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from virtualrobot import Client
    from virtualrobot.kernel_process import KernelProcess


@pytest.fixture(scope="session")
def virtualrobot_kernel() -> Iterator[KernelProcess]:
    """Return a kernel without viewer, a process of its own that ends with the run; its address is `.address`."""
    from virtualrobot.kernel_process import KernelProcess

    with KernelProcess(headless=True) as kernel:
        yield kernel


@pytest.fixture
def virtualrobot_client(virtualrobot_kernel: KernelProcess) -> Iterator[Client]:
    """Return a client of a world without nodes, signals and leases, whose time is stepped; one after the other."""
    import virtualrobot

    with virtualrobot.connect(virtualrobot_kernel.address) as client:
        for lease in client.leases():
            client.lease(*lease.robots, take=True).release()
        client.clock.set_stepped()
        client.scene.clear()
        yield client
