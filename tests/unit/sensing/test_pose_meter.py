"""Pose sensors against where nodes are, and their noise against its parameters."""

from __future__ import annotations

import numpy as np
from virtualrobot_kernel.sensing.motion_content import PoseContent
from virtualrobot_kernel.sensing.motion_reader import MotionReader
from virtualrobot_kernel.world.commands import CreateNodes
from virtualrobot_kernel.world.sensing import MotionSensor, NoiseModel, PoseSensor
from virtualrobot_kernel.world.structure import Kind, NodeSpec
from virtualrobot_sdk.poses import rotation_matrix, rotation_vector

from tests.unit.sensing.moments import moment_at, snapshot_at
from tests.unit.sensing.test_noise import assert_mean_and_deviation
from tests.unit.world.builders import TICK, Change, after, empty, random_pose, shifted


def tracked(settings: PoseSensor, rng: np.random.Generator, seed: int = 0) -> tuple[Change, np.ndarray]:
    place = random_pose(rng)
    sensor = NodeSpec("gps", Kind.MOTION_SENSOR, "body", place, data=MotionSensor(settings, seed=seed))
    return after(empty(), CreateNodes((NodeSpec("body", Kind.OBJECT), sensor))), place


def test_the_true_pose_and_velocity(rng: np.random.Generator) -> None:
    """With x = v t + a t^2 / 2 the velocity v + a t is that of the reading's own tick."""
    change, body_t_gps = tracked(PoseSensor(), rng)
    v, a, turned = rng.uniform(-1, 1, 3), rng.uniform(-5, 5, 3), random_pose(rng)

    def way(time: float) -> np.ndarray:
        return shifted(*(v * time + 0.5 * a * time**2)) @ turned

    moment = moment_at(change, 120, {"body": way})
    told = MotionReader(moment.snapshot, change.structure.node("gps")).read(moment)
    assert isinstance(told, PoseContent)
    np.testing.assert_allclose(told.world_t_node, way(120 * TICK) @ body_t_gps, atol=1e-14)
    np.testing.assert_allclose(told.linear_velocity, v + a * 120 * TICK, atol=1e-9)


def test_noise_of_position_and_of_orientation(rng: np.random.Generator, seed: int) -> None:
    """That of the orientation is a rotation vector: its three numbers have the deviation."""
    settings = PoseSensor(NoiseModel(0.02), NoiseModel(0.005))
    change, _ = tracked(settings, rng, seed)
    reader = MotionReader(snapshot_at(change, 0), change.structure.node("gps"))
    true = snapshot_at(change, 0).world_t(change.structure.node("gps").uid)
    shifts, turns = [], []
    for number in range(1, 1501):
        told = reader.read(moment_at(change, 10 + number, number=number, seed=seed))
        assert isinstance(told, PoseContent)
        shifts.append(told.world_t_node[:3, 3] - true[:3, 3])
        turns.append(rotation_vector(true[:3, :3].T @ told.world_t_node[:3, :3]))
    assert_mean_and_deviation(np.array(shifts), 0.0, 0.02)
    assert_mean_and_deviation(np.array(turns), 0.0, 0.005)
    correlation = np.corrcoef(np.hstack([shifts, turns]).T)[np.triu_indices(6, 1)]
    assert np.abs(correlation).max() < 5.9 / np.sqrt(1500)  # 15 normal numbers beyond 5.9 deviations: 6e-8


def test_orientation_in_steps(rng: np.random.Generator) -> None:
    change, _ = tracked(PoseSensor(NoiseModel(resolution=0.1), NoiseModel(resolution=0.05)), rng)
    moment = moment_at(change, 5)
    told = MotionReader(moment.snapshot, change.structure.node("gps")).read(moment)
    assert isinstance(told, PoseContent)
    true = moment.snapshot.world_t(change.structure.node("gps").uid)[:3, :3]
    stepped = rotation_matrix(np.round(rotation_vector(true) / 0.05) * 0.05)
    np.testing.assert_allclose(told.world_t_node[:3, :3], stepped, atol=1e-12)
    assert np.abs(stepped - true).max() > 1e-5
    np.testing.assert_allclose(told.world_t_node[:3, 3] * 10, np.round(told.world_t_node[:3, 3] * 10), atol=1e-9)
    np.testing.assert_allclose(told.world_t_node[:3, :3].T @ told.world_t_node[:3, :3], np.eye(3), atol=1e-12)
