from virtualrobot.v1 import geometry_pb2 as _geometry_pb2
from virtualrobot.v1 import token_pb2 as _token_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class CastRaysRequest(_message.Message):
    __slots__ = ("origins", "directions", "max_range_meters", "frame", "ray_caster", "ignored")
    ORIGINS_FIELD_NUMBER: _ClassVar[int]
    DIRECTIONS_FIELD_NUMBER: _ClassVar[int]
    MAX_RANGE_METERS_FIELD_NUMBER: _ClassVar[int]
    FRAME_FIELD_NUMBER: _ClassVar[int]
    RAY_CASTER_FIELD_NUMBER: _ClassVar[int]
    IGNORED_FIELD_NUMBER: _ClassVar[int]
    origins: _geometry_pb2.NumericArray
    directions: _geometry_pb2.NumericArray
    max_range_meters: float
    frame: str
    ray_caster: str
    ignored: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, origins: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., directions: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., max_range_meters: _Optional[float] = ..., frame: _Optional[str] = ..., ray_caster: _Optional[str] = ..., ignored: _Optional[_Iterable[str]] = ...) -> None: ...

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
