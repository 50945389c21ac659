from google.protobuf import struct_pb2 as _struct_pb2
from virtualrobot.v1 import token_pb2 as _token_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class PluginState(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    PLUGIN_STATE_UNSPECIFIED: _ClassVar[PluginState]
    PLUGIN_STATE_LOADED: _ClassVar[PluginState]
    PLUGIN_STATE_FAILED: _ClassVar[PluginState]

class ComponentKind(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    COMPONENT_KIND_UNSPECIFIED: _ClassVar[ComponentKind]
    COMPONENT_KIND_KINEMATICS: _ClassVar[ComponentKind]
    COMPONENT_KIND_IMPORTER: _ClassVar[ComponentKind]
    COMPONENT_KIND_MOBILE_KINEMATICS: _ClassVar[ComponentKind]
    COMPONENT_KIND_RAY_CASTER: _ClassVar[ComponentKind]
    COMPONENT_KIND_SENSOR_MODEL: _ClassVar[ComponentKind]
    COMPONENT_KIND_ROBOT_DRIVER: _ClassVar[ComponentKind]
    COMPONENT_KIND_PHYSICS_ENGINE: _ClassVar[ComponentKind]
    COMPONENT_KIND_VEHICLE_DYNAMICS: _ClassVar[ComponentKind]

class Isolation(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    ISOLATION_UNSPECIFIED: _ClassVar[Isolation]
    ISOLATION_IN_PROCESS: _ClassVar[Isolation]
    ISOLATION_PROCESS: _ClassVar[Isolation]
PLUGIN_STATE_UNSPECIFIED: PluginState
PLUGIN_STATE_LOADED: PluginState
PLUGIN_STATE_FAILED: PluginState
COMPONENT_KIND_UNSPECIFIED: ComponentKind
COMPONENT_KIND_KINEMATICS: ComponentKind
COMPONENT_KIND_IMPORTER: ComponentKind
COMPONENT_KIND_MOBILE_KINEMATICS: ComponentKind
COMPONENT_KIND_RAY_CASTER: ComponentKind
COMPONENT_KIND_SENSOR_MODEL: ComponentKind
COMPONENT_KIND_ROBOT_DRIVER: ComponentKind
COMPONENT_KIND_PHYSICS_ENGINE: ComponentKind
COMPONENT_KIND_VEHICLE_DYNAMICS: ComponentKind
ISOLATION_UNSPECIFIED: Isolation
ISOLATION_IN_PROCESS: Isolation
ISOLATION_PROCESS: Isolation

class ListPluginsRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class ListPluginsResponse(_message.Message):
    __slots__ = ("plugins",)
    PLUGINS_FIELD_NUMBER: _ClassVar[int]
    plugins: _containers.RepeatedCompositeFieldContainer[Plugin]
    def __init__(self, plugins: _Optional[_Iterable[_Union[Plugin, _Mapping]]] = ...) -> None: ...

class ReloadPluginsRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class ReloadPluginsResponse(_message.Message):
    __slots__ = ("plugins",)
    PLUGINS_FIELD_NUMBER: _ClassVar[int]
    plugins: _containers.RepeatedCompositeFieldContainer[Plugin]
    def __init__(self, plugins: _Optional[_Iterable[_Union[Plugin, _Mapping]]] = ...) -> None: ...

class Plugin(_message.Message):
    __slots__ = ("name", "package", "version", "api_version", "state", "reason", "components")
    NAME_FIELD_NUMBER: _ClassVar[int]
    PACKAGE_FIELD_NUMBER: _ClassVar[int]
    VERSION_FIELD_NUMBER: _ClassVar[int]
    API_VERSION_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    COMPONENTS_FIELD_NUMBER: _ClassVar[int]
    name: str
    package: str
    version: str
    api_version: str
    state: PluginState
    reason: str
    components: _containers.RepeatedCompositeFieldContainer[Component]
    def __init__(self, name: _Optional[str] = ..., package: _Optional[str] = ..., version: _Optional[str] = ..., api_version: _Optional[str] = ..., state: _Optional[_Union[PluginState, str]] = ..., reason: _Optional[str] = ..., components: _Optional[_Iterable[_Union[Component, _Mapping]]] = ...) -> None: ...

class Component(_message.Message):
    __slots__ = ("kind", "name", "description", "isolation", "deadline_seconds", "settings_schema", "endings", "uses")
    KIND_FIELD_NUMBER: _ClassVar[int]
    NAME_FIELD_NUMBER: _ClassVar[int]
    DESCRIPTION_FIELD_NUMBER: _ClassVar[int]
    ISOLATION_FIELD_NUMBER: _ClassVar[int]
    DEADLINE_SECONDS_FIELD_NUMBER: _ClassVar[int]
    SETTINGS_SCHEMA_FIELD_NUMBER: _ClassVar[int]
    ENDINGS_FIELD_NUMBER: _ClassVar[int]
    USES_FIELD_NUMBER: _ClassVar[int]
    kind: ComponentKind
    name: str
    description: str
    isolation: Isolation
    deadline_seconds: float
    settings_schema: _struct_pb2.Struct
    endings: _containers.RepeatedScalarFieldContainer[str]
    uses: _containers.RepeatedCompositeFieldContainer[ComponentUse]
    def __init__(self, kind: _Optional[_Union[ComponentKind, str]] = ..., name: _Optional[str] = ..., description: _Optional[str] = ..., isolation: _Optional[_Union[Isolation, str]] = ..., deadline_seconds: _Optional[float] = ..., settings_schema: _Optional[_Union[_struct_pb2.Struct, _Mapping]] = ..., endings: _Optional[_Iterable[str]] = ..., uses: _Optional[_Iterable[_Union[ComponentUse, _Mapping]]] = ...) -> None: ...

class ComponentUse(_message.Message):
    __slots__ = ("robot", "fault", "calls", "mean_call_seconds", "process_id", "sensor", "group")
    ROBOT_FIELD_NUMBER: _ClassVar[int]
    FAULT_FIELD_NUMBER: _ClassVar[int]
    CALLS_FIELD_NUMBER: _ClassVar[int]
    MEAN_CALL_SECONDS_FIELD_NUMBER: _ClassVar[int]
    PROCESS_ID_FIELD_NUMBER: _ClassVar[int]
    SENSOR_FIELD_NUMBER: _ClassVar[int]
    GROUP_FIELD_NUMBER: _ClassVar[int]
    robot: str
    fault: str
    calls: int
    mean_call_seconds: float
    process_id: int
    sensor: str
    group: str
    def __init__(self, robot: _Optional[str] = ..., fault: _Optional[str] = ..., calls: _Optional[int] = ..., mean_call_seconds: _Optional[float] = ..., process_id: _Optional[int] = ..., sensor: _Optional[str] = ..., group: _Optional[str] = ...) -> None: ...
