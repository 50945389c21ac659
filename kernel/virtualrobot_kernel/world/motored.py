"""Robots under physics: their base goes where forces take it, and their motions command motors. Pure.

What motions command is kept apart from where joints are, as of a robot that is measured (`State.motored`). Coordinates
that no motor moves are commanded to be where they are.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.change import Change, Forward, frozen, refuse_while_moving, single_joint
from virtualrobot_kernel.world.motors import JointMotor, MotorMode
from virtualrobot_kernel.world.physics_commands import SetJointEfforts
from virtualrobot_kernel.world.state import JointValues, State
from virtualrobot_kernel.world.structure import Joint, JointType, Node, RobotData, Structure

Floats = NDArray[np.float64]

COMMANDED = (MotorMode.VELOCITY, MotorMode.POSITION)
"""Modes of motors that motions command."""


def is_dynamic(node: Node) -> bool:
    """Return whether a node is a robot that forces move where there is an engine for them."""
    return isinstance(node.data, RobotData) and node.data.dynamic


def under_physics(structure: Structure, state: State) -> Iterator[Node]:
    """Yield the robots that forces move in this state."""
    if state.physics_settings.engine:
        yield from (structure.nodes[uid] for uid in structure.robots if is_dynamic(structure.nodes[uid]))


def motor_of(node: Node, joint: Joint) -> JointMotor:
    """Return the motor of a joint of one coordinate, with its mode and its greatest effort; 0: none."""
    assert isinstance(node.data, RobotData)
    named = next((one for one in node.data.motors if one.joint == joint.name), JointMotor(joint.name))
    usual = MotorMode.VELOCITY if joint.type is JointType.CONTINUOUS else MotorMode.POSITION
    return replace(
        named,
        mode=usual if named.mode is MotorMode.UNSPECIFIED else named.mode,
        max_effort=named.max_effort or joint.limits.effort,
    )


def check_motors(structure: Structure, node: Node) -> None:
    """Raise KernelError for a motor of a joint that a robot lacks, or that is named twice, and for a base that slides.

    What moves by forces falls, too, which a planar joint doesn't let it; and physics know no joint that mimics another.
    """
    data, robot = node.data, structure.robots[node.uid]
    assert isinstance(data, RobotData)
    named: set[str] = set()
    for one in data.motors:
        joint = single_joint(structure, node, one.joint)[0]
        if joint.name in named:
            raise KernelError(
                f"the motor of {joint.name!r} of {node.name!r} is said twice", robot=node.name, joint=joint.name
            )
        named.add(joint.name)
    if not data.dynamic:
        return
    for joint in robot.joints:
        if joint.type is JointType.PLANAR:
            raise KernelError(
                f"the joint {joint.name!r} of {node.name!r} is planar, and what moves by forces may fall; load it with "
                "the base floating",
                robot=node.name,
                joint=joint.name,
            )


def set_joint_efforts(change: Change, command: SetJointEfforts, forward: Forward) -> Change:
    """Set what motors exert; raises KernelError (WRONG_STATE) for motors of another mode, and a robot not dynamic."""
    structure, state = change.structure, change.state
    node = structure.robot(command.robot)[0]
    if not is_dynamic(node):
        raise KernelError(
            f"{node.name!r} is not dynamic, so that it has no motors; its joints are moved by motions",
            reason=Reason.WRONG_STATE,
            robot=node.name,
        )
    for name, value in command.efforts.items():
        mode = motor_of(node, single_joint(structure, node, name)[0]).mode
        if mode is not MotorMode.EFFORT:
            raise KernelError(
                f"the motor of {name!r} of {node.name!r} has the mode {mode.value!r}; efforts are of the mode 'effort'",
                reason=Reason.WRONG_STATE,
                robot=node.name,
                joint=name,
            )
        if not np.isfinite(value):
            raise KernelError(f"the effort of {name!r} must be finite, not {value}", robot=node.name, joint=name)
    told = {**state.efforts.get(node.uid, {}), **command.efforts}
    return replace(change, state=replace(state, efforts={**state.efforts, node.uid: told}))


def enter(structure: Structure, state: State, robots: Iterable[int]) -> State:
    """Return the state in which motions of these robots (uids) command motors, which hold joints where they are."""
    found = dict(state.motored)
    for uid in robots:
        if uid in structure.robots and uid not in found:
            robot = structure.robots[uid]
            v = np.zeros(robot.v_slice.stop - robot.v_slice.start)
            found[uid] = JointValues(frozen(state.q[robot.q_slice].copy()), frozen(v))
    return replace(state, motored=found)


def left(change: Change, robots: Collection[int]) -> Change:
    """Return the world in which motions of these robots (uids) command joints again, from where they are, at rest.

    Raises KernelError (ROBOT_BUSY) while one of them moves.
    """
    structure, state = change.structure, change.state
    gone = [uid for uid in robots if uid in state.motored]
    if not gone:
        return change
    for uid in gone:
        node = structure.nodes[uid]
        refuse_while_moving(change, node, {(uid, name) for name in structure.robots[uid].coordinates})
    return replace(change, state=stood(structure, state, gone))


def stood(structure: Structure, state: State, robots: Collection[int]) -> State:
    """Return the state in which robots (uids) stand where they are, and nothing is commanded of their motors."""
    v = state.v.copy()
    for uid in robots:
        v[structure.robots[uid].v_slice] = 0.0
    motored = {uid: one for uid, one in state.motored.items() if uid not in robots}
    efforts = {uid: one for uid, one in state.efforts.items() if uid not in robots}
    return replace(state, v=frozen(v), motored=motored, efforts=efforts)


def followed(structure: Structure, motored: Mapping[int, JointValues], now: Floats) -> Mapping[int, JointValues]:
    """Return what is commanded of robots under physics whose joints are at `now` (nq,): what no motor moves, that."""
    if not motored:
        return motored
    following = _following(structure, tuple(motored))
    q, v = (np.concatenate([getattr(one, name) for one in motored.values()]) for name in ("q", "v"))
    q[following.q], v[following.v] = now[following.q_now], 0.0
    frozen(q)
    frozen(v)
    return {uid: JointValues(q[of_q], v[of_v]) for uid, of_q, of_v in following.slices}


def refuse_unmotored(structure: Structure, state: State, joints: Iterable[tuple[int, str]]) -> None:
    """Raise KernelError (WRONG_STATE) for motions, by joints (robot uid, name), of what forces alone move."""
    robots = {node.uid: node for node in under_physics(structure, state)}
    for uid, name in joints:
        if uid not in robots:
            continue
        found = structure.robots[uid].coordinates[name]
        whole = structure.robots[uid].joints[found.place]
        motor = motor_of(robots[uid], whole) if found.joint is whole else None
        if motor is None or motor.mode not in COMMANDED:
            why = "by forces alone" if motor is None else f"by a motor of the mode {motor.mode.value!r}"
            raise KernelError(
                f"{name!r} of {robots[uid].name!r} is moved {why}; move joints with motors, or put it elsewhere with "
                "set_joint_positions",
                reason=Reason.WRONG_STATE,
                robot=robots[uid].name,
                joint=name,
            )


@dataclass(frozen=True, slots=True, eq=False)
class _Following:
    """Coordinates and velocities that follow what is, of some robots whose own ones lie one robot after the other.

    q, v: their places there; q_now: among all coordinates. slices: of each robot (a uid), its own q and v there.
    """

    q: NDArray[np.intp]
    v: NDArray[np.intp]
    q_now: NDArray[np.intp]
    slices: tuple[tuple[int, slice, slice], ...]


@lru_cache(maxsize=4)
def _following(structure: Structure, uids: tuple[int, ...]) -> _Following:
    at_q: list[int] = []
    at_v: list[int] = []
    now: list[int] = []
    slices: list[tuple[int, slice, slice]] = []
    first_q = first_v = 0
    for uid in uids:
        robot, node = structure.robots[uid], structure.nodes[uid]
        of_q, of_v = robot.q_slice, robot.v_slice
        for joint, q, v in zip(robot.joints, robot.q_start, robot.v_start, strict=True):
            if joint.type.coordinate_count == 1 and motor_of(node, joint).mode in COMMANDED:
                continue
            now += range(q, q + joint.type.coordinate_count)
            at_q += range(first_q + q - of_q.start, first_q + q - of_q.start + joint.type.coordinate_count)
            at_v += range(first_v + v - of_v.start, first_v + v - of_v.start + joint.type.velocity_count)
        last_q, last_v = first_q + of_q.stop - of_q.start, first_v + of_v.stop - of_v.start
        slices.append((uid, slice(first_q, last_q), slice(first_v, last_v)))
        first_q, first_v = last_q, last_v
    return _Following(np.array(at_q, np.intp), np.array(at_v, np.intp), np.array(now, np.intp), tuple(slices))
