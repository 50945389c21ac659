"""Joints that stand still: what is left of an arm, all its solutions, and paths that keep them where they are."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.errors import KernelError, LimitError, UnknownNameError
from virtualrobot_kernel.planning.extract import lock_coordinates
from virtualrobot_kernel.planning.free_joints import solve_inverse
from virtualrobot_kernel.planning.moves import Linear, PointToPoint
from virtualrobot_kernel.planning.planned_move import PoseGoal
from virtualrobot_kernel.planning.redundancy import Redundancy
from virtualrobot_kernel.planning.robots import arm_of, locked_arm, tcp_frame, tip_of
from virtualrobot_kernel.planning.solvers import PASSING_ARMS, Solvers
from virtualrobot_kernel.planning.together import joints_of
from virtualrobot_kernel.world.commands import StartMotion
from virtualrobot_sdk.kinematics import PRISMATIC, REVOLUTE, SerialChain
from virtualrobot_sdk.reference import chain_frames, tip_pose
from virtualrobot_sdk.testing.branches import all_solutions, geometric_jacobian, same

from tests.unit.planning.starts import start_of

from .robots import standing

READY = dict(zip([f"panda_joint{i}" for i in range(1, 8)], [0.1, -0.5, 0.2, -2.0, 0.1, 1.7, 0.6], strict=True))
POSES = 25


@pytest.fixture(scope="module")
def solvers() -> Iterator[Solvers]:
    solvers = Solvers(Catalog())
    yield solvers
    solvers.close()


def goal_of(started: StartMotion) -> np.ndarray:
    """Return where the only plan of a motion ends."""
    plan = started.program.stages[0].plan
    assert plan is not None
    return plan.goal


def random_chain(rng: np.random.Generator) -> SerialChain:
    """Return a chain of nine joints that follow seven coordinates, some of them sliding."""
    n, k = 9, 7
    poses = np.tile(np.eye(4), (n + 1, 1, 1))
    for pose in poses:
        pose[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        pose[:3, :3] *= np.linalg.det(pose[:3, :3])
        pose[:3, 3] = rng.normal(size=3)
    axis = rng.normal(size=(n, 3))
    return SerialChain(
        poses[:n],
        axis / np.linalg.norm(axis, axis=1, keepdims=True),
        rng.choice([REVOLUTE, PRISMATIC], n).astype(np.int8),
        np.array([0, 1, 2, 3, 4, 5, 6, 2, 5], np.int32),
        rng.uniform(-2.0, 2.0, n),
        rng.normal(size=n),
        poses[n],
        np.full(k, -3.0),
        np.full(k, 3.0),
        tuple("abcdefg"),
    )


def near_singular(chain: SerialChain, q: np.ndarray) -> bool:
    """Return whether the search, which meets a pose to 1e-9, may tell its posture less well than to 1e-5."""
    jacobian = geometric_jacobian(chain, chain_frames(chain, q[None]))[0]
    return bool(np.linalg.svd(jacobian, compute_uv=False)[-1] < 1e-4)


def test_a_chain_with_locked_coordinates_is_the_chain_there(rng: np.random.Generator) -> None:
    for _ in range(50):
        chain = random_chain(rng)
        q = rng.uniform(-3.0, 3.0, 7)
        locked = rng.choice(7, rng.integers(1, 7), replace=False)
        reduced, free = lock_coordinates(chain, {int(i): float(q[i]) for i in locked})
        assert sorted([*free, *locked]) == list(range(7))
        assert reduced.joint_names == tuple(chain.joint_names[i] for i in free)
        np.testing.assert_allclose(tip_pose(reduced, q[free]), tip_pose(chain, q), atol=1e-12)


@pytest.mark.long
def test_the_panda_with_joint_7_locked_has_all_its_solutions_in_closed_form(
    solvers: Solvers, rng: np.random.Generator
) -> None:
    """Against Newton's method from 256 random starts on the reference; both ways."""
    snapshot, panda = standing("panda", READY)
    arm = arm_of(snapshot, panda)
    chain = arm.serial()
    known = 0
    for _ in range(POSES):
        q = rng.uniform(chain.lower, chain.upper)
        wish = Redundancy({"panda_joint7": q[6]})
        reduced = locked_arm(arm, wish.locked_joints)
        assert solvers.of(snapshot, reduced).running.mean_seconds > 0.0
        np.testing.assert_allclose(tip_of(snapshot, reduced)(q[:6]), tip_of(snapshot, arm)(q), atol=1e-12)
        world_t_tcp = snapshot.world_t(arm.base) @ tip_of(snapshot, arm)(q)
        world_t_tcp = world_t_tcp @ np.linalg.inv(snapshot.world_t(arm.tip)) @ tcp_frame(snapshot, panda)
        seed = dict(zip(chain.joint_names, q.tolist(), strict=True))
        told, result = solve_inverse(snapshot, panda, world_t_tcp, seed, solvers.of, redundancy=wish)
        assert told.joint_names == chain.joint_names
        if result.reason or near_singular(reduced.serial(), q[:6]):
            continue
        np.testing.assert_allclose(result.solutions[0], q, atol=1e-6)
        assert (result.solutions[:, 6] == q[6]).all()
        for solution in result.solutions:
            np.testing.assert_allclose(tip_of(snapshot, arm)(solution), tip_of(snapshot, arm)(q), atol=1e-9)
        others = all_solutions(reduced.serial(), tip_of(snapshot, arm)(q), rng)
        known += len(others)
        for other in others:
            found = any(same(reduced.serial(), other, one[:6]) for one in result.solutions)
            assert found or near_singular(reduced.serial(), other), (q.tolist(), other.tolist())
    assert known > POSES, "the search itself must find more than the posture that it was given"


def test_the_nine_axis_arm_is_configured_by_locking_joints(solvers: Solvers, rng: np.random.Generator) -> None:
    """Whole it is solved numerically at every reachable pose; without rail and lift by its arm angle."""
    snapshot, node = standing("nine_axis", {"joint_4": 0.8})
    arm = arm_of(snapshot, node)
    chain, tip = arm.serial(), tip_of(snapshot, arm)
    for _ in range(100):
        target = snapshot.world_t(arm.base) @ tip(rng.uniform(chain.lower, chain.upper))
        _, result = solve_inverse(snapshot, node, target, {}, solvers.of)
        assert len(result.solutions), result.reason
        reached = tip(result.solutions[0])
        np.testing.assert_allclose(snapshot.world_t(arm.base) @ reached, target, atol=1e-8)
        q = rng.uniform(chain.lower, chain.upper)
        wish = Redundancy({"rail": q[0], "lift": q[1]}, arm_angle=0.3)
        _, result = solve_inverse(snapshot, node, snapshot.world_t(arm.base) @ tip(q), {}, solvers.of, redundancy=wish)
        for one, angle in zip(result.solutions, result.arm_angles, strict=True):
            np.testing.assert_allclose(tip(one), tip(q), atol=1e-9)
            assert (one[0], one[1], round(angle, 9)) == (q[0], q[1], 0.3)


def test_components_of_locked_arms_are_kept_and_the_oldest_are_dropped(solvers: Solvers) -> None:
    snapshot, panda = standing("panda", READY)
    arm = arm_of(snapshot, panda)
    first = solvers.of(snapshot, locked_arm(arm, {"panda_joint7": 0.0}))
    assert solvers.of(snapshot, locked_arm(arm, {"panda_joint7": 0.0})) is first
    for i in range(PASSING_ARMS):
        solvers.of(snapshot, locked_arm(arm, {"panda_joint7": 1e-3 * (i + 1)}))
    assert solvers.of(snapshot, locked_arm(arm, {"panda_joint7": 0.0})) is not first


@pytest.mark.parametrize(
    ("locked", "error", "words"),
    [
        ({"panda_joint77": 0.0}, UnknownNameError, "did you mean 'panda_joint7'"),
        ({"panda_finger_joint1": 0.0}, UnknownNameError, "joint that moves the flange of 'panda'"),
        ({"panda_joint4": 0.5}, LimitError, "cannot be locked at 0.5; its limits are -3.1416 to 0"),
        (dict.fromkeys(READY, 0.0), KernelError, "leave at least one free"),
    ],
)
def test_what_cannot_be_locked_is_refused(locked: dict[str, float], error: type[KernelError], words: str) -> None:
    snapshot, panda = standing("panda", READY)
    with pytest.raises(error, match=words):
        locked_arm(arm_of(snapshot, panda), locked)


def test_a_line_keeps_locked_joints_where_they_are(solvers: Solvers) -> None:
    snapshot, panda = standing("panda", READY)
    goal = tcp_frame(snapshot, panda).copy()
    goal[:3, 3] += (-0.05, 0.04, 0.06)
    move = Linear("panda", PoseGoal(goal), redundancy=Redundancy({"panda_joint3": READY["panda_joint3"]}))
    assert "panda_joint3" not in {name for _, name in joints_of(snapshot, [move])}
    started = start_of(snapshot, [move], solvers.of)
    free = [name for name in READY if name != "panda_joint3"]
    assert started.joints == tuple(("panda", name) for name in free)
    end = standing("panda", {**READY, **dict(zip(free, goal_of(started).tolist(), strict=True))})
    np.testing.assert_allclose(tcp_frame(*end), goal, atol=1e-6)


def test_a_path_locks_joints_only_where_they_are(solvers: Solvers) -> None:
    snapshot, panda = standing("panda", READY)
    goal = PoseGoal(tcp_frame(snapshot, panda))
    with pytest.raises(KernelError, match=r"'panda_joint3' of 'panda' is locked at 0.3, but it is at 0.2;"):
        start_of(snapshot, [Linear("panda", goal, redundancy=Redundancy({"panda_joint3": 0.3}))], solvers.of)
    with pytest.raises(KernelError, match=r"the arm angle 0.5 is for goals of point-to-point moves"):
        start_of(snapshot, [Linear("panda", goal, redundancy=Redundancy(arm_angle=0.5))], solvers.of)
    started = start_of(
        snapshot, [PointToPoint("panda", goal, redundancy=Redundancy({"panda_joint3": 0.3}))], solvers.of
    )
    assert dict(zip(started.joints, goal_of(started), strict=True))["panda", "panda_joint3"] == 0.3


def test_an_arm_angle_needs_an_arm_that_has_one(solvers: Solvers) -> None:
    snapshot, panda = standing("panda", READY)
    for locked in ({}, {"panda_joint7": 0.6}):
        with pytest.raises(KernelError, match=r"arm angle 0.5 cannot be given|knows no arm angle"):
            solve_inverse(
                snapshot, panda, tcp_frame(snapshot, panda), {}, solvers.of, redundancy=Redundancy(locked, 0.5)
            )
