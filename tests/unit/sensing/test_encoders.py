"""Encoders against the positions that joints are told to have."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError, Reason, UnknownNameError
from virtualrobot_kernel.sensing.motion_content import EncoderContent
from virtualrobot_kernel.sensing.motion_reader import MotionReader
from virtualrobot_kernel.sensing.reading import Moment
from virtualrobot_kernel.world.commands import CreateNodes, UpdateNode
from virtualrobot_kernel.world.sensing import Encoders, MotionSensor, NoiseModel
from virtualrobot_kernel.world.structure import Joint, JointType, Kind, LinkData, NodeSpec

from tests.unit.sensing.moments import moment_at, snapshot_at
from tests.unit.world.builders import TICK, Change, after, arm, empty, link

STEP = 2 * np.pi / 4096


def with_encoders(encoders: Encoders, parent: str = "arm.hand", seed: int = 0, rate: float = 0.0) -> Change:
    sensor = NodeSpec("encoders", Kind.MOTION_SENSOR, parent, data=MotionSensor(encoders, rate, seed))
    body = (NodeSpec("craft", Kind.ROBOT), link("craft.body", "craft", Joint("free", JointType.FLOATING)))
    return after(empty(), CreateNodes(body), arm(), CreateNodes((sensor,)))


def read(change: Change, *ticks: int, seed: int = 0, past: int = 4) -> list[EncoderContent]:
    """Return what is told of joints that move as `positions` says."""
    reader = MotionReader(snapshot_at(change, 0), change.structure.node("encoders"))
    told = []
    for number, tick in enumerate(ticks, 1):
        content = reader.read(moment_at(change, tick, q=positions, number=number, seed=seed, past=past))
        assert isinstance(content, EncoderContent)
        told.append(content)
    return told


def positions(time: float) -> np.ndarray:
    """Return all coordinates: a floating body's seven, and those of the arm's joints a, b and f."""
    return np.array([0, 0, 0, 0, 0, 0, 1, 0.3 + 0.5 * time, -0.2 - 1.5 * time, 0.01])


def test_true_positions_and_speeds() -> None:
    """All joints of one coordinate, of the robot that the sensor is on; speeds are constant, and so are differences."""
    for told, time in zip(read(with_encoders(Encoders()), 5, 30), (0.02, 0.12), strict=True):
        assert told.joint_names == ("a", "b", "f")
        np.testing.assert_array_equal(told.positions, positions(time)[7:])
        np.testing.assert_allclose(told.velocities, (0.5, -1.5, 0.0), atol=1e-10)


def test_named_joints_in_their_order() -> None:
    (told,) = read(with_encoders(Encoders(("f", "a"))), 5)
    assert told.joint_names == ("f", "a")
    np.testing.assert_array_equal(told.positions, positions(0.02)[[9, 7]])


@pytest.mark.parametrize(("rate", "period"), [(0.0, 3), (125.0, 2), (500.0, 1), (50.0, 4)])
def test_positions_in_steps_and_speeds_by_their_difference(rate: float, period: int) -> None:
    """Counts of an encoder with 4096 a turn, a period ago: 100 Hz are 2.5 ticks, and of 50 Hz 4 ticks are known."""
    change = with_encoders(Encoders(position=NoiseModel(resolution=STEP)), rate=rate)
    for told, tick in zip(read(change, 7, 20), (7, 20), strict=True):
        now, before = (np.round(positions(at * TICK)[7:] / STEP) for at in (tick, tick - period))
        np.testing.assert_allclose(told.positions, now * STEP, atol=1e-12)
        np.testing.assert_allclose(told.velocities, (now - before) * STEP / (period * TICK), atol=1e-9)


def test_speeds_are_of_the_positions_that_were_told(seed: int) -> None:
    """At 125 Hz every other tick is told; noise and walk of the last reading come back to the bit."""
    change = with_encoders(Encoders(position=NoiseModel(0.1, 0.2, 0.3)), seed=seed, rate=125.0)
    told = read(change, 5, 7, 9, seed=seed)
    for before, now in pairwise(told):
        np.testing.assert_allclose(now.velocities * 2 * TICK, now.positions - before.positions, atol=1e-12)
    (alone,) = read(change, 5, seed=seed)
    np.testing.assert_array_equal(alone.velocities, told[0].velocities)


def test_readings_repeat(seed: int) -> None:
    change = with_encoders(Encoders(position=NoiseModel(0.1, 0.2, 0.3)), seed=seed)
    first, second = read(change, 5, 9, 700, seed=seed), read(change, 5, 9, 700, seed=seed)
    for one, other in zip(first, second, strict=True):
        np.testing.assert_array_equal(one.positions, other.positions)
        np.testing.assert_array_equal(one.velocities, other.velocities)
    assert (first[0].positions != positions(0.02)[7:]).all()


def test_a_joint_that_is_not_there() -> None:
    with pytest.raises(UnknownNameError, match=r"no joint of 'arm' that turns or slides named 'free'"):
        read(with_encoders(Encoders(("free",))), 5)


def test_no_robot() -> None:
    with pytest.raises(KernelError, match="'encoders' are on no robot") as refused:
        read(with_encoders(Encoders(), parent="world"), 5)
    assert refused.value.reason is Reason.WRONG_STATE


def test_a_joint_that_is_renamed_is_still_measured() -> None:
    change = with_encoders(Encoders(("b", "a")))
    change = after(change, UpdateNode("arm.two", data=LinkData(Joint("elbow", JointType.REVOLUTE, (0.0, 0.0, 1.0)))))
    (told,) = read(change, 5)
    assert told.joint_names == ("elbow", "a")
    np.testing.assert_array_equal(told.positions, positions(0.02)[[8, 7]])


def test_other_robots_have_their_own_joints() -> None:
    """The same name in another robot is not renamed."""
    sensor = NodeSpec("others", Kind.MOTION_SENSOR, "second.hand", data=MotionSensor(Encoders(("b",))))
    change = after(with_encoders(Encoders(("b",))), arm("second"), CreateNodes((sensor,)))
    change = after(change, UpdateNode("arm.two", data=LinkData(Joint("elbow", JointType.REVOLUTE, (0.0, 0.0, 1.0)))))
    data = change.structure.node("others").data
    assert isinstance(data, MotionSensor) and isinstance(data.kind, Encoders)
    assert data.kind.joints == ("b",)


def test_robots_that_are_changed_while_it_reads(rng: np.random.Generator) -> None:
    """A new joint: it stood as it stands, and the others as they did."""
    change = with_encoders(Encoders())
    reader = MotionReader(snapshot_at(change, 0), change.structure.node("encoders"))
    reader.read(moment_at(change, 5, q=positions))
    longer = after(change, CreateNodes((link("arm.more", "arm.hand", Joint("c", JointType.REVOLUTE)),)))
    history = tuple(snapshot_at(change, tick, q=positions) for tick in (8, 9))
    now = snapshot_at(longer, 10)
    told = reader.read(Moment(now, history, 2, rng))
    assert isinstance(told, EncoderContent)
    assert told.joint_names == ("a", "b", "f", "c")
    np.testing.assert_allclose(told.velocities[3], 0.0)
    before = positions(8 * TICK)[7:]
    np.testing.assert_allclose(told.velocities[:3], (now.state.q[7:10] - before) / (2 * TICK))
