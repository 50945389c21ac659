"""Inertial units against motions whose turning rate and acceleration are formulas."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from virtualrobot_kernel.sensing.imu import EARTH_FIELD
from virtualrobot_kernel.sensing.motion_content import ImuContent
from virtualrobot_kernel.sensing.motion_reader import MotionReader
from virtualrobot_kernel.sensing.reading import Moment
from virtualrobot_kernel.world.commands import CreateNodes, SetJointPositions
from virtualrobot_kernel.world.sensing import Imu, MotionSensor, NoiseModel
from virtualrobot_kernel.world.structure import Kind, NodeSpec
from virtualrobot_sdk.poses import rotation_matrix

from tests.unit.sensing.moments import Way, moment_at, snapshot_at
from tests.unit.world.builders import TICK, Change, after, arm, empty, random_pose, shifted

UP = np.array([0.0, 0.0, 9.81])


def mounted(rng: np.random.Generator, imu: Imu | None = None, seed: int = 0) -> tuple[Change, np.ndarray]:
    """Return a world of a body and an inertial unit somewhere on it, and where."""
    body_t_imu = random_pose(rng)
    change = after(
        empty(),
        CreateNodes(
            (
                NodeSpec("body", Kind.OBJECT),
                NodeSpec("imu", Kind.MOTION_SENSOR, "body", body_t_imu, data=MotionSensor(imu or Imu(), seed=seed)),
            )
        ),
    )
    return change, body_t_imu


def read(change: Change, tick: int, way: Way) -> tuple[ImuContent, np.ndarray]:
    """Return what the unit tells at a tick, and how it is turned in the world at the tick before."""
    moment = moment_at(change, tick, {"body": way})
    node = change.structure.node("imu")
    content = MotionReader(moment.snapshot, node).read(moment)
    assert isinstance(content, ImuContent)
    return content, moment.history[-1].world_t(node.uid)[:3, :3]


def test_at_rest_it_feels_its_weight_and_the_field(rng: np.random.Generator) -> None:
    change, _ = mounted(rng, Imu(magnetic_field=(1e-5, -2e-5, 3e-5)))
    place = random_pose(rng)
    told, turn = read(change, int(rng.integers(2, 100_000)), lambda _: place)
    np.testing.assert_allclose(told.angular_velocity, 0.0, atol=1e-9)
    np.testing.assert_allclose(told.linear_acceleration, turn.T @ UP, atol=1e-9)
    np.testing.assert_allclose(told.magnetic_field, turn.T @ (1e-5, -2e-5, 3e-5), atol=1e-18)


def test_the_earths_field_points_north_and_down(rng: np.random.Generator) -> None:
    change, _ = mounted(rng)
    told, turn = read(change, 5, lambda _: np.eye(4))
    np.testing.assert_allclose(turn @ told.magnetic_field, EARTH_FIELD, atol=1e-18)


def test_constant_acceleration_along_a_rail(rng: np.random.Generator) -> None:
    """With x = v t + a t^2 / 2; the difference of second order has no error then."""
    change, _ = mounted(rng)
    start, v, a = random_pose(rng), rng.uniform(-1, 1, 3), rng.uniform(-9, 9, 3)

    def way(time: float) -> np.ndarray:
        pose = start.copy()
        pose[:3, 3] += v * time + 0.5 * a * time**2
        return pose

    told, turn = read(change, 250, way)
    np.testing.assert_allclose(told.angular_velocity, 0.0, atol=1e-9)
    np.testing.assert_allclose(told.linear_acceleration, turn.T @ (a + UP), atol=1e-8)


def test_uniform_circular_motion(rng: np.random.Generator) -> None:
    """It is w x (w x r) inwards; differences make it smaller by (w dt)^2 / 12, by Taylor's series."""
    change, body_t_imu = mounted(rng)
    start, w = random_pose(rng), rng.uniform(-3, 3, 3)

    def way(time: float) -> np.ndarray:
        turned = np.eye(4)
        turned[:3, :3] = rotation_matrix(w * time)
        return turned @ start

    tick = 333
    told, turn = read(change, tick, way)
    origin = (way((tick - 1) * TICK) @ body_t_imu)[:3, 3]
    inwards = np.cross(w, np.cross(w, origin))
    error = float(np.linalg.norm(w) * TICK) ** 2 / 12
    np.testing.assert_allclose(told.angular_velocity, turn.T @ w, atol=1e-9)
    np.testing.assert_allclose(turn @ told.linear_acceleration, inwards + UP, rtol=0, atol=1e-3)
    size = np.linalg.norm(turn @ told.linear_acceleration - UP)
    assert size == pytest.approx(np.linalg.norm(inwards) * (1 - error), rel=1e-7)


def test_a_turn_that_grows_faster(rng: np.random.Generator) -> None:
    """About a standing axis: the angle is b t^2 / 2, the rate b t, and both differences are exact."""
    change, _ = mounted(rng)
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    start, b = random_pose(rng), 4.0

    def way(time: float) -> np.ndarray:
        pose = start.copy()
        pose[:3, :3] = rotation_matrix(axis * 0.5 * b * time**2) @ start[:3, :3]
        return pose

    told, turn = read(change, 400, way)
    np.testing.assert_allclose(turn @ told.angular_velocity, axis * b * 399 * TICK, atol=1e-9)


def test_without_a_past_joints_go_at_their_speeds(rng: np.random.Generator) -> None:
    """A single reading of a turning arm: the rates of its two parallel axes add up."""
    sensor = NodeSpec("imu", Kind.MOTION_SENSOR, "arm.hand", shifted(x=0.1), data=MotionSensor(Imu()))
    change = after(empty(), arm(), CreateNodes((sensor,)), SetJointPositions("arm", {"a": 0.3, "b": -0.4}))
    v = np.array([0.7, 0.5, 0.0])
    now = snapshot_at(replace(change, state=replace(change.state, v=v)), 10)
    told = MotionReader(now, change.structure.node("imu")).read(Moment(now, (), 1, rng))
    assert isinstance(told, ImuContent)
    np.testing.assert_allclose(told.angular_velocity, (0.0, 0.0, 1.2), atol=1e-9)
    # In the hand's frame, by R. Featherstone's recursion written out for two bars of 0.5 m and 0.6 m.
    angle = -0.4 - 0.5 * TICK
    inwards = -(0.7**2) * 0.5 * np.array([np.cos(angle), -np.sin(angle), 0.0]) - [1.2**2 * 0.6, 0.0, 0.0]
    np.testing.assert_allclose(told.linear_acceleration, inwards + UP, rtol=1e-5, atol=1e-4)


def test_a_body_that_is_new_is_at_rest(rng: np.random.Generator) -> None:
    change, _ = mounted(rng)
    now, before = snapshot_at(change, 10), [snapshot_at(empty(), tick) for tick in (8, 9)]
    told = MotionReader(now, change.structure.node("imu")).read(Moment(now, tuple(before), 1, rng))
    assert isinstance(told, ImuContent)
    assert np.linalg.norm(told.linear_acceleration) == pytest.approx(9.81)


def test_snapshots_of_one_tick_count_once(rng: np.random.Generator) -> None:
    """Commands between two ticks publish a world of the same tick: the last one counts."""
    change, _ = mounted(rng)
    ways = [{"body": lambda time, shift=shift: shifted(x=shift + time)} for shift in (0.3, 0.0)]
    history = [snapshot_at(change, tick, way) for tick in (8, 9) for way in ways]
    now = snapshot_at(change, 10, ways[1])
    told = MotionReader(now, change.structure.node("imu")).read(Moment(now, tuple(history), 1, rng))
    assert isinstance(told, ImuContent)
    assert np.linalg.norm(told.linear_acceleration) == pytest.approx(9.81)


def test_each_part_has_its_noise(rng: np.random.Generator, seed: int) -> None:
    """Ranges tell which setting is whose."""
    imu = Imu(NoiseModel(50.0, range=0.1), NoiseModel(50.0, range=0.2), NoiseModel(50.0, range=0.3))
    change, _ = mounted(rng, imu, seed)
    reader = MotionReader(snapshot_at(change, 0), change.structure.node("imu"))
    told = [reader.read(moment_at(change, tick, seed=seed, number=tick)) for tick in range(2, 30)]
    for name, limit in (("angular_velocity", 0.1), ("linear_acceleration", 0.2), ("magnetic_field", 0.3)):
        values = np.array([getattr(one, name) for one in told])
        assert np.abs(values).max() == limit
        assert {-limit, limit} <= set(np.unique(values))
