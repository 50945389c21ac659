from google.protobuf import struct_pb2 as _struct_pb2
from virtualrobot.v1 import geometry_pb2 as _geometry_pb2
from virtualrobot.v1 import token_pb2 as _token_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class PhysicsSettings(_message.Message):
    __slots__ = ("engine", "engine_settings", "gravity", "substeps")
    ENGINE_FIELD_NUMBER: _ClassVar[int]
    ENGINE_SETTINGS_FIELD_NUMBER: _ClassVar[int]
    GRAVITY_FIELD_NUMBER: _ClassVar[int]
    SUBSTEPS_FIELD_NUMBER: _ClassVar[int]
    engine: str
    engine_settings: _struct_pb2.Struct
    gravity: _geometry_pb2.Vector3
    substeps: int
    def __init__(self, engine: _Optional[str] = ..., engine_settings: _Optional[_Union[_struct_pb2.Struct, _Mapping]] = ..., gravity: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., substeps: _Optional[int] = ...) -> None: ...

class SetPhysics(_message.Message):
    __slots__ = ("engine", "engine_settings", "gravity", "substeps")
    ENGINE_FIELD_NUMBER: _ClassVar[int]
    ENGINE_SETTINGS_FIELD_NUMBER: _ClassVar[int]
    GRAVITY_FIELD_NUMBER: _ClassVar[int]
    SUBSTEPS_FIELD_NUMBER: _ClassVar[int]
    engine: str
    engine_settings: _struct_pb2.Struct
    gravity: _geometry_pb2.Vector3
    substeps: int
    def __init__(self, engine: _Optional[str] = ..., engine_settings: _Optional[_Union[_struct_pb2.Struct, _Mapping]] = ..., gravity: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., substeps: _Optional[int] = ...) -> None: ...

class GetPhysicsRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class GetPhysicsResponse(_message.Message):
    __slots__ = ("stamp", "settings", "fault", "moving_parts", "contacts")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    SETTINGS_FIELD_NUMBER: _ClassVar[int]
    FAULT_FIELD_NUMBER: _ClassVar[int]
    MOVING_PARTS_FIELD_NUMBER: _ClassVar[int]
    CONTACTS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    settings: PhysicsSettings
    fault: str
    moving_parts: _containers.RepeatedScalarFieldContainer[str]
    contacts: _containers.RepeatedCompositeFieldContainer[PhysicsContact]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., settings: _Optional[_Union[PhysicsSettings, _Mapping]] = ..., fault: _Optional[str] = ..., moving_parts: _Optional[_Iterable[str]] = ..., contacts: _Optional[_Iterable[_Union[PhysicsContact, _Mapping]]] = ...) -> None: ...

class PhysicsContact(_message.Message):
    __slots__ = ("first", "second", "position", "force")
    FIRST_FIELD_NUMBER: _ClassVar[int]
    SECOND_FIELD_NUMBER: _ClassVar[int]
    POSITION_FIELD_NUMBER: _ClassVar[int]
    FORCE_FIELD_NUMBER: _ClassVar[int]
    first: str
    second: str
    position: _geometry_pb2.Vector3
    force: _geometry_pb2.Vector3
    def __init__(self, first: _Optional[str] = ..., second: _Optional[str] = ..., position: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ..., force: _Optional[_Union[_geometry_pb2.Vector3, _Mapping]] = ...) -> None: ...
