from google.protobuf import timestamp_pb2 as _timestamp_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class NumericType(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    NUMERIC_TYPE_UNSPECIFIED: _ClassVar[NumericType]
    NUMERIC_TYPE_FLOAT64: _ClassVar[NumericType]
    NUMERIC_TYPE_FLOAT32: _ClassVar[NumericType]
    NUMERIC_TYPE_INT32: _ClassVar[NumericType]
    NUMERIC_TYPE_UINT8: _ClassVar[NumericType]
NUMERIC_TYPE_UNSPECIFIED: NumericType
NUMERIC_TYPE_FLOAT64: NumericType
NUMERIC_TYPE_FLOAT32: NumericType
NUMERIC_TYPE_INT32: NumericType
NUMERIC_TYPE_UINT8: NumericType

class Vector3(_message.Message):
    __slots__ = ("x", "y", "z")
    X_FIELD_NUMBER: _ClassVar[int]
    Y_FIELD_NUMBER: _ClassVar[int]
    Z_FIELD_NUMBER: _ClassVar[int]
    x: float
    y: float
    z: float
    def __init__(self, x: _Optional[float] = ..., y: _Optional[float] = ..., z: _Optional[float] = ...) -> None: ...

class Quaternion(_message.Message):
    __slots__ = ("x", "y", "z", "w")
    X_FIELD_NUMBER: _ClassVar[int]
    Y_FIELD_NUMBER: _ClassVar[int]
    Z_FIELD_NUMBER: _ClassVar[int]
    W_FIELD_NUMBER: _ClassVar[int]
    x: float
    y: float
    z: float
    w: float
    def __init__(self, x: _Optional[float] = ..., y: _Optional[float] = ..., z: _Optional[float] = ..., w: _Optional[float] = ...) -> None: ...

class Pose(_message.Message):
    __slots__ = ("position", "orientation")
    POSITION_FIELD_NUMBER: _ClassVar[int]
    ORIENTATION_FIELD_NUMBER: _ClassVar[int]
    position: Vector3
    orientation: Quaternion
    def __init__(self, position: _Optional[_Union[Vector3, _Mapping]] = ..., orientation: _Optional[_Union[Quaternion, _Mapping]] = ...) -> None: ...

class Color(_message.Message):
    __slots__ = ("red", "green", "blue", "alpha")
    RED_FIELD_NUMBER: _ClassVar[int]
    GREEN_FIELD_NUMBER: _ClassVar[int]
    BLUE_FIELD_NUMBER: _ClassVar[int]
    ALPHA_FIELD_NUMBER: _ClassVar[int]
    red: float
    green: float
    blue: float
    alpha: float
    def __init__(self, red: _Optional[float] = ..., green: _Optional[float] = ..., blue: _Optional[float] = ..., alpha: _Optional[float] = ...) -> None: ...

class NumericArray(_message.Message):
    __slots__ = ("type", "shape", "data")
    TYPE_FIELD_NUMBER: _ClassVar[int]
    SHAPE_FIELD_NUMBER: _ClassVar[int]
    DATA_FIELD_NUMBER: _ClassVar[int]
    type: NumericType
    shape: _containers.RepeatedScalarFieldContainer[int]
    data: bytes
    def __init__(self, type: _Optional[_Union[NumericType, str]] = ..., shape: _Optional[_Iterable[int]] = ..., data: _Optional[bytes] = ...) -> None: ...

class Stamp(_message.Message):
    __slots__ = ("wall_time", "simulation_time_seconds", "tick", "structure_revision", "state_revision", "tick_nanoseconds", "epoch")
    WALL_TIME_FIELD_NUMBER: _ClassVar[int]
    SIMULATION_TIME_SECONDS_FIELD_NUMBER: _ClassVar[int]
    TICK_FIELD_NUMBER: _ClassVar[int]
    STRUCTURE_REVISION_FIELD_NUMBER: _ClassVar[int]
    STATE_REVISION_FIELD_NUMBER: _ClassVar[int]
    TICK_NANOSECONDS_FIELD_NUMBER: _ClassVar[int]
    EPOCH_FIELD_NUMBER: _ClassVar[int]
    wall_time: _timestamp_pb2.Timestamp
    simulation_time_seconds: float
    tick: int
    structure_revision: int
    state_revision: int
    tick_nanoseconds: int
    epoch: int
    def __init__(self, wall_time: _Optional[_Union[_timestamp_pb2.Timestamp, _Mapping]] = ..., simulation_time_seconds: _Optional[float] = ..., tick: _Optional[int] = ..., structure_revision: _Optional[int] = ..., state_revision: _Optional[int] = ..., tick_nanoseconds: _Optional[int] = ..., epoch: _Optional[int] = ...) -> None: ...
