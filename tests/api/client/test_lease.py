"""Leases through the client: what a program writes, and what it is told when it loses its robots."""

from __future__ import annotations

import contextlib
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Robot
from virtualrobot.leases import Lease
from virtualrobot.v1 import lease_pb2

from tests.api.client.conftest import IIWA, Run
from tests.api.client.test_motion import BENT, begun, slow
from tests.kernels import KernelProcess


@pytest.fixture
def other(client: Client, kernel: KernelProcess) -> Iterator[Client]:
    """Return another client of the same kernel; asked for after the arm, it leaves before the world is emptied."""
    with virtualrobot.connect(kernel.address) as other:
        yield other


def until_free(client: Client) -> None:
    waiting = threading.Event()
    for _ in range(3000):
        if not client.leases():
            return
        waiting.wait(0.01)
    raise AssertionError(f"still leased: {client.leases()}")


def test_in_the_block_nobody_else_moves_the_robot(client: Client, iiwa: Robot, other: Client) -> None:
    with iiwa.lease(owner="cell 3") as lease:
        assert (lease.robots, lease.owner, lease.lost) == (("iiwa",), "cell 3", "")
        with pytest.raises(virtualrobot.LeasedError, match="'iiwa' is leased by 'cell 3'") as refused:
            other.robot("iiwa").move_joints(BENT)
        assert refused.value.metadata["robot"] == "iiwa"
        assert (refused.value.reason, refused.value.code) == ("LEASED", "PERMISSION_DENIED")
        with pytest.raises(virtualrobot.LeasedError):
            other.robot("iiwa").set_positions(BENT)
        with pytest.raises(virtualrobot.LeasedError):
            other.lease("iiwa")
        iiwa.move_joints(BENT)
        iiwa.speed_factor = 0.5
        assert other.robot("iiwa").speed_factor == 0.5
        (shown,) = other.leases()
        assert (shown.id, shown.robots, shown.owner, shown.since) == (lease.id, ("iiwa",), "cell 3", lease.since)
    assert client.leases() == []
    other.robot("iiwa").move_joints(np.zeros(7))
    iiwa.move_joints(BENT)


def test_several_robots_and_leases_in_leases(client: Client, iiwa: Robot, other: Client) -> None:
    second, third = (client.load_robot(IIWA, name=name) for name in ("second", "third"))
    with client.lease("iiwa", "second"), third.lease():
        client.move_together([iiwa.ptp(BENT), second.ptp(BENT), third.ptp(BENT)])
        with pytest.raises(virtualrobot.LeasedError):
            other.move_together([iiwa.ptp(BENT)])
    assert client.leases() == []
    with pytest.raises(virtualrobot.UnknownNameError, match="'iwa'"):
        client.lease("iiwa", "iwa")
    assert client.leases() == []


def test_whoever_is_robbed_is_told_and_moves_nothing_any_more(client: Client, iiwa: Robot, other: Client) -> None:
    with iiwa.lease(owner="Ada") as lease:
        motion = begun(slow(iiwa))
        with other.lease("iiwa", take=True, owner="Bob"):
            assert "'Bob'" in lease.wait_for_loss(30.0)
            assert lease.robots == ()
            with pytest.raises(virtualrobot.MotionCancelledError, match="taken over by 'Bob'"):
                motion.wait()
        # Bob has left; but a program that has lost its robot must not go on as if nothing had been.
        with pytest.raises(virtualrobot.LeaseEndedError, match="'Bob'"):
            iiwa.move_joints(BENT)
    iiwa.move_joints(BENT)  # it has been told, and may move a free robot as anyone may


def test_the_end_of_the_client_is_the_end_of_its_lease(client: Client, iiwa: Robot, other: Client) -> None:
    lease = other.lease("iiwa")
    motion = slow_of(other)
    other.close()
    until_free(client)
    with pytest.raises(virtualrobot.MotionAbortedError):
        client.motions(running_only=False)[-1].wait(30.0)
    assert client.motions(running_only=False)[-1].id == motion
    assert lease.wait_for_loss(30.0)
    iiwa.move_joints(BENT)


def slow_of(client: Client) -> str:
    robot = client.robot("iiwa")
    return robot.start(robot.ptp(BENT, speed_factor=0.001), wait=False, on_disconnect="continue").id


PROGRAM = """
import sys
import virtualrobot
client = virtualrobot.connect(sys.argv[1])
lease = client.lease("iiwa")
robot = client.robot("iiwa")
print(robot.start(robot.ptp([1.0] * 7, speed_factor=0.001), wait=False, on_disconnect="continue").id, flush=True)
lease.wait_for_loss()
"""


def test_a_killed_program_loses_its_lease(client: Client, iiwa: Robot, kernel: KernelProcess) -> None:
    command = [sys.executable, "-c", PROGRAM, kernel.address]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as program:
        assert program.stdout
        id = program.stdout.readline().strip()
        (shown,) = client.leases()
        assert f"({program.pid})" in shown.owner  # who it is, without being asked
        program.kill()
    (motion,) = (one for one in client.motions(running_only=False) if one.id == id)
    with pytest.raises(virtualrobot.MotionAbortedError, match="expired"):
        motion.wait(30.0)
    until_free(client)


def test_a_lease_outlasts_waiting(client: Client, iiwa: Robot) -> None:
    with iiwa.lease() as lease:
        assert lease.wait_for_loss(2.5) == ""
        iiwa.move_joints(BENT)


class Wire:
    """A proxy that carries bytes to a kernel, until it is cut; it can be used again at once."""

    def __init__(self, address: str) -> None:
        """Listen on a free port of this machine."""
        host, _, port = address.rpartition(":")
        self._kernel = (host, int(port))
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._ends: list[socket.socket] = []
        self.address = f"127.0.0.1:{self._listener.getsockname()[1]}"
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        with contextlib.suppress(OSError):  # closed
            while True:
                near = self._listener.accept()[0]
                far = socket.create_connection(self._kernel)
                self._ends += [near, far]
                for source, sink in ((near, far), (far, near)):
                    threading.Thread(target=self._carry, args=(source, sink), daemon=True).start()

    def _carry(self, source: socket.socket, sink: socket.socket) -> None:
        with contextlib.suppress(OSError):  # cut
            while data := source.recv(65536):
                sink.sendall(data)

    def cut(self) -> None:
        """End all connections."""
        ends, self._ends = self._ends, []
        for end in ends:
            with contextlib.suppress(OSError):  # the other side was faster
                end.shutdown(socket.SHUT_RDWR)
            end.close()

    def close(self) -> None:
        """End all connections and listen no more."""
        with contextlib.suppress(OSError):  # not every system shuts a listener down; Linux would accept once more
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        self.cut()


@pytest.fixture
def wire(kernel: KernelProcess) -> Iterator[Wire]:
    wire = Wire(kernel.address)
    yield wire
    wire.close()


@pytest.mark.long
def test_a_short_break_of_the_connection_costs_no_lease(
    client: Client, iiwa: Robot, kernel: KernelProcess, wire: Wire
) -> None:
    with virtualrobot.connect(wire.address) as far, far.lease("iiwa", owner="far") as lease:
        for _ in range(3):
            wire.cut()
            assert lease.wait_for_loss(1.5) == ""  # longer than the grace
        assert [shown.id for shown in client.leases()] == [lease.id]
        far.robot("iiwa").move_joints(BENT)


def test_a_connection_that_stays_away_costs_the_lease(
    client: Client, iiwa: Robot, kernel: KernelProcess, wire: Wire
) -> None:
    far = virtualrobot.connect(wire.address)
    lease = far.lease("iiwa")
    id = slow_of(far)
    wire.close()
    until_free(client)
    (motion,) = (one for one in client.motions(running_only=False) if one.id == id)
    with pytest.raises(virtualrobot.MotionAbortedError, match="expired"):
        motion.wait(30.0)
    assert "no kernel answers" in lease.wait_for_loss(30.0)
    assert lease.robots == ()
    far.close()


def test_releasing_twice_does_no_harm(client: Client, iiwa: Robot) -> None:
    lease = iiwa.lease()
    lease.release()
    lease.release()
    assert lease.robots == ()
    iiwa.move_joints(BENT)


def test_the_command_shows_leases(client: Client, iiwa: Robot, run: Run) -> None:
    assert run("leases") == ""
    with client.lease("iiwa", owner="cell 3") as lease:
        assert run("leases").startswith("iiwa: cell 3, since 20")
        assert run("leases").endswith(f" ({lease.id})\n")
        assert "is leased by 'cell 3'" in run("move", "iiwa", "--joints", "0,0,0,0,0,0,0", code=1)
        assert run("stop") == "nothing moves\n"


def test_who_loses_a_robot_before_the_kernel_tells_of_anything_is_told_why(client: Client, iiwa: Robot) -> None:
    acquired = client.services.lease.AcquireLease(lease_pb2.AcquireLeaseRequest(robots=["iiwa"], owner="cell 3"))
    with client.lease("iiwa", take=True, owner="the teach pendant"):
        lease = Lease(client.services, acquired.lease, acquired.token)
        assert lease.wait_for_loss(timeout=60.0) == "taken over by 'the teach pendant'"
        lease.release()
