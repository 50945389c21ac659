from google.protobuf import field_mask_pb2 as _field_mask_pb2
from virtualrobot.v1 import geometry_pb2 as _geometry_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class View(_message.Message):
    __slots__ = ("background", "grid_hidden", "joint_axes", "bounding_boxes", "camera")
    BACKGROUND_FIELD_NUMBER: _ClassVar[int]
    GRID_HIDDEN_FIELD_NUMBER: _ClassVar[int]
    JOINT_AXES_FIELD_NUMBER: _ClassVar[int]
    BOUNDING_BOXES_FIELD_NUMBER: _ClassVar[int]
    CAMERA_FIELD_NUMBER: _ClassVar[int]
    background: _geometry_pb2.Color
    grid_hidden: bool
    joint_axes: _containers.RepeatedScalarFieldContainer[str]
    bounding_boxes: _containers.RepeatedScalarFieldContainer[str]
    camera: Camera
    def __init__(self, background: _Optional[_Union[_geometry_pb2.Color, _Mapping]] = ..., grid_hidden: bool = ..., joint_axes: _Optional[_Iterable[str]] = ..., bounding_boxes: _Optional[_Iterable[str]] = ..., camera: _Optional[_Union[Camera, _Mapping]] = ...) -> None: ...

class Camera(_message.Message):
    __slots__ = ("position", "target", "field_of_view_radians")
    POSITION_FIELD_NUMBER: _ClassVar[int]
    TARGET_FIELD_NUMBER: _ClassVar[int]
    FIELD_OF_VIEW_RADIANS_FIELD_NUMBER: _ClassVar[int]
    position: _geometry_pb2.Vector3
    target: _geometry_pb2.Vector3
    field_of_view_radians: float
    def __init__(self, position: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., target: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., field_of_view_radians: _Optional[float] = ...) -> None: ...

class GetViewRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class GetViewResponse(_message.Message):
    __slots__ = ("view", "viewer_count")
    VIEW_FIELD_NUMBER: _ClassVar[int]
    VIEWER_COUNT_FIELD_NUMBER: _ClassVar[int]
    view: View
    viewer_count: int
    def __init__(self, view: _Optional[_Union[View, _Mapping]] = ..., viewer_count: _Optional[int] = ...) -> None: ...

class UpdateViewRequest(_message.Message):
    __slots__ = ("view", "mask")
    VIEW_FIELD_NUMBER: _ClassVar[int]
    MASK_FIELD_NUMBER: _ClassVar[int]
    view: View
    mask: _field_mask_pb2.FieldMask
    def __init__(self, view: _Optional[_Union[View, _Mapping]] = ..., mask: _Optional[_Union[_field_mask_pb2.FieldMask, _Mapping]] = ...) -> None: ...

class UpdateViewResponse(_message.Message):
    __slots__ = ("view",)
    VIEW_FIELD_NUMBER: _ClassVar[int]
    view: View
    def __init__(self, view: _Optional[_Union[View, _Mapping]] = ...) -> None: ...

class WatchViewRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class WatchViewResponse(_message.Message):
    __slots__ = ("view",)
    VIEW_FIELD_NUMBER: _ClassVar[int]
    view: View
    def __init__(self, view: _Optional[_Union[View, _Mapping]] = ...) -> None: ...
