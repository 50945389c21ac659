"""Objectives with edges along a path: what they ask for is rounded off, and where the arm cannot go it is nothing."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.motion.cartesian_plan import plan_lin
from virtualrobot_kernel.motion.line import line_between
from virtualrobot_kernel.motion.nullspace import NonsmoothObjective
from virtualrobot_kernel.motion.nullspace_reference import GAIN, nullspace_reference
from virtualrobot_kernel.motion.resolved_rate import TcpKinematics
from virtualrobot_kernel.planning.planned_move import joint_limits
from virtualrobot_kernel.planning.robots import arm_of
from virtualrobot_kernel.planning.solvers import Solvers

from tests.unit.planning.robots import standing

START = np.array([0.2, 0.5, 0.1, -1.5, 0.0, 1.1, 0.0])


@pytest.fixture(scope="module")
def iiwa() -> Iterator[TcpKinematics]:
    solvers = Solvers(Catalog())
    snapshot, node = standing("iiwa")
    yield TcpKinematics(solvers.of(snapshot, arm_of(snapshot, node)), np.eye(4))
    solvers.close()


def edged(q: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the cost |q3 - 0.2| + |q1|, whose gradient jumps."""
    off = np.array([q[0], 0.0, q[2] - 0.2, 0.0, 0.0, 0.0, 0.0])
    return float(np.abs(off).sum()), np.sign(off)


def test_a_line_follows_an_objective_with_edges_and_stays_a_line(iiwa: TcpKinematics) -> None:
    """To 0.01 mm, within limits of velocity and acceleration; the cost at its end is less than without."""
    snapshot, node = standing("iiwa")
    limits, _ = joint_limits(snapshot, node, arm_of(snapshot, node).joint_names)
    goal = iiwa.pose(START)
    goal[:3, 3] += (0.05, 0.2, 0.1)
    line = (goal - iiwa.pose(START))[:3, 3]
    plain = plan_lin(iiwa.kinematics, START, goal, limits)
    wished = plan_lin(iiwa.kinematics, START, goal, limits, objective=NonsmoothObjective(edged))
    assert edged(wished.goal)[0] < edged(plain.goal)[0] - 0.05
    np.testing.assert_allclose(iiwa.pose(wished.goal), goal, atol=1e-6)
    places, velocities, accelerations, *_ = wished.tracks[0].derivatives(np.linspace(0.0, wished.duration, 200))
    for q, velocity, acceleration in zip(places, velocities, accelerations, strict=True):
        off = (iiwa.pose(q) - iiwa.pose(START))[:3, 3]
        assert np.linalg.norm(off - line * (off @ line) / (line @ line)) < 1e-5
        assert (np.abs(velocity) <= limits.velocity * 1.001).all()
        assert (np.abs(acceleration) <= limits.acceleration * 1.01).all()


def test_what_it_gives_is_smooth_and_bounded(iiwa: TcpKinematics) -> None:
    """At most GAIN times what the path itself takes; no step is longer than a smooth curve's of 200 places."""
    goal = iiwa.pose(START)
    goal[:3, 3] += (0.05, 0.2, 0.1)
    line = line_between(iiwa.pose(START), goal)
    motion = nullspace_reference(iiwa.pose, iiwa.jacobian, np.ones(6), line, START, edged)
    given = np.array([motion(u) for u in np.linspace(0.0, 1.0, 1001)])
    needed = np.linalg.norm(np.linalg.lstsq(iiwa.jacobian(START), line.twist(0.0), rcond=None)[0])
    assert 0.01 < np.linalg.norm(given, axis=1).max() < 3.0 * GAIN * needed
    assert np.abs(np.diff(given, axis=0)).max() < 0.02 * np.abs(given).max()


def test_beyond_reach_it_is_nothing(iiwa: TcpKinematics) -> None:
    goal = iiwa.pose(START)
    goal[:3, 3] += (5.0, 0.0, 0.0)
    motion = nullspace_reference(
        iiwa.pose, iiwa.jacobian, np.ones(6), line_between(iiwa.pose(START), goal), START, edged
    )
    assert motion(0.0).any() and not motion(0.9).any() and not motion(1.0).any()
