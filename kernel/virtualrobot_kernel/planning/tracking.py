"""Motions that track a frame of another robot: the joint that moves it, and the arms that follow."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from virtualrobot_sdk.poses import inverse

from virtualrobot_kernel.errors import KernelError, LimitError
from virtualrobot_kernel.motion.conveyor_tracking import ConveyorTracking, TrackingArm
from virtualrobot_kernel.motion.limits import JointLimits
from virtualrobot_kernel.motion.polynomial import Array
from virtualrobot_kernel.motion.program import Program
from virtualrobot_kernel.planning.actuators import actuator_limits
from virtualrobot_kernel.planning.planned_move import joint_limits
from virtualrobot_kernel.planning.program import TrackingSpec
from virtualrobot_kernel.planning.robots import Arm, tip_of, tip_t_tcp
from virtualrobot_kernel.planning.tracked_limits import (
    Place,
    Rates,
    braking_share,
    budget,
    checked_rates,
    fastest_at,
    slowed,
    stretch,
)
from virtualrobot_kernel.world.change import single_joint
from virtualrobot_kernel.world.commands import StartMotion, Tracking
from virtualrobot_kernel.world.preconditions import Aspect, TcpPath, preconditions_of
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Joint, JointType, Node

LARGEST_WINDOW = 100.0
"""Largest window in meters or radians: each centimetre of it is checked."""

TRIED_WINDOWS = 3
"""Number of shorter windows that are tried before a refusal names one."""

CATCHING_UP = 3.0
"""Time to catch up and to leave together, as a multiple of that to reach the frame's speed by the arm's own part of its
acceleration, about."""

GoOn = Callable[[], None]
"""Callback before each stage is checked; raises KernelError when nobody waits for the plan any more."""

_Tracked = tuple[Program, ConveyorTracking]


class _TooFast(Exception):
    """Arms cannot keep up everywhere: `places` (c,) of the frame, and what they keep up with there, `fastest` (c,)."""

    def __init__(self, places: Array, fastest: Array) -> None:
        super().__init__("the arm cannot keep up")
        self.places, self.fastest = places, fastest


@dataclass(frozen=True, slots=True)
class _Frame:
    """Joint that moves a tracked node: its robot, its data, the link (a uid) that it moves, and its position."""

    robot: Node
    joint: Joint
    link: int
    position: float
    unit: str


def arms_joints(joints: Iterable[tuple[int, str]], moved: Sequence[Arm]) -> set[tuple[int, str]]:
    """Return joints (robot uid, name), with all joints of the arms that have one of them: these go along as a whole."""
    needed = set(joints)
    for arm in moved:
        own = {(arm.robot.uid, name) for name in arm.joint_names}
        if not own.isdisjoint(needed):
            needed |= own
    return needed


def tracked(
    snapshot: Snapshot,
    command: StartMotion,
    tracking: TrackingSpec,
    moved_arms: Sequence[Arm],
    go_on: GoOn = lambda: None,
) -> StartMotion:
    """Return a planned motion of some arms as one that goes along with a node, slower where the joints need it.

    Raises KernelError when no joint of another robot, or more than one, moves the node; when an arm can't go along all
    the way, with the place; or when the window or the speed makes no sense.
    """
    structure = snapshot.structure
    moved = set(command.joints)
    arms = [(arm.robot, arm) for arm in moved_arms if any((arm.robot.name, name) in moved for name in arm.joint_names)]
    for place, (robot, arm) in enumerate(arms):
        if any(np.intersect1d(arm.q_index, other.q_index).size for _, other in arms[:place]):
            raise KernelError(
                f"{robot.name!r}{arm.group} cannot go along with {tracking.node!r} together with another group that "
                "has some of its joints; move one of them",
                field="tracking",
                robot=robot.name,
            )
    if not arms:
        raise KernelError("only arms can go along with a frame, and this motion moves none", field="tracking")
    frame = _frame(snapshot, tracking.node, arms, moved)
    for robot, arm in arms:
        _check_carriers(snapshot, robot, arm, tracking.node, moved)
    window, velocity = _window(frame, tracking), min(tracking.max_velocity or np.inf, frame.joint.limits.velocity)
    joints = tuple(dict.fromkeys([*command.joints, *((robot.name, j) for robot, arm in arms for j in arm.joint_names)]))
    planned = _widened(snapshot, command.program, joints)
    tracking_arms = [_tracking_arm(snapshot, robot, arm, joints, frame) for robot, arm in arms]

    def checked(within: tuple[float, float]) -> _Tracked:
        return _checked(snapshot, planned, frame, within, velocity, arms, tracking_arms, go_on)

    try:
        program, tracked = checked(window)
    except _TooFast as too_fast:
        raise _advised(frame, window, velocity, too_fast, checked) from None
    ways = [TcpPath(robot.uid, (structure.node(tracking.node).uid,), arm.group) for robot, arm in arms]
    uids = ((structure.robot(robot)[0].uid, joint) for robot, joint in joints)
    preconditions = (*command.preconditions, *preconditions_of(structure, snapshot.state, uids, ways))
    return replace(
        command,
        joints=joints,
        program=program,
        # Where the frame's joint stands is what may change.
        preconditions=tuple(f for f in preconditions if (f.uid, f.aspect) != (frame.link, Aspect.POSITION)),
        tracking=Tracking(frame.robot.name, frame.joint.name, tracked),
    )


def _frame(
    snapshot: Snapshot, name: str, arms: Sequence[tuple[Node, Arm]], moved: Collection[tuple[str, str]]
) -> _Frame:
    """Return the one joint that moves a node against the arms' bases; raise KernelError when there isn't one."""
    structure = snapshot.structure
    above = [node.uid for node in structure.ancestors(structure.node(name).uid)]
    found: dict[int, tuple[int, int]] = {}
    for _, arm in arms:
        carrying = {node.uid for node in structure.ancestors(arm.base)}
        for uid in above:
            if uid not in carrying and structure.nodes[uid].is_moved:
                owner = structure.robot_of(uid)
                assert owner is not None  # it is a link
                found[uid] = owner.uid, int(structure.forest.q_index[structure.rows[uid]])
    names = [f"{_joint_at(snapshot, *key).name!r} of {structure.nodes[key[0]].name!r}" for key in found.values()]
    own = {robot.uid for robot, _ in arms}
    keys = list(found.values())
    if len(keys) != 1 or keys[0][0] in own:
        told = f"it is moved by {', '.join(names)}" if names else "no joint moves it"
        if any((structure.nodes[robot].name, _joint_at(snapshot, robot, at).name) in moved for robot, at in keys):
            told += ", which the motion moves itself"
        raise KernelError(
            f"a motion cannot go along with {name!r}: {told}; name a node that exactly one joint of another robot "
            "moves, such as a conveyor's belt",
            field="tracking.node",
            node=name,
        )
    (link, (robot, place)), *_ = found.items()
    joint = _joint_at(snapshot, robot, place)
    if joint.type not in (JointType.PRISMATIC, JointType.REVOLUTE, JointType.CONTINUOUS):
        raise KernelError(
            f"a motion cannot go along with {name!r}: the joint {joint.name!r} that moves it is {joint.type.value[0]}; "
            "prismatic, revolute and continuous ones can be followed",
            field="tracking.node",
            node=name,
        )
    unit = "m" if joint.type is JointType.PRISMATIC else "rad"
    return _Frame(structure.nodes[robot], joint, link, float(snapshot.state.q[place]), unit)


def _check_carriers(snapshot: Snapshot, robot: Node, arm: Arm, name: str, moved: Collection[tuple[str, str]]) -> None:
    """Raise KernelError when the motion moves what carries the arm but not the frame: then no place is what it was."""
    structure = snapshot.structure
    common = {node.uid for node in structure.ancestors(structure.node(name).uid)}
    for node in structure.ancestors(arm.base):
        if node.uid in common or not node.is_moved:
            continue
        owner = structure.robot_of(node.uid)
        assert owner is not None  # it is a link
        joint = _joint_at(snapshot, owner.uid, int(structure.forest.q_index[structure.rows[node.uid]]))
        if (owner.name, joint.name) in moved:
            raise KernelError(
                f"{robot.name!r} cannot go along with {name!r} while the same motion moves what carries it, "
                f"{joint.name!r} of {owner.name!r}; move that before",
                field="tracking",
                robot=robot.name,
                joint=joint.name,
            )


def _joint_at(snapshot: Snapshot, robot: int, place: int) -> Joint:
    index = snapshot.structure.robots[robot]
    return index.joints[index.q_start.index(place)]


def _window(frame: _Frame, tracking: TrackingSpec) -> tuple[float, float]:
    """Return between which displacements the frame is followed; a joint's limits shorten the window."""
    if abs(tracking.window) > LARGEST_WINDOW:
        raise KernelError(
            f"tracking.window is at most {LARGEST_WINDOW:g} {frame.unit} either way, not {tracking.window:g}",
            field="tracking.window",
        )
    low = max(min(tracking.window, 0.0), frame.joint.limits.lower - frame.position)
    high = min(max(tracking.window, 0.0), frame.joint.limits.upper - frame.position)
    if (high if tracking.window > 0.0 else -low) <= 0.0:
        raise LimitError(
            f"the joint {frame.joint.name!r} of {frame.robot.name!r} stands at its limit, {frame.position:g} "
            f"{frame.unit}, and cannot move by {tracking.window:g} {frame.unit} from there",
            joint=frame.joint.name,
            value=frame.position,
        )
    return min(low, 0.0), max(high, 0.0)


def _widened(snapshot: Snapshot, program: Program, joints: Sequence[tuple[str, str]]) -> Program:
    """Return the program for more joints, which stand still in it."""
    structure = snapshot.structure
    places = [single_joint(structure, structure.robot(robot)[0], joint)[1] for robot, joint in joints]
    start = snapshot.state.q[places].copy()
    start[: len(program.start)] = program.start
    return replace(program, start=start)


def _tracking_arm(
    snapshot: Snapshot, robot: Node, arm: Arm, joints: Sequence[tuple[str, str]], frame: _Frame
) -> TrackingArm:
    chain = arm.serial()
    structure = snapshot.structure
    base_t_link = inverse(snapshot.world_t(arm.base)) @ snapshot.world_t(frame.link)
    row = structure.rows[frame.link]
    columns = np.array([joints.index((robot.name, name)) for name in arm.joint_names])
    tracking_arm = TrackingArm(
        columns,
        chain._replace(post=np.ascontiguousarray(chain.post @ tip_t_tcp(snapshot, arm))),
        1.0,
        int(structure.forest.joint_type[row]),
        base_t_link[:3, :3] @ structure.forest.axis[row],
        base_t_link[:3, 3].copy(),
        float(structure.forest.multiplier[row]),
    )
    jacobian = tracking_arm.jacobians(snapshot.state.q[arm.q_index][None])[0]
    turning = np.linalg.norm(jacobian[3:], axis=0) > 1e-9
    lever = float(np.linalg.norm(jacobian[:3], axis=0)[turning].max(initial=0.0))
    return replace(tracking_arm, weight=1.0 / lever if lever > 1e-6 else 1.0)


def _checked(
    snapshot: Snapshot,
    program: Program,
    frame: _Frame,
    window: tuple[float, float],
    velocity: float,
    arms: Sequence[tuple[Node, Arm]],
    tracking_arms: Sequence[TrackingArm],
    go_on: GoOn,
) -> _Tracked:
    """Return the program as slow as the joints need it, and how the frame is followed; raise where they can't."""
    rates: list[tuple[Rates, JointLimits]] = []
    q = program.start
    for number, stage in enumerate(program.stages):
        go_on()
        for (robot, arm), tracking_arm in zip(arms, tracking_arms, strict=True):
            limits, _ = joint_limits(snapshot, robot, arm.joint_names)
            place = _place(snapshot, program, robot, arm, frame)
            motors = actuator_limits(snapshot, robot, arm.joint_names)
            rates.append((checked_rates(tracking_arm, limits, motors, stage, number, q, window, place), limits))
        if stage.plan is not None:
            q = q.copy()
            q[list(stage.columns)] = stage.plan.goal
    places, fastest = fastest_at(rates)
    if velocity > fastest.min():
        raise _TooFast(places, fastest)
    taken = budget(rates, velocity, frame.joint.limits.acceleration)
    stages = list(program.stages)
    for number, stage in enumerate(stages):
        of_stage = [(one, limits) for one, limits in rates if one.stage == number]
        factor = max(stretch(one, limits, taken) for one, limits in of_stage)
        if factor > 1.0 and stage.plan is not None and stage.plan.kind == "trajectory":
            raise LimitError(
                f"going along with {frame.joint.name!r} at {velocity:g} {frame.unit}/s the trajectory would have to "
                f"take {factor:.4g} times as long as its times say",
                factor=factor,
            )
        shares = {
            int(column): braking_share(one, limits, taken, factor)
            for (one, limits), tracking_arm in zip(of_stage, tracking_arms, strict=True)
            for column in tracking_arm.columns
        }
        stages[number] = slowed(stage, factor, shares)
    tracked = ConveyorTracking(
        tuple(tracking_arms), frame.position, *window, taken.velocity, taken.acceleration, taken.own_acceleration,
        taken.own_jerk,
    )  # fmt: skip
    return replace(program, stages=tuple(stages)), tracked


def _advised(
    frame: _Frame,
    window: tuple[float, float],
    velocity: float,
    too_fast: _TooFast,
    checked: Callable[[tuple[float, float]], _Tracked],
) -> LimitError:
    """Return the refusal of a velocity that arms cannot keep up with all along a window, with what would do instead.

    A shorter window is named where the motion can be planned in it, as `checked` tries, and has time for it.
    """
    places, fastest = too_fast.places, too_fast.fastest
    joint, unit, worst = frame.joint.name, frame.unit, int(np.argmin(fastest))
    reach: float | None = None
    remedy = f"a max_velocity of at most {fastest[worst]:.4g} {unit}/s"
    kept_up = int(np.argmax(fastest < velocity))
    for end in places[max(kept_up - TRIED_WINDOWS, 1) : kept_up][::-1].tolist():
        try:
            program, tracked = checked((max(window[0], min(end, 0.0)), min(window[1], max(end, 0.0))))
        except (KernelError, _TooFast):
            continue
        if abs(end) >= velocity * (program.duration + CATCHING_UP * velocity / tracked.own_acceleration):
            reach = end
            remedy = f"a window no longer than {end:.4g} {unit}, or {remedy}"
        break
    error = LimitError(
        f"the arm cannot keep up with the joint {joint!r} at {velocity:g} {unit}/s where this is at "
        f"{frame.position + places[worst]:.4g} {unit}, {places[worst]:+.4g} {unit} from where it is; give {remedy}",
        joint=joint,
        value=velocity,
        limit=float(fastest[worst]),
    )
    if reach is not None:
        error.metadata["window"] = str(reach)
    return error


def _place(snapshot: Snapshot, program: Program, robot: Node, arm: Arm, frame: _Frame) -> Place:
    """Return the function that names places of the motion and of the frame."""
    tip, point = tip_of(snapshot, arm), tip_t_tcp(snapshot, arm)

    def place(number: int, time: float, displacement: float, q: Array) -> tuple[str, dict[str, object]]:
        stage = program.stages[number]
        step = stage.steps[max(0, bisect_right(stage.steps, time, key=lambda one: one[0]) - 1)][1]
        share = (program.begins[number] + time) / program.duration if program.duration > 0.0 else 1.0
        x, y, z = (snapshot.world_t(arm.base) @ tip(q) @ point)[:3, 3]
        unit = frame.unit
        words = (
            f"at {100.0 * share:.1f}% of the motion{f', in step {step},' if program.step_count else ''} with the joint "
            f"{frame.joint.name!r} of {frame.robot.name!r} at {frame.position + displacement:.4g} {unit}, "
            f"{displacement:+.4g} {unit} from where it is (TCP at x {x:.4f}, y {y:.4f}, z {z:.4f} m in the world)"
        )
        metadata: dict[str, object] = {
            "robot": robot.name,
            "step": step,
            "fraction": f"{share:.6f}",
            "tracked_position": f"{frame.position + displacement:.6f}",
            "displacement": f"{displacement:.6f}",
            "position": f"{x:.6f}, {y:.6f}, {z:.6f}",
        }
        return words, metadata

    return place
