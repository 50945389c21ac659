"""Redundant arms through the client: locked joints, arm angles, preferences, at poses and on paths."""

from __future__ import annotations

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Robot
from virtualrobot.motions.moves import Move

from tests.api.client.conftest import IIWA

READY = dict(zip([f"panda_joint{i}" for i in range(1, 8)], [-0.2, 0.9, -0.6, -1.8, 1.3, 2.2, 0.6], strict=True))


@pytest.fixture
def panda(client: Client) -> Robot:
    robot = client.load_robot("model://panda", name="panda")
    robot.set_positions(READY)
    return robot


@pytest.fixture
def iiwa(client: Client) -> Robot:
    robot = client.load_robot(IIWA, name="iiwa")
    robot.set_positions([0.2, 0.6, 0.1, -1.2, 0.3, 0.9, 0.4])
    return robot


def test_a_locked_joint_gives_all_branches_and_stands_there_after_a_move(panda: Robot) -> None:
    solution = panda.solve_inverse(panda.tcp, lock=["panda_joint7"])
    assert len(solution.solutions) > 1
    np.testing.assert_allclose(solution.best, list(READY.values()), atol=1e-6)
    assert (solution.solutions[:, 6] == READY["panda_joint7"]).all()
    for q in solution.solutions:
        np.testing.assert_allclose(panda.solve_forward(q).world_t_tcp, panda.tcp, atol=1e-8)
    there = panda.tcp
    panda.move_pose(there, lock={"panda_joint7": 0.9})
    assert panda.positions[6] == pytest.approx(0.9)
    np.testing.assert_allclose(panda.tcp, there, atol=1e-6)


def test_a_line_and_an_arc_keep_a_locked_joint(panda: Robot) -> None:
    before = panda.positions
    panda.move_linear(panda.tcp @ virtualrobot.pose(z=0.04), lock=["panda_joint1"])
    goal = panda.tcp @ virtualrobot.pose(x=0.04)
    panda.move_circular(via=panda.tcp[:3, 3] + (0.02, 0.0, 0.02), goal=goal, lock={"panda_joint1": before[0]})
    np.testing.assert_allclose(panda.tcp, goal, atol=1e-6)
    assert panda.positions[0] == before[0]
    with pytest.raises(virtualrobot.InvalidArgumentError, match=r"locked at 0.5, but it is at -0.2;"):
        panda.move_linear(panda.tcp @ virtualrobot.pose(z=-0.04), lock={"panda_joint1": 0.5})


def test_an_arm_angle_is_told_and_asked_for(iiwa: Robot) -> None:
    here = iiwa.solve_inverse(iiwa.tcp)
    assert len(here.arm_angles) == len(here.solutions) > 1
    there, angle = iiwa.tcp, here.arm_angles[0] + 0.4
    turned = iiwa.solve_inverse(there, arm_angle=angle)
    assert turned.arm_angles[0] == pytest.approx(angle)
    iiwa.move_pose(there, arm_angle=angle)
    np.testing.assert_allclose(iiwa.positions, turned.best, atol=1e-6)
    np.testing.assert_allclose(iiwa.tcp, there, atol=1e-6)


@pytest.mark.long
def test_a_preference_is_followed_at_a_pose_and_along_a_line(iiwa: Robot) -> None:
    wanted = dict(zip(iiwa.joint_names, iiwa.positions.tolist(), strict=True))
    there = iiwa.tcp
    iiwa.move_pose(there, arm_angle=iiwa.solve_inverse(there).arm_angles[0] + 0.5)
    back = iiwa.solve_inverse(there, prefer=wanted)
    np.testing.assert_allclose(back.best, list(wanted.values()), atol=2e-3)
    start = iiwa.positions
    goal = iiwa.tcp @ virtualrobot.pose(z=-0.15)
    iiwa.move_linear(goal)
    plain = iiwa.positions
    iiwa.set_positions(start)
    iiwa.move_linear(goal, prefer=wanted)
    np.testing.assert_allclose(iiwa.tcp, goal, atol=1e-6)
    target = np.array(list(wanted.values()))
    assert np.linalg.norm(iiwa.positions - target) < np.linalg.norm(plain - target)
    for prefer in ("limits", "manipulability"):
        assert iiwa.solve_inverse(goal, prefer=prefer).solved


def least_on_the_way(client: Client, iiwa: Robot, move: Move) -> float:
    """Return the least distance of the arm to the ball by MeasureDistances, at 25 samples of a plan."""
    told = iiwa.plan(move).robots["iiwa"]
    chosen = told.positions[np.linspace(0, len(told.positions) - 1, 25).astype(int)]
    at = [{"iiwa": dict(zip(told.joint_names, q.tolist(), strict=True))} for q in chosen]
    return min(client.collisions.distance("iiwa", to=["ball"], configurations=one).distance for one in at)


@pytest.mark.long
def test_an_arm_stays_away_from_a_ball(client: Client, iiwa: Robot) -> None:
    """At a pose, along a line, an arc and a spline: the least distance is greater with the wish than without."""
    start = [0.0, 0.5, 0.0, -1.5, 0.0, 1.1416, 0.0]
    iiwa.set_positions(start)
    client.scene.add_object("ball", virtualrobot.sphere(0.08), pose=virtualrobot.pose(0.25, -0.27, 0.75))

    def distance(q: np.ndarray) -> float:
        at = {"iiwa": dict(zip(iiwa.joint_names, q.tolist(), strict=True))}
        return client.collisions.distance("iiwa", to=["ball"], configurations=at).distance

    plain, better = iiwa.solve_inverse(iiwa.tcp), iiwa.solve_inverse(iiwa.tcp, prefer="distance")
    assert distance(better.best) > distance(plain.best) + 0.1
    np.testing.assert_allclose(iiwa.solve_forward(better.best).world_t_tcp, iiwa.tcp, atol=1e-8)
    goal, via = iiwa.tcp, iiwa.tcp
    goal[:3, 3] += (0.05, -0.2, 0.1)
    via[:3, 3] += (0.05, -0.1, 0.08)

    def moves(prefer: str | None) -> list[Move]:
        arc = iiwa.circular(via[:3, 3], goal, prefer=prefer)
        return [iiwa.linear(goal, prefer=prefer), arc, iiwa.spline([via, goal], prefer=prefer)]

    for plain_move, wished in zip(moves(None), moves("distance"), strict=True):
        far = least_on_the_way(client, iiwa, wished)
        assert far > 0.05 and far > least_on_the_way(client, iiwa, plain_move) + 0.02
    iiwa.move_linear(goal, prefer="distance")
    np.testing.assert_allclose(iiwa.tcp, goal, atol=1e-6)


@pytest.mark.parametrize(
    ("wish", "words"),
    [
        ({"lock": "panda_joint7"}, "lock is 'panda_joint7'; it must be a dictionary"),
        ({"lock": ["panda_joint8"]}, "there is no joint 'panda_joint8' to lock"),
        ({"lock": {"panda_joint8": 0.0}}, "did you mean 'panda_joint7'"),
        ({"lock": {"panda_joint7": float("nan")}}, "locked_joints"),
        ({"lock": {"panda_joint7": 9.0}}, "cannot be locked at 9; its limits are"),
        ({"arm_angle": 0.3}, "the arm angle 0.3 cannot be given"),
        ({"arm_angle": float("inf")}, "redundancy.arm_angle_radians must be a finite number"),
        ({"prefer": "speed"}, "prefer is 'speed'"),
        ({"prefer": {}}, "preference is POSTURE, but posture is empty"),
        ({"prefer": {"panda_joint8": 0.0}}, "panda_joint8"),
        ({"arm_angle": 0.3, "prefer": "limits"}, "give one"),
    ],
    ids=str,
)
def test_wishes_that_make_no_sense_are_refused(panda: Robot, wish: dict, words: str) -> None:
    for call in (panda.solve_inverse, panda.move_pose):
        with pytest.raises(virtualrobot.VirtualRobotError, match=words):
            call(panda.tcp, **wish)


def test_moves_to_joints_take_no_wish(panda: Robot) -> None:
    with pytest.raises(virtualrobot.InvalidArgumentError, match="redundancy is for goals that are poses"):
        panda.start(panda.ptp(READY, lock={"panda_joint7": 0.6}))
    line = panda.linear(panda.tcp @ virtualrobot.pose(z=0.01))
    line._message.redundancy.arm_angle_radians = 0.2
    with pytest.raises(virtualrobot.InvalidArgumentError, match="for goals of point-to-point moves"):
        panda.start(line)
