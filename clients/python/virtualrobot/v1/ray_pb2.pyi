from virtualrobot.v1 import geometry_pb2 as _geometry_pb2
from virtualrobot.v1 import view_pb2 as _view_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class CastRaysRequest(_message.Message):
    __slots__ = ("origins", "directions", "max_range_meters", "frame", "ray_caster")
    ORIGINS_FIELD_NUMBER: _ClassVar[int]
    DIRECTIONS_FIELD_NUMBER: _ClassVar[int]
    MAX_RANGE_METERS_FIELD_NUMBER: _ClassVar[int]
    FRAME_FIELD_NUMBER: _ClassVar[int]
    RAY_CASTER_FIELD_NUMBER: _ClassVar[int]
    origins: _geometry_pb2.NumericArray
    directions: _geometry_pb2.NumericArray
    max_range_meters: float
    frame: str
    ray_caster: str
    def __init__(self, origins: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., directions: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., max_range_meters: _Optional[float] = ..., frame: _Optional[str] = ..., ray_caster: _Optional[str] = ...) -> None: ...

class CastRaysResponse(_message.Message):
    __slots__ = ("stamp", "distances", "elements", "element_names", "normals", "cast_seconds")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    DISTANCES_FIELD_NUMBER: _ClassVar[int]
    ELEMENTS_FIELD_NUMBER: _ClassVar[int]
    ELEMENT_NAMES_FIELD_NUMBER: _ClassVar[int]
    NORMALS_FIELD_NUMBER: _ClassVar[int]
    CAST_SECONDS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    distances: _geometry_pb2.NumericArray
    elements: _geometry_pb2.NumericArray
    element_names: _containers.RepeatedScalarFieldContainer[str]
    normals: _geometry_pb2.NumericArray
    cast_seconds: float
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., distances: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., elements: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., element_names: _Optional[_Iterable[str]] = ..., normals: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., cast_seconds: _Optional[float] = ...) -> None: ...

class CompareRayCastersRequest(_message.Message):
    __slots__ = ("ray_casters", "rays", "seed")
    RAY_CASTERS_FIELD_NUMBER: _ClassVar[int]
    RAYS_FIELD_NUMBER: _ClassVar[int]
    SEED_FIELD_NUMBER: _ClassVar[int]
    ray_casters: _containers.RepeatedScalarFieldContainer[str]
    rays: int
    seed: int
    def __init__(self, ray_casters: _Optional[_Iterable[str]] = ..., rays: _Optional[int] = ..., seed: _Optional[int] = ...) -> None: ...

class CompareRayCastersResponse(_message.Message):
    __slots__ = ("stamp", "progress", "comparisons")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    PROGRESS_FIELD_NUMBER: _ClassVar[int]
    COMPARISONS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    progress: float
    comparisons: _containers.RepeatedCompositeFieldContainer[RayCasterComparison]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., progress: _Optional[float] = ..., comparisons: _Optional[_Iterable[_Union[RayCasterComparison, _Mapping]]] = ...) -> None: ...

class RayCasterComparison(_message.Message):
    __slots__ = ("ray_caster", "fault", "agreement", "other_element", "median_difference_meters", "largest_difference_meters", "first_cast_seconds", "cast_seconds")
    RAY_CASTER_FIELD_NUMBER: _ClassVar[int]
    FAULT_FIELD_NUMBER: _ClassVar[int]
    AGREEMENT_FIELD_NUMBER: _ClassVar[int]
    OTHER_ELEMENT_FIELD_NUMBER: _ClassVar[int]
    MEDIAN_DIFFERENCE_METERS_FIELD_NUMBER: _ClassVar[int]
    LARGEST_DIFFERENCE_METERS_FIELD_NUMBER: _ClassVar[int]
    FIRST_CAST_SECONDS_FIELD_NUMBER: _ClassVar[int]
    CAST_SECONDS_FIELD_NUMBER: _ClassVar[int]
    ray_caster: str
    fault: str
    agreement: float
    other_element: float
    median_difference_meters: float
    largest_difference_meters: float
    first_cast_seconds: float
    cast_seconds: float
    def __init__(self, ray_caster: _Optional[str] = ..., fault: _Optional[str] = ..., agreement: _Optional[float] = ..., other_element: _Optional[float] = ..., median_difference_meters: _Optional[float] = ..., largest_difference_meters: _Optional[float] = ..., first_cast_seconds: _Optional[float] = ..., cast_seconds: _Optional[float] = ...) -> None: ...

class PickRequest(_message.Message):
    __slots__ = ("camera", "camera_sensor", "width", "height", "column", "row")
    CAMERA_FIELD_NUMBER: _ClassVar[int]
    CAMERA_SENSOR_FIELD_NUMBER: _ClassVar[int]
    WIDTH_FIELD_NUMBER: _ClassVar[int]
    HEIGHT_FIELD_NUMBER: _ClassVar[int]
    COLUMN_FIELD_NUMBER: _ClassVar[int]
    ROW_FIELD_NUMBER: _ClassVar[int]
    camera: _view_pb2.Camera
    camera_sensor: str
    width: int
    height: int
    column: float
    row: float
    def __init__(self, camera: _Optional[_Union[_view_pb2.Camera, _Mapping]] = ..., camera_sensor: _Optional[str] = ..., width: _Optional[int] = ..., height: _Optional[int] = ..., column: _Optional[float] = ..., row: _Optional[float] = ...) -> None: ...

class PickResponse(_message.Message):
    __slots__ = ("stamp", "node", "world_point", "node_point", "normal", "distance_meters", "color")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    NODE_FIELD_NUMBER: _ClassVar[int]
    WORLD_POINT_FIELD_NUMBER: _ClassVar[int]
    NODE_POINT_FIELD_NUMBER: _ClassVar[int]
    NORMAL_FIELD_NUMBER: _ClassVar[int]
    DISTANCE_METERS_FIELD_NUMBER: _ClassVar[int]
    COLOR_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    node: str
    world_point: _geometry_pb2.Vector3
    node_point: _geometry_pb2.Vector3
    normal: _geometry_pb2.Vector3
    distance_meters: float
    color: _geometry_pb2.Color
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., node: _Optional[str] = ..., world_point: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., node_point: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., normal: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., distance_meters: _Optional[float] = ..., color: _Optional[_Union[_geometry_pb2.Color, _Mapping]] = ...) -> None: ...

class MeasureRequest(_message.Message):
    __slots__ = ("first", "second")
    FIRST_FIELD_NUMBER: _ClassVar[int]
    SECOND_FIELD_NUMBER: _ClassVar[int]
    first: _view_pb2.NodePoint
    second: _view_pb2.NodePoint
    def __init__(self, first: _Optional[_Union[_view_pb2.NodePoint, _Mapping]] = ..., second: _Optional[_Union[_view_pb2.NodePoint, _Mapping]] = ...) -> None: ...

class MeasureResponse(_message.Message):
    __slots__ = ("stamp", "distance_meters", "first", "second")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    DISTANCE_METERS_FIELD_NUMBER: _ClassVar[int]
    FIRST_FIELD_NUMBER: _ClassVar[int]
    SECOND_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    distance_meters: float
    first: _geometry_pb2.Vector3
    second: _geometry_pb2.Vector3
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., distance_meters: _Optional[float] = ..., first: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., second: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ...) -> None: ...

class WatchMeasureRequest(_message.Message):
    __slots__ = ("first", "second", "max_rate_hertz")
    FIRST_FIELD_NUMBER: _ClassVar[int]
    SECOND_FIELD_NUMBER: _ClassVar[int]
    MAX_RATE_HERTZ_FIELD_NUMBER: _ClassVar[int]
    first: _view_pb2.NodePoint
    second: _view_pb2.NodePoint
    max_rate_hertz: float
    def __init__(self, first: _Optional[_Union[_view_pb2.NodePoint, _Mapping]] = ..., second: _Optional[_Union[_view_pb2.NodePoint, _Mapping]] = ..., max_rate_hertz: _Optional[float] = ...) -> None: ...

class WatchMeasureResponse(_message.Message):
    __slots__ = ("measure",)
    MEASURE_FIELD_NUMBER: _ClassVar[int]
    measure: MeasureResponse
    def __init__(self, measure: _Optional[_Union[MeasureResponse, _Mapping]] = ...) -> None: ...
