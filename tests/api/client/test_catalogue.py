"""Every model that is known by name, on a real kernel: it loads, touches nothing, has limits, and its arm is solved."""

from __future__ import annotations

import numpy as np
import pytest
from virtualrobot import Client, Robot

from tests.tiers import every_fifth
from tests.unit.formats.models import MODELS

POSES = 50

NO_ARM = ("mobile", "legged", "gripper")
"""Kinds without an arm to solve."""

SOLVED_IN_CLOSED_FORM = ("closed_form", "arm_angle")


def reachable(robot: Robot, rng: np.random.Generator) -> dict[str, float]:
    """Return joint positions within limits, drawn evenly; a joint that turns without end goes half a turn."""
    named = {}
    for name in robot.chain_joint_names:
        lower, upper = robot.limits[name].lower, robot.limits[name].upper
        low = -np.pi if lower is None else max(lower, -2.0 * np.pi)
        named[name] = float(rng.uniform(low, np.pi if upper is None else min(upper, 2.0 * np.pi)))
    return named


@pytest.mark.parametrize("name", every_fifth([model.name for model in MODELS.values() if model.installed]))
def test_a_model_is_loaded_touches_nothing_and_its_arm_is_solved(
    client: Client, name: str, rng: np.random.Generator
) -> None:
    model = MODELS[name]
    robot = client.load_robot(f"model://{name}", name="robot")
    arm = robot.chain_joint_names if model.kind not in NO_ARM else []
    assert model.axes == len(arm or robot.joint_names)
    assert all(robot.limits[joint].velocity > 0.0 for joint in robot.joint_names)
    assert not client.collisions.check().pairs
    for posture in robot.postures.values():
        assert not client.collisions.check({"robot": posture}).pairs
    # A base that drives without end has postures that are far away: how those are solved is a matter of its own.
    for _ in range(POSES if arm and model.kind != "mobile_manipulator" else 0):
        pose = robot.solve_forward(reachable(robot, rng)).world_t_tcp
        best = robot.solve_inverse(pose).by_name()
        np.testing.assert_allclose(robot.solve_forward(best).world_t_tcp, pose, atol=2e-6)


@pytest.mark.parametrize("name", every_fifth([model.name for model in MODELS.values() if model.scene]))
def test_an_arm_of_our_own_has_postures_and_where_its_wrist_allows_a_closed_form(client: Client, name: str) -> None:
    robot = client.load_robot(f"model://{name}")
    assert set(robot.postures) == {"zero", "home"}
    numeric = {"crx10ia", "gen3", "xarm7", "cobra600"}
    assert (robot.kinematics in SOLVED_IN_CLOSED_FORM) == (name not in numeric)
    assert all(limits.lower is not None and limits.upper is not None for limits in robot.limits.values())
    if robot.kinematics == "closed_form":
        pose = robot.solve_forward(robot.postures["home"]).world_t_tcp
        solved = robot.solve_inverse(pose)
        assert len(set(solved.configurations)) == len(solved.solutions) >= 2
