from virtualrobot.v1 import geometry_pb2 as _geometry_pb2
from virtualrobot.v1 import nodes_pb2 as _nodes_pb2
from virtualrobot.v1 import token_pb2 as _token_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class Postures(_message.Message):
    __slots__ = ("robot", "group", "joint_names", "positions")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    GROUP_FIELD_NUMBER: _ClassVar[int]
    JOINT_NAMES_FIELD_NUMBER: _ClassVar[int]
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    robot: str
    group: _nodes_pb2.GroupSelection
    joint_names: _containers.RepeatedScalarFieldContainer[str]
    positions: _geometry_pb2.NumericArray
    def __init__(self, robot: _Optional[str] = ..., group: _Optional[_Union[_nodes_pb2.GroupSelection, _Mapping]] = ..., joint_names: _Optional[_Iterable[str]] = ..., positions: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ...) -> None: ...

class CalibrateToolRequest(_message.Message):
    __slots__ = ("postures",)
    POSTURES_FIELD_NUMBER: _ClassVar[int]
    postures: Postures
    def __init__(self, postures: _Optional[_Union[Postures, _Mapping]] = ...) -> None: ...

class CalibrateToolResponse(_message.Message):
    __slots__ = ("stamp", "tip", "tip_error", "point", "residuals")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    TIP_FIELD_NUMBER: _ClassVar[int]
    TIP_ERROR_FIELD_NUMBER: _ClassVar[int]
    POINT_FIELD_NUMBER: _ClassVar[int]
    RESIDUALS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    tip: _geometry_pb2.Vector3
    tip_error: _geometry_pb2.Vector3
    point: _geometry_pb2.Vector3
    residuals: _geometry_pb2.NumericArray
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., tip: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., tip_error: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., point: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., residuals: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ...) -> None: ...

class CalibrateBaseRequest(_message.Message):
    __slots__ = ("postures", "points")
    POSTURES_FIELD_NUMBER: _ClassVar[int]
    POINTS_FIELD_NUMBER: _ClassVar[int]
    postures: Postures
    points: _geometry_pb2.NumericArray
    def __init__(self, postures: _Optional[_Union[Postures, _Mapping]] = ..., points: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ...) -> None: ...

class CalibrateBaseResponse(_message.Message):
    __slots__ = ("stamp", "world_t_base", "residuals")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    WORLD_T_BASE_FIELD_NUMBER: _ClassVar[int]
    RESIDUALS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    world_t_base: _geometry_pb2.Pose
    residuals: _geometry_pb2.NumericArray
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., world_t_base: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., residuals: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ...) -> None: ...

class CalibrateJointsRequest(_message.Message):
    __slots__ = ("postures", "points", "fixed_joints", "with_base", "with_tip")
    POSTURES_FIELD_NUMBER: _ClassVar[int]
    POINTS_FIELD_NUMBER: _ClassVar[int]
    FIXED_JOINTS_FIELD_NUMBER: _ClassVar[int]
    WITH_BASE_FIELD_NUMBER: _ClassVar[int]
    WITH_TIP_FIELD_NUMBER: _ClassVar[int]
    postures: Postures
    points: _geometry_pb2.NumericArray
    fixed_joints: _containers.RepeatedScalarFieldContainer[str]
    with_base: bool
    with_tip: bool
    def __init__(self, postures: _Optional[_Union[Postures, _Mapping]] = ..., points: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., fixed_joints: _Optional[_Iterable[str]] = ..., with_base: bool = ..., with_tip: bool = ...) -> None: ...

class CalibrateJointsResponse(_message.Message):
    __slots__ = ("stamp", "joint_names", "offsets", "offset_errors", "world_t_base", "tip", "residuals_before", "residuals")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    JOINT_NAMES_FIELD_NUMBER: _ClassVar[int]
    OFFSETS_FIELD_NUMBER: _ClassVar[int]
    OFFSET_ERRORS_FIELD_NUMBER: _ClassVar[int]
    WORLD_T_BASE_FIELD_NUMBER: _ClassVar[int]
    TIP_FIELD_NUMBER: _ClassVar[int]
    RESIDUALS_BEFORE_FIELD_NUMBER: _ClassVar[int]
    RESIDUALS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    joint_names: _containers.RepeatedScalarFieldContainer[str]
    offsets: _geometry_pb2.NumericArray
    offset_errors: _geometry_pb2.NumericArray
    world_t_base: _geometry_pb2.Pose
    tip: _geometry_pb2.Vector3
    residuals_before: _geometry_pb2.NumericArray
    residuals: _geometry_pb2.NumericArray
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., joint_names: _Optional[_Iterable[str]] = ..., offsets: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., offset_errors: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., world_t_base: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., tip: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., residuals_before: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., residuals: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ...) -> None: ...
