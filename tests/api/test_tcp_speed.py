"""Speed limit of a tool centre point over TCP: whatever moves the arm, its tool is nowhere faster, tick by tick."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import virtualrobot
from virtualrobot import Client, LimitError, RobotBusyError, WrongStateError
from virtualrobot.motions.motion import Motion
from virtualrobot.robots.robot import Robot

from tests.api.asking import IIWA
from tests.kernels import KernelProcess, Stubs

LIMIT = 0.25
TICK_SECONDS = 0.004
POSTURE = (0.0, 0.6, 0.0, -1.2, 0.0, 0.9, 0.0)


@pytest.fixture
def client(stepped_kernel: KernelProcess, stepped: Stubs) -> Iterator[Client]:
    with virtualrobot.connect(stepped_kernel.address) as client:
        yield client


@pytest.fixture
def arm(client: Client) -> Robot:
    arm = client.load_robot(IIWA, name="arm")
    client.scene.add_tool("rod", arm.flange, tool_center_points={"tip": virtualrobot.pose(0.0, 0.1, 0.3)})
    arm.set_positions(POSTURE)
    return arm


def fastest(client: Client, arm: Robot, motion: Motion) -> float:
    """Return the greatest distance between two ticks over a tick's time (m/s) until a motion has ended."""
    places = [arm.tcp[:3, 3]]
    while not motion.phase.ended:
        client.clock.step(1)
        places.append(arm.tcp[:3, 3])
    return float(np.linalg.norm(np.diff(places, axis=0), axis=1).max() / TICK_SECONDS)


MOTIONS: dict[str, Callable[[Client, Robot], Motion]] = {
    "joints": lambda client, arm: arm.move_joints({"lbr_iiwa_joint_1": 0.5}, wait=False),
    "line": lambda client, arm: arm.move_linear(arm.tcp @ virtualrobot.pose(y=0.3), velocity=0.6, wait=False),
    "joint jog": lambda client, arm: arm.jog_joint("lbr_iiwa_joint_1", 1.0, distance=0.3),
    "jog": lambda client, arm: arm.jog([0.0, 0.0, -1.0], velocity=1.0, distance=0.3),
    "program": lambda client, arm: (
        client.program()
        .move(arm.ptp({"lbr_iiwa_joint_1": 0.3}), zone=0.03)
        .move(arm.ptp({"lbr_iiwa_joint_2": 0.4}))
        .start(wait=False)
    ),
}


@pytest.mark.long
@pytest.mark.parametrize(
    "kind", [pytest.param(kind, marks=[pytest.mark.long] * (kind != "joint jog")) for kind in MOTIONS]
)
def test_no_motion_is_faster(client: Client, arm: Robot, kind: str) -> None:
    """Without the limit each is, else this would say nothing; with it they are not much slower than they may be."""
    before = fastest(client, arm, MOTIONS[kind](client, arm))
    assert before > 1.5 * LIMIT
    arm.set_positions(POSTURE)
    arm.tcp_speed_limit = LIMIT
    assert arm.tcp_speed_limit == arm.state.tcp_speed_limit == LIMIT
    assert 0.9 * LIMIT <= fastest(client, arm, MOTIONS[kind](client, arm)) <= LIMIT


@pytest.mark.long
def test_steps_that_are_appended_keep_it(client: Client, arm: Robot) -> None:
    arm.tcp_speed_limit = LIMIT
    motion = client.program().move(arm.ptp({"lbr_iiwa_joint_1": 0.2}), zone=0.02).start(open=True)
    client.clock.step(10)
    motion.append(client.program().move(arm.ptp({"lbr_iiwa_joint_1": 0.6})), last=True)
    assert fastest(client, arm, motion) <= LIMIT
    np.testing.assert_allclose(arm.positions[0], 0.6, atol=1e-12)


def test_setpoints_of_the_tool_keep_it(client: Client, arm: Robot) -> None:
    """Led at the greatest speed of the stream, and braking from it; a twist at the limit is refused, with both."""
    arm.tcp_speed_limit = 0.1
    refused = r"at 0.1 m/s, and the stream's max_velocity_meters_per_second is 0.0980"
    with pytest.raises(LimitError, match=refused), arm.stream_tool("twist", timeout=10.0) as stream:
        stream.send([0.1, 0.0, 0.0, 0.0, 0.0, 0.0], wait=True)
    client.clock.step(2)
    stream = arm.stream_tool("twist", timeout=10.0)
    places = [arm.tcp[:3, 3]]
    for _ in range(60):
        stream.send([0.0, 0.098, 0.0, 0.0, 0.0, 0.0], wait=True)
        client.clock.step(1)
        places.append(arm.tcp[:3, 3])
    stream.cancel()
    while not stream.motion.phase.ended:
        client.clock.step(1)
        places.append(arm.tcp[:3, 3])
    speeds = np.linalg.norm(np.diff(places, axis=0), axis=1) / TICK_SECONDS
    assert 0.097 <= speeds.max() <= 0.1


def test_what_nobody_can_slow_is_refused(client: Client, arm: Robot) -> None:
    arm.tcp_speed_limit = LIMIT
    with pytest.raises(LimitError, match=r"would go at .* m/s, and its limit is 0.25 m/s"):
        arm.move_trajectory([0.0, 0.5], [POSTURE, (0.6, *POSTURE[1:])], wait=False)
    with pytest.raises(WrongStateError, match=r"has a speed limit of .* m/s, which setpoints"), arm.stream():
        pass
    for limit in (-1.0, np.inf, np.nan):
        with pytest.raises(virtualrobot.InvalidArgumentError):
            arm.tcp_speed_limit = limit
    assert arm.tcp_speed_limit == LIMIT
    arm.move_joints({"lbr_iiwa_joint_1": 0.5}, wait=False)
    client.clock.step(5)
    with pytest.raises(RobotBusyError):
        arm.tcp_speed_limit = 0.0


def test_a_scene_file_keeps_it(client: Client, arm: Robot, tmp_path: Path) -> None:
    arm.tcp_speed_limit = LIMIT
    client.scene.save(tmp_path / "cell.yaml")
    client.scene.clear()
    client.scene.load_scene(tmp_path / "cell.yaml")
    assert client.robots["arm"].tcp_speed_limit == LIMIT
