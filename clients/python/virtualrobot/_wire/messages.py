"""NumPy arrays to messages of the contract and back."""

from __future__ import annotations

import math
import operator
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from numbers import Real
from pathlib import PurePath
from typing import Any, Generic, TypeVar

import numpy as np
from google.protobuf.internal.enum_type_wrapper import EnumTypeWrapper
from google.protobuf.message import Message
from google.protobuf.struct_pb2 import Struct, Value
from google.protobuf.text_format import MessageToString
from numpy.typing import NDArray

from virtualrobot._wire.arguments import ArrayLike
from virtualrobot._wire.showing import shown
from virtualrobot.errors import InvalidArgumentError
from virtualrobot.geometry import Matrix, checked_pose, pose_from_quaternion, quaternion_of
from virtualrobot.v1 import geometry_pb2, nodes_pb2

_DTYPES = {
    geometry_pb2.NUMERIC_TYPE_FLOAT64: np.dtype("<f8"),
    geometry_pb2.NUMERIC_TYPE_FLOAT32: np.dtype("<f4"),
    geometry_pb2.NUMERIC_TYPE_INT32: np.dtype("<i4"),
    geometry_pb2.NUMERIC_TYPE_UINT8: np.dtype("u1"),
}
_TYPES = {dtype: number for number, dtype in _DTYPES.items()}


@shown
@dataclass(frozen=True, slots=True)
class Stamp:
    """Instant of a state.

    Attributes:
        wall_time: the kernel's wall clock, UTC.
        simulation_time: simulation time (s): tick times the tick's length.
        tick: number of ticks since the world began.
        structure_revision: counts changes of the structure; `Scene.batch` and starts may demand one.
        state_revision: counts published states; equal ones tell of the same instant.
        tick_length: length of a tick (s).
        epoch: rises when the world is replaced as a whole and with each start of a kernel; what was told of a lower one
            is of another world.
    """

    wall_time: datetime
    simulation_time: float
    tick: int
    structure_revision: int
    state_revision: int
    tick_length: float
    epoch: int

    @property
    def _brief(self) -> str:
        return f"{self.simulation_time:.3f} s, tick {self.tick}"


def pair_messages(pairs: Iterable[tuple[str, str]]) -> list[nodes_pb2.NodePair]:
    """Return pairs of nodes, by their names, as messages."""
    return [nodes_pb2.NodePair(first=first, second=second) for first, second in pairs]


def several(given: str | Iterable[str]) -> list[str]:
    """Return names, of which one may be given by itself."""
    return [given] if isinstance(given, str) else list(given)


def stamp_of(message: geometry_pb2.Stamp) -> Stamp:
    """Return the stamp of a message."""
    return Stamp(
        message.wall_time.ToDatetime(UTC),
        message.simulation_time_seconds,
        message.tick,
        message.structure_revision,
        message.state_revision,
        message.tick_nanoseconds / 1e9,
        message.epoch,
    )


M = TypeVar("M", bound=Message)
_MOST_SHOWN = 200
"""Greatest size in bytes of a message that is shown field by field."""


@dataclass(frozen=True, slots=True, repr=False)
class Wrapped(Generic[M]):
    """Base of values that a function of this library makes and that others take as they are."""

    _message: M

    def __repr__(self) -> str:
        """Return the type and what the value says, in one line; of a large one what it tells of."""
        if (size := self._message.ByteSize()) > _MOST_SHOWN:
            told = ", ".join(field.name for field, _ in self._message.ListFields())
            return f"<{type(self).__name__} of {size:,} bytes: {told}>"
        return f"<{type(self).__name__} {MessageToString(self._message, as_one_line=True)}>"


def whole(value: object, what: str, most: int = 2**32 - 1) -> int:
    """Return a count, or a seed (`most` of 2**64 - 1), that a message can hold; `what` names it in the error."""
    try:
        number = operator.index(value)  # pyright: ignore[reportArgumentType] what has no index raises TypeError
    except TypeError:
        number = -1
    if not 0 <= number <= most:
        raise InvalidArgumentError(f"{what} is a whole number from 0 to {most}, not {value!r}")
    return number


Number = TypeVar("Number", int, float)


def value_or_default(value: Number | None, what: str) -> Number | int:
    """Return a number for a field in which 0 means the default, as None does here; 0 itself is refused."""
    if value == 0:
        raise InvalidArgumentError(f"{what} is {value!r}; it must not be 0, and None means the default")
    return 0 if value is None else value


def count_or_default(value: int | None, what: str) -> int:
    """Return a count for a field in which 0 means the default, as None does here; 0 itself is refused."""
    return whole(value_or_default(value, what), what)


def count_or_none(value: int | None, what: str) -> int | None:
    """Return a count for a field that may be absent, as None is here."""
    return None if value is None else whole(value, what)


def seed_of(value: object) -> int:
    """Return what noise or rays are drawn from as a message holds it."""
    return whole(value, "a seed", 2**64 - 1)


def vector_message(values: ArrayLike, what: str = "a vector") -> geometry_pb2.Vector3:
    """Return three finite numbers as a message; `what` names them in the error."""
    array = np.asarray(values, dtype=float)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise InvalidArgumentError(f"{what} has 3 finite numbers, not {np.asarray(values).tolist()}")
    return geometry_pb2.Vector3(x=array[0], y=array[1], z=array[2])


def pose_message(matrix: ArrayLike) -> geometry_pb2.Pose:
    """Return a 4x4 pose as a message."""
    matrix = checked_pose(matrix)
    x, y, z, w = quaternion_of(matrix)
    return geometry_pb2.Pose(
        position=vector_message(matrix[:3, 3]), orientation=geometry_pb2.Quaternion(x=x, y=y, z=z, w=w)
    )


def pose_of(message: geometry_pb2.Pose) -> Matrix:
    """Return a message as a 4x4 pose."""
    p, q = message.position, message.orientation
    turn = (q.x, q.y, q.z, q.w) if message.HasField("orientation") else (0.0, 0.0, 0.0, 1.0)
    return pose_from_quaternion((p.x, p.y, p.z), turn)


def vector_of(message: geometry_pb2.Vector3) -> NDArray[np.float64]:
    """Return x, y, z as an array (3,)."""
    return np.array([message.x, message.y, message.z])


def array_message(values: ArrayLike, dtype: str = "<f8") -> geometry_pb2.NumericArray:
    """Return numbers as a message of bulk numbers, stored as `dtype`: <f8, <f4, <i4 or u1."""
    array = np.ascontiguousarray(values, dtype=np.dtype(dtype))
    return geometry_pb2.NumericArray(type=_TYPES[array.dtype], shape=array.shape, data=array.tobytes())


def array_of(message: geometry_pb2.NumericArray) -> NDArray[Any]:
    """Return bulk numbers as an array of their own shape; read-only, without a copy. An absent one is empty."""
    if message.type not in _DTYPES:
        return np.empty(0)
    return np.frombuffer(message.data, _DTYPES[message.type]).reshape(tuple(message.shape))


def words_of(enum: EnumTypeWrapper, prefix: str) -> dict[int, str]:
    """Return the names of an enum's numbers in small letters, without what all begin with; that of 0 says nothing."""
    return {number: name.removeprefix(prefix).lower() for name, number in enum.items() if number}


def joint_map(values: Mapping[str, float]) -> dict[str, float]:
    """Return joint values by name as plain floats."""
    return {str(name): float(value) for name, value in values.items()}


def settings_message(settings: Mapping[str, object]) -> Struct:
    """Return a component's settings as a message: numbers, text, true or false, lists and groups (by name) of these.

    Arrays count as lists and paths as text. Raises InvalidArgumentError for anything else.
    """
    if not isinstance(settings, Mapping):
        raise InvalidArgumentError(f"settings are a dictionary, not {settings!r}")
    message = Struct()
    message.update(_plain(settings, ""))
    return message


def settings_of(message: Struct) -> dict[str, Any]:
    """Return a component's settings, or a JSON schema, as dictionaries (by name) and lists; whole numbers are int."""
    # A message keeps no order.
    return {name: _value_of(message.fields[name]) for name in sorted(message.fields)}


def _plain(value: object, path: str) -> Any:  # noqa: ANN401 what a Struct takes
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if value is None or isinstance(value, bool | str):
        return value
    if isinstance(value, Real) and math.isfinite(value):
        return float(value)
    if isinstance(value, PurePath):
        return str(value)
    if isinstance(value, Mapping):
        return {str(name): _plain(inner, f"{path}.{name}" if path else str(name)) for name, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(inner, f"{path}[{number}]") for number, inner in enumerate(value)]
    raise InvalidArgumentError(
        f"the setting {path!r} is {value!r}; it must be a finite number, text, true or false, a list or a dictionary"
    )


def _value_of(value: Value) -> Any:  # noqa: ANN401 what the Struct holds
    kind = value.WhichOneof("kind")
    if kind == "struct_value":
        return settings_of(value.struct_value)
    if kind == "list_value":
        return [_value_of(inner) for inner in value.list_value.values]
    if kind in (None, "null_value"):
        return None
    plain = getattr(value, kind)
    # A Struct has float64 only.
    return int(plain) if kind == "number_value" and plain.is_integer() and abs(plain) < 2**53 else plain


_COLORS = {
    "white": (1.0, 1.0, 1.0),
    "black": (0.0, 0.0, 0.0),
    "grey": (0.5, 0.5, 0.5),
    "gray": (0.5, 0.5, 0.5),
    "red": (0.85, 0.15, 0.12),
    "green": (0.18, 0.62, 0.25),
    "blue": (0.13, 0.38, 0.80),
    "yellow": (0.95, 0.78, 0.15),
    "orange": (0.95, 0.50, 0.10),
    "purple": (0.50, 0.25, 0.65),
    "brown": (0.55, 0.38, 0.22),
    "cyan": (0.10, 0.70, 0.75),
}


def color_message(color: str | ArrayLike) -> geometry_pb2.Color:
    """Return a colour: a name, `#rrggbb`, `#rrggbbaa`, or 3 or 4 numbers from 0 to 1 (the last: opacity)."""
    if isinstance(color, str):
        if color.lower() in _COLORS:
            values = np.array(_COLORS[color.lower()])
        else:
            try:
                values = np.frombuffer(bytes.fromhex(color.removeprefix("#")), np.uint8) / 255.0
            except ValueError:
                values = np.empty(0)
            if not color.startswith("#") or values.size not in (3, 4):
                raise InvalidArgumentError(f"{color!r} is no colour: use {', '.join(sorted(_COLORS))} or #rrggbb")
    else:
        values = np.asarray(color, dtype=float)
    if values.shape not in ((3,), (4,)) or not ((values >= 0) & (values <= 1)).all():
        raise InvalidArgumentError(f"a colour has 3 or 4 numbers from 0 to 1, not {np.asarray(color).tolist()}")
    message = geometry_pb2.Color(red=values[0], green=values[1], blue=values[2])
    if values.size == 4:
        message.alpha = values[3]
    return message


def group_message(group: str | tuple[str, str] | None) -> nodes_pb2.GroupSelection | None:
    """Return the choice of a group by name, or by (base link, tip link); None for none."""
    if group is None:
        return None
    if isinstance(group, str):
        return nodes_pb2.GroupSelection(name=group)
    base, tip = group
    return nodes_pb2.GroupSelection(base_link=base, tip_link=tip)
