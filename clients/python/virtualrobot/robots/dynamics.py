"""Masses of tools and parts, and the torques that a movement takes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from virtualrobot._wire.arguments import ArrayLike, checked
from virtualrobot._wire.messages import Wrapped, array_message, array_of, vector_message
from virtualrobot._wire.showing import shown
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.v1 import geometry_pb2, nodes_pb2, robot_pb2

Samples = Mapping[str, ArrayLike] | ArrayLike
"""Values of joints: by name, a number or one for each sample; or in order, (k,) or (n, k)."""


class Inertial(Wrapped[nodes_pb2.Inertial]):
    """Mass of a body and how it is spread; `inertial` makes it."""

    __slots__ = ()
    _called = "what virtualrobot.inertial makes"


@checked
def inertial(
    mass: float,
    center_of_mass: ArrayLike = (0.0, 0.0, 0.0),
    diagonal: ArrayLike = (0.0, 0.0, 0.0),
    products: ArrayLike = (0.0, 0.0, 0.0),
) -> Inertial:
    """Return a mass and how it is spread, for `add_tool` and `add_part`.

    Args:
        mass: the mass (kg), above 0.
        center_of_mass: x, y, z in meters, in the frame of the tool or part.
        diagonal: xx, yy, zz of the inertia about the centre of mass in kg m^2, along the axes of that frame.
        products: xy, xz, yz of it; the entries of the matrix, as in URDF.

    Example:
        >>> scene.add_tool("gripper", robot.flange, inertial=virtualrobot.inertial(0.9, (0, 0, 0.06)))
    """
    if not 0.0 < mass < np.inf:
        raise InvalidArgumentError(f"a mass is above 0 kg, not {mass}")
    message = nodes_pb2.Inertial(
        mass_kilograms=mass,
        link_t_inertial=geometry_pb2.Pose(position=vector_message(center_of_mass, "the centre of mass")),
        diagonal=vector_message(diagonal, "the diagonal of the inertia"),
        products=vector_message(products, "the products of inertia"),
    )
    return Inertial(message)


@dataclass(frozen=True, slots=True)
class EffortViolation:
    """An effort above its joint's limit: at `sample` (from 0), both in N m (sliding joints: N)."""

    joint: str
    sample: int
    effort: float
    limit: float


@shown
@dataclass(frozen=True, slots=True)
class InverseDynamics:
    """Inverse dynamics of a movement of n samples of k joints: efforts and base wrenches.

    Attributes:
        joint_names: the joints that the columns are.
        efforts: (n, k), effort of each joint on the link that it moves: N m, for sliding joints N.
        gravity_efforts: (n, k), that part of the efforts which holds the weight at rest.
        base_wrenches: (n, 6), force in N and moment in N m about the robot's origin that hold its base, in its frame.
        first_violation: the first effort above its joint's limit; None when there is none or no limit is known.
        payload: mass (kg) of the bodies that the robot carries besides its links.
        warnings: bodies that have no mass though they are moved, and bodies that count only as points.
    """

    joint_names: tuple[str, ...]
    efforts: NDArray[np.float64]
    gravity_efforts: NDArray[np.float64]
    base_wrenches: NDArray[np.float64]
    first_violation: EffortViolation | None
    payload: float
    warnings: tuple[str, ...]

    @staticmethod
    def of(message: robot_pb2.SolveInverseDynamicsResponse) -> InverseDynamics:
        """Return what a message tells."""
        first = message.first_violation
        violation = EffortViolation(first.joint, first.sample, first.effort, first.limit)
        return InverseDynamics(
            tuple(message.joint_names),
            array_of(message.efforts),
            array_of(message.gravity_efforts),
            array_of(message.base_wrenches),
            violation if message.HasField("first_violation") else None,
            message.payload_kilograms,
            tuple(message.warnings),
        )


def movement_message(
    robot: str,
    joint_names: list[str],
    positions: Samples | None,
    velocities: Samples | None,
    accelerations: Samples | None,
) -> robot_pb2.SolveInverseDynamicsRequest:
    """Return a movement as a message; values by name say which joints the columns are."""
    given = {"positions": positions, "velocities": velocities, "accelerations": accelerations}
    told = {field: values for field, values in given.items() if values is not None}
    if named := [values for values in told.values() if isinstance(values, Mapping)]:
        if len(named) < len(told) or joint_names:
            raise InvalidArgumentError("give all values by joint name, or all in order")
        joint_names = list(dict.fromkeys(str(name) for values in named for name in values))
    request = robot_pb2.SolveInverseDynamicsRequest(robot=robot, joint_names=joint_names)
    rows = {field: sample_rows(values, joint_names, field) for field, values in told.items()}
    count = max((len(array) for array in rows.values()), default=1)
    for field, array in rows.items():
        # A single row holds for all samples.
        whole = np.broadcast_to(array, (count, array.shape[1])) if len(array) == 1 else array
        getattr(request, field).CopyFrom(array_message(whole))
    return request


def sample_rows(values: Samples, names: list[str], field: str) -> NDArray[np.float64]:
    """Return values as (n, k)."""
    try:
        if isinstance(values, Mapping):
            if missing := [name for name in names if name not in values]:
                raise InvalidArgumentError(f"{field} lacks the joint {missing[0]!r}; the others name it")
            columns = np.broadcast_arrays(*(np.asarray(values[name], dtype=float) for name in names))
            array = np.stack([np.atleast_1d(column) for column in columns], axis=-1)
        else:
            array = np.atleast_2d(np.asarray(values, dtype=float))
    except (TypeError, ValueError) as error:
        raise InvalidArgumentError(f"{field} are numbers, as many for each joint: {error}") from error
    if array.ndim != 2:
        raise InvalidArgumentError(f"{field} have the shape (n, k), a column for each joint, not {array.shape}")
    return array
