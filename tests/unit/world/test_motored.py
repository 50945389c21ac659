"""Robots under physics in the pure world: motions command motors, and where joints are says what was computed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from virtualrobot_kernel.errors import KernelError
from virtualrobot_kernel.world.change import Change
from virtualrobot_kernel.world.commands import CreateNodes, RemoveNode, SetJointPositions, StopMotions, UpdateNode
from virtualrobot_kernel.world.measured import commanded
from virtualrobot_kernel.world.motors import JointMotor, MotorMode
from virtualrobot_kernel.world.physics_commands import SetDynamics, SetJointEfforts, SetPhysics
from virtualrobot_kernel.world.structure import Joint, JointType, Kind, NodeSpec, RobotData

from tests.unit.world.builders import LIMITS, after, empty, link, ticked
from tests.unit.world.test_measured import move

Z = (0.0, 0.0, 1.0)
DATA = RobotData(dynamic=True, motors=(JointMotor("caster", MotorMode.FREE), JointMotor("pull", MotorMode.EFFORT)))
REST = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]


@pytest.fixture
def cell() -> Change:
    """Return a world with a robot on a floating base: a joint with a motor, a caster, and one that is pulled."""
    nodes = (
        NodeSpec("arm", Kind.ROBOT, data=DATA),
        link("arm.hull", "arm", Joint("free", JointType.FLOATING)),
        link("arm.one", "arm.hull", Joint("a", JointType.REVOLUTE, Z, LIMITS)),
        link("arm.wheel", "arm.hull", Joint("caster", JointType.CONTINUOUS, Z)),
        link("arm.pulled", "arm.hull", Joint("pull", JointType.CONTINUOUS, Z)),
    )
    return after(empty(), CreateNodes(nodes), SetPhysics("an engine"))


def told(change: Change, x: float, a: float, caster: float, *, entering: bool = False) -> Change:
    """Return the world in which it was computed where base, motor and caster are at the end of the tick."""
    q = np.array([x, *REST[1:], a, caster, 0.0])
    robots = (change.structure.node("arm").uid,) if entering else ()
    command = SetDynamics(np.arange(10, dtype=np.int32), q, np.arange(9, dtype=np.int32), np.full(9, 0.1), robots)
    return after(change, command)


def test_motions_command_motors_and_joints_are_where_they_are_computed(cell: Change) -> None:
    now = told(after(cell, move(0.5)), 0.0, 0.0, 0.0, entering=True)
    alone = after(replace(cell, state=replace(cell.state, physics=None)), move(0.5))
    for tick in range(1, 300):
        now, alone = ticked(now), ticked(alone)
        q = commanded(now.structure, now.state)[0]
        assert q[7] == alone.state.q[7]
        assert now.state.q[7:9].tolist() == [0.4 * 0.001 * (tick - 1), 0.01 * (tick - 1)]
        # Base and caster have no motors: they are commanded to be where they are.
        assert q[[0, 8]].tolist() == [0.1 * (tick - 1), 0.01 * (tick - 1)]
        now = told(now, 0.1 * tick, 0.4 * 0.001 * tick, 0.01 * tick)
    assert commanded(now.structure, now.state)[0][7] == 0.5


def test_what_forces_alone_move_is_moved_by_no_motion(cell: Change) -> None:
    for joint, why in (("caster", "a motor of the mode 'free'"), ("pull", "a motor of the mode 'effort'")):
        with pytest.raises(KernelError, match=f"'{joint}' of 'arm' is moved by {why}"):
            after(cell, move(0.5, joint=joint))
    with pytest.raises(KernelError, match="'free/x' of 'arm' is moved by forces alone"):
        after(cell, move(0.5, joint="free/x"))


def test_it_leaves_physics_where_it_is_once_it_stands(cell: Change) -> None:
    now = ticked(told(after(cell, move(0.5)), 0.0, 0.0, 0.0, entering=True))
    with pytest.raises(KernelError, match="the robot 'arm' moves in"):
        after(now, SetPhysics(""))
    with pytest.raises(KernelError, match="the robot 'arm' moves in"):
        after(now, UpdateNode("arm", data=replace(DATA, dynamic=False)))
    now = told(ticked(now, 300), 0.2, 0.45, 0.3)
    now = ticked(now)
    for left in (after(now, SetPhysics("")), after(now, UpdateNode("arm", data=replace(DATA, dynamic=False)))):
        assert left.state.motored == {}
        assert left.state.q.tolist() == now.state.q.tolist()
        assert not left.state.v.any()
        assert ticked(left).state.q.tolist() == now.state.q.tolist()
    assert after(now, RemoveNode("arm")).state.motored == {}


def test_what_is_put_elsewhere_is_commanded_there(cell: Change) -> None:
    now = ticked(told(cell, 0.0, 0.1, 0.0, entering=True))
    now = after(now, SetJointPositions("arm", {"a": 0.7}))
    assert (now.state.q[7], now.state.v.any()) == (0.7, False)
    assert commanded(now.structure, now.state)[0][7] == 0.7


def test_efforts_are_of_motors_that_exert_them(cell: Change) -> None:
    uid = cell.structure.node("arm").uid
    now = after(cell, SetJointEfforts("arm", {"pull": 2.0}))
    assert now.state.efforts == {uid: {"pull": 2.0}}
    assert after(now, StopMotions(("arm",))).state.efforts == {}
    for efforts, said in (
        ({"a": 1.0}, "the mode 'position'; efforts are of the mode 'effort'"),
        ({"pull": np.nan}, "must be finite"),
        ({"push": 1.0}, "push"),
    ):
        with pytest.raises(KernelError, match=said):
            after(cell, SetJointEfforts("arm", efforts))
    still = after(cell, UpdateNode("arm", data=replace(DATA, dynamic=False)))
    with pytest.raises(KernelError, match="is not dynamic"):
        after(still, SetJointEfforts("arm", {"pull": 1.0}))


@pytest.mark.parametrize(
    ("motors", "said"),
    [
        ((JointMotor("b"),), "b"),
        ((JointMotor("free"),), "several coordinates"),
        ((JointMotor("a"), JointMotor("a", MotorMode.FREE)), "'a' of 'arm' is said twice"),
    ],
)
def test_motors_of_no_joint_are_refused(cell: Change, motors: tuple[JointMotor, ...], said: str) -> None:
    with pytest.raises(KernelError, match=said):
        after(cell, UpdateNode("arm", data=replace(DATA, motors=motors)))
