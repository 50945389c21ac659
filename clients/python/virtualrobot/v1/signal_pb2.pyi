from virtualrobot.v1 import geometry_pb2 as _geometry_pb2
from virtualrobot.v1 import token_pb2 as _token_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class SignalDirection(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    SIGNAL_DIRECTION_UNSPECIFIED: _ClassVar[SignalDirection]
    SIGNAL_DIRECTION_INPUT: _ClassVar[SignalDirection]
    SIGNAL_DIRECTION_OUTPUT: _ClassVar[SignalDirection]
    SIGNAL_DIRECTION_INTERNAL: _ClassVar[SignalDirection]
SIGNAL_DIRECTION_UNSPECIFIED: SignalDirection
SIGNAL_DIRECTION_INPUT: SignalDirection
SIGNAL_DIRECTION_OUTPUT: SignalDirection
SIGNAL_DIRECTION_INTERNAL: SignalDirection

class SignalValue(_message.Message):
    __slots__ = ("boolean", "integer", "number", "text", "group")
    BOOLEAN_FIELD_NUMBER: _ClassVar[int]
    INTEGER_FIELD_NUMBER: _ClassVar[int]
    NUMBER_FIELD_NUMBER: _ClassVar[int]
    TEXT_FIELD_NUMBER: _ClassVar[int]
    GROUP_FIELD_NUMBER: _ClassVar[int]
    boolean: bool
    integer: int
    number: float
    text: str
    group: BooleanGroup
    def __init__(self, boolean: bool = ..., integer: _Optional[int] = ..., number: _Optional[float] = ..., text: _Optional[str] = ..., group: _Optional[_Union[BooleanGroup, _Mapping]] = ...) -> None: ...

class BooleanGroup(_message.Message):
    __slots__ = ("values",)
    VALUES_FIELD_NUMBER: _ClassVar[int]
    values: _containers.RepeatedScalarFieldContainer[bool]
    def __init__(self, values: _Optional[_Iterable[bool]] = ...) -> None: ...

class Signal(_message.Message):
    __slots__ = ("name", "value", "description", "unit", "direction", "owner")
    NAME_FIELD_NUMBER: _ClassVar[int]
    VALUE_FIELD_NUMBER: _ClassVar[int]
    DESCRIPTION_FIELD_NUMBER: _ClassVar[int]
    UNIT_FIELD_NUMBER: _ClassVar[int]
    DIRECTION_FIELD_NUMBER: _ClassVar[int]
    OWNER_FIELD_NUMBER: _ClassVar[int]
    name: str
    value: SignalValue
    description: str
    unit: str
    direction: SignalDirection
    owner: str
    def __init__(self, name: _Optional[str] = ..., value: _Optional[_Union[SignalValue, _Mapping]] = ..., description: _Optional[str] = ..., unit: _Optional[str] = ..., direction: _Optional[_Union[SignalDirection, str]] = ..., owner: _Optional[str] = ...) -> None: ...

class GetSignalsRequest(_message.Message):
    __slots__ = ("names",)
    NAMES_FIELD_NUMBER: _ClassVar[int]
    names: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, names: _Optional[_Iterable[str]] = ...) -> None: ...

class GetSignalsResponse(_message.Message):
    __slots__ = ("stamp", "signals")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    SIGNALS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    signals: _containers.RepeatedCompositeFieldContainer[Signal]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., signals: _Optional[_Iterable[_Union[Signal, _Mapping]]] = ...) -> None: ...

class WatchSignalsRequest(_message.Message):
    __slots__ = ("names",)
    NAMES_FIELD_NUMBER: _ClassVar[int]
    names: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, names: _Optional[_Iterable[str]] = ...) -> None: ...

class WatchSignalsResponse(_message.Message):
    __slots__ = ("stamp", "signals", "removed_names")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    SIGNALS_FIELD_NUMBER: _ClassVar[int]
    REMOVED_NAMES_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    signals: _containers.RepeatedCompositeFieldContainer[Signal]
    removed_names: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., signals: _Optional[_Iterable[_Union[Signal, _Mapping]]] = ..., removed_names: _Optional[_Iterable[str]] = ...) -> None: ...
