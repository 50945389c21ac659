"""The forward pass against pinocchio on real robots, and by the laws of each joint type."""

from __future__ import annotations

import numpy as np
import pinocchio  # pyright: ignore[reportMissingImports]  a path file makes it importable
import pytest
from scipy.spatial.transform import Rotation
from virtualrobot_kernel.numeric.forest import (
    FIXED,
    FLOATING,
    PLANAR,
    PRISMATIC,
    REVOLUTE,
    UNUSED,
    forward_forest,
    topological_order,
)

from tests.unit.world.builders import random_pose, unit

from .urdf_arrays import URDFS, read, world_poses


def single(kind: int, q: np.ndarray, axis: np.ndarray, parent_t_node: np.ndarray | None = None) -> np.ndarray:
    """Return the pose of one joint of a kind at q."""
    pose = np.eye(4) if parent_t_node is None else parent_t_node
    out = np.full((1, 4, 4), np.nan)
    zero = np.zeros(1, np.int32)
    kinds = np.array([kind], np.int8)
    forward_forest(zero, zero - 1, kinds, axis[None], zero, np.ones(1), np.zeros(1), pose[None].copy(), q, out)
    return out[0]


@pytest.mark.parametrize("name", sorted(URDFS))
def test_link_poses_agree_with_pinocchio(name: str, rng: np.random.Generator) -> None:
    forest = read(URDFS[name])
    model = pinocchio.buildModelFromUrdf(str(URDFS[name]), mimic=True)
    data = model.createData()
    for _ in range(50):
        q = rng.uniform(np.maximum(forest.lower, -np.pi), np.minimum(forest.upper, np.pi))
        theirs = pinocchio.neutral(model)
        for joint, value in zip(forest.joints, q, strict=True):
            theirs[model.joints[model.getJointId(joint)].idx_q] = value
        pinocchio.framesForwardKinematics(model, data, theirs)
        expected = [data.oMf[model.getFrameId(link)].homogeneous for link in forest.links]
        np.testing.assert_allclose(world_poses(forest, q), expected, atol=1e-9)


def test_puma_equals_the_product_of_its_published_table(rng: np.random.Generator) -> None:
    # Corke and Armstrong-Helouvry 1994: a, alpha, d of standard Denavit-Hartenberg; see the README of the models.
    a = [0, 0.4318, 0.0203, 0, 0, 0]
    alpha = [np.pi / 2, 0, -np.pi / 2, np.pi / 2, -np.pi / 2, 0]
    d = [0, 0, 0.15005, 0.4318, 0, 0]
    forest = read(URDFS["puma560"])
    tip = forest.links.index("tool0")
    for _ in range(100):
        q = rng.uniform(forest.lower, forest.upper)
        expected = np.eye(4)
        expected[2, 3] = 26.45 * 0.0254
        for i in range(6):
            c, s, ca, sa = np.cos(q[i]), np.sin(q[i]), np.cos(alpha[i]), np.sin(alpha[i])
            expected = expected @ [
                [c, -s * ca, s * sa, a[i] * c],
                [s, c * ca, -c * sa, a[i] * s],
                [0, sa, ca, d[i]],
                [0, 0, 0, 1],
            ]
        np.testing.assert_allclose(world_poses(forest, q)[tip], expected, atol=1e-12)


def test_puma_has_its_published_limits() -> None:
    forest = read(URDFS["puma560"])
    # Wang and Chen 1991.
    np.testing.assert_allclose(np.degrees(forest.lower), [-160, -45, -225, -110, -100, -266], atol=1e-9)
    np.testing.assert_allclose(np.degrees(forest.upper), [160, 225, 45, 170, 100, 266], atol=1e-9)


def test_revolute_joint_turns_by_the_exponential_of_its_axis(rng: np.random.Generator) -> None:
    for axis in (unit(rng), np.array([0.0, 0, 1]), np.array([0.0, 0, -1]), np.array([1.0, 0, 0])):
        angle, pose = rng.uniform(-7, 7), random_pose(rng)
        expected = np.eye(4)
        expected[:3, :3] = Rotation.from_rotvec(axis * angle).as_matrix()
        np.testing.assert_allclose(single(REVOLUTE, np.array([angle]), axis, pose), pose @ expected, atol=1e-14)


def test_prismatic_joint_moves_along_its_axis(rng: np.random.Generator) -> None:
    axis, pose = unit(rng), random_pose(rng)
    expected = np.eye(4)
    expected[:3, 3] = axis * 0.7
    np.testing.assert_allclose(single(PRISMATIC, np.array([0.7]), axis, pose), pose @ expected, atol=1e-14)


def test_floating_joint_takes_any_length_of_quaternion(rng: np.random.Generator) -> None:
    quaternion, position = rng.normal(size=4) * 3, rng.normal(size=3)
    pose = single(FLOATING, np.concatenate([position, quaternion]), np.zeros(3))
    np.testing.assert_allclose(pose[:3, :3], Rotation.from_quat(quaternion).as_matrix(), atol=1e-14)
    np.testing.assert_array_equal(pose[:3, 3], position)


def test_floating_joint_reads_the_zero_quaternion_as_identity() -> None:
    np.testing.assert_array_equal(single(FLOATING, np.zeros(7), np.zeros(3)), np.eye(4))


def test_planar_joint_moves_in_the_plane_normal_to_its_axis(rng: np.random.Generator) -> None:
    nearly_down = np.array([1e-9, 0.0, -1.0])
    for axis in (unit(rng), unit(rng) * [1, 1, -1], np.array([0, 0, 1.0]), np.array([1.0, 0, 0]), nearly_down):
        x, y, theta = rng.normal(size=3)
        smallest = Rotation.align_vectors(axis[None], [[0, 0, 1.0]])[0]
        pose = single(PLANAR, np.array([x, y, theta]), axis)
        if axis[2] > -0.9999:  # nearer to down scipy's own choice of axis is rounded; the laws below still hold
            np.testing.assert_allclose(pose[:3, 3], smallest.apply([x, y, 0]), atol=1e-12)
        np.testing.assert_allclose(pose[:3, :3], Rotation.from_rotvec(axis * theta).as_matrix(), atol=1e-12)
        assert abs(pose[:3, 3] @ axis) < 1e-12
        assert np.linalg.norm(pose[:3, 3]) == pytest.approx(np.hypot(x, y), abs=1e-12)


def test_planar_joint_about_minus_z_is_turned_by_half_a_turn_about_x() -> None:
    pose = single(PLANAR, np.array([2.0, 3.0, 0.0]), np.array([0.0, 0, -1]))
    np.testing.assert_array_equal(pose[:3, 3], [2, -3, 0])
    nearly = single(PLANAR, np.array([2.0, 3.0, 0.0]), np.array([0.0, 1e-9, -1]))
    np.testing.assert_allclose(nearly[:3, 3], [2, -3, 0], atol=1e-8)


def test_mimic_joints_follow_their_source(rng: np.random.Generator) -> None:
    factor, shift = rng.normal(size=2)
    q = rng.normal(size=1)
    out = np.empty((2, 4, 4))
    forward_forest(
        np.array([0, 1], np.int32),
        np.array([-1, 0], np.int32),
        np.array([REVOLUTE, REVOLUTE], np.int8),
        np.array([[0.0, 0, 1], [0, 0, 1]]),
        np.zeros(2, np.int32),
        np.array([1.0, factor]),
        np.array([0.0, shift]),
        np.tile(np.eye(4), (2, 1, 1)),
        q,
        out,
    )
    angle = q[0] + factor * q[0] + shift
    np.testing.assert_allclose(out[1, :3, :3], Rotation.from_rotvec([0, 0, angle]).as_matrix(), atol=1e-14)


def test_rows_that_are_not_in_order_stay_untouched_and_inputs_may_be_read_only() -> None:
    parent = np.array([-1, UNUSED, 0], np.int32)
    poses = np.tile(np.eye(4), (3, 1, 1))
    poses.setflags(write=False)
    out = np.full((3, 4, 4), 7.0)
    forward_forest(
        topological_order(parent),
        parent,
        np.full(3, FIXED, np.int8),
        np.zeros((3, 3)),
        np.full(3, -1, np.int32),
        np.ones(3),
        np.zeros(3),
        poses,
        np.empty(0),
        out,
    )
    np.testing.assert_array_equal(out[1], np.full((4, 4), 7.0))
    np.testing.assert_array_equal(out[[0, 2]], poses[:2])


def test_a_wrong_type_of_array_is_refused_instead_of_compiled() -> None:
    with pytest.raises(TypeError):
        topological_order(np.array([-1, 0], np.int64))


def test_order_puts_parents_first_for_any_numbering(rng: np.random.Generator) -> None:
    n = 300
    names = rng.permutation(n)
    parent = np.empty(n, np.int32)
    for i in range(n):
        parent[names[i]] = -1 if i < 3 else names[rng.integers(i)]
    order = topological_order(parent)
    assert sorted(order) == list(range(n))
    place = np.argsort(order)
    assert all(parent[row] < 0 or place[parent[row]] < place[row] for row in range(n))


@pytest.mark.parametrize(
    ("parent", "lost"),
    [([1, 0], 2), ([0], 1), ([-1, 2, 3, 1], 3), ([-1, 5], 1), ([-1, -3], 1), ([UNUSED, 0], 1), ([-1, 0], 0), ([], 0)],
)
def test_loops_and_unknown_parents_leave_minus_one_at_the_end(parent: list[int], lost: int) -> None:
    order = topological_order(np.array(parent, np.int32))
    assert np.count_nonzero(order < 0) == lost
    assert (order[len(order) - lost :] == -1).all()
