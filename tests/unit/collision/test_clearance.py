"""How far arms are from things, how that changes with joints, and lines that keep away, by coal."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from virtualrobot_kernel.collision.clearance import near_by
from virtualrobot_kernel.collision.pool import ScenePool
from virtualrobot_kernel.components.catalog import Catalog
from virtualrobot_kernel.motion.nullspace import DISTANCE_RANGE
from virtualrobot_kernel.planning.free_joints import cartesian_tcp
from virtualrobot_kernel.planning.moves import Linear
from virtualrobot_kernel.planning.planned_move import PoseGoal
from virtualrobot_kernel.planning.redundancy import FREE, Preference, Redundancy
from virtualrobot_kernel.planning.robots import arm_of, locked_arm, standing_at, tcp_frame
from virtualrobot_kernel.planning.solvers import Solvers
from virtualrobot_kernel.planning.together import plan_moves
from virtualrobot_kernel.world.commands import CreateNodes
from virtualrobot_kernel.world.figures import Figure, Sphere
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Kind, NodeSpec

from tests.tiers import Draws
from tests.unit.collision.worlds import SHAPES, after, coal_distances, scene_of, with_robots

STARTS = {"iiwa": [0.0, 0.5, 0.0, -1.5, 0.0, 1.1416, 0.0], "panda": [0.0, 0.2, 0.0, -1.9, 0.0, 2.1, 0.785]}
BALLS = {"iiwa": (0.25, -0.27, 0.75), "panda": (0.25, -0.22, 0.6)}
DISTANCE = Redundancy(preference=Preference.DISTANCE)
NEAR_OF = near_by(ScenePool(SHAPES))


@pytest.fixture(scope="module")
def solvers() -> Iterator[Solvers]:
    solvers = Solvers(Catalog())
    yield solvers
    solvers.close()


def beside(kind: str, start: np.ndarray | list[float], ball: tuple[float, float, float]) -> Snapshot:
    """Return a robot whose arm stands somewhere, and a ball of 8 cm."""
    pose = np.eye(4)
    pose[:3, 3] = ball
    spec = NodeSpec("ball", Kind.OBJECT, parent_t_node=pose, figures=(Figure(Sphere(0.08)),))
    snapshot = after(with_robots(kind), CreateNodes((spec,)))
    arm = arm_of(snapshot, snapshot.structure.node(kind))
    return standing_at(snapshot, arm.q_index, np.array(start))


@pytest.mark.parametrize("kind", ["iiwa", "panda"])
def test_gradients_are_those_of_the_distances(kind: str, rng: np.random.Generator, draws: Draws) -> None:
    """By differences over 2e-6 rad; a nearest point that jumps just there would spoil one, so the middle one counts."""
    off: list[float] = []
    for _ in range(draws(15)):
        snapshot = beside(kind, np.array(STARTS[kind]) + rng.uniform(-0.2, 0.2, 7), BALLS[kind])
        arm = arm_of(snapshot, snapshot.structure.node(kind))
        near, q = NEAR_OF(snapshot, arm), snapshot.state.q[arm.q_index]
        distances, gradients = near(q)
        assert gradients.shape == (len(distances), 7)
        assert (np.diff(distances) >= 0.0).all() and distances[-1] <= DISTANCE_RANGE
        nearest = snapshot.structure.node("ball").uid
        first = scene_of(snapshot).distances(
            [node.uid for node in snapshot.structure.below(snapshot.structure.node(kind).uid)], [nearest], 0.0
        )
        assert distances[0] == pytest.approx(first[0].distance, abs=1e-12)
        if distances[0] == 0.0:
            assert not gradients[0].any()
            continue
        steps = 1e-6 * np.eye(7)
        differences = [(near(q + step)[0][0] - near(q - step)[0][0]) / 2e-6 for step in steps]
        off.append(float(np.abs(gradients[0] - differences).max()))
    assert np.median(off) < 1e-4


def test_a_locked_joint_is_where_it_is_locked() -> None:
    snapshot = beside("iiwa", STARTS["iiwa"], BALLS["iiwa"])
    arm = arm_of(snapshot, snapshot.structure.node("iiwa"))
    elsewhere = locked_arm(arm, {"lbr_iiwa_joint_1": 0.4})
    q = np.array(STARTS["iiwa"])
    locked, gradients = NEAR_OF(snapshot, elsewhere)(q[1:])
    free, _ = NEAR_OF(snapshot, arm)(np.array([0.4, *q[1:]]))
    np.testing.assert_allclose(locked, free, atol=1e-12)
    assert gradients.shape == (len(locked), 6)


def test_far_from_everything_nothing_is_near() -> None:
    snapshot = beside("iiwa", STARTS["iiwa"], (5.0, 0.0, 0.0))
    near = NEAR_OF(snapshot, arm_of(snapshot, snapshot.structure.node("iiwa")))
    distances, gradients = near(np.array(STARTS["iiwa"]))
    assert distances.shape == (0,) and gradients.shape == (0, 7)


@pytest.mark.parametrize("kind", ["iiwa", "panda"])
def test_a_line_beside_a_ball_keeps_away_and_straight(solvers: Solvers, kind: str) -> None:
    """The least distance of 40 samples by coal: more by 4 cm; the tool is on the line to 0.01 mm and does not turn."""
    snapshot = beside(kind, STARTS[kind], BALLS[kind])
    robot = snapshot.structure.node(kind)
    arm, ball = arm_of(snapshot, robot), snapshot.structure.node("ball").uid
    start = tcp_frame(snapshot, robot)
    goal = start.copy()
    goal[:3, 3] += (0.05, -0.2, 0.1)
    along = (goal - start)[:3, 3]
    pairs = [(min(uid, ball), max(uid, ball)) for uid in snapshot.structure.robots[robot.uid].links]
    tcp = cartesian_tcp(snapshot, arm, solvers.of, FREE)
    base_t_start = tcp.pose(snapshot.state.q[arm.q_index])
    least = []
    for redundancy in (FREE, DISTANCE):
        (planned,) = plan_moves(snapshot, [Linear(kind, PoseGoal(goal), redundancy=redundancy)], solvers.of, NEAR_OF)
        path = planned.plan.tracks[0].path
        told = []
        for q in map(path.evaluate, np.linspace(path.start, path.end, 40)):
            scene = scene_of(standing_at(snapshot, arm.q_index, q))
            told.append(min(coal_distances(scene, [pair for pair in pairs if pair[0] in scene.bodies.elements])))
            way = tcp.pose(q)[:3, 3] - base_t_start[:3, 3]
            assert np.linalg.norm(way - along * (way @ along) / (along @ along)) < 1e-5
            np.testing.assert_allclose(tcp.pose(q)[:3, :3], base_t_start[:3, :3], atol=1e-6)
        least.append(min(told))
    assert least[1] > max(least[0], 0.0) + 0.04
