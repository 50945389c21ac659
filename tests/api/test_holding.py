"""Hold-to-run over TCP: a motion stands until it is held, runs while beats come, and slows down on its path without."""

from __future__ import annotations

import queue
import socket
import threading
from collections.abc import Iterator
from contextlib import suppress

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, InvalidArgumentError, Phase, WrongStateError
from virtualrobot.v1 import motion_pb2

from tests.api.asking import IIWA, joints, load, refusal
from tests.api.reading import step
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

PAUSING, PAUSED = motion_pb2.MOTION_PHASE_PAUSING, motion_pb2.MOTION_PHASE_PAUSED
RUNNING = motion_pb2.MOTION_PHASE_RUNNING


@pytest.fixture
def client(stepped_kernel: KernelProcess, stepped: Stubs) -> Iterator[Client]:
    with virtualrobot.connect(stepped_kernel.address) as client:
        yield client


def test_it_runs_while_it_is_held(client: Client) -> None:
    arm = client.load_robot(IIWA, name="arm")
    motion = arm.move_joints([1.5] * 7, speed_factor=0.1, hold=True)
    client.clock.step(20)
    assert motion.phase is Phase.PAUSED and not arm.positions.any()
    for refused in (motion.resume, motion.run_step):
        with pytest.raises(WrongStateError, match="was started to run only while it is held, which HoldMotion does"):
            refused()

    def goes_on() -> bool:
        client.clock.step(10)
        return motion.progress > 0.2

    with motion.held():
        until(goes_on)
        with pytest.raises(WrongStateError, match=f"another call holds '{motion.id}' already"), motion.held():
            pass
    client.clock.step(400)
    assert motion.phase is Phase.PAUSED and 0.2 < motion.progress < 1.0
    np.testing.assert_allclose(arm.positions, arm.positions[0], atol=1e-9)  # on its path, which is a straight one
    here = arm.positions
    client.clock.step(50)
    np.testing.assert_array_equal(arm.positions, here)

    def has_ended() -> bool:
        client.clock.step(10)
        return motion.phase.ended

    with motion.held():
        until(has_ended)
    assert motion.phase is Phase.SUCCEEDED
    np.testing.assert_allclose(arm.positions, 1.5, atol=1e-12)
    with motion.held():  # what has ended ends the call
        pass


def test_a_loop_that_hangs_holds_nothing(client: Client) -> None:
    """The loop that looks at the key sends the beats: the block is open, and its thread is well, but nobody beats."""
    arm = client.load_robot(IIWA, name="arm")
    motion = arm.move_joints([1.5] * 7, speed_factor=0.1, hold=True)

    def goes_on() -> bool:
        beat()
        client.clock.step(10)
        return motion.progress > 0.1

    def stands() -> bool:
        client.clock.step(10)
        return motion.phase is Phase.PAUSED

    with motion.beats() as beat:
        until(goes_on)
        until(stands)
        here = arm.positions
        client.clock.step(50)
        np.testing.assert_array_equal(arm.positions, here)
        until(lambda: beat() or motion.phase is Phase.RUNNING)
    until(stands)

    def has_ended() -> bool:
        beat()
        client.clock.step(20)
        return motion.phase.ended

    with motion.beats() as beat:
        until(has_ended)
    assert motion.phase is Phase.SUCCEEDED


class Network:
    """A network between clients and a kernel that can be cut: what is sent arrives no more, and nobody knows."""

    def __init__(self, address: str) -> None:
        """Lead to a kernel."""
        host, _, port = address.rpartition(":")
        self._to = host, int(port)
        self._whole = threading.Event()
        self._whole.set()
        self._server = socket.create_server(("127.0.0.1", 0))
        self._ends = [self._server]
        self.address = f"127.0.0.1:{self._server.getsockname()[1]}"
        threading.Thread(target=self._serve, daemon=True).start()

    def cut(self) -> None:
        self._whole.clear()

    def close(self) -> None:
        self._whole.set()
        for end in self._ends:
            with suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)  # wakes who waits for something from it
            end.close()

    def _serve(self) -> None:
        with suppress(OSError):
            while True:
                near, _ = self._server.accept()
                far = socket.create_connection(self._to)
                self._ends += [near, far]
                for ends in ((near, far), (far, near)):
                    threading.Thread(target=self._carry, args=ends, daemon=True).start()

    def _carry(self, source: socket.socket, target: socket.socket) -> None:
        with suppress(OSError):
            while data := source.recv(65536):
                self._whole.wait()
                target.sendall(data)


def test_a_network_that_is_cut_holds_nothing(stepped_kernel: KernelProcess, stepped: Stubs) -> None:
    """Beats are sent on, and don't arrive; neither end knows that the other one is gone."""
    load(stepped, IIWA, "arm")
    network = Network(stepped_kernel.address)
    try:
        with virtualrobot.connect(network.address) as far:
            arm = far.robot("arm")
            motion = arm.move_joints([1.5] * 7, speed_factor=0.1, hold=True, on_disconnect="continue")
            now = motion_pb2.GetMotionRequest(id=motion.id)

            def is_at(*phases: int) -> bool:
                step(stepped, 5)
                return stepped.motion.GetMotion(now).motion.phase in phases

            with suppress(virtualrobot.VirtualRobotError), motion.held():
                until(lambda: is_at(RUNNING))
                network.cut()
                until(lambda: is_at(PAUSED))
                here = stepped.motion.GetMotion(now).motion.progress
                step(stepped, 200)
                assert stepped.motion.GetMotion(now).motion.progress == here < 1.0
                network.close()
    finally:
        network.close()


class Beats:
    """Beats that a test sends when it likes, in a call of its own."""

    def __init__(self, stubs: Stubs, id: str) -> None:
        """Begin with one beat."""
        self.ready: queue.Queue[motion_pb2.HoldMotionRequest | None] = queue.Queue()
        self.ready.put(motion_pb2.HoldMotionRequest(id=id))
        self.call = stubs.motion.HoldMotion(iter(self.ready.get, None))

    def phase(self) -> int:
        return next(self.call).motion.phase


def test_silence_counts_as_a_key_that_is_let_go(stepped: Stubs) -> None:
    """Also in real time a call that stays open without beats lets the motion slow down; a new beat lets it go on."""
    load(stepped, IIWA, "arm")
    move = joints("arm", 0.1, lbr_iiwa_joint_1=2.0)
    request = motion_pb2.StartMotionRequest(
        spec=motion_pb2.MotionSpec(moves=[move]), hold=True, on_disconnect=motion_pb2.DISCONNECT_POLICY_CONTINUE
    )
    id = stepped.motion.StartMotion(request).motion.id
    beats = Beats(stepped, id)
    assert beats.phase() == RUNNING
    step(stepped, 30)
    assert beats.phase() in (PAUSING, PAUSED)
    beats.ready.put(motion_pb2.HoldMotionRequest())
    assert beats.phase() == RUNNING
    assert beats.phase() in (PAUSING, PAUSED)
    beats.ready.put(motion_pb2.HoldMotionRequest(sent_seconds=float("nan")))
    assert refusal(beats.phase).metadata["field"] == "sent_seconds"
    beats = Beats(stepped, id)
    assert beats.phase() == RUNNING
    assert beats.phase() in (PAUSING, PAUSED)
    beats.ready.put(motion_pb2.HoldMotionRequest(id="motion-999"))
    told = refusal(beats.phase)
    assert told.reason == "INVALID_ARGUMENT" and "this call holds" in told.message


def test_a_client_that_is_gone_holds_nothing(stepped: Stubs) -> None:
    load(stepped, IIWA, "arm")
    move = joints("arm", 0.1, lbr_iiwa_joint_1=2.0)
    request = motion_pb2.StartMotionRequest(
        spec=motion_pb2.MotionSpec(moves=[move]), hold=True, on_disconnect=motion_pb2.DISCONNECT_POLICY_CONTINUE
    )
    id = stepped.motion.StartMotion(request).motion.id
    beats, done = Beats(stepped, id), threading.Event()

    def send() -> None:
        while not done.wait(0.02):
            beats.ready.put(motion_pb2.HoldMotionRequest())

    sender = threading.Thread(target=send)
    sender.start()
    assert beats.phase() == RUNNING
    step(stepped, 30)
    done.set()
    sender.join()
    beats.call.cancel()
    now = motion_pb2.GetMotionRequest(id=id)
    until(lambda: stepped.motion.GetMotion(now).motion.phase in (PAUSING, PAUSED))
    step(stepped, 400)
    assert stepped.motion.GetMotion(now).motion.phase == PAUSED


def test_what_can_not_be_held_is_refused(client: Client, stepped: Stubs) -> None:
    arm = client.load_robot(IIWA, name="arm")
    with pytest.raises(InvalidArgumentError, match="its start can't wait for it"):
        arm.move_joints([0.1] * 7, hold=True, wait=True)
    belt = client.load_robot("model://conveyor", name="belt", pose=virtualrobot.pose(0.6))
    here = np.linalg.inv(client.scene.node("belt.belt").pose) @ arm.tcp
    along = virtualrobot.Tracking("belt.belt", window=0.1)
    assert belt.joint_names
    with pytest.raises(InvalidArgumentError, match="can't be held"):
        arm.move_linear(here, reference="belt.belt", tracking=along, hold=True)
    assert refusal(lambda: next(stepped.motion.HoldMotion(iter(())))).reason == "UNKNOWN_NAME"
