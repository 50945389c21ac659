from google.protobuf import field_mask_pb2 as _field_mask_pb2
from virtualrobot.v1 import collision_pb2 as _collision_pb2
from virtualrobot.v1 import geometry_pb2 as _geometry_pb2
from virtualrobot.v1 import token_pb2 as _token_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class PointColor(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    POINT_COLOR_UNSPECIFIED: _ClassVar[PointColor]
    POINT_COLOR_DISTANCE: _ClassVar[PointColor]
    POINT_COLOR_INTENSITY: _ClassVar[PointColor]

class ImageFormat(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    IMAGE_FORMAT_UNSPECIFIED: _ClassVar[ImageFormat]
    IMAGE_FORMAT_PNG: _ClassVar[ImageFormat]
    IMAGE_FORMAT_JPEG: _ClassVar[ImageFormat]
    IMAGE_FORMAT_RAW: _ClassVar[ImageFormat]

class ColorMap(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    COLOR_MAP_UNSPECIFIED: _ClassVar[ColorMap]
    COLOR_MAP_VIRIDIS: _ClassVar[ColorMap]
    COLOR_MAP_TURBO: _ClassVar[ColorMap]
    COLOR_MAP_HEAT: _ClassVar[ColorMap]
POINT_COLOR_UNSPECIFIED: PointColor
POINT_COLOR_DISTANCE: PointColor
POINT_COLOR_INTENSITY: PointColor
IMAGE_FORMAT_UNSPECIFIED: ImageFormat
IMAGE_FORMAT_PNG: ImageFormat
IMAGE_FORMAT_JPEG: ImageFormat
IMAGE_FORMAT_RAW: ImageFormat
COLOR_MAP_UNSPECIFIED: ColorMap
COLOR_MAP_VIRIDIS: ColorMap
COLOR_MAP_TURBO: ColorMap
COLOR_MAP_HEAT: ColorMap

class View(_message.Message):
    __slots__ = ("background", "grid_hidden", "joint_axes", "bounding_boxes", "camera", "sensors", "measurements", "collisions_hidden", "clearances", "ghosts")
    BACKGROUND_FIELD_NUMBER: _ClassVar[int]
    GRID_HIDDEN_FIELD_NUMBER: _ClassVar[int]
    JOINT_AXES_FIELD_NUMBER: _ClassVar[int]
    BOUNDING_BOXES_FIELD_NUMBER: _ClassVar[int]
    CAMERA_FIELD_NUMBER: _ClassVar[int]
    SENSORS_FIELD_NUMBER: _ClassVar[int]
    MEASUREMENTS_FIELD_NUMBER: _ClassVar[int]
    COLLISIONS_HIDDEN_FIELD_NUMBER: _ClassVar[int]
    CLEARANCES_FIELD_NUMBER: _ClassVar[int]
    GHOSTS_FIELD_NUMBER: _ClassVar[int]
    background: _geometry_pb2.Color
    grid_hidden: bool
    joint_axes: _containers.RepeatedScalarFieldContainer[str]
    bounding_boxes: _containers.RepeatedScalarFieldContainer[str]
    camera: Camera
    sensors: _containers.RepeatedCompositeFieldContainer[SensorOverlay]
    measurements: _containers.RepeatedCompositeFieldContainer[Measurement]
    collisions_hidden: bool
    clearances: _containers.RepeatedCompositeFieldContainer[Clearance]
    ghosts: _containers.RepeatedCompositeFieldContainer[Ghost]
    def __init__(self, background: _Optional[_Union[_geometry_pb2.Color, _Mapping]] = ..., grid_hidden: bool = ..., joint_axes: _Optional[_Iterable[str]] = ..., bounding_boxes: _Optional[_Iterable[str]] = ..., camera: _Optional[_Union[Camera, _Mapping]] = ..., sensors: _Optional[_Iterable[_Union[SensorOverlay, _Mapping]]] = ..., measurements: _Optional[_Iterable[_Union[Measurement, _Mapping]]] = ..., collisions_hidden: bool = ..., clearances: _Optional[_Iterable[_Union[Clearance, _Mapping]]] = ..., ghosts: _Optional[_Iterable[_Union[Ghost, _Mapping]]] = ...) -> None: ...

class SensorOverlay(_message.Message):
    __slots__ = ("sensor", "rays", "points", "color_by", "frustum", "image")
    SENSOR_FIELD_NUMBER: _ClassVar[int]
    RAYS_FIELD_NUMBER: _ClassVar[int]
    POINTS_FIELD_NUMBER: _ClassVar[int]
    COLOR_BY_FIELD_NUMBER: _ClassVar[int]
    FRUSTUM_FIELD_NUMBER: _ClassVar[int]
    IMAGE_FIELD_NUMBER: _ClassVar[int]
    sensor: str
    rays: bool
    points: bool
    color_by: PointColor
    frustum: bool
    image: bool
    def __init__(self, sensor: _Optional[str] = ..., rays: bool = ..., points: bool = ..., color_by: _Optional[_Union[PointColor, str]] = ..., frustum: bool = ..., image: bool = ...) -> None: ...

class NodePoint(_message.Message):
    __slots__ = ("node", "point")
    NODE_FIELD_NUMBER: _ClassVar[int]
    POINT_FIELD_NUMBER: _ClassVar[int]
    node: str
    point: _geometry_pb2.Vector3
    def __init__(self, node: _Optional[str] = ..., point: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ...) -> None: ...

class Measurement(_message.Message):
    __slots__ = ("name", "first", "second")
    NAME_FIELD_NUMBER: _ClassVar[int]
    FIRST_FIELD_NUMBER: _ClassVar[int]
    SECOND_FIELD_NUMBER: _ClassVar[int]
    name: str
    first: NodePoint
    second: NodePoint
    def __init__(self, name: _Optional[str] = ..., first: _Optional[_Union[NodePoint, _Mapping]] = ..., second: _Optional[_Union[NodePoint, _Mapping]] = ...) -> None: ...

class Clearance(_message.Message):
    __slots__ = ("name", "first", "second")
    NAME_FIELD_NUMBER: _ClassVar[int]
    FIRST_FIELD_NUMBER: _ClassVar[int]
    SECOND_FIELD_NUMBER: _ClassVar[int]
    name: str
    first: _containers.RepeatedScalarFieldContainer[str]
    second: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, name: _Optional[str] = ..., first: _Optional[_Iterable[str]] = ..., second: _Optional[_Iterable[str]] = ...) -> None: ...

class Ghost(_message.Message):
    __slots__ = ("name", "configurations", "color", "opacity")
    NAME_FIELD_NUMBER: _ClassVar[int]
    CONFIGURATIONS_FIELD_NUMBER: _ClassVar[int]
    COLOR_FIELD_NUMBER: _ClassVar[int]
    OPACITY_FIELD_NUMBER: _ClassVar[int]
    name: str
    configurations: _collision_pb2.RobotConfigurations
    color: _geometry_pb2.Color
    opacity: float
    def __init__(self, name: _Optional[str] = ..., configurations: _Optional[_Union[_collision_pb2.RobotConfigurations, _Mapping]] = ..., color: _Optional[_Union[_geometry_pb2.Color, _Mapping]] = ..., opacity: _Optional[float] = ...) -> None: ...

class Camera(_message.Message):
    __slots__ = ("position", "target", "field_of_view_radians", "node", "keeps_direction")
    POSITION_FIELD_NUMBER: _ClassVar[int]
    TARGET_FIELD_NUMBER: _ClassVar[int]
    FIELD_OF_VIEW_RADIANS_FIELD_NUMBER: _ClassVar[int]
    NODE_FIELD_NUMBER: _ClassVar[int]
    KEEPS_DIRECTION_FIELD_NUMBER: _ClassVar[int]
    position: _geometry_pb2.Vector3
    target: _geometry_pb2.Vector3
    field_of_view_radians: float
    node: str
    keeps_direction: bool
    def __init__(self, position: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., target: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., field_of_view_radians: _Optional[float] = ..., node: _Optional[str] = ..., keeps_direction: bool = ...) -> None: ...

class GetViewRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class GetViewResponse(_message.Message):
    __slots__ = ("stamp", "view", "viewer_count")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    VIEW_FIELD_NUMBER: _ClassVar[int]
    VIEWER_COUNT_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    view: View
    viewer_count: int
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., view: _Optional[_Union[View, _Mapping]] = ..., viewer_count: _Optional[int] = ...) -> None: ...

class UpdateViewRequest(_message.Message):
    __slots__ = ("view", "update_mask")
    VIEW_FIELD_NUMBER: _ClassVar[int]
    UPDATE_MASK_FIELD_NUMBER: _ClassVar[int]
    view: View
    update_mask: _field_mask_pb2.FieldMask
    def __init__(self, view: _Optional[_Union[View, _Mapping]] = ..., update_mask: _Optional[_Union[_field_mask_pb2.FieldMask, _Mapping]] = ...) -> None: ...

class UpdateViewResponse(_message.Message):
    __slots__ = ("stamp", "view")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    VIEW_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    view: View
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., view: _Optional[_Union[View, _Mapping]] = ...) -> None: ...

class WatchViewRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class WatchViewResponse(_message.Message):
    __slots__ = ("stamp", "view")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    VIEW_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    view: View
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., view: _Optional[_Union[View, _Mapping]] = ...) -> None: ...

class Shot(_message.Message):
    __slots__ = ("camera", "camera_sensor", "width", "height", "format", "plain")
    CAMERA_FIELD_NUMBER: _ClassVar[int]
    CAMERA_SENSOR_FIELD_NUMBER: _ClassVar[int]
    WIDTH_FIELD_NUMBER: _ClassVar[int]
    HEIGHT_FIELD_NUMBER: _ClassVar[int]
    FORMAT_FIELD_NUMBER: _ClassVar[int]
    PLAIN_FIELD_NUMBER: _ClassVar[int]
    camera: Camera
    camera_sensor: str
    width: int
    height: int
    format: ImageFormat
    plain: bool
    def __init__(self, camera: _Optional[_Union[Camera, _Mapping]] = ..., camera_sensor: _Optional[str] = ..., width: _Optional[int] = ..., height: _Optional[int] = ..., format: _Optional[_Union[ImageFormat, str]] = ..., plain: bool = ...) -> None: ...

class CaptureImageRequest(_message.Message):
    __slots__ = ("shot",)
    SHOT_FIELD_NUMBER: _ClassVar[int]
    shot: Shot
    def __init__(self, shot: _Optional[_Union[Shot, _Mapping]] = ...) -> None: ...

class CaptureImageResponse(_message.Message):
    __slots__ = ("stamp", "image", "width", "height")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    IMAGE_FIELD_NUMBER: _ClassVar[int]
    WIDTH_FIELD_NUMBER: _ClassVar[int]
    HEIGHT_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    image: bytes
    width: int
    height: int
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., image: _Optional[bytes] = ..., width: _Optional[int] = ..., height: _Optional[int] = ...) -> None: ...

class CaptureModelRequest(_message.Message):
    __slots__ = ("name",)
    NAME_FIELD_NUMBER: _ClassVar[int]
    name: str
    def __init__(self, name: _Optional[str] = ...) -> None: ...

class CaptureModelResponse(_message.Message):
    __slots__ = ("image", "width", "height")
    IMAGE_FIELD_NUMBER: _ClassVar[int]
    WIDTH_FIELD_NUMBER: _ClassVar[int]
    HEIGHT_FIELD_NUMBER: _ClassVar[int]
    image: bytes
    width: int
    height: int
    def __init__(self, image: _Optional[bytes] = ..., width: _Optional[int] = ..., height: _Optional[int] = ...) -> None: ...

class RecordFilmRequest(_message.Message):
    __slots__ = ("shot", "frames_per_second", "duration_seconds")
    SHOT_FIELD_NUMBER: _ClassVar[int]
    FRAMES_PER_SECOND_FIELD_NUMBER: _ClassVar[int]
    DURATION_SECONDS_FIELD_NUMBER: _ClassVar[int]
    shot: Shot
    frames_per_second: float
    duration_seconds: float
    def __init__(self, shot: _Optional[_Union[Shot, _Mapping]] = ..., frames_per_second: _Optional[float] = ..., duration_seconds: _Optional[float] = ...) -> None: ...

class RecordFilmResponse(_message.Message):
    __slots__ = ("stamp", "frame", "image", "behind")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    FRAME_FIELD_NUMBER: _ClassVar[int]
    IMAGE_FIELD_NUMBER: _ClassVar[int]
    BEHIND_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    frame: int
    image: bytes
    behind: int
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., frame: _Optional[int] = ..., image: _Optional[bytes] = ..., behind: _Optional[int] = ...) -> None: ...

class PickPixelRequest(_message.Message):
    __slots__ = ("camera", "camera_sensor", "width", "height", "column", "row")
    CAMERA_FIELD_NUMBER: _ClassVar[int]
    CAMERA_SENSOR_FIELD_NUMBER: _ClassVar[int]
    WIDTH_FIELD_NUMBER: _ClassVar[int]
    HEIGHT_FIELD_NUMBER: _ClassVar[int]
    COLUMN_FIELD_NUMBER: _ClassVar[int]
    ROW_FIELD_NUMBER: _ClassVar[int]
    camera: Camera
    camera_sensor: str
    width: int
    height: int
    column: float
    row: float
    def __init__(self, camera: _Optional[_Union[Camera, _Mapping]] = ..., camera_sensor: _Optional[str] = ..., width: _Optional[int] = ..., height: _Optional[int] = ..., column: _Optional[float] = ..., row: _Optional[float] = ...) -> None: ...

class PickPixelResponse(_message.Message):
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

class MeasurePointDistanceRequest(_message.Message):
    __slots__ = ("first", "second")
    FIRST_FIELD_NUMBER: _ClassVar[int]
    SECOND_FIELD_NUMBER: _ClassVar[int]
    first: NodePoint
    second: NodePoint
    def __init__(self, first: _Optional[_Union[NodePoint, _Mapping]] = ..., second: _Optional[_Union[NodePoint, _Mapping]] = ...) -> None: ...

class PointDistance(_message.Message):
    __slots__ = ("distance_meters", "first", "second")
    DISTANCE_METERS_FIELD_NUMBER: _ClassVar[int]
    FIRST_FIELD_NUMBER: _ClassVar[int]
    SECOND_FIELD_NUMBER: _ClassVar[int]
    distance_meters: float
    first: _geometry_pb2.Vector3
    second: _geometry_pb2.Vector3
    def __init__(self, distance_meters: _Optional[float] = ..., first: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., second: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ...) -> None: ...

class MeasurePointDistanceResponse(_message.Message):
    __slots__ = ("stamp", "distance")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    DISTANCE_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    distance: PointDistance
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., distance: _Optional[_Union[PointDistance, _Mapping]] = ...) -> None: ...

class WatchPointDistanceRequest(_message.Message):
    __slots__ = ("first", "second", "max_rate_hertz")
    FIRST_FIELD_NUMBER: _ClassVar[int]
    SECOND_FIELD_NUMBER: _ClassVar[int]
    MAX_RATE_HERTZ_FIELD_NUMBER: _ClassVar[int]
    first: NodePoint
    second: NodePoint
    max_rate_hertz: float
    def __init__(self, first: _Optional[_Union[NodePoint, _Mapping]] = ..., second: _Optional[_Union[NodePoint, _Mapping]] = ..., max_rate_hertz: _Optional[float] = ...) -> None: ...

class WatchPointDistanceResponse(_message.Message):
    __slots__ = ("stamp", "distance")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    DISTANCE_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    distance: PointDistance
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., distance: _Optional[_Union[PointDistance, _Mapping]] = ...) -> None: ...

class MeetViewersRequest(_message.Message):
    __slots__ = ("world_t_head", "scale")
    WORLD_T_HEAD_FIELD_NUMBER: _ClassVar[int]
    SCALE_FIELD_NUMBER: _ClassVar[int]
    world_t_head: _geometry_pb2.Pose
    scale: float
    def __init__(self, world_t_head: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., scale: _Optional[float] = ...) -> None: ...

class Viewer(_message.Message):
    __slots__ = ("id", "name", "world_t_head", "scale")
    ID_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    WORLD_T_HEAD_FIELD_NUMBER: _ClassVar[int]
    SCALE_FIELD_NUMBER: _ClassVar[int]
    id: str
    name: str
    world_t_head: _geometry_pb2.Pose
    scale: float
    def __init__(self, id: _Optional[str] = ..., name: _Optional[str] = ..., world_t_head: _Optional[_Union[_geometry_pb2.Pose, _Mapping]] = ..., scale: _Optional[float] = ...) -> None: ...

class MeetViewersResponse(_message.Message):
    __slots__ = ("viewers",)
    VIEWERS_FIELD_NUMBER: _ClassVar[int]
    viewers: _containers.RepeatedCompositeFieldContainer[Viewer]
    def __init__(self, viewers: _Optional[_Iterable[_Union[Viewer, _Mapping]]] = ...) -> None: ...

class Coat(_message.Message):
    __slots__ = ("name", "node", "vertices", "faces", "values", "color_map", "low", "high", "unit", "title", "palette", "node_uid")
    NAME_FIELD_NUMBER: _ClassVar[int]
    NODE_FIELD_NUMBER: _ClassVar[int]
    VERTICES_FIELD_NUMBER: _ClassVar[int]
    FACES_FIELD_NUMBER: _ClassVar[int]
    VALUES_FIELD_NUMBER: _ClassVar[int]
    COLOR_MAP_FIELD_NUMBER: _ClassVar[int]
    LOW_FIELD_NUMBER: _ClassVar[int]
    HIGH_FIELD_NUMBER: _ClassVar[int]
    UNIT_FIELD_NUMBER: _ClassVar[int]
    TITLE_FIELD_NUMBER: _ClassVar[int]
    PALETTE_FIELD_NUMBER: _ClassVar[int]
    NODE_UID_FIELD_NUMBER: _ClassVar[int]
    name: str
    node: str
    vertices: _geometry_pb2.NumericArray
    faces: _geometry_pb2.NumericArray
    values: bytes
    color_map: ColorMap
    low: float
    high: float
    unit: str
    title: str
    palette: bytes
    node_uid: int
    def __init__(self, name: _Optional[str] = ..., node: _Optional[str] = ..., vertices: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., faces: _Optional[_Union[_geometry_pb2.NumericArray, _Mapping]] = ..., values: _Optional[bytes] = ..., color_map: _Optional[_Union[ColorMap, str]] = ..., low: _Optional[float] = ..., high: _Optional[float] = ..., unit: _Optional[str] = ..., title: _Optional[str] = ..., palette: _Optional[bytes] = ..., node_uid: _Optional[int] = ...) -> None: ...

class CoatValues(_message.Message):
    __slots__ = ("name", "first", "values")
    NAME_FIELD_NUMBER: _ClassVar[int]
    FIRST_FIELD_NUMBER: _ClassVar[int]
    VALUES_FIELD_NUMBER: _ClassVar[int]
    name: str
    first: int
    values: bytes
    def __init__(self, name: _Optional[str] = ..., first: _Optional[int] = ..., values: _Optional[bytes] = ...) -> None: ...

class SetCoatRequest(_message.Message):
    __slots__ = ("coat",)
    COAT_FIELD_NUMBER: _ClassVar[int]
    coat: Coat
    def __init__(self, coat: _Optional[_Union[Coat, _Mapping]] = ...) -> None: ...

class SetCoatResponse(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class PaintCoatRequest(_message.Message):
    __slots__ = ("values",)
    VALUES_FIELD_NUMBER: _ClassVar[int]
    values: CoatValues
    def __init__(self, values: _Optional[_Union[CoatValues, _Mapping]] = ...) -> None: ...

class PaintCoatResponse(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class RemoveCoatsRequest(_message.Message):
    __slots__ = ("names",)
    NAMES_FIELD_NUMBER: _ClassVar[int]
    names: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, names: _Optional[_Iterable[str]] = ...) -> None: ...

class RemoveCoatsResponse(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class WatchCoatsRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class WatchCoatsResponse(_message.Message):
    __slots__ = ("coats", "values", "removed_names")
    COATS_FIELD_NUMBER: _ClassVar[int]
    VALUES_FIELD_NUMBER: _ClassVar[int]
    REMOVED_NAMES_FIELD_NUMBER: _ClassVar[int]
    coats: _containers.RepeatedCompositeFieldContainer[Coat]
    values: _containers.RepeatedCompositeFieldContainer[CoatValues]
    removed_names: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, coats: _Optional[_Iterable[_Union[Coat, _Mapping]]] = ..., values: _Optional[_Iterable[_Union[CoatValues, _Mapping]]] = ..., removed_names: _Optional[_Iterable[str]] = ...) -> None: ...
