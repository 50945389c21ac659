"""Real kernels for tests: server processes on free ports, reached over TCP."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import grpc
import pytest
import virtualrobot
from virtualrobot import kernel_process
from virtualrobot.v1 import (
    asset_pb2_grpc,
    collision_pb2_grpc,
    driver_pb2,
    driver_pb2_grpc,
    history_pb2,
    history_pb2_grpc,
    kernel_pb2,
    kernel_pb2_grpc,
    lease_pb2,
    lease_pb2_grpc,
    motion_pb2_grpc,
    path_pb2_grpc,
    physics_pb2_grpc,
    proposal_pb2,
    proposal_pb2_grpc,
    ray_pb2_grpc,
    record_pb2_grpc,
    robot_pb2_grpc,
    scene_pb2,
    scene_pb2_grpc,
    sensor_pb2_grpc,
    signal_pb2_grpc,
    token_pb2_grpc,
    view_pb2_grpc,
)

from tests.forked import FORKS, Forked

START_SECONDS = 900
"""A guard against a kernel that never answers; the very first start compiles for about a minute of a core."""

EMPTY_SCENE = "schema_version: 1\n"


def pytest_configure() -> None:
    """Let kernels that clients start in this process be forked, too."""
    if FORKS:
        pytest.MonkeyPatch().setattr(kernel_process, "start_child", _forked_child)


def _forked_child(*arguments: str) -> Forked:
    return Forked(*arguments, child=True)


class Stubs:
    """One stub for each service of the contract, on one channel."""

    def __init__(self, channel: grpc.Channel) -> None:
        """Make the stubs."""
        self.channel = channel
        self.kernel = kernel_pb2_grpc.KernelServiceStub(channel)
        self.asset = asset_pb2_grpc.AssetServiceStub(channel)
        self.scene = scene_pb2_grpc.SceneServiceStub(channel)
        self.robot = robot_pb2_grpc.RobotServiceStub(channel)
        self.motion = motion_pb2_grpc.MotionServiceStub(channel)
        self.signal = signal_pb2_grpc.SignalServiceStub(channel)
        self.lease = lease_pb2_grpc.LeaseServiceStub(channel)
        self.view = view_pb2_grpc.ViewServiceStub(channel)
        self.sensor = sensor_pb2_grpc.SensorServiceStub(channel)
        self.collision = collision_pb2_grpc.CollisionServiceStub(channel)
        self.driver = driver_pb2_grpc.DriverServiceStub(channel)
        self.physics = physics_pb2_grpc.PhysicsServiceStub(channel)
        self.ray = ray_pb2_grpc.RayServiceStub(channel)
        self.history = history_pb2_grpc.HistoryServiceStub(channel)
        self.token = token_pb2_grpc.TokenServiceStub(channel)
        self.record = record_pb2_grpc.RecordServiceStub(channel)
        self.proposal = proposal_pb2_grpc.ProposalServiceStub(channel)
        self.path = path_pb2_grpc.PathServiceStub(channel)


@dataclass
class KernelProcess:
    """A kernel in a process of its own; `lines` are what it has printed."""

    process: subprocess.Popen[str] | Forked
    mode: kernel_pb2.ClockMode
    """Mode of its clock when nobody changes that."""
    lines: list[str] = field(default_factory=list)
    address: str = ""
    token: str = ""
    token_file: Path | None = None
    ready: threading.Event = field(default_factory=threading.Event)
    """Set when it listens, or has ended."""

    def read(self) -> None:
        """Read what it prints until it ends."""
        assert self.process.stdout
        for line in self.process.stdout:
            self.lines.append(line.rstrip())
            if line.startswith("listening on "):
                self.address = line.removeprefix("listening on ").strip()
                self.ready.set()
        self.ready.set()

    def await_start(self) -> KernelProcess:
        """Return this kernel once it can be reached."""
        assert self.ready.wait(START_SECONDS), f"the kernel did not start: {self.lines}"
        assert self.address, f"the kernel ended at once: {self.lines}"
        if self.token_file is not None:
            self.token = self.token_file.read_text()
        return self

    def channel(self, options: Sequence[tuple[str, int]] = ()) -> grpc.Channel:
        """Return a new channel that sends the token, if the kernel wants one."""
        channel = grpc.insecure_channel(self.address, options)
        if not self.token:
            return channel
        # The types ask for a class where a function will do.
        credentials = grpc.metadata_call_credentials(
            lambda _, callback: callback((("authorization", f"Bearer {self.token}"),), None)  # pyright: ignore
        )
        secure = grpc.composite_channel_credentials(grpc.local_channel_credentials(), credentials)
        return grpc.secure_channel(self.address, secure)

    def stubs(self) -> Stubs:
        """Return stubs on a new channel."""
        return Stubs(self.channel())

    def end(self, seconds: float = 120.0) -> int:
        """Ask the kernel to end and return its exit code."""
        self.process.terminate()  # does nothing where it has ended
        return self.await_end(seconds)

    def await_end(self, seconds: float = 120.0) -> int:
        """Return the exit code of a kernel that has been asked to end once: a second signal would end it at once."""
        try:
            return self.process.wait(seconds)
        finally:
            if self.process.poll() is None:
                self.process.kill()
            if self.process.stdout:
                self.process.stdout.close()


StartKernel = Callable[..., KernelProcess]


@contextmanager
def kernels(folders: pytest.TempPathFactory) -> Iterator[StartKernel]:
    """Give a function that starts a kernel with the given options and waits until it can be reached; end all of them.

    With `token` the kernel writes one that the stubs use; with neither, `no_token=False` leaves it to the options.
    """
    started: list[KernelProcess] = []

    def start(
        *options: str,
        token: bool = False,
        no_token: bool = True,
        environment: dict[str, str] | None = None,
    ) -> KernelProcess:
        command = ["--port", "0", "--headless", *options]
        if "--files" not in options:
            # This test run's own folder, and the clone's, whose models tests load.
            command += ["--files", str(folders.getbasetemp()), "--files", os.getcwd()]
        token_file: Path | None = None
        if token:
            token_file = folders.mktemp("token") / "token"
            command += ["--token-file", str(token_file)]
        elif no_token:
            command.append("--no-token")
        process: subprocess.Popen[str] | Forked
        if FORKS and not environment:
            process = Forked("serve", *command)
        else:
            process = subprocess.Popen(
                [sys.executable, "-m", "virtualrobot_kernel.serve", *command],
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                env={**os.environ, **(environment or {})},
            )
        mode = kernel_pb2.CLOCK_MODE_STEPPED if "--stepped" in options else kernel_pb2.CLOCK_MODE_REALTIME
        kernel = KernelProcess(process, mode, token_file=token_file)
        started.append(kernel)
        threading.Thread(target=kernel.read, daemon=True).start()
        return kernel.await_start()

    try:
        yield start
    finally:
        running = [kernel for kernel in started if kernel.process.poll() is None]
        for kernel in running:
            kernel.process.terminate()
        codes = {kernel.process.pid: kernel.await_end() for kernel in started}
        assert [codes[kernel.process.pid] for kernel in running] == [0] * len(running)


@pytest.fixture(scope="module")
def start_kernel(tmp_path_factory: pytest.TempPathFactory) -> Iterator[StartKernel]:
    """Return a function that starts a kernel with options of its own, which ends with the test file."""
    with kernels(tmp_path_factory) as start:
        yield start


@contextmanager
def emptied(process: KernelProcess) -> Iterator[Stubs]:
    """Give stubs to a kernel from which all is taken that clients have left."""
    stubs = process.stubs()
    for lease in stubs.lease.ListLeases(lease_pb2.ListLeasesRequest()).leases:
        taken = stubs.lease.TakeLease(lease_pb2.TakeLeaseRequest(robots=lease.robots))
        stubs.lease.ReleaseLease(lease_pb2.ReleaseLeaseRequest(token=taken.token))
    stubs.kernel.SetClock(kernel_pb2.SetClockRequest(mode=process.mode, speed_factor=1.0))
    # Nodes, signals, motions, speed factor, collision settings and the view.
    stubs.scene.LoadScene(scene_pb2.LoadSceneRequest(text=EMPTY_SCENE))
    stubs.driver.ReleaseCell(driver_pb2.ReleaseCellRequest())
    for proposal in stubs.proposal.ListProposals(proposal_pb2.ListProposalsRequest()).proposals:
        if proposal.state == proposal_pb2.PROPOSAL_STATE_PROPOSED:
            stubs.proposal.RejectProposal(proposal_pb2.RejectProposalRequest(id=proposal.id))
    for checkpoint in stubs.history.ListCheckpoints(history_pb2.ListCheckpointsRequest()).checkpoints:
        stubs.history.RemoveCheckpoint(history_pb2.RemoveCheckpointRequest(name=checkpoint.name))
    yield stubs
    stubs.channel.close()


def _set_clock(kernel: KernelProcess, mode: kernel_pb2.ClockMode) -> None:
    with kernel.channel() as channel:
        kernel_pb2_grpc.KernelServiceStub(channel).SetClock(kernel_pb2.SetClockRequest(mode=mode, speed_factor=1.0))


class SharedKernels:
    """Kernels for all files of a worker that need no options, one of a kind: a start takes two seconds of a core."""

    def __init__(self, start: StartKernel) -> None:
        """Keep how they are started."""
        self._start = start
        self._running: dict[tuple[str, ...], KernelProcess] = {}

    def lend(self, *options: str) -> Iterator[KernelProcess]:
        """Yield the kernel with these options, or another one when a test has ended it; leave it idle."""
        kernel = self._running.get(options)
        if kernel is None or kernel.process.poll() is not None:
            kernel = self._running[options] = self._start(*options)
        else:
            _set_clock(kernel, kernel.mode)
        yield kernel
        if kernel.process.poll() is None:
            with emptied(kernel):
                pass
            _set_clock(kernel, kernel_pb2.CLOCK_MODE_STEPPED)  # ticks that nobody waits for cost others their time


@pytest.fixture(scope="session")
def shared_kernels(tmp_path_factory: pytest.TempPathFactory) -> Iterator[SharedKernels]:
    """Return the kernels that files share."""
    with kernels(tmp_path_factory) as start:
        yield SharedKernels(start)


@pytest.fixture(scope="module")
def kernel(shared_kernels: SharedKernels) -> Iterator[KernelProcess]:
    """Return a kernel whose time follows the wall clock; others have used it."""
    yield from shared_kernels.lend()


@pytest.fixture(scope="module")
def stepped_kernel(shared_kernels: SharedKernels) -> Iterator[KernelProcess]:
    """Return a kernel whose time goes on by Step only; others have used it."""
    yield from shared_kernels.lend("--stepped")


@pytest.fixture
def stubs(kernel: KernelProcess) -> Iterator[Stubs]:
    """Return stubs to a kernel in REALTIME with an empty world."""
    with emptied(kernel) as stubs:
        yield stubs


@pytest.fixture
def stepped(stepped_kernel: KernelProcess) -> Iterator[Stubs]:
    """Return stubs to a kernel in STEPPED mode with an empty world."""
    with emptied(stepped_kernel) as stubs:
        yield stubs


@pytest.fixture
def client(kernel: KernelProcess, stubs: Stubs) -> Iterator[virtualrobot.Client]:
    """Return a client of a kernel with an empty world whose time follows the wall clock."""
    with virtualrobot.connect(kernel.address) as client:
        yield client


@pytest.fixture
def steps(stepped_kernel: KernelProcess, stepped: Stubs) -> Iterator[virtualrobot.Client]:
    """Return a client of a kernel with an empty world whose time goes on by steps."""
    with virtualrobot.connect(stepped_kernel.address) as client:
        yield client
