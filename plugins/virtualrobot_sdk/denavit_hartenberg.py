"""Serial arms as tables of Denavit-Hartenberg parameters: from a table to poses, and to the arrays of a chain.

J. Denavit and R. S. Hartenberg, A kinematic notation for lower-pair mechanisms based on matrices, J. Applied Mechanics
22, 1955. The two orders in use, with Rz(theta) for a turn about z and Tz(d) for a shift along it:

- standard: A_i = Rz(theta_i) Tz(d_i) Tx(a_i) Rx(alpha_i) (R. P. Paul, Robot Manipulators, 1981, chapter 2);
- modified: A_i = Rx(alpha_i) Tx(a_i) Rz(theta_i) Tz(d_i) (J. J. Craig, Introduction to Robotics, 1986, eq. 3.6; what
  stands in row i here are Craig's alpha_{i-1} and a_{i-1}).
"""

from __future__ import annotations

import math
from dataclasses import MISSING, dataclass, fields
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from msgspec import Meta

from virtualrobot_sdk.errors import ArgumentError
from virtualrobot_sdk.kinematics import PRISMATIC, REVOLUTE, Codes, Floats
from virtualrobot_sdk.poses import from_quaternion

Convention = Literal["standard", "modified"]
PoseNumbers = tuple[float, float, float, float, float, float, float]
"""x, y, z in meters and a quaternion x, y, z, w of any length above 0."""

GREATEST = 1e12
"""The greatest length that is taken, in meters."""


@dataclass(frozen=True, slots=True)
class Row:
    """One joint of a table."""

    type: Annotated[
        Literal["revolute", "prismatic"],
        Meta(description="Whether the joint's position is added to theta (revolute) or to d (prismatic)."),
    ] = "revolute"
    a_meters: Annotated[float, Meta(description="Length of the link, along x.")] = 0.0
    alpha_radians: Annotated[float, Meta(description="Twist of the link, about x.")] = 0.0
    d_meters: Annotated[float, Meta(description="Offset of the joint, along z.")] = 0.0
    theta_radians: Annotated[float, Meta(description="Angle of the joint, about z.")] = 0.0

    def __post_init__(self) -> None:
        """Raise ArgumentError for a number that is not finite or greater than GREATEST."""
        for name in ("a_meters", "alpha_radians", "d_meters", "theta_radians"):
            value = getattr(self, name)
            if not abs(value) <= GREATEST:
                right = f"it must be a finite number of at most {GREATEST:g}"
                raise ArgumentError(f"{name} is {value}; {right}", field=name, value=value)


@dataclass(frozen=True, slots=True)
class Table:
    """A serial arm as a Denavit-Hartenberg table."""

    convention: Annotated[
        Convention,
        Meta(description="standard: Rz(theta) Tz(d) Tx(a) Rx(alpha) (Paul); modified: Rx Tx Rz Tz (Craig)."),
    ]
    rows: Annotated[tuple[Row, ...], Meta(description="The joints from base to tip.")]
    base_t_first: Annotated[
        PoseNumbers | None,
        Meta(description="The frame before the first row in the robot's base: x y z qx qy qz qw."),
    ] = None
    last_t_flange: Annotated[
        PoseNumbers | None, Meta(description="The flange in the frame of the last row: x y z qx qy qz qw.")
    ] = None

    def __post_init__(self) -> None:
        """Raise ArgumentError when there is no row, or for a pose that is not finite or whose quaternion is zero."""
        if not self.rows:
            raise ArgumentError("rows is empty; a Denavit-Hartenberg table has a row for each joint", field="rows")
        for name in ("base_t_first", "last_t_flange"):
            numbers = getattr(self, name)
            if numbers is not None and not (
                all(abs(value) <= GREATEST for value in numbers) and math.hypot(*numbers[3:]) > 1e-9
            ):
                right = "x y z qx qy qz qw must be finite, and the quaternion not zero"
                raise ArgumentError(f"{name} is {list(numbers)}; {right}", field=name, value=numbers)


class SerialArrays(NamedTuple):
    """The geometry of a table with n rows as `SerialChain` has it, each joint at position 0.

    Joint i moves about or along z of its frame: for standard tables that of row i - 1, for modified ones that of row i.
    """

    pre: Floats
    """(n, 4, 4) pose of each joint's frame, in the frame before it; the first is in the base."""
    axis: Floats
    """(n, 3) unit axis in the joint's frame: z."""
    joint_type: Codes
    """(n,) REVOLUTE or PRISMATIC."""
    post: Floats
    """(4, 4) pose of the flange in the frame of the last joint."""
    joint_t_row: Floats
    """(n, 4, 4) pose of row i's frame, T_0^i of the textbooks, in the frame of joint i after its motion."""


def transform(row: Row, convention: Convention, position: float = 0.0) -> Floats:
    """Return A_i (4, 4): row i's frame in the frame before it, with the joint at `position` (rad or m).

    Paul 1981, chapter 2, or Craig 1986, eq. 3.6.
    """
    slides = row.type == "prismatic"
    along_z = _screw(2, row.theta_radians + (0.0 if slides else position), row.d_meters + (position if slides else 0.0))
    along_x = _screw(0, row.alpha_radians, row.a_meters)
    return along_z @ along_x if convention == "standard" else along_x @ along_z


def serial_arrays(table: Table) -> SerialArrays:
    """Return the arrays of the chain from the base to the flange.

    A turn about z and a shift along z may change places, so that a row splits into the joint's motion and a fixed rest:
    before the motion for modified tables, after it for standard ones.
    """
    n = len(table.rows)
    links = np.array([transform(row, table.convention) for row in table.rows])
    base, flange = pose(table.base_t_first), pose(table.last_t_flange)
    unmoved = np.tile(np.eye(4), (n, 1, 1))
    if table.convention == "standard":
        pre, post, joint_t_row = np.concatenate([base[None], links[:-1]]), links[-1] @ flange, links
    else:
        pre, post, joint_t_row = np.concatenate([(base @ links[0])[None], links[1:]]), flange, unmoved
    kinds = [PRISMATIC if row.type == "prismatic" else REVOLUTE for row in table.rows]
    axis = np.tile([0.0, 0.0, 1.0], (n, 1))
    return SerialArrays(pre, axis, np.array(kinds, np.int8), post, joint_t_row)


def frames(table: Table, positions: Floats) -> Floats:
    """Return the poses (n + 1, 4, 4) of the n rows' frames and of the flange in the base, at `positions` (n,).

    The product of the A_i as it stands; rad for turning joints and m for sliding ones.
    """
    reached = pose(table.base_t_first)
    found = []
    for row, position in zip(table.rows, positions.tolist(), strict=True):
        reached = reached @ transform(row, table.convention, position)
        found.append(reached)
    return np.array([*found, reached @ pose(table.last_t_flange)])


def pose(numbers: PoseNumbers | None) -> Floats:
    """Return x y z qx qy qz qw as a pose (4, 4); None is the identity."""
    result = np.eye(4)
    if numbers is not None:
        result[:3, :3] = from_quaternion(np.array(numbers[3:]) / math.hypot(*numbers[3:]))
        result[:3, 3] = numbers[:3]
    return result


def plain(table: Table) -> dict[str, Any]:
    """Return the table as plain values (dicts, lists, numbers, texts) without defaults: settings that give it again."""
    result = _told(table)
    result["rows"] = [_told(row) for row in table.rows]
    return result


def _told(settings: Row | Table) -> dict[str, Any]:
    """Return the fields that differ from their defaults; tuples as lists."""
    values = {field.name: (getattr(settings, field.name), field.default) for field in fields(settings)}
    return {
        name: list(value) if isinstance(value, tuple) else value
        for name, (value, default) in values.items()
        if default is MISSING or value != default
    }


def _screw(axis: int, angle: float, distance: float) -> Floats:
    """Return the turn about a coordinate axis (0: x, 2: z) together with the shift along it, (4, 4)."""
    c, s = math.cos(angle), math.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    result = np.eye(4)
    result[i, i] = result[j, j] = c
    result[i, j], result[j, i] = -s, s
    result[axis, 3] = distance
    return result
