"""Answers of a kernel as NumPy arrays, and whole worlds to compare. Rotations are scipy's, not the kernel's own."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from google.protobuf.message import Message
from scipy.spatial.transform import Rotation
from virtualrobot.v1 import geometry_pb2, kernel_pb2, motion_pb2, robot_pb2, scene_pb2, signal_pb2, view_pb2

from tests.kernels import Stubs

DTYPES = {
    geometry_pb2.NUMERIC_TYPE_FLOAT64: "<f8",
    geometry_pb2.NUMERIC_TYPE_FLOAT32: "<f4",
    geometry_pb2.NUMERIC_TYPE_INT32: "<i4",
    geometry_pb2.NUMERIC_TYPE_UINT8: "u1",
}


def values(array: geometry_pb2.NumericArray) -> np.ndarray:
    """Return the numbers of an array."""
    return np.frombuffer(array.data, DTYPES[array.type]).reshape(tuple(array.shape))


def array(
    numbers: object, kind: geometry_pb2.NumericType = geometry_pb2.NUMERIC_TYPE_FLOAT64
) -> geometry_pb2.NumericArray:
    """Return numbers as an array message."""
    stored = np.asarray(numbers, DTYPES[kind])
    return geometry_pb2.NumericArray(type=kind, shape=stored.shape, data=stored.tobytes())  # pyright: ignore[reportArgumentType]


def matrices(array: geometry_pb2.NumericArray) -> np.ndarray:
    """Return rows of x, y, z and quaternion as poses (n, 4, 4); an absent array has no rows."""
    if not array.data:
        return np.empty((0, 4, 4))
    rows = values(array)
    result = np.tile(np.eye(4), (len(rows), 1, 1))
    result[:, :3, 3] = rows[:, :3]
    result[:, :3, :3] = Rotation.from_quat(rows[:, 3:]).as_matrix()
    return result


def matrix(pose: geometry_pb2.Pose) -> np.ndarray:
    """Return a pose as (4, 4); absent parts are identity."""
    result = np.eye(4)
    result[:3, 3] = pose.position.x, pose.position.y, pose.position.z
    if pose.HasField("orientation"):
        turn = pose.orientation
        result[:3, :3] = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_matrix()
    return result


def pose(matrix: np.ndarray) -> geometry_pb2.Pose:
    """Return (4, 4) as a pose."""
    x, y, z = matrix[:3, 3]
    a, b, c, d = Rotation.from_matrix(matrix[:3, :3]).as_quat()
    return geometry_pb2.Pose(
        position=geometry_pb2.Vector3(x=x, y=y, z=z), orientation=geometry_pb2.Quaternion(x=a, y=b, z=c, w=d)
    )


def random_matrix(rng: np.random.Generator, size: float = 1.0) -> np.ndarray:
    """Return a pose (4, 4) in a cube of `size` m about the origin, turned any way."""
    result = np.eye(4)
    result[:3, 3] = rng.uniform(-size, size, 3)
    result[:3, :3] = Rotation.random(rng=rng).as_matrix()
    return result


def scene(stubs: Stubs, *names: str) -> dict[str, np.ndarray]:
    """Return where nodes are in the world, (4, 4) by name."""
    answer = stubs.scene.GetScene(scene_pb2.GetSceneRequest(names=names))
    return dict(zip((node.name for node in answer.nodes), matrices(answer.world_t_node), strict=True))


def state(stubs: Stubs, robot: str) -> robot_pb2.RobotState:
    """Return the state of one robot."""
    return stubs.robot.GetRobotStates(robot_pb2.GetRobotStatesRequest(names=[robot])).robots[0]


def step(stubs: Stubs, ticks: int = 1) -> kernel_pb2.StepClockResponse:
    """Let time go on by some ticks."""
    return stubs.kernel.StepClock(kernel_pb2.StepClockRequest(ticks=ticks))


def world(stubs: Stubs) -> dict[str, Any]:
    """Return all that a client can read of the world, without the clock."""
    answers: dict[str, Message] = {
        "scene": stubs.scene.GetScene(scene_pb2.GetSceneRequest()),
        "robots": stubs.robot.GetRobotStates(robot_pb2.GetRobotStatesRequest()),
        "signals": stubs.signal.GetSignals(signal_pb2.GetSignalsRequest()),
        "motions": stubs.motion.ListMotions(motion_pb2.ListMotionsRequest()),
        "view": stubs.view.GetView(view_pb2.GetViewRequest()),
        "saved": stubs.scene.SaveScene(scene_pb2.SaveSceneRequest()),
    }
    revision = answers["scene"].stamp.structure_revision  # pyright: ignore[reportAttributeAccessIssue] it has a stamp
    for answer in answers.values():
        if "stamp" in answer.DESCRIPTOR.fields_by_name:
            answer.ClearField("stamp")
    return {"revision": revision, **answers}


@contextmanager
def unchanged(stubs: Stubs) -> Iterator[None]:
    """Fail when anything in the world is another after the block than before; nothing may move meanwhile."""
    before = world(stubs)
    yield
    after = world(stubs)
    for part, value in before.items():
        assert after[part] == value, f"the refused call changed {part}"
