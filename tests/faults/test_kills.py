"""Random clients at a kernel with a folder, which is killed again and again, and whose components fail."""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import mkdtemp

import pytest
from google.protobuf.struct_pb2 import Struct
from hypothesis import strategies as st
from hypothesis.stateful import rule
from virtualrobot.v1 import history_pb2, lease_pb2, robot_pb2

from tests.faults.clients import Client, running
from tests.faults.machine import ARMS, WorldOfFaults, angles, numbers
from tests.faults.running import APART, run
from tests.kernels import KernelProcess, StartKernel, Stubs
from tests.plugins.install import environment, install

FAILING = ("crashes", "raises_at_work", "returns_nan", "wrong_shape")
GUARD = 120.0
WORLDS = 4
"""Number of worlds that are drawn together: the first one is always the simplest, of kills alone."""


class KilledWorld(WorldOfFaults):
    """World of faults whose kernel is killed: it comes back with all that was answered, and everything stands.

    Each has a folder of its own, so that what happens in a world comes from what was drawn for it.
    """

    started: Callable[[Path], KernelProcess]
    """Starts a kernel on a folder."""
    place: Path
    """Folder in which the worlds have theirs."""
    trigger: Path
    """File that makes components fail while it is there."""
    kills = worlds = 0

    def __init__(self) -> None:
        """Start a kernel and connect to it."""
        self.folder = Path(mkdtemp(prefix="cell-", dir=self.place))
        self.kernel = self.started(self.folder)
        self.connect = lambda: Stubs(self.kernel.channel(APART))
        super().__init__()

    @rule()
    def kill(self) -> None:
        """Kill the kernel and start it again."""
        before, stubs = self._look(), self.watcher.stubs
        moving = {motion.id for motion in running(stubs)}
        kept = self._checkpoints()
        os.kill(self.kernel.process.pid, signal.SIGKILL)
        self.kernel.process.wait(GUARD)
        KilledWorld.kills += 1
        self.kernel = self.started(self.folder)
        for client in (*self.clients, self.watcher):
            client.vanish()
        self.watcher, self.clients = Client(self.connect), [Client(self.connect) for _ in self.clients]
        after = self._look()
        assert after.scene.stamp.tick == before.scene.stamp.tick
        assert after.scene.stamp.epoch > before.scene.stamp.epoch
        assert after.edited() == before.edited()
        assert after.signals.signals == before.signals.signals
        assert [one.positions for one in after.robots.robots] == [one.positions for one in before.robots.robots]
        assert not any(speed for one in after.robots.robots for speed in one.velocities)
        assert not running(self.watcher.stubs), f"these ran before: {moving}"
        assert not self.watcher.stubs.lease.ListLeases(lease_pb2.ListLeasesRequest()).leases
        assert self._checkpoints() == kept
        self.seen = after  # snapshots are counted anew in each epoch
        self.kept = {name: (look, True) for name, (look, _) in self.kept.items()}  # motions that ended are told anew

    @rule(who=numbers, robot=st.sampled_from(ARMS), angle=angles, ticks=st.integers(1, 60))
    def kill_on_the_way(self, who: int, robot: str, angle: float, ticks: int) -> None:
        """Kill the kernel while an arm moves, unless that is leased or busy."""
        self.move(who, robot, 0, angle, dwell=False)
        self.step(ticks)
        self.kill()

    @rule(who=numbers, robot=st.sampled_from(ARMS), component=st.sampled_from((*FAILING, "chain")))
    def choose(self, who: int, robot: str, component: str) -> None:
        """Choose a component for an arm, which may fail later."""
        client, settings = self._client(who), Struct()
        if component != "chain":
            settings["trigger"] = str(self.trigger)
        choice = robot_pb2.KinematicsChoice(robot=robot, kinematics=component, settings=settings)
        request = robot_pb2.SetKinematicsRequest(choice=choice)
        self._leasing(client, {robot}, client.stubs.robot.SetKinematics, request)

    @rule(robot=st.sampled_from(ARMS), fails=st.booleans())
    def solve(self, robot: str, fails: bool) -> None:
        """Solve for where the arm is, while components fail or not: nothing changes."""
        before = self._look()
        if fails:
            self.trigger.touch()
        try:
            state = next((one for one in before.robots.robots if one.name == robot), None)
            pose = state.world_t_tcp if state else None
            self.watcher.ask(
                self.watcher.stubs.robot.SolveInverse,
                robot_pb2.SolveInverseRequest(robot=robot, reference_t_tcp=pose),
            )
        finally:
            self.trigger.unlink(missing_ok=True)
        assert self._look().content() == before.content(), "an answer or a fault of a component has changed the world"

    def teardown(self) -> None:
        """Undo all, end the kernel and verify what its folder has recorded."""
        failed = sys.exception() is not None
        try:
            super().teardown()
        finally:
            code = self.kernel.end(GUARD)
        if not failed:  # what fails first is told
            assert code == 0
            verify(self.folder)
            shutil.rmtree(self.folder)
        KilledWorld.worlds += 1

    def _checkpoints(self) -> list[history_pb2.Checkpoint]:
        return list(self.watcher.stubs.history.ListCheckpoints(history_pb2.ListCheckpointsRequest()).checkpoints)


@pytest.fixture
def killed(start_kernel: StartKernel, arm: Path, tmp_path: Path) -> type[KilledWorld]:
    """Return the machine of kernels with a folder and with components that fail."""
    site = environment(install(tmp_path / "site", *FAILING))

    def started(folder: Path) -> KernelProcess:
        return start_kernel("--stepped", "--data", str(folder), "--files", str(arm.parent), environment=site)

    fields = {"started": staticmethod(started), "place": tmp_path, "arm": arm, "trigger": tmp_path / "trigger"}
    return type("World", (KilledWorld,), fields)


def verify(folder: Path) -> None:
    """Fail unless the replay of a folder comes to the same joints in every tick."""
    command = [sys.executable, "-m", "virtualrobot", "replay", str(folder), "--verify"]
    told = subprocess.run(command, capture_output=True, text=True, timeout=20 * GUARD)
    assert told.returncode == 0, told.stdout + told.stderr


@pytest.mark.hunted
@pytest.mark.timeout(0)
def test_a_kernel_that_is_killed_has_lost_nothing(killed: type[KilledWorld], seed: int, hunt_seconds: float) -> None:
    until, rng = time.monotonic() + 0.8 * hunt_seconds, random.Random(seed)
    while time.monotonic() < until:
        run(killed, rng.randrange(2**32), worlds=WORLDS, steps=25, shrink=False)  # each try would start kernels
    print(f"{killed.kills} kills in {killed.worlds} worlds")
