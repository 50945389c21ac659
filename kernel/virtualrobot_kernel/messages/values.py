"""Poses, vectors, colours, arrays and stamps: messages to NumPy and back. What comes in is checked here, once."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np
from google.protobuf.field_mask_pb2 import FieldMask
from google.protobuf.message import Message
from google.protobuf.timestamp_pb2 import Timestamp
from numpy.typing import NDArray
from virtualrobot.v1 import geometry_pb2
from virtualrobot_sdk.poses import from_quaternion, quaternion

from virtualrobot_kernel.errors import KernelError, UnknownNameError
from virtualrobot_kernel.world.state import Snapshot

GRID = 2.0**-48
PIVOTS = [3, 0, 1, 2]

FIRST_EPOCH = int(time.time() * 1000.0)
"""Epoch of a world that has not been replaced: higher than any of a kernel that ran before."""

GREATEST = 1e12
"""The greatest length that is taken, in meters: beyond the orbit of Saturn."""

MOST_DIMENSIONS = 8
"""The most dimensions of an array that are looked at; NumPy has 64 at most, and no field wants more than three."""

M = TypeVar("M", bound=Message)

DTYPES = {
    geometry_pb2.NUMERIC_TYPE_FLOAT64: np.dtype("<f8"),
    geometry_pb2.NUMERIC_TYPE_FLOAT32: np.dtype("<f4"),
    geometry_pb2.NUMERIC_TYPE_INT32: np.dtype("<i4"),
    geometry_pb2.NUMERIC_TYPE_UINT8: np.dtype("u1"),
}


def finite(value: float, what: str) -> float:
    """Return the value; raise KernelError when it is not finite."""
    if not math.isfinite(value):
        raise KernelError(f"{what} must be a finite number, not {value}", field=what, value=value)
    return value


def check_enum(message: Message, field: str) -> None:
    """Raise KernelError when an enum field holds a number that the contract does not name."""
    enum = message.DESCRIPTOR.fields_by_name[field].enum_type
    assert enum is not None
    values = enum.values_by_number
    number = getattr(message, field)
    if number not in values:
        names = ", ".join(value.name for value in values.values())
        raise KernelError(f"{field} is {number}, which has no meaning; give one of {names}", field=field, value=number)


def positive(value: float, what: str) -> float:
    """Return the value; raise KernelError when it is not finite and above 0."""
    if not 0.0 < value <= GREATEST:
        raise KernelError(f"{what} must be above 0 and at most {GREATEST:g}, not {value:g}", field=what, value=value)
    return value


def not_negative(value: float, what: str) -> float:
    """Return the value; raise KernelError when it is not finite or below 0."""
    if finite(value, what) < 0.0:
        raise KernelError(f"{what} must be 0 or above, not {value:g}", field=what, value=value)
    return value


def by_name(values: Mapping[str, float], what: str) -> dict[str, float]:
    """Return a map in the order of its keys, which in protobuf's differs from process to process.

    Raises KernelError, which names the field `what` and the key, for a number that is not finite.
    """
    return {name: finite(values[name], f"{what}[{name!r}]") for name in sorted(values)}


def vector(message: geometry_pb2.Vector3, what: str) -> tuple[float, float, float]:
    """Return x, y, z; raise KernelError when one is not finite or so great that chains of poses would overflow."""
    x, y, z = message.x, message.y, message.z
    if not (abs(x) <= GREATEST and abs(y) <= GREATEST and abs(z) <= GREATEST):
        raise KernelError(
            f"the parts of {what} must be finite and at most {GREATEST:g}, not {x:g}, {y:g}, {z:g}", field=what
        )
    return x, y, z


def vector_message(values: Iterable[float]) -> geometry_pb2.Vector3:
    """Return a Vector3 of x, y, z."""
    x, y, z = values
    return geometry_pb2.Vector3(x=x, y=y, z=z)


def color(message: geometry_pb2.Color, what: str) -> tuple[float, float, float, float]:
    """Return red, green, blue, alpha; raise KernelError unless all are from 0 to 1."""
    alpha = message.alpha if message.HasField("alpha") else 1.0
    parts = (message.red, message.green, message.blue, alpha)
    if not all(0.0 <= part <= 1.0 for part in parts):
        raise KernelError(f"{what} must have parts from 0 to 1, not {parts}", field=what)
    return parts


def color_message(color: tuple[float, ...]) -> geometry_pb2.Color:
    """Return red, green, blue, alpha as a message."""
    red, green, blue, alpha = color
    return geometry_pb2.Color(red=red, green=green, blue=blue, alpha=alpha if alpha != 1.0 else None)


def pose(message: geometry_pb2.Pose, what: str = "pose") -> NDArray[np.float64]:
    """Return a pose as a read-only (4, 4) array; absent parts are identity."""
    result = np.eye(4)
    if message.HasField("position"):
        result[:3, 3] = vector(message.position, f"{what}.position")
    if message.HasField("orientation"):
        turn = message.orientation
        result[:3, :3] = from_quaternion(snapped(np.array([turn.x, turn.y, turn.z, turn.w]), f"{what}.orientation"))
    result.setflags(write=False)
    return result


def snapped(xyzw: NDArray[np.float64], what: str) -> NDArray[np.float64]:
    """Return the unit quaternion x, y, z, w whose components lie on a grid of 2^-48, the largest one excepted.

    It is within 4e-15 rad of the one given. A quaternion on this grid survives the way to a matrix and back to the last
    bit, which no rounding to the nearest float does: so a scene that is saved and loaded again is the same.
    """
    length = float(np.linalg.norm(xyzw))
    if not (math.isfinite(length) and length > 1e-9):
        raise KernelError(f"{what} must be a quaternion of a length above 0, not {xyzw.tolist()}", field=what)
    result = np.round(xyzw / length / GRID) * GRID
    # Among components that are as good as equal always the same one is the largest: w, x, y, z.
    sizes = np.abs(result[PIVOTS])
    pivot = PIVOTS[int(np.argmax(sizes >= sizes.max() - 1e-9))]
    result[pivot] = 0.0
    result[pivot] = math.copysign(math.sqrt(1.0 - float(result @ result)), xyzw[pivot])
    return (result if result[3] > 0.0 or (result[3] == 0.0 and result[pivot] > 0.0) else -result) + 0.0


def pose_message(matrix: NDArray[np.float64]) -> geometry_pb2.Pose:
    """Return a (4, 4) pose as a message; the part that changes nothing is left out."""
    message = geometry_pb2.Pose()
    if matrix[:3, 3].any():
        message.position.CopyFrom(vector_message(matrix[:3, 3].tolist()))
    if not np.array_equal(matrix[:3, :3], np.eye(3)):
        x, y, z, w = snapped(np.array(quaternion(matrix[:3, :3])), "orientation").tolist()
        message.orientation.CopyFrom(geometry_pb2.Quaternion(x=x, y=y, z=z, w=w))
    return message


def is_identity(matrix: NDArray[np.float64]) -> bool:
    """Return whether a pose changes nothing."""
    return bool(np.array_equal(matrix, np.eye(4)))


def poses_array(matrices: NDArray[np.float64]) -> geometry_pb2.NumericArray:
    """Return (n, 4, 4) poses as an array (n, 7) of x, y, z and the quaternion x, y, z, w."""
    turns = np.array([quaternion(matrix) for matrix in matrices[:, :3, :3]]).reshape(-1, 4)
    return array_message(np.concatenate([matrices[:, :3, 3], turns], axis=1))


def array_message(
    values: NDArray, kind: geometry_pb2.NumericType = geometry_pb2.NUMERIC_TYPE_FLOAT64
) -> geometry_pb2.NumericArray:
    """Return an array as a message."""
    stored = np.ascontiguousarray(values, DTYPES[kind])
    return geometry_pb2.NumericArray(type=kind, shape=stored.shape, data=stored.tobytes())  # pyright: ignore[reportArgumentType]


def array(message: geometry_pb2.NumericArray, shape: Sequence[int | None], what: str) -> NDArray:
    """Return the array as float64 (8-bit ones as they are); None in `shape` stands for any length."""
    dtype = DTYPES.get(message.type)
    if dtype is None:
        raise KernelError(f"{what}.type must say how the numbers are stored, such as NUMERIC_TYPE_FLOAT64", field=what)
    given = tuple(message.shape)
    if len(given) > MOST_DIMENSIONS:
        raise KernelError(
            f"{what} may have {MOST_DIMENSIONS} dimensions, not {len(given)}", field=what, dimensions=len(given)
        )
    if len(given) != len(shape) or any(
        want is not None and have != want for have, want in zip(given, shape, strict=False)
    ):
        wanted = ", ".join("n" if want is None else str(want) for want in shape)
        raise KernelError(f"{what} must have the shape ({wanted}), not {given}", field=what, shape=given)
    if math.prod(given) * dtype.itemsize != len(message.data):
        raise KernelError(
            f"{what} of shape {given} needs {math.prod(given) * dtype.itemsize} bytes, not {len(message.data)}",
            field=what,
        )
    values = np.frombuffer(message.data, dtype).reshape(given)
    if dtype.kind == "f" and not (finite_ones := np.isfinite(values)).all():
        place = tuple(int(indices[0]) for indices in np.nonzero(~finite_ones))
        row = f" in row {place[0]}" if len(place) > 1 else ""
        raise KernelError(
            f"{what} holds a number that is not finite: {values[place]}{row}", field=what, place=list(place)
        )
    return values if dtype.kind == "u" else values.astype(np.float64)


def expected_revision(message: Any) -> int | None:  # noqa: ANN401 any message with the field
    """Return the revision that the structure must still have, or None where the message does not say one."""
    return message.expected_structure_revision if message.HasField("expected_structure_revision") else None


def stamp(snapshot: Snapshot) -> geometry_pb2.Stamp:
    """Return when a snapshot was true."""
    seconds = int(snapshot.wall_time)
    return geometry_pb2.Stamp(
        wall_time=Timestamp(seconds=seconds, nanos=int((snapshot.wall_time - seconds) * 1e9)),
        simulation_time_seconds=snapshot.simulation_time,
        tick=snapshot.state.tick,
        structure_revision=snapshot.structure.revision,
        state_revision=snapshot.revision,
        tick_nanoseconds=round(snapshot.tick_seconds * 1e9),
        epoch=FIRST_EPOCH + snapshot.state.epoch,
    )


def mask_fields(mask: FieldMask, message: type[Message]) -> frozenset[str] | None:
    """Return the fields that a mask wants, or None for all; raise UnknownNameError for anything but whole fields."""
    valid = message.DESCRIPTOR.fields_by_name
    for path in mask.paths:
        if path not in valid:
            raise UnknownNameError(f"field of {message.DESCRIPTOR.name}", path, valid)
    return frozenset(mask.paths) or None


def masked(message: M, fields: frozenset[str] | None) -> M:
    """Return the message with nothing but these fields (None: as it is)."""
    if fields is not None:
        for field, _ in message.ListFields():
            if field.name not in fields:
                message.ClearField(field.name)  # pyright: ignore[reportArgumentType]
    return message
