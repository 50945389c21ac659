"""Inverse kinematics and paths of tool centre points, with objectives of the joints that these leave free."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from virtualrobot_sdk.kinematics import InverseOptions, InverseResult, InverseStatus, Kinematics, SerialChain
from virtualrobot_sdk.poses import inverse, rotation_vector

from virtualrobot_kernel.errors import KernelError, Reason, UnknownNameError
from virtualrobot_kernel.motion.nullspace import (
    NonsmoothObjective,
    SecondaryObjective,
    improved,
    joint_limit_clearance,
    manipulability,
    obstacle_clearance,
    posture_distance,
)
from virtualrobot_kernel.motion.resolved_rate import TcpKinematics
from virtualrobot_kernel.planning.redundancy import FREE, NearOf, Preference, Redundancy
from virtualrobot_kernel.planning.robots import (
    Arm,
    SolverOf,
    arm_of,
    joint_vector,
    kind_of_joint,
    locked_arm,
    tip_t_tcp,
)
from virtualrobot_kernel.units import millimetres_question
from virtualrobot_kernel.world.figures import Pose
from virtualrobot_kernel.world.groups import WHOLE, Group
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Node, TargetData

IMPROVED = 8
"""Number of solutions of a component that are improved: those nearest to the seed."""
IMPROVED_NONSMOOTH = 3
"""Number of solutions that are improved where an objective takes long to ask."""
NEEDED = 6
"""Number of joints that a pose takes: an arm with no more has none to spare."""
_SAME = 1e-4
_FOUND = 1e-6


def cartesian_tcp(
    snapshot: Snapshot, arm: Arm, solver_of: SolverOf, redundancy: Redundancy, near_of: NearOf | None = None
) -> TcpKinematics:
    """Return the chosen tool centre point of an arm as it is led along a path, with the objective of free joints."""
    tcp = TcpKinematics(solver_of(snapshot, arm), tip_t_tcp(snapshot, arm))
    start = snapshot.state.q[arm.q_index]
    return replace(tcp, objective=objective_of(snapshot, arm, redundancy, tcp.jacobian, start, near_of))


def objective_of(
    snapshot: Snapshot,
    arm: Arm,
    redundancy: Redundancy,
    jacobian: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    start: NDArray[np.float64],
    near_of: NearOf | None = None,
) -> SecondaryObjective | None:
    """Return the objective for the joints (k,) of an arm; None without an objective or without a joint to spare.

    `snapshot` is the world that distances are measured in, `jacobian` gives (6, k), `start` (k,) is where its lengths
    are made comparable, `near_of` measures the distances. Raises UnknownNameError for a joint of a
    posture that the arm has not.
    """
    chain = arm.serial()
    for name in redundancy.posture:
        if name not in chain.joint_names and name not in redundancy.locked_joints:
            raise UnknownNameError(kind_of_joint(arm), name, chain.joint_names)
    if len(chain.joint_names) <= NEEDED:
        return None
    match redundancy.preference:
        case Preference.JOINT_LIMITS:
            return joint_limit_clearance(chain.lower, chain.upper)
        case Preference.POSTURE:
            return posture_distance(np.array([redundancy.posture.get(name, np.nan) for name in chain.joint_names]))
        case Preference.MANIPULABILITY:
            given = jacobian(start)
            lever = float(np.linalg.norm(given[:3], axis=0)[np.linalg.norm(given[3:], axis=0) > 1e-9].max(initial=0.0))
            weights = np.array([1.0 / lever if lever > 1e-6 else 1.0] * 3 + [1.0] * 3)[:, None]
            return manipulability(lambda q: jacobian(q) * weights)
        case Preference.DISTANCE:
            assert near_of is not None, "nothing measures distances"
            return obstacle_clearance(near_of(snapshot, arm), chain.lower, chain.upper)
        case Preference.UNSPECIFIED:
            return None


def solve_inverse(
    snapshot: Snapshot,
    robot: Node,
    world_t_tcp: Pose,
    seed: Mapping[str, float],
    solver_of: SolverOf,
    configuration: str = "",
    redundancy: Redundancy = FREE,
    group: Group = WHOLE,
    near_of: NearOf | None = None,
) -> tuple[Arm, InverseResult]:
    """Return the arm of a group and the joints that bring its tool centre point to `world_t_tcp` (4, 4).

    Only those of one configuration where it is named; an unknown name is refused with the component's own words. The
    solutions have all joints of the arm; those that are locked are where they are locked. With a preference each is the
    best near one that the component gives, and the best comes first.
    """
    arm = arm_of(snapshot, robot, group)
    reduced = locked_arm(arm, redundancy.locked_joints)
    solver = solver_of(snapshot, reduced)
    base_t_tip = inverse(snapshot.world_t(arm.base)) @ world_t_tcp @ inverse(tip_t_tcp(snapshot, arm))
    start = joint_vector(snapshot, reduced, seed)
    options = InverseOptions(seed=start, configuration=configuration, arm_angle=redundancy.arm_angle)
    result = solver.inverse(base_t_tip, options)
    if (objective := objective_of(snapshot, reduced, redundancy, solver.jacobian, start, near_of)) is not None:
        result = _preferred(solver, reduced.serial(), base_t_tip, result, options, objective)
    if redundancy.arm_angle is not None and len(result.solutions) and not result.arm_angles:
        raise KernelError(
            f"the kinematics component of {robot.name!r} knows no arm angle, so {redundancy.arm_angle:g} cannot be "
            "given; choose `arm_angle`",
            robot=robot.name,
            field="arm_angle_radians",
        )
    return arm, result._replace(solutions=_expanded(arm, reduced, result.solutions))


def reached(
    snapshot: Snapshot,
    robot: Node,
    world_t_tcp: Pose,
    solver_of: SolverOf,
    configuration: str = "",
    redundancy: Redundancy = FREE,
    group: Group = WHOLE,
    near_of: NearOf | None = None,
    reference: str = "",
) -> tuple[Arm, list[NDArray[np.float64]]]:
    """Return the arm and its solutions (k,), at least one, as `solve_inverse` does from where the joints are.

    Where `reference`, the node in whose frame the goal is given, is a target that was taught with this robot, it does
    so from where the joints were then. Raise KernelError when there is none: LIMIT_EXCEEDED where the component knows
    that only limits forbid it, else UNREACHABLE.
    """
    seed = taught_positions(snapshot, arm_of(snapshot, robot, group), reference)
    arm, result = solve_inverse(
        snapshot, robot, world_t_tcp, seed, solver_of, configuration, redundancy, group, near_of
    )
    if not len(result.solutions):
        outside = result.status is InverseStatus.OUTSIDE_LIMITS
        base = snapshot.world_t_node[snapshot.structure.rows[robot.uid]]
        far = float(np.linalg.norm(world_t_tcp[:3, 3] - base[:3, 3]))
        raise KernelError(
            f"{robot.name!r}{group} cannot reach the pose: {result.reason}{millimetres_question(far)}",
            reason=Reason.LIMIT_EXCEEDED if outside else Reason.UNREACHABLE,
            robot=robot.name,
            position_error_meters=result.position_error,
            rotation_error_radians=result.rotation_error,
        )
    return arm, list(result.solutions)


def taught_positions(snapshot: Snapshot, arm: Arm, reference: str) -> dict[str, float]:
    """Return where the joints of an arm were, by name, when a target was taught with its robot, as far as limits allow.

    Empty where `reference` is no target, or was taught with another robot or other joints.
    """
    target = snapshot.structure.node(reference).data
    if arm.chain is None or not isinstance(target, TargetData) or target.robot != arm.robot.name:
        return {}
    limits = zip(arm.joint_names, arm.chain.lower.tolist(), arm.chain.upper.tolist(), strict=True)
    taught = target.joint_positions
    return {name: min(max(taught[name], lower), upper) for name, lower, upper in limits if name in taught}


def _preferred(
    solver: Kinematics,
    chain: SerialChain,
    base_t_tip: Pose,
    result: InverseResult,
    options: InverseOptions,
    objective: SecondaryObjective,
) -> InverseResult:
    """Return solutions improved by an objective: each the best near one of them, the best first, with its own name."""

    def deviation(q: NDArray[np.float64]) -> NDArray[np.float64]:
        reached = solver.forward(q)[-1]
        turn = rotation_vector(base_t_tip[:3, :3] @ reached[:3, :3].T)
        return np.concatenate([base_t_tip[:3, 3] - reached[:3, 3], turn])

    told: list[tuple[float, NDArray[np.float64], str, tuple[float, ...]]] = []
    most = IMPROVED_NONSMOOTH if isinstance(objective, NonsmoothObjective) else IMPROVED
    for i, given in enumerate(result.solutions[:most]):
        best = improved(solver.jacobian, deviation, given, objective, chain.lower, chain.upper)
        # The component tells its name: on its way a posture may have come to another branch.
        again = solver.inverse(base_t_tip, replace(options, seed=best))
        off = np.abs(again.solutions - best).max(axis=1, initial=0.0)
        if len(off) and off.min() < _FOUND:
            j = int(off.argmin())
            best, name, angles = again.solutions[j], again.configurations[j], again.arm_angles[j : j + 1]
        elif result.configurations[i] or result.arm_angles:
            # What has left the wanted configuration is of no use, nor is what nobody tells the arm angle of.
            best, name, angles = given, result.configurations[i], result.arm_angles[i : i + 1]
        else:
            name, angles = "", ()
        if not any(np.abs(best - other).max() < _SAME for _, other, _, _ in told):
            told.append((objective(best)[0], best, name, angles))
    told.sort(key=lambda one: one[0])
    return result._replace(
        solutions=np.array([q for _, q, _, _ in told]).reshape(-1, len(chain.joint_names)),
        configurations=tuple(name for _, _, name, _ in told),
        arm_angles=tuple(angle for _, _, _, angles in told for angle in angles),
    )


def _expanded(arm: Arm, reduced: Arm, solutions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return solutions (m, k) of all joints from those of an arm with locked ones."""
    if not reduced.locked:
        return solutions
    every = np.empty((len(solutions), len(arm.q_index)))
    free = dict(zip(reduced.q_index.tolist(), solutions.T, strict=True))
    for column, place in zip(every.T, arm.q_index.tolist(), strict=True):
        column[:] = free[place] if place in free else reduced.locked[place]
    return every
