"""CheckConfigurations: the world at the call, progress, its end with whom it is for, killed processes, refusals."""

from __future__ import annotations

import math
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence

import grpc
import numpy as np
import psutil
import pytest
from numpy.typing import ArrayLike
from virtualrobot.v1 import collision_pb2

from tests.api.asking import IIWA, apply, box, create, load, refusal
from tests.api.reading import array, values
from tests.kernels import KernelProcess, Stubs
from tests.waiting import until

pytestmark = pytest.mark.long


def rows_of(
    positions: ArrayLike, robot: str = "arm", joint_names: Sequence[str] = ()
) -> collision_pb2.RobotConfigurations:
    return collision_pb2.RobotConfigurations(robot=robot, joint_names=joint_names, positions=array(positions))


def checks(
    stubs: Stubs, *configurations: collision_pb2.RobotConfigurations, robots: Sequence[str] = ()
) -> Iterator[collision_pb2.CheckConfigurationsResponse]:
    request = collision_pb2.CheckConfigurationsRequest(configurations=configurations, robots=robots)
    return stubs.collision.CheckConfigurations(request)


def test_configurations_are_checked_in_the_world_as_it_was_at_the_call(stubs: Stubs) -> None:
    """A box is put where the arm stands while 20,000 equal configurations are checked."""
    load(stubs, IIWA, "arm")
    stream = checks(stubs, rows_of(np.zeros((20_000, 7))))
    first = next(stream)
    assert (first.progress, len(first.touching.shape)) == (0.0, 0)
    apply(stubs, create(box("box", z=0.1)))
    rows, progress = [], [0.0]
    for response in stream:
        assert response.stamp == first.stamp and not response.pairs
        touching = values(response.touching)
        assert (touching == -1).all()
        rows.extend(range(response.first_row, response.first_row + len(touching)))
        progress.append(response.progress)
    assert sorted(rows) == list(range(20_000))
    assert progress == sorted(progress) and progress[-1] == 1.0 and progress.count(1.0) == 1
    *_, now = checks(stubs, rows_of(np.zeros((3, 7))))
    assert values(now.touching).tolist() == [0, 0, 0]
    assert now.stamp.structure_revision > first.stamp.structure_revision
    assert now.pairs[0].second == "box"


def computing(kernel: KernelProcess) -> list[psutil.Process]:
    """Return the processes of a kernel that compute; those that wait for work take no time at all."""
    children = psutil.Process(kernel.process.pid).children()
    before = [spent(child) for child in children]
    time.sleep(0.2)
    return [child for child, then in zip(children, before, strict=True) if spent(child) > then + 0.015]


def spent(process: psutil.Process) -> float:
    """Return the seconds of a core that a process has had; 0 when it has ended."""
    try:
        return sum(process.cpu_times()[:2])
    except psutil.NoSuchProcess:
        return 0.0


CLIENT = """
import sys, numpy, virtualrobot
client = virtualrobot.connect(sys.argv[1], token=sys.argv[2])
told = lambda part: part and print("runs", flush=True)
client.collisions.check_configurations("arm", numpy.zeros((250_000, 7)), progress=told)
"""


@pytest.mark.parametrize("end", ["cancel", "deadline", "client is killed"])
def test_a_check_that_nobody_waits_for_ends(stubs: Stubs, kernel: KernelProcess, end: str) -> None:
    """What is left of it would take most of a minute."""
    load(stubs, IIWA, "arm")
    list(checks(stubs, rows_of(np.zeros((1, 7)))))  # now there are processes: their start counts in no deadline
    if end == "client is killed":
        words = [sys.executable, "-c", CLIENT, kernel.address, kernel.token]
        with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as client:
            assert client.stdout and client.stdout.readline() == "runs\n"
            client.kill()
    else:
        request = collision_pb2.CheckConfigurationsRequest(configurations=[rows_of(np.zeros((250_000, 7)))])
        stream = stubs.collision.CheckConfigurations(request, timeout=4.0 if end == "deadline" else None)
        assert [next(stream).progress for _ in range(2)][1] < 0.1
        if end == "cancel":
            stream.cancel()
        with pytest.raises(grpc.RpcError):
            list(stream)
    until(lambda: not computing(kernel))
    *_, last = checks(stubs, rows_of(np.zeros((1, 7))))
    assert last.progress == 1.0


def test_a_process_that_is_killed_is_an_error_of_its_call_only(stubs: Stubs, kernel: KernelProcess) -> None:
    load(stubs, IIWA, "arm")
    stream = checks(stubs, rows_of(np.zeros((250_000, 7))))
    assert [next(stream).progress for _ in range(2)][1] > 0.0
    # Again and again: on a busy machine another child of the kernel may be the only one that got on meanwhile.
    failed = refusal(lambda: [one.kill() for _ in stream for one in computing(kernel)])
    assert (failed.code, failed.reason) == (grpc.StatusCode.INTERNAL, "INTERNAL")
    assert "SIGKILL" in failed.message or sys.platform == "win32"
    *_, last = checks(stubs, rows_of(np.zeros((1, 7))))
    assert last.progress == 1.0


@pytest.mark.parametrize(
    ("configurations", "reason", "says"),
    [
        ([], "INVALID_ARGUMENT", "configurations names no robot"),
        ([rows_of(np.zeros((2, 7)), "leg")], "UNKNOWN_NAME", "'leg'"),
        ([rows_of(np.zeros((2, 1)), "box")], "UNKNOWN_NAME", "'box'"),
        ([rows_of(np.zeros((2, 7)))] * 2, "INVALID_ARGUMENT", "configurations[1] names the robot 'arm' again"),
        ([rows_of(np.zeros((2, 6)))], "INVALID_ARGUMENT", "shape (n, 7), not (2, 6)"),
        ([rows_of(np.zeros(7))], "INVALID_ARGUMENT", "shape (n, 7), not (7,)"),
        ([collision_pb2.RobotConfigurations(robot="arm")], "INVALID_ARGUMENT", "positions.type"),
        ([rows_of([[0.0]], joint_names=["elbow"])], "UNKNOWN_NAME", "'elbow'"),
        (
            [rows_of([[0, 0]], joint_names=["lbr_iiwa_joint_1"] * 2)],
            "INVALID_ARGUMENT",
            "names 'lbr_iiwa_joint_1' twice",
        ),
        ([rows_of([[0] * 7, [math.nan] * 7])], "INVALID_ARGUMENT", "not finite: nan in row 1"),
        ([rows_of([[0] * 7, [math.inf] * 7])], "INVALID_ARGUMENT", "not finite: inf in row 1"),
        ([rows_of([[0] * 7, [0] * 6 + [9]])], "LIMIT_EXCEEDED", "in row 1, the joint 'lbr_iiwa_joint_7' of 'arm'"),
        ([rows_of([[-9] + [0] * 6])], "LIMIT_EXCEEDED", "in row 0, the joint 'lbr_iiwa_joint_1' of 'arm'"),
        ([rows_of(np.zeros((2, 7))), rows_of(np.zeros((3, 7)), "other")], "INVALID_ARGUMENT", "has 3 rows"),
    ],
)
def test_configurations_that_cannot_be_are_refused_before_any_work(
    stubs: Stubs, configurations: list[collision_pb2.RobotConfigurations], reason: str, says: str
) -> None:
    load(stubs, IIWA, "arm")
    load(stubs, IIWA, "other")
    apply(stubs, create(box("box")))
    stream = checks(stubs, *configurations)
    found = refusal(lambda: next(stream))
    assert (found.reason, says in found.message) == (reason, True), found.message
    assert refusal(lambda: next(checks(stubs, rows_of(np.zeros((1, 7))), robots=["box"]))).reason == "UNKNOWN_NAME"
