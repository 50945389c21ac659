from google.protobuf import struct_pb2 as _struct_pb2
from virtualrobot.v1 import geometry_pb2 as _geometry_pb2
from virtualrobot.v1 import sensing_pb2 as _sensing_pb2
from virtualrobot.v1 import token_pb2 as _token_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class SensorState(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    SENSOR_STATE_UNSPECIFIED: _ClassVar[SensorState]
    SENSOR_STATE_STOPPED: _ClassVar[SensorState]
    SENSOR_STATE_RUNNING: _ClassVar[SensorState]
    SENSOR_STATE_FAULT: _ClassVar[SensorState]

class SensorKind(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    SENSOR_KIND_UNSPECIFIED: _ClassVar[SensorKind]
    SENSOR_KIND_RANGE: _ClassVar[SensorKind]
    SENSOR_KIND_CAMERA: _ClassVar[SensorKind]
    SENSOR_KIND_CONTACT: _ClassVar[SensorKind]
    SENSOR_KIND_MOTION: _ClassVar[SensorKind]

class ReadingFrame(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    READING_FRAME_UNSPECIFIED: _ClassVar[ReadingFrame]
    READING_FRAME_SENSOR: _ClassVar[ReadingFrame]
    READING_FRAME_ROBOT: _ClassVar[ReadingFrame]
    READING_FRAME_WORLD: _ClassVar[ReadingFrame]
SENSOR_STATE_UNSPECIFIED: SensorState
SENSOR_STATE_STOPPED: SensorState
SENSOR_STATE_RUNNING: SensorState
SENSOR_STATE_FAULT: SensorState
SENSOR_KIND_UNSPECIFIED: SensorKind
SENSOR_KIND_RANGE: SensorKind
SENSOR_KIND_CAMERA: SensorKind
SENSOR_KIND_CONTACT: SensorKind
SENSOR_KIND_MOTION: SensorKind
READING_FRAME_UNSPECIFIED: ReadingFrame
READING_FRAME_SENSOR: ReadingFrame
READING_FRAME_ROBOT: ReadingFrame
READING_FRAME_WORLD: ReadingFrame

class ListSensorsRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class ListSensorsResponse(_message.Message):
    __slots__ = ("stamp", "sensors")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    SENSORS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    sensors: _containers.RepeatedCompositeFieldContainer[SensorStatus]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., sensors: _Optional[_Iterable[_Union[SensorStatus, _Mapping]]] = ...) -> None: ...

class SensorStatus(_message.Message):
    __slots__ = ("name", "kind", "state", "fault", "rate_hertz", "readings", "missed", "mean_reading_seconds")
    NAME_FIELD_NUMBER: _ClassVar[int]
    KIND_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    FAULT_FIELD_NUMBER: _ClassVar[int]
    RATE_HERTZ_FIELD_NUMBER: _ClassVar[int]
    READINGS_FIELD_NUMBER: _ClassVar[int]
    MISSED_FIELD_NUMBER: _ClassVar[int]
    MEAN_READING_SECONDS_FIELD_NUMBER: _ClassVar[int]
    name: str
    kind: SensorKind
    state: SensorState
    fault: str
    rate_hertz: float
    readings: int
    missed: int
    mean_reading_seconds: float
    def __init__(self, name: _Optional[str] = ..., kind: _Optional[_Union[SensorKind, str]] = ..., state: _Optional[_Union[SensorState, str]] = ..., fault: _Optional[str] = ..., rate_hertz: _Optional[float] = ..., readings: _Optional[int] = ..., missed: _Optional[int] = ..., mean_reading_seconds: _Optional[float] = ...) -> None: ...

class StartSensors(_message.Message):
    __slots__ = ("sensors",)
    SENSORS_FIELD_NUMBER: _ClassVar[int]
    sensors: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, sensors: _Optional[_Iterable[str]] = ...) -> None: ...

class StopSensors(_message.Message):
    __slots__ = ("sensors",)
    SENSORS_FIELD_NUMBER: _ClassVar[int]
    sensors: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, sensors: _Optional[_Iterable[str]] = ...) -> None: ...

class ReadingOptions(_message.Message):
    __slots__ = ("intensities", "elements", "points", "frame", "images")
    INTENSITIES_FIELD_NUMBER: _ClassVar[int]
    ELEMENTS_FIELD_NUMBER: _ClassVar[int]
    POINTS_FIELD_NUMBER: _ClassVar[int]
    FRAME_FIELD_NUMBER: _ClassVar[int]
    IMAGES_FIELD_NUMBER: _ClassVar[int]
    intensities: bool
    elements: bool
    points: bool
    frame: ReadingFrame
    images: _containers.RepeatedScalarFieldContainer[_sensing_pb2.ImageKind]
    def __init__(self, intensities: bool = ..., elements: bool = ..., points: bool = ..., frame: _Optional[_Union[ReadingFrame, str]] = ..., images: _Optional[_Iterable[_Union[_sensing_pb2.ImageKind, str]]] = ...) -> None: ...

class ReadSensorRequest(_message.Message):
    __slots__ = ("sensor", "options")
    SENSOR_FIELD_NUMBER: _ClassVar[int]
    OPTIONS_FIELD_NUMBER: _ClassVar[int]
    sensor: str
    options: ReadingOptions
    def __init__(self, sensor: _Optional[str] = ..., options: _Optional[_Union[ReadingOptions, _Mapping]] = ...) -> None: ...

class ReadSensorResponse(_message.Message):
    __slots__ = ("reading",)
    READING_FIELD_NUMBER: _ClassVar[int]
    reading: SensorReading
    def __init__(self, reading: _Optional[_Union[SensorReading, _Mapping]] = ...) -> None: ...

class WatchReadingsRequest(_message.Message):
    __slots__ = ("sensors", "options", "max_rate_hertz", "every_reading", "run")
    SENSORS_FIELD_NUMBER: _ClassVar[int]
    OPTIONS_FIELD_NUMBER: _ClassVar[int]
    MAX_RATE_HERTZ_FIELD_NUMBER: _ClassVar[int]
    EVERY_READING_FIELD_NUMBER: _ClassVar[int]
    RUN_FIELD_NUMBER: _ClassVar[int]
    sensors: _containers.RepeatedScalarFieldContainer[str]
    options: ReadingOptions
    max_rate_hertz: float
    every_reading: bool
    run: bool
    def __init__(self, sensors: _Optional[_Iterable[str]] = ..., options: _Optional[_Union[ReadingOptions, _Mapping]] = ..., max_rate_hertz: _Optional[float] = ..., every_reading: bool = ..., run: bool = ...) -> None: ...

class WatchReadingsResponse(_message.Message):
    __slots__ = ("readings",)
    READINGS_FIELD_NUMBER: _ClassVar[int]
    readings: _containers.RepeatedCompositeFieldContainer[SensorReading]
    def __init__(self, readings: _Optional[_Iterable[_Union[SensorReading, _Mapping]]] = ...) -> None: ...

class SensorReading(_message.Message):
    __slots__ = ("stamp", "sensor", "state", "fault", "number", "missed", "world_t_sensor", "lost", "range", "camera", "contact", "imu", "encoders", "pose", "wrench")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    SENSOR_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    FAULT_FIELD_NUMBER: _ClassVar[int]
    NUMBER_FIELD_NUMBER: _ClassVar[int]
    MISSED_FIELD_NUMBER: _ClassVar[int]
    WORLD_T_SENSOR_FIELD_NUMBER: _ClassVar[int]
    LOST_FIELD_NUMBER: _ClassVar[int]
    RANGE_FIELD_NUMBER: _ClassVar[int]
    CAMERA_FIELD_NUMBER: _ClassVar[int]
    CONTACT_FIELD_NUMBER: _ClassVar[int]
    IMU_FIELD_NUMBER: _ClassVar[int]
    ENCODERS_FIELD_NUMBER: _ClassVar[int]
    POSE_FIELD_NUMBER: _ClassVar[int]
    WRENCH_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    sensor: str
    state: SensorState
    fault: str
    number: int
    missed: int
    world_t_sensor: _geometry_pb2.Pose
    lost: int
    range: RangeReading
    camera: CameraReading
    contact: ContactReading
    imu: ImuReading
    encoders: EncoderReading
    pose: PoseReading
    wrench: WrenchReading
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., sensor: _Optional[str] = ..., state: _Optional[_Union[SensorState, str]] = ..., fault: _Optional[str] = ..., number: _Optional[int] = ..., missed: _Optional[int] = ..., world_t_sensor: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., lost: _Optional[int] = ..., range: _Optional[_Union[RangeReading, _Mapping]] = ..., camera: _Optional[_Union[CameraReading, _Mapping]] = ..., contact: _Optional[_Union[ContactReading, _Mapping]] = ..., imu: _Optional[_Union[ImuReading, _Mapping]] = ..., encoders: _Optional[_Union[EncoderReading, _Mapping]] = ..., pose: _Optional[_Union[PoseReading, _Mapping]] = ..., wrench: _Optional[_Union[WrenchReading, _Mapping]] = ...) -> None: ...

class RangeReading(_message.Message):
    __slots__ = ("distances", "valid", "intensities", "elements", "element_names", "points", "frame", "ages")
    DISTANCES_FIELD_NUMBER: _ClassVar[int]
    VALID_FIELD_NUMBER: _ClassVar[int]
    INTENSITIES_FIELD_NUMBER: _ClassVar[int]
    ELEMENTS_FIELD_NUMBER: _ClassVar[int]
    ELEMENT_NAMES_FIELD_NUMBER: _ClassVar[int]
    POINTS_FIELD_NUMBER: _ClassVar[int]
    FRAME_FIELD_NUMBER: _ClassVar[int]
    AGES_FIELD_NUMBER: _ClassVar[int]
    distances: _geometry_pb2.NumericArray
    valid: _geometry_pb2.NumericArray
    intensities: _geometry_pb2.NumericArray
    elements: _geometry_pb2.NumericArray
    element_names: _containers.RepeatedScalarFieldContainer[str]
    points: _geometry_pb2.NumericArray
    frame: ReadingFrame
    ages: _geometry_pb2.NumericArray
    def __init__(self, distances: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., valid: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., intensities: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., elements: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., element_names: _Optional[_Iterable[str]] = ..., points: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., frame: _Optional[_Union[ReadingFrame, str]] = ..., ages: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ...) -> None: ...

class CameraReading(_message.Message):
    __slots__ = ("images", "width", "height", "intrinsics", "distortion", "element_names", "stereo_baseline_meters", "projection")
    IMAGES_FIELD_NUMBER: _ClassVar[int]
    WIDTH_FIELD_NUMBER: _ClassVar[int]
    HEIGHT_FIELD_NUMBER: _ClassVar[int]
    INTRINSICS_FIELD_NUMBER: _ClassVar[int]
    DISTORTION_FIELD_NUMBER: _ClassVar[int]
    ELEMENT_NAMES_FIELD_NUMBER: _ClassVar[int]
    STEREO_BASELINE_METERS_FIELD_NUMBER: _ClassVar[int]
    PROJECTION_FIELD_NUMBER: _ClassVar[int]
    images: _containers.RepeatedCompositeFieldContainer[Image]
    width: int
    height: int
    intrinsics: _sensing_pb2.CameraIntrinsics
    distortion: _containers.RepeatedScalarFieldContainer[float]
    element_names: _containers.RepeatedScalarFieldContainer[str]
    stereo_baseline_meters: float
    projection: _sensing_pb2.CameraProjection
    def __init__(self, images: _Optional[_Iterable[_Union[Image, _Mapping]]] = ..., width: _Optional[int] = ..., height: _Optional[int] = ..., intrinsics: _Optional[_Union[_sensing_pb2.CameraIntrinsics, _Mapping]] = ..., distortion: _Optional[_Iterable[float]] = ..., element_names: _Optional[_Iterable[str]] = ..., stereo_baseline_meters: _Optional[float] = ..., projection: _Optional[_Union[_sensing_pb2.CameraProjection, str]] = ...) -> None: ...

class Image(_message.Message):
    __slots__ = ("kind", "right", "pixels")
    KIND_FIELD_NUMBER: _ClassVar[int]
    RIGHT_FIELD_NUMBER: _ClassVar[int]
    PIXELS_FIELD_NUMBER: _ClassVar[int]
    kind: _sensing_pb2.ImageKind
    right: bool
    pixels: _geometry_pb2.NumericArray
    def __init__(self, kind: _Optional[_Union[_sensing_pb2.ImageKind, str]] = ..., right: bool = ..., pixels: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ...) -> None: ...

class ContactReading(_message.Message):
    __slots__ = ("contacts",)
    CONTACTS_FIELD_NUMBER: _ClassVar[int]
    contacts: _containers.RepeatedCompositeFieldContainer[Contact]
    def __init__(self, contacts: _Optional[_Iterable[_Union[Contact, _Mapping]]] = ...) -> None: ...

class Contact(_message.Message):
    __slots__ = ("element", "other", "distance_meters", "point", "other_point", "normal", "force")
    ELEMENT_FIELD_NUMBER: _ClassVar[int]
    OTHER_FIELD_NUMBER: _ClassVar[int]
    DISTANCE_METERS_FIELD_NUMBER: _ClassVar[int]
    POINT_FIELD_NUMBER: _ClassVar[int]
    OTHER_POINT_FIELD_NUMBER: _ClassVar[int]
    NORMAL_FIELD_NUMBER: _ClassVar[int]
    FORCE_FIELD_NUMBER: _ClassVar[int]
    element: str
    other: str
    distance_meters: float
    point: _geometry_pb2.Vector3
    other_point: _geometry_pb2.Vector3
    normal: _geometry_pb2.Vector3
    force: _geometry_pb2.Vector3
    def __init__(self, element: _Optional[str] = ..., other: _Optional[str] = ..., distance_meters: _Optional[float] = ..., point: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., other_point: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., normal: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., force: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ...) -> None: ...

class ImuReading(_message.Message):
    __slots__ = ("angular_velocity", "linear_acceleration", "magnetic_field")
    ANGULAR_VELOCITY_FIELD_NUMBER: _ClassVar[int]
    LINEAR_ACCELERATION_FIELD_NUMBER: _ClassVar[int]
    MAGNETIC_FIELD_FIELD_NUMBER: _ClassVar[int]
    angular_velocity: _geometry_pb2.Vector3
    linear_acceleration: _geometry_pb2.Vector3
    magnetic_field: _geometry_pb2.Vector3
    def __init__(self, angular_velocity: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., linear_acceleration: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., magnetic_field: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ...) -> None: ...

class EncoderReading(_message.Message):
    __slots__ = ("joint_names", "positions", "velocities")
    JOINT_NAMES_FIELD_NUMBER: _ClassVar[int]
    POSITIONS_FIELD_NUMBER: _ClassVar[int]
    VELOCITIES_FIELD_NUMBER: _ClassVar[int]
    joint_names: _containers.RepeatedScalarFieldContainer[str]
    positions: _containers.RepeatedScalarFieldContainer[float]
    velocities: _containers.RepeatedScalarFieldContainer[float]
    def __init__(self, joint_names: _Optional[_Iterable[str]] = ..., positions: _Optional[_Iterable[float]] = ..., velocities: _Optional[_Iterable[float]] = ...) -> None: ...

class PoseReading(_message.Message):
    __slots__ = ("world_t_node", "linear_velocity")
    WORLD_T_NODE_FIELD_NUMBER: _ClassVar[int]
    LINEAR_VELOCITY_FIELD_NUMBER: _ClassVar[int]
    world_t_node: _geometry_pb2.Pose
    linear_velocity: _geometry_pb2.Vector3
    def __init__(self, world_t_node: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., linear_velocity: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ...) -> None: ...

class WrenchReading(_message.Message):
    __slots__ = ("force", "torque")
    FORCE_FIELD_NUMBER: _ClassVar[int]
    TORQUE_FIELD_NUMBER: _ClassVar[int]
    force: _geometry_pb2.Vector3
    torque: _geometry_pb2.Vector3
    def __init__(self, force: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., torque: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ...) -> None: ...

class SetRangeComponentsRequest(_message.Message):
    __slots__ = ("sensor", "ray_caster", "ray_caster_settings", "sensor_model", "sensor_model_settings")
    SENSOR_FIELD_NUMBER: _ClassVar[int]
    RAY_CASTER_FIELD_NUMBER: _ClassVar[int]
    RAY_CASTER_SETTINGS_FIELD_NUMBER: _ClassVar[int]
    SENSOR_MODEL_FIELD_NUMBER: _ClassVar[int]
    SENSOR_MODEL_SETTINGS_FIELD_NUMBER: _ClassVar[int]
    sensor: str
    ray_caster: str
    ray_caster_settings: _struct_pb2.Struct
    sensor_model: str
    sensor_model_settings: _struct_pb2.Struct
    def __init__(self, sensor: _Optional[str] = ..., ray_caster: _Optional[str] = ..., ray_caster_settings: _Optional[_Union[_struct_pb2.Struct, _Mapping]] = ..., sensor_model: _Optional[str] = ..., sensor_model_settings: _Optional[_Union[_struct_pb2.Struct, _Mapping]] = ...) -> None: ...

class SetRangeComponentsResponse(_message.Message):
    __slots__ = ("stamp", "cast_seconds", "model_seconds", "rays")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    CAST_SECONDS_FIELD_NUMBER: _ClassVar[int]
    MODEL_SECONDS_FIELD_NUMBER: _ClassVar[int]
    RAYS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    cast_seconds: float
    model_seconds: float
    rays: int
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., cast_seconds: _Optional[float] = ..., model_seconds: _Optional[float] = ..., rays: _Optional[int] = ...) -> None: ...

class ListSensorPresetsRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class ListSensorPresetsResponse(_message.Message):
    __slots__ = ("presets",)
    PRESETS_FIELD_NUMBER: _ClassVar[int]
    presets: _containers.RepeatedCompositeFieldContainer[SensorPreset]
    def __init__(self, presets: _Optional[_Iterable[_Union[SensorPreset, _Mapping]]] = ...) -> None: ...

class SensorPreset(_message.Message):
    __slots__ = ("name", "description", "source", "sensor")
    NAME_FIELD_NUMBER: _ClassVar[int]
    DESCRIPTION_FIELD_NUMBER: _ClassVar[int]
    SOURCE_FIELD_NUMBER: _ClassVar[int]
    SENSOR_FIELD_NUMBER: _ClassVar[int]
    name: str
    description: str
    source: str
    sensor: _sensing_pb2.RangeSensor
    def __init__(self, name: _Optional[str] = ..., description: _Optional[str] = ..., source: _Optional[str] = ..., sensor: _Optional[_Union[_sensing_pb2.RangeSensor, _Mapping]] = ...) -> None: ...
