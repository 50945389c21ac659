from google.protobuf import struct_pb2 as _struct_pb2
from virtualrobot.v1 import geometry_pb2 as _geometry_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class CameraProjection(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    CAMERA_PROJECTION_UNSPECIFIED: _ClassVar[CameraProjection]
    CAMERA_PROJECTION_PINHOLE: _ClassVar[CameraProjection]
    CAMERA_PROJECTION_FISHEYE: _ClassVar[CameraProjection]
    CAMERA_PROJECTION_SPHERICAL: _ClassVar[CameraProjection]

class ImageKind(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    IMAGE_KIND_UNSPECIFIED: _ClassVar[ImageKind]
    IMAGE_KIND_COLOR: _ClassVar[ImageKind]
    IMAGE_KIND_DEPTH: _ClassVar[ImageKind]
    IMAGE_KIND_SEGMENTATION: _ClassVar[ImageKind]
    IMAGE_KIND_NORMALS: _ClassVar[ImageKind]

class LightKind(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    LIGHT_KIND_UNSPECIFIED: _ClassVar[LightKind]
    LIGHT_KIND_POINT: _ClassVar[LightKind]
    LIGHT_KIND_SPOT: _ClassVar[LightKind]
    LIGHT_KIND_DIRECTIONAL: _ClassVar[LightKind]
CAMERA_PROJECTION_UNSPECIFIED: CameraProjection
CAMERA_PROJECTION_PINHOLE: CameraProjection
CAMERA_PROJECTION_FISHEYE: CameraProjection
CAMERA_PROJECTION_SPHERICAL: CameraProjection
IMAGE_KIND_UNSPECIFIED: ImageKind
IMAGE_KIND_COLOR: ImageKind
IMAGE_KIND_DEPTH: ImageKind
IMAGE_KIND_SEGMENTATION: ImageKind
IMAGE_KIND_NORMALS: ImageKind
LIGHT_KIND_UNSPECIFIED: LightKind
LIGHT_KIND_POINT: LightKind
LIGHT_KIND_SPOT: LightKind
LIGHT_KIND_DIRECTIONAL: LightKind

class RangeSensor(_message.Message):
    __slots__ = ("preset", "pattern", "rate_hertz", "min_range_meters", "max_range_meters", "ray_caster", "ray_caster_settings", "sensor_model", "sensor_model_settings", "seed", "motion_distortion", "running")
    PRESET_FIELD_NUMBER: _ClassVar[int]
    PATTERN_FIELD_NUMBER: _ClassVar[int]
    RATE_HERTZ_FIELD_NUMBER: _ClassVar[int]
    MIN_RANGE_METERS_FIELD_NUMBER: _ClassVar[int]
    MAX_RANGE_METERS_FIELD_NUMBER: _ClassVar[int]
    RAY_CASTER_FIELD_NUMBER: _ClassVar[int]
    RAY_CASTER_SETTINGS_FIELD_NUMBER: _ClassVar[int]
    SENSOR_MODEL_FIELD_NUMBER: _ClassVar[int]
    SENSOR_MODEL_SETTINGS_FIELD_NUMBER: _ClassVar[int]
    SEED_FIELD_NUMBER: _ClassVar[int]
    MOTION_DISTORTION_FIELD_NUMBER: _ClassVar[int]
    RUNNING_FIELD_NUMBER: _ClassVar[int]
    preset: str
    pattern: ScanPattern
    rate_hertz: float
    min_range_meters: float
    max_range_meters: float
    ray_caster: str
    ray_caster_settings: _struct_pb2.Struct
    sensor_model: str
    sensor_model_settings: _struct_pb2.Struct
    seed: int
    motion_distortion: bool
    running: bool
    def __init__(self, preset: _Optional[str] = ..., pattern: _Optional[_Union[ScanPattern, _Mapping]] = ..., rate_hertz: _Optional[float] = ..., min_range_meters: _Optional[float] = ..., max_range_meters: _Optional[float] = ..., ray_caster: _Optional[str] = ..., ray_caster_settings: _Optional[_Union[_struct_pb2.Struct, _Mapping]] = ..., sensor_model: _Optional[str] = ..., sensor_model_settings: _Optional[_Union[_struct_pb2.Struct, _Mapping]] = ..., seed: _Optional[int] = ..., motion_distortion: bool = ..., running: bool = ...) -> None: ...

class ScanPattern(_message.Message):
    __slots__ = ("beam", "fan", "spinning", "raster", "ring", "free")
    BEAM_FIELD_NUMBER: _ClassVar[int]
    FAN_FIELD_NUMBER: _ClassVar[int]
    SPINNING_FIELD_NUMBER: _ClassVar[int]
    RASTER_FIELD_NUMBER: _ClassVar[int]
    RING_FIELD_NUMBER: _ClassVar[int]
    FREE_FIELD_NUMBER: _ClassVar[int]
    beam: SingleBeam
    fan: Fan
    spinning: Spinning
    raster: Raster
    ring: Ring
    free: FreeBeams
    def __init__(self, beam: _Optional[_Union[SingleBeam, _Mapping]] = ..., fan: _Optional[_Union[Fan, _Mapping]] = ..., spinning: _Optional[_Union[Spinning, _Mapping]] = ..., raster: _Optional[_Union[Raster, _Mapping]] = ..., ring: _Optional[_Union[Ring, _Mapping]] = ..., free: _Optional[_Union[FreeBeams, _Mapping]] = ...) -> None: ...

class SingleBeam(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class Fan(_message.Message):
    __slots__ = ("count", "start_angle_radians", "end_angle_radians")
    COUNT_FIELD_NUMBER: _ClassVar[int]
    START_ANGLE_RADIANS_FIELD_NUMBER: _ClassVar[int]
    END_ANGLE_RADIANS_FIELD_NUMBER: _ClassVar[int]
    count: int
    start_angle_radians: float
    end_angle_radians: float
    def __init__(self, count: _Optional[int] = ..., start_angle_radians: _Optional[float] = ..., end_angle_radians: _Optional[float] = ...) -> None: ...

class Spinning(_message.Message):
    __slots__ = ("columns", "elevations_radians")
    COLUMNS_FIELD_NUMBER: _ClassVar[int]
    ELEVATIONS_RADIANS_FIELD_NUMBER: _ClassVar[int]
    columns: int
    elevations_radians: _containers.RepeatedScalarFieldContainer[float]
    def __init__(self, columns: _Optional[int] = ..., elevations_radians: _Optional[_Iterable[float]] = ...) -> None: ...

class Raster(_message.Message):
    __slots__ = ("columns", "rows", "horizontal_field_radians", "vertical_field_radians")
    COLUMNS_FIELD_NUMBER: _ClassVar[int]
    ROWS_FIELD_NUMBER: _ClassVar[int]
    HORIZONTAL_FIELD_RADIANS_FIELD_NUMBER: _ClassVar[int]
    VERTICAL_FIELD_RADIANS_FIELD_NUMBER: _ClassVar[int]
    columns: int
    rows: int
    horizontal_field_radians: float
    vertical_field_radians: float
    def __init__(self, columns: _Optional[int] = ..., rows: _Optional[int] = ..., horizontal_field_radians: _Optional[float] = ..., vertical_field_radians: _Optional[float] = ...) -> None: ...

class Ring(_message.Message):
    __slots__ = ("count", "radius_meters", "start_angle_radians", "end_angle_radians")
    COUNT_FIELD_NUMBER: _ClassVar[int]
    RADIUS_METERS_FIELD_NUMBER: _ClassVar[int]
    START_ANGLE_RADIANS_FIELD_NUMBER: _ClassVar[int]
    END_ANGLE_RADIANS_FIELD_NUMBER: _ClassVar[int]
    count: int
    radius_meters: float
    start_angle_radians: float
    end_angle_radians: float
    def __init__(self, count: _Optional[int] = ..., radius_meters: _Optional[float] = ..., start_angle_radians: _Optional[float] = ..., end_angle_radians: _Optional[float] = ...) -> None: ...

class FreeBeams(_message.Message):
    __slots__ = ("directions", "origins")
    DIRECTIONS_FIELD_NUMBER: _ClassVar[int]
    ORIGINS_FIELD_NUMBER: _ClassVar[int]
    directions: _geometry_pb2.NumericArray
    origins: _geometry_pb2.NumericArray
    def __init__(self, directions: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., origins: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ...) -> None: ...

class CameraSensor(_message.Message):
    __slots__ = ("width", "height", "projection", "horizontal_field_radians", "intrinsics", "distortion", "near_meters", "far_meters", "rate_hertz", "images", "color_noise", "depth_noise_meters", "seed", "stereo_baseline_meters", "running", "water_attenuation_per_meter", "water_color")
    WIDTH_FIELD_NUMBER: _ClassVar[int]
    HEIGHT_FIELD_NUMBER: _ClassVar[int]
    PROJECTION_FIELD_NUMBER: _ClassVar[int]
    HORIZONTAL_FIELD_RADIANS_FIELD_NUMBER: _ClassVar[int]
    INTRINSICS_FIELD_NUMBER: _ClassVar[int]
    DISTORTION_FIELD_NUMBER: _ClassVar[int]
    NEAR_METERS_FIELD_NUMBER: _ClassVar[int]
    FAR_METERS_FIELD_NUMBER: _ClassVar[int]
    RATE_HERTZ_FIELD_NUMBER: _ClassVar[int]
    IMAGES_FIELD_NUMBER: _ClassVar[int]
    COLOR_NOISE_FIELD_NUMBER: _ClassVar[int]
    DEPTH_NOISE_METERS_FIELD_NUMBER: _ClassVar[int]
    SEED_FIELD_NUMBER: _ClassVar[int]
    STEREO_BASELINE_METERS_FIELD_NUMBER: _ClassVar[int]
    RUNNING_FIELD_NUMBER: _ClassVar[int]
    WATER_ATTENUATION_PER_METER_FIELD_NUMBER: _ClassVar[int]
    WATER_COLOR_FIELD_NUMBER: _ClassVar[int]
    width: int
    height: int
    projection: CameraProjection
    horizontal_field_radians: float
    intrinsics: CameraIntrinsics
    distortion: _containers.RepeatedScalarFieldContainer[float]
    near_meters: float
    far_meters: float
    rate_hertz: float
    images: _containers.RepeatedScalarFieldContainer[ImageKind]
    color_noise: float
    depth_noise_meters: float
    seed: int
    stereo_baseline_meters: float
    running: bool
    water_attenuation_per_meter: _geometry_pb2.Vector3
    water_color: _geometry_pb2.Color
    def __init__(self, width: _Optional[int] = ..., height: _Optional[int] = ..., projection: _Optional[_Union[CameraProjection, str]] = ..., horizontal_field_radians: _Optional[float] = ..., intrinsics: _Optional[_Union[CameraIntrinsics, _Mapping]] = ..., distortion: _Optional[_Iterable[float]] = ..., near_meters: _Optional[float] = ..., far_meters: _Optional[float] = ..., rate_hertz: _Optional[float] = ..., images: _Optional[_Iterable[_Union[ImageKind, str]]] = ..., color_noise: _Optional[float] = ..., depth_noise_meters: _Optional[float] = ..., seed: _Optional[int] = ..., stereo_baseline_meters: _Optional[float] = ..., running: bool = ..., water_attenuation_per_meter: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., water_color: _Optional[_Union[_geometry_pb2.Color, _Mapping]] = ...) -> None: ...

class CameraIntrinsics(_message.Message):
    __slots__ = ("fx", "fy", "cx", "cy")
    FX_FIELD_NUMBER: _ClassVar[int]
    FY_FIELD_NUMBER: _ClassVar[int]
    CX_FIELD_NUMBER: _ClassVar[int]
    CY_FIELD_NUMBER: _ClassVar[int]
    fx: float
    fy: float
    cx: float
    cy: float
    def __init__(self, fx: _Optional[float] = ..., fy: _Optional[float] = ..., cx: _Optional[float] = ..., cy: _Optional[float] = ...) -> None: ...

class ContactSensor(_message.Message):
    __slots__ = ("watched", "range_meters", "region_size", "ignored", "rate_hertz", "running")
    WATCHED_FIELD_NUMBER: _ClassVar[int]
    RANGE_METERS_FIELD_NUMBER: _ClassVar[int]
    REGION_SIZE_FIELD_NUMBER: _ClassVar[int]
    IGNORED_FIELD_NUMBER: _ClassVar[int]
    RATE_HERTZ_FIELD_NUMBER: _ClassVar[int]
    RUNNING_FIELD_NUMBER: _ClassVar[int]
    watched: str
    range_meters: float
    region_size: _geometry_pb2.Vector3
    ignored: _containers.RepeatedScalarFieldContainer[str]
    rate_hertz: float
    running: bool
    def __init__(self, watched: _Optional[str] = ..., range_meters: _Optional[float] = ..., region_size: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., ignored: _Optional[_Iterable[str]] = ..., rate_hertz: _Optional[float] = ..., running: bool = ...) -> None: ...

class MotionSensor(_message.Message):
    __slots__ = ("imu", "encoders", "pose", "force_torque", "rate_hertz", "seed", "running")
    IMU_FIELD_NUMBER: _ClassVar[int]
    ENCODERS_FIELD_NUMBER: _ClassVar[int]
    POSE_FIELD_NUMBER: _ClassVar[int]
    FORCE_TORQUE_FIELD_NUMBER: _ClassVar[int]
    RATE_HERTZ_FIELD_NUMBER: _ClassVar[int]
    SEED_FIELD_NUMBER: _ClassVar[int]
    RUNNING_FIELD_NUMBER: _ClassVar[int]
    imu: Imu
    encoders: Encoders
    pose: PoseSensor
    force_torque: ForceTorqueSensor
    rate_hertz: float
    seed: int
    running: bool
    def __init__(self, imu: _Optional[_Union[Imu, _Mapping]] = ..., encoders: _Optional[_Union[Encoders, _Mapping]] = ..., pose: _Optional[_Union[PoseSensor, _Mapping]] = ..., force_torque: _Optional[_Union[ForceTorqueSensor, _Mapping]] = ..., rate_hertz: _Optional[float] = ..., seed: _Optional[int] = ..., running: bool = ...) -> None: ...

class NoiseModel(_message.Message):
    __slots__ = ("standard_deviation", "bias_standard_deviation", "bias_walk", "resolution", "range")
    STANDARD_DEVIATION_FIELD_NUMBER: _ClassVar[int]
    BIAS_STANDARD_DEVIATION_FIELD_NUMBER: _ClassVar[int]
    BIAS_WALK_FIELD_NUMBER: _ClassVar[int]
    RESOLUTION_FIELD_NUMBER: _ClassVar[int]
    RANGE_FIELD_NUMBER: _ClassVar[int]
    standard_deviation: float
    bias_standard_deviation: float
    bias_walk: float
    resolution: float
    range: float
    def __init__(self, standard_deviation: _Optional[float] = ..., bias_standard_deviation: _Optional[float] = ..., bias_walk: _Optional[float] = ..., resolution: _Optional[float] = ..., range: _Optional[float] = ...) -> None: ...

class Imu(_message.Message):
    __slots__ = ("gyroscope", "accelerometer", "magnetometer", "magnetic_field")
    GYROSCOPE_FIELD_NUMBER: _ClassVar[int]
    ACCELEROMETER_FIELD_NUMBER: _ClassVar[int]
    MAGNETOMETER_FIELD_NUMBER: _ClassVar[int]
    MAGNETIC_FIELD_FIELD_NUMBER: _ClassVar[int]
    gyroscope: NoiseModel
    accelerometer: NoiseModel
    magnetometer: NoiseModel
    magnetic_field: _geometry_pb2.Vector3
    def __init__(self, gyroscope: _Optional[_Union[NoiseModel, _Mapping]] = ..., accelerometer: _Optional[_Union[NoiseModel, _Mapping]] = ..., magnetometer: _Optional[_Union[NoiseModel, _Mapping]] = ..., magnetic_field: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ...) -> None: ...

class Encoders(_message.Message):
    __slots__ = ("joints", "position")
    JOINTS_FIELD_NUMBER: _ClassVar[int]
    POSITION_FIELD_NUMBER: _ClassVar[int]
    joints: _containers.RepeatedScalarFieldContainer[str]
    position: NoiseModel
    def __init__(self, joints: _Optional[_Iterable[str]] = ..., position: _Optional[_Union[NoiseModel, _Mapping]] = ...) -> None: ...

class PoseSensor(_message.Message):
    __slots__ = ("position", "orientation")
    POSITION_FIELD_NUMBER: _ClassVar[int]
    ORIENTATION_FIELD_NUMBER: _ClassVar[int]
    position: NoiseModel
    orientation: NoiseModel
    def __init__(self, position: _Optional[_Union[NoiseModel, _Mapping]] = ..., orientation: _Optional[_Union[NoiseModel, _Mapping]] = ...) -> None: ...

class ForceTorqueSensor(_message.Message):
    __slots__ = ("force", "torque", "include_parent")
    FORCE_FIELD_NUMBER: _ClassVar[int]
    TORQUE_FIELD_NUMBER: _ClassVar[int]
    INCLUDE_PARENT_FIELD_NUMBER: _ClassVar[int]
    force: NoiseModel
    torque: NoiseModel
    include_parent: bool
    def __init__(self, force: _Optional[_Union[NoiseModel, _Mapping]] = ..., torque: _Optional[_Union[NoiseModel, _Mapping]] = ..., include_parent: bool = ...) -> None: ...

class Light(_message.Message):
    __slots__ = ("kind", "color", "intensity", "cone_angle_radians", "shadowless")
    KIND_FIELD_NUMBER: _ClassVar[int]
    COLOR_FIELD_NUMBER: _ClassVar[int]
    INTENSITY_FIELD_NUMBER: _ClassVar[int]
    CONE_ANGLE_RADIANS_FIELD_NUMBER: _ClassVar[int]
    SHADOWLESS_FIELD_NUMBER: _ClassVar[int]
    kind: LightKind
    color: _geometry_pb2.Color
    intensity: float
    cone_angle_radians: float
    shadowless: bool
    def __init__(self, kind: _Optional[_Union[LightKind, str]] = ..., color: _Optional[_Union[_geometry_pb2.Color, _Mapping]] = ..., intensity: _Optional[float] = ..., cone_angle_radians: _Optional[float] = ..., shadowless: bool = ...) -> None: ...
