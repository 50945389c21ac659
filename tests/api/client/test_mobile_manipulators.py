"""Mobile manipulators over TCP: base and arm move together in time, and bring the tool to a pose together."""

from __future__ import annotations

import math

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client
from virtualrobot.errors import InvalidArgumentError, UnknownNameError, UnreachableError, WrongStateError
from virtualrobot.motions.state import Phase
from virtualrobot.robots.robot import Robot

from tests.api.client.test_crafts import place


@pytest.fixture
def frankie(client: Client) -> Robot:
    """Return QUT's Frankie, a Panda on a base of two wheels; time goes on by steps."""
    client.clock.set_stepped()
    robot = client.load_robot("model://frankie", base="planar")
    robot.set_positions({"panda_joint2": -0.3, "panda_joint4": -2.0, "panda_joint6": 1.7})
    return robot


def test_base_and_arm_begin_and_end_together(client: Client, frankie: Robot) -> None:
    """Half way of the wheels is half way of the arm, and the base is on its arc."""
    goals = {"panda_joint1": 0.8, "panda_joint4": -1.4}
    way = frankie.way([[0.6, 0.0, 0.5]], joints=goals)
    plan = way.plan(sample_time=0.02).robots["frankie"]
    motion = way.start(wait=False)
    shares = []
    for _ in range(8):
        client.clock.step(60)
        heading = place(client, "frankie.panda_base_arm")[2]
        joints = dict(zip(frankie.coordinates, frankie.positions.tolist(), strict=True))
        shares.append((heading / 0.5, joints["panda_joint1"] / 0.8, (joints["panda_joint4"] + 2.0) / 0.6))
    np.testing.assert_allclose([row[1:] for row in shares], [[row[0]] * 2 for row in shares], atol=1e-6)
    assert 0.0 < shares[0][0] < shares[-1][0]
    client.clock.step(4000)
    assert motion.state.phase is Phase.SUCCEEDED
    ends = [0.6 / 0.5 * math.sin(0.5), 0.6 / 0.5 * (1.0 - math.cos(0.5)), 0.5]
    np.testing.assert_allclose(place(client, "frankie.panda_base_arm"), ends, atol=1e-6)
    np.testing.assert_allclose(frankie.tcp, plan.world_t_tcp[-1], atol=1e-6)


def test_joints_that_cannot_go_along_with_a_way_are_named(frankie: Robot) -> None:
    with pytest.raises(UnknownNameError, match="no joint of 'frankie' named 'panda_joint9'; did you mean"):
        frankie.way([[0.5, 0.0, 0.0]], joints={"panda_joint9": 1.0})
    for name in ("left_wheel", "base/x"):
        with pytest.raises(InvalidArgumentError, match=f"'{name}' of 'frankie' is moved by .*panda_joint1"):
            frankie.way_to(0.5, 0.0, joints={name: 1.0})


def test_a_pose_out_of_reach_is_reached_by_base_and_arm(client: Client, frankie: Robot) -> None:
    goal = virtualrobot.pose(2.0, 1.2, 0.7, roll=math.pi)
    assert not frankie.solve_inverse(goal).solved
    way = frankie.way_to_reach(goal)
    assert way.length > 1.0
    motion = way.start(wait=False)
    client.clock.step(10_000)
    assert motion.state.phase is Phase.SUCCEEDED
    np.testing.assert_allclose(frankie.tcp, goal, atol=1e-5)
    # From here the arm alone is enough.
    before = place(client, "frankie.panda_base_arm")
    joints = dict(zip(frankie.coordinates, frankie.positions.tolist(), strict=True))
    near = frankie.solve_forward({"panda_joint1": joints["panda_joint1"] + 0.1}).world_t_tcp
    way = frankie.way_to_reach(near)
    assert len(way.parts) == 0
    way.start(wait=False)
    client.clock.step(3000)
    np.testing.assert_allclose(frankie.tcp, near, atol=1e-5)
    np.testing.assert_array_equal(place(client, "frankie.panda_base_arm"), before)
    with pytest.raises(UnreachableError, match="'frankie' reaches the pose from no place"):
        frankie.way_to_reach(virtualrobot.pose(1.0, 0.0, 3.0))


@pytest.mark.long
def test_it_goes_to_the_side_from_which_nothing_is_touched(client: Client, frankie: Robot) -> None:
    """A wall stands between it and the nearest places: it goes to another one, or says so."""
    goal = virtualrobot.pose(1.6, 0.0, 0.7, roll=math.pi)
    client.scene.add_object("table", virtualrobot.box(0.3, 0.3, 0.5), pose=virtualrobot.pose(x=0.95, z=0.25))
    way = frankie.way_to_reach(goal)
    assert way.check().ok
    way.start(wait=False)
    client.clock.step(10_000)
    np.testing.assert_allclose(frankie.tcp, goal, atol=1e-5)
    assert not client.collisions.check()


@pytest.mark.long
@pytest.mark.parametrize("model", ["frankie", "frankie_omni", "ridgeback"])
def test_without_a_base_joint_they_move_as_their_files_have_them(client: Client, model: str) -> None:
    client.clock.set_stepped()
    robot = client.load_robot(f"model://{model}")
    assert not any("wheel" in name for name in robot.joint_names)
    slides = [name for name, kind in robot.joint_types.items() if kind == "prismatic" and "finger" not in name]
    robot.move_joints({slides[0]: 0.5}, wait=False)
    client.clock.step(3000)
    assert robot.state.positions[robot.joint_names.index(slides[0])] == pytest.approx(0.5)
    with pytest.raises(WrongStateError, match="is no craft"):
        robot.way_to(1.0, 0.0)
