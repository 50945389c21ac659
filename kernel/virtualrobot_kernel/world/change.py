"""World under change as one value, which commands take and return, with the helpers that every command needs."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import KernelError, LimitError, Reason, UnknownNameError
from virtualrobot_kernel.motion.limits import TOLERANCE, JointLimits
from virtualrobot_kernel.motion.orientation import unit
from virtualrobot_kernel.units import degrees_question, millimetres_question
from virtualrobot_kernel.world import index
from virtualrobot_kernel.world.figures import Pose
from virtualrobot_kernel.world.state import JointValues, Motion, Rated, Selection, Signal, State
from virtualrobot_kernel.world.structure import Coordinate, Joint, JointType, Node, Structure

Forward = Callable[[Structure, State], NDArray[np.float64]]
"""Forward pass: returns world_t_node (N, 4, 4). Given from outside, because it is compiled."""

LIMIT_TOLERANCE = TOLERANCE
"""Tolerance of joint values beyond their limits, as motions may leave them, in radians or meters."""


@dataclass(frozen=True, slots=True, eq=False)
class Change:
    """World before or after a command.

    `created` are uids of nodes and ids of motions, `picked` uids of parts that were picked; both in order.
    """

    structure: Structure
    state: State
    created: tuple[int | str, ...] = ()
    picked: tuple[int, ...] = ()


def extended(change: Change, new: Mapping[int, Node], next_uid: int, poses: Mapping[int, Pose]) -> Change:
    """Return the world with more nodes, which start as `rebuilt` says; what is there keeps its places."""
    old, state = change.structure, change.state
    if not index.appends(old, new):
        return rebuilt(change, {**old.nodes, **new}, next_uid, poses)
    structure = index.extended(old, new, next_uid)
    joints = [joint for uid in new if uid in structure.robots for joint in structure.robots[uid].joints]
    state = replace(
        state,
        q=np.concatenate([state.q, *map(neutral, joints)]),
        v=np.concatenate([state.v, np.zeros(structure.v_count - old.v_count)]),
        parent_t_node=np.concatenate([state.parent_t_node, [poses[uid] for uid in new]]),
    )
    return replace(change, structure=structure, state=state)


def rebuilt(change: Change, nodes: Mapping[int, Node], next_uid: int, poses: Mapping[int, Pose]) -> Change:
    """Return the world with other nodes: rows, joints and motions find their places again.

    `poses` holds `parent_t_node` (4, 4) of the new nodes by uid. A joint of the same link and type stays where
    it is, whatever its name. New joints start at zero, or at the limit nearest to it; new floating ones start unturned.
    """
    old, state = change.structure, change.state
    new = index.build(nodes, next_uid, old.revision)
    parent_t_node = np.empty((len(nodes), 4, 4))
    for uid, row in new.rows.items():
        parent_t_node[row] = poses[uid] if uid in poses else state.parent_t_node[old.rows[uid]]
    q, v = np.zeros(new.q_count), np.zeros(new.v_count)
    places = {link: (joint.type, at_q, at_v) for link, joint, at_q, at_v in _joints(old)}
    for link, joint, at_q, at_v in _joints(new):
        nq, nv = joint.type.coordinate_count, joint.type.velocity_count
        kind, from_q, from_v = places.get(link, (None, 0, 0))
        if kind is joint.type:
            q[at_q : at_q + nq] = state.q[from_q : from_q + nq]
            v[at_v : at_v + nv] = state.v[from_v : from_v + nv]
        else:
            q[at_q : at_q + nq] = neutral(joint)
    motions = tuple(relocated(new, motion) for motion in state.motions)
    state = replace(state, q=q, v=v, parent_t_node=parent_t_node, motions=motions)
    return replace(change, structure=new, state=_among(old, new, state))


def shortened(change: Change, gone: Collection[int]) -> Change:
    """Return the world without its last nodes (uids), as `rebuilt` would; `index.ends_with` says whether it can."""
    old, state = change.structure, change.state
    new = index.shortened(old, gone)
    state = replace(
        state,
        q=state.q[: new.q_count],
        v=state.v[: new.v_count],
        parent_t_node=state.parent_t_node[: len(new.nodes)],
        motions=tuple(relocated(new, motion) for motion in state.motions),
    )
    return replace(change, structure=new, state=_among(old, new, state))


def _among(old: Structure, new: Structure, state: State) -> State:
    """Return a state in which nothing is about nodes that are gone."""
    alive = new.nodes.keys()
    return replace(
        state,
        signals=_owned(state.signals, alive),
        commanded=_kept(old, new, state.commanded),
        readings=_kept(old, new, state.readings),
        motored=_kept(old, new, state.motored),
        efforts={uid: efforts for uid, efforts in state.efforts.items() if uid in alive},
        dynamics=None,  # its places may be those of others now
        twists={uid: twist for uid, twist in state.twists.items() if uid in alive},
        tool_states={uid: name for uid, name in state.tool_states.items() if uid in alive},
        selections=_selected(new, state.selections),
        speed_factors={uid: factor for uid, factor in state.speed_factors.items() if uid in alive},
        tcp_speed_limits={uid: limit for uid, limit in state.tcp_speed_limits.items() if uid in alive},
        allowed_pairs={pair: why for pair, why in state.allowed_pairs.items() if alive >= set(pair)},
        collisions=state.collisions.among(alive),
        running_sensors={uid: start for uid, start in state.running_sensors.items() if uid in alive},
    )


def _selected(structure: Structure, selections: Mapping[int, Selection]) -> Mapping[int, Selection]:
    """Return what robots work with: no tool where theirs is gone, or is their tool no more."""
    return {
        uid: selection if not selection.tool or selection.tool in structure.tools.get(uid, ()) else Selection()
        for uid, selection in selections.items()
        if uid in structure.robots
    }


def _owned(signals: Mapping[str, Signal], alive: Collection[int]) -> Mapping[str, Signal]:
    """Return signals, those whose owner is gone without one; the same object where that is none of them."""
    if all(not signal.owner or signal.owner in alive for signal in signals.values()):
        return signals
    return {name: signal if signal.owner in alive else replace(signal, owner=0) for name, signal in signals.items()}


def _kept(old: Structure, new: Structure, values: Mapping[int, JointValues]) -> Mapping[int, JointValues]:
    """Return values of robots that have the same kinds of joints as before."""

    def kinds(structure: Structure, uid: int) -> list[JointType]:
        return [joint.type for joint in structure.robots[uid].joints]

    return {uid: one for uid, one in values.items() if uid in new.robots and kinds(old, uid) == kinds(new, uid)}


def _joints(structure: Structure) -> Iterator[tuple[int, Joint, int, int]]:
    """Yield all joints with coordinates: the link that each moves (a uid), and where it begins in q and in v."""
    for robot in structure.robots.values():
        yield from zip(index.moved_links(structure, robot), robot.joints, robot.q_start, robot.v_start, strict=True)


def neutral(joint: Joint) -> NDArray[np.float64]:
    """Return the coordinates of a joint at zero, or at the limit nearest to zero; shape (nq,)."""
    q = np.zeros(joint.type.coordinate_count)
    if joint.type is JointType.FLOATING:
        q[6] = 1.0
    elif joint.type is not JointType.PLANAR:
        q[0] = min(max(0.0, joint.limits.lower), joint.limits.upper)
    return q


def relocated(structure: Structure, motion: Motion) -> Motion:
    """Return a motion whose columns point to where its joints are in `structure`."""
    q_index, v_index, rated = joint_places(structure, motion.joints)
    motion = replace(motion, q_index=q_index, v_index=v_index, rated=rated)
    return (
        motion
        if motion.tracked_joint is None
        else replace(motion, tracked_at=place_of(structure, *motion.tracked_joint))
    )


def place_of(structure: Structure, uid: int, name: str) -> tuple[int, int] | None:
    """Return the places of a robot's coordinate in q and in v, None when there is no such robot or joint any more."""
    robot = structure.robots.get(uid)
    found = robot.coordinates.get(name) if robot else None
    return (found.q, found.v) if found else None


def joint_places(
    structure: Structure, joints: Iterable[tuple[int, str]]
) -> tuple[NDArray[np.int32], NDArray[np.int32], Rated]:
    """Return the places in q (k,) and in v (m,) of coordinates, given as (robot uid, name), and whose the latter are.

    Of a quaternion, the columns of x, y and z have the angular velocity, and that of w has none.
    """
    found = [structure.robots[uid].coordinates[name] for uid, name in joints]
    q_index = np.array([one.q for one in found], np.int32)
    rated = [column for column, one in enumerate(found) if one.v >= 0]
    v_index = np.array([found[column].v for column in rated], np.int32)
    return q_index, v_index, ... if len(rated) == len(found) else np.array(rated, np.intp)


def coordinate_of(structure: Structure, robot: Node, name: str) -> Coordinate:
    """Return a robot's coordinate; raise KernelError that says which there are when it has none of that name."""
    found = structure.robots[robot.uid]
    if name in found.coordinates:
        return found.coordinates[name]
    joint = next((joint for joint in found.joints if joint.name == name), None)
    if joint is None:
        raise UnknownNameError(f"joint of {robot.name!r} that can be moved", name, found.coordinates)
    own = ", ".join(map(repr, joint.coordinate_names))
    raise KernelError(
        f"the joint {name!r} of {robot.name!r} is {joint.type.value[0]} and has several coordinates; name {own}",
        robot=robot.name,
        joint=name,
    )


def single_joint(structure: Structure, robot: Node, name: str) -> tuple[Joint, int, int]:
    """Return a joint with one coordinate and its places in q and v, as `coordinate_of` does."""
    found = coordinate_of(structure, robot, name)
    return found.joint, found.q, found.v


def joint_limits(structure: Structure, robot: Node, names: Sequence[str]) -> JointLimits:
    """Return the limits of coordinates by name, (k,); raise KernelError where a quaternion is not all named."""
    found = [coordinate_of(structure, robot, name) for name in names]
    shifts: dict[int, list[int]] = {}
    turns: dict[int, dict[int, int]] = {}
    for column, one in enumerate(found):
        if 3 <= (at := one.q - structure.robots[robot.uid].q_start[one.place]):
            turns.setdefault(one.place, {})[at] = column
        elif one.joint.type is JointType.PRISMATIC:
            shifts.setdefault(one.place, []).append(column)
    for place, columns in turns.items():
        if len(columns) < 4:
            joint = structure.robots[robot.uid].joints[place]
            own = ", ".join(map(repr, joint.coordinate_names[3:]))
            raise KernelError(
                f"the joint {joint.name!r} of {robot.name!r} turns by a quaternion; name all of {own} or none",
                robot=robot.name,
                joint=joint.name,
            )
    quaternions = tuple(tuple(column for _, column in sorted(columns.items())) for columns in turns.values())
    vectors = (*map(tuple, shifts.values()), *(columns[:3] for columns in quaternions))
    fields = ("lower", "upper", "velocity", "acceleration", "jerk")
    values = {field: np.array([getattr(one.joint.limits, field) for one in found]) for field in fields}
    sliding = frozenset(name for name, one in zip(names, found, strict=True) if one.joint.type is JointType.PRISMATIC)
    return JointLimits(tuple(names), **values, vectors=vectors, quaternions=quaternions, sliding=sliding)


def check_joint_value(robot: str, joint: Joint, value: float) -> None:
    """Raise LimitError when a value is outside the joint's limits, KernelError when it is not finite."""
    unit = "m" if joint.type is JointType.PRISMATIC else "rad"
    about = {"robot": robot, "joint": joint.name, "value": value}
    if not np.isfinite(value):
        raise KernelError(f"the joint {joint.name!r} of {robot!r} cannot be at {value}; give a finite number", **about)
    lower, upper = joint.limits.lower, joint.limits.upper
    if not lower - LIMIT_TOLERANCE <= value <= upper + LIMIT_TOLERANCE:
        raise LimitError(
            f"the joint {joint.name!r} of {robot!r} cannot be at {value:g} {unit}; "
            f"its limits are {lower:g} to {upper:g} {unit}"
            f"{degrees_question(value) if unit == 'rad' else millimetres_question(value)}",
            lower=lower,
            upper=upper,
            **about,
        )


def with_positions(
    structure: Structure, robot: Node, q: NDArray[np.float64], positions: Mapping[str, float]
) -> NDArray[np.float64]:
    """Return all coordinates q (nq,) with some of a robot's, by name, elsewhere.

    Raises as `coordinate_of`, `check_joint_value` and `check_coordinates` do.
    """
    index, q = structure.robots[robot.uid], q.copy()
    for name, value in positions.items():
        found = coordinate_of(structure, robot, name)
        check_joint_value(robot.name, found.joint, value)
        q[found.q] = value
    q[index.q_slice] = check_coordinates(robot, index.joints, q[index.q_slice], limited=False)
    return q


def check_coordinates(
    robot: Node, joints: Sequence[Joint], coordinates: NDArray[np.float64], *, limited: bool = True
) -> NDArray[np.float64]:
    """Return all coordinates (nq,) of a robot, with quaternions of unit length.

    Raises KernelError for a wrong count, for what is not finite and for a quaternion that has not length 1, and, where
    they are `limited`, LimitError for a joint outside its limits.
    """
    wanted = sum(joint.type.coordinate_count for joint in joints)
    if coordinates.shape != (wanted,):
        raise KernelError(
            f"the robot {robot.name!r} has {wanted} coordinates, not {coordinates.size}",
            robot=robot.name,
            wanted=wanted,
        )
    if not np.isfinite(coordinates).all():
        raise KernelError(
            f"the coordinates of {robot.name!r} must be finite, not {coordinates.tolist()}", robot=robot.name
        )
    result, at = coordinates.copy(), 0
    for joint in joints:
        count = joint.type.coordinate_count
        if count == 1 and limited:
            check_joint_value(robot.name, joint, float(result[at]))
        elif joint.type is JointType.FLOATING:
            result[at + 3 : at + 7] = unit(result[at + 3 : at + 7], f"the joint {joint.name!r} of {robot.name!r}")
        at += count
    return result


def refuse_measured(change: Change, robot: Node) -> None:
    """Raise KernelError (WRONG_STATE) when the joints of a robot are measured: nobody can put a real one elsewhere."""
    if robot.uid in change.state.commanded:
        raise KernelError(
            f"the joints of {robot.name!r} are measured and cannot be put elsewhere; move them by a motion",
            reason=Reason.WRONG_STATE,
            robot=robot.name,
        )


def moving_motion(state: State, joints: set[tuple[int, str]]) -> Motion | None:
    """Return a running motion that moves one of these joints, given as (robot uid, joint name), or None."""
    return next((motion for motion in state.motions if not joints.isdisjoint(motion.joints)), None)


def refuse_while_moving(change: Change, robot: Node, joints: set[tuple[int, str]]) -> None:
    """Raise KernelError (ROBOT_BUSY) when one of these joints moves."""
    if motion := moving_motion(change.state, joints):
        raise KernelError(
            f"the robot {robot.name!r} moves in {motion.id!r}; wait for its end or cancel it",
            reason=Reason.ROBOT_BUSY,
            robot=robot.name,
            motion=motion.id,
        )


def frozen(array: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the array after making it read-only."""
    array.setflags(write=False)
    return array
