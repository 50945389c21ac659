"""Whether a plan keeps the limits of a robot's actuators, where those are not the joints'."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from virtualrobot_kernel.errors import LimitError
from virtualrobot_kernel.motion.planned import Plan
from virtualrobot_kernel.motion.polynomial import PiecewisePolynomial
from virtualrobot_kernel.world.actuators import LIMIT_TOLERANCE, actuators_of, beyond
from virtualrobot_kernel.world.change import single_joint
from virtualrobot_kernel.world.state import Snapshot
from virtualrobot_kernel.world.structure import Node


def check_plan(snapshot: Snapshot, robot: Node, joint_names: Sequence[str], plan: Plan) -> None:
    """Raise LimitError when a plan, whose columns are joints of one robot, leads an actuator beyond its limits."""
    (track,) = plan.tracks
    found = first_beyond(snapshot, robot, joint_names, track.path)
    if found is not None:
        raise found[1]


def first_beyond(
    snapshot: Snapshot, robot: Node, joint_names: Sequence[str], path: PiecewisePolynomial
) -> tuple[float, LimitError] | None:
    """Return where a path, whose columns are joints of one robot, first leads an actuator beyond its limits.

    That is a share of the path, and the refusal. Exact also between samples: an actuator's position is a linear
    combination of the joints' paths, so it is a piecewise polynomial as they are. Joints that the plan does not move
    stay where the snapshot has them.
    """
    found = []
    for actuator in actuators_of(robot):
        if not any(joint in joint_names for joint, _ in actuator.terms):
            continue
        rest = actuator.offset
        ratios = np.zeros(len(joint_names))
        for joint, ratio in actuator.terms:
            if joint in joint_names:
                ratios[joint_names.index(joint)] = ratio
            else:
                rest += ratio * float(snapshot.state.q[single_joint(snapshot.structure, robot, joint)[1]])
        coefficients = path.coefficients @ ratios[:, None]
        coefficients[:, 0, 0] += rest
        lower, upper = np.array([actuator.lower]), np.array([actuator.upper])
        excursion = PiecewisePolynomial(path.breaks, coefficients).first_excursion(lower, upper, LIMIT_TOLERANCE)
        if excursion is not None:
            share = (excursion.entered - path.start) / (path.end - path.start)
            error = beyond(robot, actuator, excursion.value, f" after {100.0 * share:.3g}% of the way")
            found.append((share, error))
    return min(found, key=lambda one: one[0], default=None)
