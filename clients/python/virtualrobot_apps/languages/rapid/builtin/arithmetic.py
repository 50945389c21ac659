"""Numbers and places: arithmetic, positions, orientations and poses. Angles are degrees, lengths mm."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from virtualrobot_apps.languages.rapid.faults import RapidFault
from virtualrobot_apps.languages.rapid.frames import inverse, product, rotated, to_euler_zyx, to_quaternion
from virtualrobot_apps.languages.rapid.support import linked, scaled
from virtualrobot_apps.languages.rapid.table import function, instruction


def _argument(compute: Callable[..., float], *values: float) -> float:
    try:
        return compute(*values)
    except ValueError as error:
        raise RapidFault("ERR_ARGVALERR", f"{', '.join(f'{one:g}' for one in values)} is outside its domain") from error


@function("Abs", "num Value", "num")
def _abs(task: object, value: float) -> float:
    """Absolute value."""
    return abs(value)


@function("Sqrt", "num Value", "num")
def _sqrt(task: object, value: float) -> float:
    """Square root."""
    return _argument(math.sqrt, value)


@function("Exp", "num Exponent", "num")
def _exp(task: object, exponent: float) -> float:
    """Power of e."""
    return math.exp(exponent)


@function("Pow", "num Base, num Exponent", "num")
def _pow(task: object, base: float, exponent: float) -> float:
    """Power of a number."""
    return _argument(math.pow, base, exponent)


@function("Sin", "num Angle", "num")
def _sin(task: object, angle: float) -> float:
    """Sine of an angle in degrees."""
    return math.sin(math.radians(angle))


@function("Cos", "num Angle", "num")
def _cos(task: object, angle: float) -> float:
    """Cosine of an angle in degrees."""
    return math.cos(math.radians(angle))


@function("Tan", "num Angle", "num")
def _tan(task: object, angle: float) -> float:
    """Tangent of an angle in degrees."""
    return math.tan(math.radians(angle))


@function("ASin", "num Value", "num")
def _asin(task: object, value: float) -> float:
    """Angle in degrees whose sine this is, -90 to 90."""
    return math.degrees(_argument(math.asin, value))


@function("ACos", "num Value", "num")
def _acos(task: object, value: float) -> float:
    """Angle in degrees whose cosine this is, 0 to 180."""
    return math.degrees(_argument(math.acos, value))


@function("ATan", "num Value", "num")
def _atan(task: object, value: float) -> float:
    """Angle in degrees whose tangent this is, -90 to 90."""
    return math.degrees(math.atan(value))


@function("ATan2", "num Y, num X", "num")
def _atan2(task: object, y: float, x: float) -> float:
    """Angle in degrees of the direction (x, y), -180 to 180."""
    return math.degrees(math.atan2(y, x))


@function("Round", r"num Val \num Dec", "num")
def _round(task: object, value: float, decimals: float | None) -> float:
    """Number rounded to so many decimals, halves away from 0."""
    power = 10.0 ** int(decimals or 0)
    return math.copysign(math.floor(abs(value) * power + 0.5) / power, value)


@function("Trunc", r"num Val \num Dec", "num")
def _trunc(task: object, value: float, decimals: float | None) -> float:
    """Number cut off after so many decimals."""
    power = 10.0 ** int(decimals or 0)
    return math.trunc(value * power) / power


@function("Min", "num A, num B", "num")
def _min(task: object, a: float, b: float) -> float:
    """Smaller one of two numbers."""
    return min(a, b)


@function("Max", "num A, num B", "num")
def _max(task: object, a: float, b: float) -> float:
    """Larger one of two numbers."""
    return max(a, b)


@function("Dim", "any Array, num Dimension", "num")
def _dim(task: object, array: Any, dimension: float) -> float:  # noqa: ANN401 an array of anything
    """Number of elements of an array along a dimension, from 1."""
    for _ in range(int(dimension) - 1):
        array = array[0] if isinstance(array, list) else None
    if not isinstance(array, list) or dimension < 1:
        raise RapidFault("ERR_INVDIM", f"the array has no dimension {dimension:g}")
    return float(len(array))


@instruction("Incr", "inout num Name")
def _incr(task: object, holder: list[float], index: int) -> None:
    """Adds 1 to a variable."""
    holder[index] += 1.0


@instruction("Decr", "inout num Name")
def _decr(task: object, holder: list[float], index: int) -> None:
    """Takes 1 from a variable."""
    holder[index] -= 1.0


@instruction("Add", "inout num Name, num AddValue")
def _add(task: object, holder: list[float], index: int, value: float) -> None:
    """Adds a number to a variable."""
    holder[index] += value


@instruction("Clear", "inout num Name")
def _clear(task: object, holder: list[float], index: int) -> None:
    """Sets a variable to 0."""
    holder[index] = 0.0


# Places.


@function("Offs", "robtarget Point, num XOffset, num YOffset, num ZOffset", "robtarget")
def _offs(task: object, point: list[Any], x: float, y: float, z: float) -> list[Any]:
    """Place beside another one, along the axes of the work object."""
    (a, b, c), *rest = point
    return [[a + x, b + y, c + z], *rest]


@function("RelTool", r"robtarget Point, num Dx, num Dy, num Dz \num Rx \num Ry \num Rz", "robtarget")
def _rel_tool(
    task: object,
    point: list[Any],
    dx: float,
    dy: float,
    dz: float,
    rx: float | None,
    ry: float | None,
    rz: float | None,
) -> list[Any]:
    """Place beside another one, along the axes of the tool, and turned about its x, then y, then z."""
    place, turn, *rest = point
    # Each turn is about an axis of the tool that the ones before have turned already.
    for axis, angle in enumerate((rx, ry, rz)):
        half = math.radians(angle or 0.0) / 2.0
        one = [math.cos(half), 0.0, 0.0, 0.0]
        one[axis + 1] = math.sin(half)
        turn = linked(turn, one)
    offset = rotated(point[1], [dx, dy, dz])
    return [[a + b for a, b in zip(place, offset, strict=True)], turn, *rest]


@function("PoseMult", "pose Pose1, pose Pose2", "pose")
def _pose_mult(task: object, first: list[Any], second: list[Any]) -> list[Any]:
    """Pose that is given in another one."""
    return product(first, second)


@function("PoseInv", "pose Pose", "pose")
def _pose_inv(task: object, pose: list[Any]) -> list[Any]:
    """Inverse of a pose."""
    return inverse(pose)


@function("PoseVect", "pose Pose, pos Pos", "pos")
def _pose_vect(task: object, pose: list[Any], place: list[float]) -> list[float]:
    """Position that is given in a pose."""
    return [a + b for a, b in zip(pose[0], rotated(pose[1], place), strict=True)]


@function("OrientZYX", "num ZAngle, num YAngle, num XAngle", "orient")
def _orient_zyx(task: object, z: float, y: float, x: float) -> list[float]:
    """Orientation that is turned about z, then its y, then its x."""
    return to_quaternion(z, y, x)


@function("EulerZYX", r"\switch X | switch Y | switch Z, orient Rotation", "num")
def _euler_zyx(task: object, x: bool | None, y: bool | None, z: bool | None, rotation: list[float]) -> float:
    """Angle of an orientation about x, y or z, of the turns about z, its y and its x."""
    if not (x or y or z):
        raise RapidFault("ERR_ARGVALERR", r"EulerZYX needs \X, \Y or \Z")
    about_z, about_y, about_x = to_euler_zyx(rotation)
    return about_x if x else about_y if y else about_z


@function("NOrient", "orient Rotation", "orient")
def _n_orient(task: object, rotation: list[float]) -> list[float]:
    """Orientation brought to length 1."""
    length = math.hypot(*rotation)
    if length < 1e-9:
        raise RapidFault("ERR_ARGVALERR", "an orientation can't be zero")
    return scaled(rotation, 1.0 / length)


@function("Distance", "pos Point1, pos Point2", "num")
def _distance(task: object, first: list[float], second: list[float]) -> float:
    """Distance of two positions."""
    return math.dist(first, second)


@function("VectMagn", "pos Vector", "num")
def _vect_magn(task: object, vector: list[float]) -> float:
    """Length of a vector."""
    return math.hypot(*vector)


@function("CrossProd", "pos Vector1, pos Vector2", "pos")
def _cross_prod(task: object, first: list[float], second: list[float]) -> list[float]:
    """Vector product of two vectors."""
    (a, b, c), (d, e, f) = first, second
    return [b * f - c * e, c * d - a * f, a * e - b * d]


@function("DotProd", "pos Vector1, pos Vector2", "num")
def _dot_prod(task: object, first: list[float], second: list[float]) -> float:
    """Scalar product of two vectors."""
    return sum(a * b for a, b in zip(first, second, strict=True))
