"""Inverse dynamics of robots as they stand in a snapshot: torques of a movement, tools and held parts included."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot_kernel.errors import KernelError, Reason, UnknownNameError
from virtualrobot_kernel.numeric.dynamics import inverse_dynamics
from virtualrobot_kernel.planning.bodies import Bodies, bodies_of
from virtualrobot_kernel.world.change import LIMIT_TOLERANCE, check_joint_value
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Joint, Node

GRAVITY = (0.0, 0.0, -9.81)
"""Gravity in the world's frame, m/s^2; what pinocchio, MuJoCo and PyBullet's examples take too."""

MOST_SAMPLES = 100_000
"""Greatest number of samples in one call."""

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class EffortViolation:
    """Effort (N m or N) above its joint's limit, at a sample (from 0)."""

    joint: str
    sample: int
    effort: float
    limit: float


@dataclass(frozen=True, slots=True, eq=False)
class Dynamics:
    """Efforts and wrenches of a movement of n samples of k joints.

    efforts and gravity_efforts (n, k): N m or N, all and what holds the weight at rest. base_wrenches (n, 6): force (N)
    and moment (N m) about the robot's origin that hold its base, in its frame. `payload` is in kg.
    """

    joint_names: tuple[str, ...]
    efforts: Floats
    gravity_efforts: Floats
    base_wrenches: Floats
    first_violation: EffortViolation | None
    payload: float
    warnings: tuple[str, ...]


def solve_inverse_dynamics(
    snapshot: Snapshot,
    robot: Node,
    joint_names: Sequence[str] = (),
    positions: Floats | None = None,
    velocities: Floats | None = None,
    accelerations: Floats | None = None,
) -> Dynamics:
    """Return the efforts of a movement; other joints and the robot's base stand as they are in the snapshot.

    Args:
        snapshot: the world, whose tools, held parts and robots on the robot are carried along.
        robot: the robot.
        joint_names: joints of one coordinate, the k columns; empty means all of these.
        positions: (n, k) radians or meters, within the joints' limits; None: where the joints are.
        velocities: (n, k) rad/s or m/s; None: 0.
        accelerations: (n, k) rad/s^2 or m/s^2; None: 0.

    Raises:
        KernelError: arrays of different shape or that hold numbers that are not finite, too many samples (TOO_LARGE),
            a joint named twice, efforts beyond all numbers, or a robot without joints of one coordinate
            (WRONG_STATE).
        UnknownNameError: a joint that the robot has not, or that has several coordinates.
        LimitError: a position outside its joint's limits.
    """
    bodies = bodies_of(snapshot, robot)
    columns = _columns(robot, bodies, joint_names)
    joints = [bodies.joints[column] for column in columns]
    given = {"positions": positions, "velocities": velocities, "accelerations": accelerations}
    arrays = _checked({name: values for name, values in given.items() if values is not None}, len(columns))
    count = next((len(values) for values in arrays.values()), 1)
    if positions is not None:
        _check_limits(robot.name, joints, arrays["positions"])
    q = np.tile(snapshot.state.q[bodies.q_index], (count, 1))
    v, a = np.zeros_like(q), np.zeros_like(q)
    for values, name in ((q, "positions"), (v, "velocities"), (a, "accelerations")):
        if name in arrays:
            values[:, columns] = arrays[name]
    gravity = snapshot.world_t(robot.uid)[:3, :3].T @ GRAVITY
    efforts, wrenches = run(bodies, gravity, q, v, a)
    at_rest, _ = run(bodies, gravity, q, np.zeros_like(v), np.zeros_like(a))
    if not (np.isfinite(efforts).all() and np.isfinite(wrenches).all()):
        raise KernelError(
            f"velocities, accelerations or masses of {robot.name!r} are so great that its efforts are no finite "
            "numbers",
            robot=robot.name,
        )
    efforts, at_rest = efforts[:, columns], at_rest[:, columns]
    violation = first_violation(joints, efforts)
    names = tuple(joint.name for joint in joints)
    return Dynamics(names, efforts, at_rest, wrenches, violation, bodies.payload, bodies.warnings)


def run(bodies: Bodies, gravity: Floats, q: Floats, v: Floats, a: Floats) -> tuple[Floats, Floats]:
    """Return efforts (n, k) and base wrenches (n, 6) for all joints of `bodies`; gravity (3,) in the robot's frame."""
    efforts, wrenches = np.empty_like(q), np.empty((len(q), 6))
    inverse_dynamics(
        bodies.parent,
        bodies.joint_type,
        bodies.axis,
        bodies.joint_index,
        bodies.multiplier,
        bodies.offset,
        bodies.parent_t_body,
        bodies.mass,
        bodies.moment,
        bodies.inertia,
        gravity,
        q,
        v,
        a,
        efforts,
        wrenches,
    )
    return efforts, wrenches


def first_violation(joints: Sequence[Joint], efforts: Floats) -> EffortViolation | None:
    """Return the first effort above its joint's limit: of the first sample, and there of the first joint."""
    limits = np.array([joint.limits.effort for joint in joints])
    above = (np.abs(efforts) > limits) & (limits > 0.0)
    if not above.any():
        return None
    sample, column = divmod(int(above.argmax()), len(joints))
    return EffortViolation(joints[column].name, sample, float(efforts[sample, column]), float(limits[column]))


def _columns(robot: Node, bodies: Bodies, names: Sequence[str]) -> list[int]:
    """Return the places of the named joints among the bodies' joints; without names all."""
    known = [joint.name for joint in bodies.joints]
    if not known:
        raise KernelError(
            f"the robot {robot.name!r} has no joint that turns or slides; there is nothing that needs a torque",
            reason=Reason.WRONG_STATE,
            robot=robot.name,
        )
    for name in names:
        if name not in known:
            raise UnknownNameError(f"joint of {robot.name!r} that turns or slides", name, known)
        if names.count(name) > 1:
            raise KernelError(f"the joint {name!r} of {robot.name!r} is named twice", robot=robot.name, joint=name)
    return [known.index(name) for name in names or known]


def _checked(arrays: Mapping[str, Floats], joints: int) -> Mapping[str, Floats]:
    """Return the arrays after checking that all have n rows and a column for each joint, and finite numbers."""
    first = next(iter(arrays.values()), None)
    for name, values in arrays.items():
        if values.ndim != 2 or values.shape[1] != joints or not len(values):
            wanted = f"(n, {joints}), a row for each sample and a column for each joint"
            raise KernelError(f"{name} must have the shape {wanted}, not {values.shape}", field=name)
        if first is not None and values.shape != first.shape:
            raise KernelError(
                f"{name} has {len(values)} samples and {next(iter(arrays))} {len(first)}; both need as many", field=name
            )
        if len(values) > MOST_SAMPLES:
            raise KernelError(
                f"{name} has {len(values)} samples; give at most {MOST_SAMPLES} at a time",
                reason=Reason.TOO_LARGE,
                field=name,
            )
        if not np.isfinite(values).all():
            row, column = np.argwhere(~np.isfinite(values))[0].tolist()
            raise KernelError(
                f"{name}[{row}, {column}] is {values[row, column]}; give a finite number", field=name, sample=row
            )
    return arrays


def _check_limits(robot: str, joints: Sequence[Joint], positions: Floats) -> None:
    """Raise LimitError for the first position outside its joint's limits."""
    lower = np.array([joint.limits.lower for joint in joints])
    upper = np.array([joint.limits.upper for joint in joints])
    outside = (positions < lower - LIMIT_TOLERANCE) | (positions > upper + LIMIT_TOLERANCE)
    for sample, column in np.argwhere(outside)[:1].tolist():
        check_joint_value(robot, joints[column], float(positions[sample, column]))
