"""Every model that is known by name, on a real kernel: it loads, touches nothing, has limits, and its arm is solved."""

from __future__ import annotations

import re

import numpy as np
import pytest
from virtualrobot import Client, Robot

from tests.tiers import Draws, every_fifth
from tests.unit.formats.models import MODELS

POSES = 50

ALSO_IN_PACKAGES = {
    **{name: f"{name}_meshes" for name in ("ur5e", "ur3e", "ur5", "ur10e", "irb120", "ur3", "ur10", "xarm7")},
    "irb4600_40_255": "irb4600_meshes",
    "panda_arm": "panda",
}
"""Arms of our own, and the models of packages that they are compared with."""

OTHER_SPEEDS = {"irb4600_40_255", "ur3", "ur10"}
"""Arms whose models in packages have other speeds than the data sheets: 150, and 124 degrees/s for all joints."""

FRAMES = {"panda": ("panda_link0", "panda_link8"), "xarm7_meshes": ("link_base", "link7")}
"""Links of models of packages that are the frames of the controller and of the flange; of others `base` and `tool0`."""

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


TOOLS = [name for name, model in MODELS.items() if model.kind == "gripper" and not model.axes]
ARMS = [name for name, model in MODELS.items() if model.scene and model.kind not in NO_ARM]
ROBOTS = [name for name, model in MODELS.items() if model.installed and name not in TOOLS]


@pytest.mark.parametrize("name", every_fifth(ROBOTS))
def test_a_model_is_loaded_touches_nothing_and_its_arm_is_solved(
    client: Client, name: str, rng: np.random.Generator, draws: Draws
) -> None:
    model = MODELS[name]
    robot = client.load_robot(f"model://{name}", name="robot")
    arm = robot.chain_joint_names if model.kind not in NO_ARM else []
    # Legs of a walking machine may be robots of their own, and two arms on a torso are no chain.
    whole = sum(len(one.joint_names) for one in client.robots())
    assert model.axes in (len(arm), whole)
    assert all(robot.limits[joint].velocity > 0.0 for joint in robot.joint_names)
    assert not client.collisions.check().pairs
    for posture in robot.postures.values():
        assert not client.collisions.check({"robot": posture}).pairs
    # A base that drives without end has postures that are far away: how those are solved is a matter of its own.
    for _ in range(draws(POSES) if arm and model.kind != "mobile_manipulator" else 0):
        pose = robot.solve_forward(reachable(robot, rng)).world_t_tcp
        best = robot.solve_inverse(pose).by_name()
        np.testing.assert_allclose(robot.solve_forward(best).world_t_tcp, pose, atol=2e-6)


@pytest.mark.parametrize("name", every_fifth(ARMS))
def test_an_arm_of_our_own_has_postures_and_where_its_wrist_allows_a_closed_form(client: Client, name: str) -> None:
    robot = client.load_robot(f"model://{name}")
    assert set(robot.postures) == {"zero", "home"}
    numeric = {"crx10ia", "gen3", "xarm7", "cobra600", "panda_arm"}
    assert (robot.kinematics in SOLVED_IN_CLOSED_FORM) == (name not in numeric)
    assert all(limits.lower is not None and limits.upper is not None for limits in robot.limits.values())
    if robot.kinematics == "closed_form":
        pose = robot.solve_forward(robot.postures["home"]).world_t_tcp
        solved = robot.solve_inverse(pose)
        # The A255 has one posture there: the other elbow needs +90 deg of a joint that ends at 0, its back 180 of 175.
        assert len(set(solved.configurations)) == len(solved.solutions) >= (1 if name == "a255" else 2)


@pytest.mark.parametrize("ours", every_fifth(ALSO_IN_PACKAGES))
def test_an_arm_of_our_own_moves_as_the_model_of_a_package_does(
    client: Client, ours: str, rng: np.random.Generator
) -> None:
    """Flange in the frame that the controller shows, `tool0` in `base` of ROS (REP 199), to the digits of the files."""
    theirs = ALSO_IN_PACKAGES[ours]
    if not MODELS[theirs].installed:
        pytest.skip(MODELS[theirs].how_to_install)
    own, other = client.load_robot(f"model://{ours}"), client.load_robot(f"model://{theirs}")
    base, tool = FRAMES.get(theirs, ("base", "tool0"))
    for _ in range(10):
        q = np.clip(list(reachable(own, rng).values()), -3.0, 3.0)
        links = other.solve_forward(dict(zip(other.chain_joint_names, q, strict=True))).world_t_link
        expected = np.linalg.inv(links[f"{theirs}.{base}"]) @ links[f"{theirs}.{tool}"]
        found = own.solve_forward(dict(zip(own.chain_joint_names, q, strict=True))).world_t_tcp
        np.testing.assert_allclose(found, expected, atol=5e-5)
    if ours in OTHER_SPEEDS:
        return
    for mine, name in zip(own.limits.values(), other.chain_joint_names, strict=True):
        assert mine.velocity == pytest.approx(other.limits[name].velocity, abs=2e-3)


@pytest.mark.parametrize("name", ["robotiq_2f_85", "robotiq_2f_140", "wsg50_110", "franka_hand"])
def test_a_gripper_is_open_by_the_stroke_that_it_tells_and_its_tool_closes_it(client: Client, name: str) -> None:
    gripper = client.load_robot(f"model://{name}")
    told = re.search(r"stroke of (\d+) mm", MODELS[name].description)
    assert told
    tool = gripper.tool()
    assert (list(tool.states), tool.state, list(tool.tool_center_points)) == (["open", "closed"], "open", ["tcp"])
    links = gripper.solve_forward().world_t_link
    width = links[f"{name}.left_finger"][1, 3] - links[f"{name}.right_finger"][1, 3]
    assert width == pytest.approx(int(told[1]) / 1000.0)
    tool.close()
    assert gripper.positions == pytest.approx([0.0], abs=1e-9)
    assert not client.collisions.check().pairs


@pytest.mark.parametrize("name", TOOLS)
def test_cups_and_magnets_that_are_loaded_at_a_flange_are_the_arms_tool(client: Client, name: str) -> None:
    arm = client.load_robot("model://ur5e", name="arm")
    flange = arm.tcp
    client.scene.load(f"model://{name}", parent="arm.flange", name="tool")
    tool = arm.tool()
    assert (arm.tools, list(tool.states), tool.state) == (["tool"], ["off", "on"], "off")
    tool.set("on")
    assert next(state for state in arm.watch() if state.tool_states["tool"] == "on")
    along = np.linalg.inv(flange) @ arm.tcp
    assert along[2, 3] == pytest.approx({"vacuum_cup": 0.06, "vacuum_gripper": 0.06, "magnet_gripper": 0.05}[name])
    assert len(tool.tool_center_points) == (5 if name == "vacuum_gripper" else 1)
    assert not client.collisions.check().pairs
