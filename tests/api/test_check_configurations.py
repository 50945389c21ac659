"""CheckConfigurations: the world at the call, progress, its end with whom it is for, killed processes, refusals."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Sequence

import grpc
import numpy as np
import psutil
import pytest
from numpy.typing import ArrayLike
from virtualrobot.v1 import collision_pb2

from tests.api.asking import IIWA, apply, box, create, load, refusal
from tests.api.conftest import KernelProcess, Stubs
from tests.api.reading import array, values


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


def test_a_check_of_configurations_that_nobody_waits_for_ends(stubs: Stubs) -> None:
    """What is left of it would take minutes; the next one has its turn at once."""
    load(stubs, IIWA, "arm")
    for end in ("cancel", "deadline"):
        request = collision_pb2.CheckConfigurationsRequest(configurations=[rows_of(np.zeros((250_000, 7)))])
        stream = stubs.collision.CheckConfigurations(request, timeout=3.0 if end == "deadline" else None)
        if end == "cancel":
            assert [next(stream).progress for _ in range(2)][1] < 0.1
            stream.cancel()
        with pytest.raises(grpc.RpcError):
            list(stream)
        *_, last = stubs.collision.CheckConfigurations(
            collision_pb2.CheckConfigurationsRequest(configurations=[rows_of(np.zeros((1, 7)))]), timeout=20.0
        )
        assert last.progress == 1.0


def test_a_process_that_is_killed_is_an_error_of_its_calls_only(stubs: Stubs, kernel: KernelProcess) -> None:
    load(stubs, IIWA, "arm")
    stream = checks(stubs, rows_of(np.zeros((250_000, 7))))
    assert [next(stream).progress for _ in range(2)][1] > 0.0
    for child in psutil.Process(kernel.process.pid).children():
        if any("worker.child" in word for word in child.cmdline()):
            child.kill()
    failed = refusal(lambda: list(stream))
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
