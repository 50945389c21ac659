"""Configurations through the client: what a robot gets by itself, solving and moving to a named one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, Robot

from tests.api.client.conftest import IIWA

NAMES = {
    f"{shoulder} {elbow} {wrist}"
    for shoulder in ("left", "right")
    for elbow in ("up", "down")
    for wrist in ("noflip", "flip")
}
READY = np.array([0.1, 0.7, -2.6, 0.4, 0.8, -0.3])


@pytest.fixture
def puma(client: Client) -> Robot:
    robot = client.load_robot("model://puma560", name="puma")
    robot.set_positions(READY)
    return robot


def test_a_robot_gets_the_closed_form_where_its_geometry_has_one(client: Client, puma: Robot, tmp_path: Path) -> None:
    assert puma.kinematics == "closed_form"
    assert client.load_robot(IIWA, name="iiwa").kinematics == "arm_angle", "seven joints"
    assert client.load_robot("model://panda", name="panda").kinematics == "chain", "no spherical wrist"
    client.scene.save(tmp_path / "cell.yaml")
    assert "kinematics:" not in (tmp_path / "cell.yaml").read_text(), "what was found is not what was chosen"
    puma.set_kinematics("chain")
    assert puma.kinematics == "chain"
    client.scene.save(tmp_path / "cell.yaml")
    assert "kinematics: chain" in (tmp_path / "cell.yaml").read_text()
    check = puma.set_kinematics(None)
    assert puma.kinematics == "closed_form"
    assert check.inverse_position_error < 1e-9


def test_all_branches_come_by_name_and_the_present_posture_first(puma: Robot) -> None:
    solution = puma.solve_inverse(puma.tcp)
    np.testing.assert_allclose(solution.best, READY, atol=1e-9)
    assert len(solution.solutions) == len(set(solution.configurations)) > 1
    assert {" ".join(name.split()[:3]) for name in solution.configurations} <= NAMES
    for one in solution.solutions:
        np.testing.assert_allclose(puma.solve_forward(one).world_t_tcp, puma.tcp, atol=1e-9)


@pytest.mark.parametrize("model", ["model://puma560", "model://irb120", "model://ur5e", IIWA, "model://panda"])
def test_a_posture_has_the_name_that_its_pose_gives_it(client: Client, model: str, rng: np.random.Generator) -> None:
    arm = client.load_robot(model, name="arm")
    joints = arm.joint_names[: 7 if model in (IIWA, "model://panda") else 6]
    lower, upper = np.clip([(one.lower, one.upper) for one in map(arm.limits.__getitem__, joints)], -3.0, 3.0).T
    names: set[str] = set()
    for _ in range(20):
        q = dict(zip(joints, rng.uniform(lower, upper).tolist(), strict=True))
        solved = arm.solve_forward(q, with_configuration=True)
        found = arm.solve_inverse(solved.world_t_tcp, q)
        here = int(np.abs(found.solutions - list(q.values())).max(axis=1).argmin())
        np.testing.assert_allclose(found.solutions[here], list(q.values()), atol=1e-6)
        assert solved.configuration == found.configurations[here]
        names.add(solved.configuration)
    assert names == {""} if model == "model://panda" else len(names) > 1
    assert arm.solve_forward(q).configuration == "", "it was not asked for"


def test_full_turns_are_in_the_name_of_a_posture(client: Client) -> None:
    arm = client.load_robot("model://ur5e", name="arm")
    q = dict(zip(arm.joint_names, [0.1, -1.2, 1.3, -0.8, 0.9, 0.4], strict=True))
    name = arm.solve_forward(q, with_configuration=True).configuration
    last = arm.joint_names[-1]
    turned = arm.solve_forward({**q, last: q[last] - 2.0 * np.pi}, with_configuration=True).configuration
    assert turned == f"{name} {last}-1"


def test_only_a_named_configuration_is_solved_and_moved_to(puma: Robot) -> None:
    there = puma.tcp
    every = puma.solve_inverse(there)
    other = next(name for name in every.configurations if name.split()[:2] != every.configurations[0].split()[:2])
    only = puma.solve_inverse(there, configuration=other)
    assert only.configurations[0] == other
    puma.move_pose(there, configuration=other)
    np.testing.assert_allclose(puma.positions, only.best, atol=1e-6)
    np.testing.assert_allclose(puma.tcp, there, atol=1e-6)


def test_a_configuration_that_there_is_not_is_refused_with_the_valid_ones(client: Client, puma: Robot) -> None:
    for call in (puma.solve_inverse, puma.move_pose):
        with pytest.raises(virtualrobot.InvalidArgumentError, match="'left up noflip'") as refusal:
            call(puma.tcp, configuration="elbow up")
        assert set(refusal.value.metadata["valid"].split(", ")) == NAMES
    panda = client.load_robot("model://panda", name="panda")
    with pytest.raises(virtualrobot.InvalidArgumentError, match="names none"):
        panda.solve_inverse(panda.tcp, configuration="left up noflip")


def test_joints_and_lines_take_no_configuration(puma: Robot) -> None:
    with pytest.raises(virtualrobot.InvalidArgumentError, match="for a goal that is a pose"):
        puma.ptp({"joint_1": 0.0}, configuration="left up noflip")
    line = puma.linear(puma.tcp @ virtualrobot.pose(z=0.01))
    line._message.linear.goal.configuration = "left up noflip"
    with pytest.raises(virtualrobot.InvalidArgumentError, match="keeps the configuration that it starts in"):
        puma.start(line)


def test_a_configuration_that_does_not_reach_says_which_do(puma: Robot) -> None:
    every = {" ".join(name.split()[:3]) for name in puma.solve_inverse(puma.tcp).configurations}
    missing = NAMES - every
    assert missing, "limits shut out some branch of this posture"
    name = sorted(missing)[0]
    solution = puma.solve_inverse(puma.tcp, configuration=name)
    assert not solution.solved
    assert name in solution.explanation
    with pytest.raises(virtualrobot.LimitError, match="others:"):
        puma.move_pose(puma.tcp, configuration=name)
