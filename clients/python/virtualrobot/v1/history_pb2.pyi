from google.protobuf import timestamp_pb2 as _timestamp_pb2
from virtualrobot.v1 import geometry_pb2 as _geometry_pb2
from virtualrobot.v1 import lease_pb2 as _lease_pb2
from virtualrobot.v1 import token_pb2 as _token_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class StepKind(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    STEP_KIND_UNSPECIFIED: _ClassVar[StepKind]
    STEP_KIND_EDIT: _ClassVar[StepKind]
    STEP_KIND_UNDO: _ClassVar[StepKind]
    STEP_KIND_REDO: _ClassVar[StepKind]
    STEP_KIND_MOTION: _ClassVar[StepKind]
    STEP_KIND_SIGNAL: _ClassVar[StepKind]
    STEP_KIND_OTHER: _ClassVar[StepKind]
    STEP_KIND_RESTORE: _ClassVar[StepKind]
STEP_KIND_UNSPECIFIED: StepKind
STEP_KIND_EDIT: StepKind
STEP_KIND_UNDO: StepKind
STEP_KIND_REDO: StepKind
STEP_KIND_MOTION: StepKind
STEP_KIND_SIGNAL: StepKind
STEP_KIND_OTHER: StepKind
STEP_KIND_RESTORE: StepKind

class Step(_message.Message):
    __slots__ = ("number", "first_number", "kind", "label", "author", "mine", "time", "tick", "nodes", "undone", "undoes")
    NUMBER_FIELD_NUMBER: _ClassVar[int]
    FIRST_NUMBER_FIELD_NUMBER: _ClassVar[int]
    KIND_FIELD_NUMBER: _ClassVar[int]
    LABEL_FIELD_NUMBER: _ClassVar[int]
    AUTHOR_FIELD_NUMBER: _ClassVar[int]
    MINE_FIELD_NUMBER: _ClassVar[int]
    TIME_FIELD_NUMBER: _ClassVar[int]
    TICK_FIELD_NUMBER: _ClassVar[int]
    NODES_FIELD_NUMBER: _ClassVar[int]
    UNDONE_FIELD_NUMBER: _ClassVar[int]
    UNDOES_FIELD_NUMBER: _ClassVar[int]
    number: int
    first_number: int
    kind: StepKind
    label: str
    author: str
    mine: bool
    time: _timestamp_pb2.Timestamp
    tick: int
    nodes: _containers.RepeatedScalarFieldContainer[str]
    undone: bool
    undoes: int
    def __init__(self, number: _Optional[int] = ..., first_number: _Optional[int] = ..., kind: _Optional[_Union[StepKind, str]] = ..., label: _Optional[str] = ..., author: _Optional[str] = ..., mine: bool = ..., time: _Optional[_Union[_timestamp_pb2.Timestamp, _Mapping]] = ..., tick: _Optional[int] = ..., nodes: _Optional[_Iterable[str]] = ..., undone: bool = ..., undoes: _Optional[int] = ...) -> None: ...

class ListStepsRequest(_message.Message):
    __slots__ = ("node", "author", "only_mine", "since", "until", "kinds", "page_size", "page_token")
    NODE_FIELD_NUMBER: _ClassVar[int]
    AUTHOR_FIELD_NUMBER: _ClassVar[int]
    ONLY_MINE_FIELD_NUMBER: _ClassVar[int]
    SINCE_FIELD_NUMBER: _ClassVar[int]
    UNTIL_FIELD_NUMBER: _ClassVar[int]
    KINDS_FIELD_NUMBER: _ClassVar[int]
    PAGE_SIZE_FIELD_NUMBER: _ClassVar[int]
    PAGE_TOKEN_FIELD_NUMBER: _ClassVar[int]
    node: str
    author: str
    only_mine: bool
    since: _timestamp_pb2.Timestamp
    until: _timestamp_pb2.Timestamp
    kinds: _containers.RepeatedScalarFieldContainer[StepKind]
    page_size: int
    page_token: str
    def __init__(self, node: _Optional[str] = ..., author: _Optional[str] = ..., only_mine: bool = ..., since: _Optional[_Union[_timestamp_pb2.Timestamp, _Mapping]] = ..., until: _Optional[_Union[_timestamp_pb2.Timestamp, _Mapping]] = ..., kinds: _Optional[_Iterable[_Union[StepKind, str]]] = ..., page_size: _Optional[int] = ..., page_token: _Optional[str] = ...) -> None: ...

class ListStepsResponse(_message.Message):
    __slots__ = ("stamp", "steps", "next_page_token")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    STEPS_FIELD_NUMBER: _ClassVar[int]
    NEXT_PAGE_TOKEN_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    steps: _containers.RepeatedCompositeFieldContainer[Step]
    next_page_token: str
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., steps: _Optional[_Iterable[_Union[Step, _Mapping]]] = ..., next_page_token: _Optional[str] = ...) -> None: ...

class WatchStepsRequest(_message.Message):
    __slots__ = ("from_number",)
    FROM_NUMBER_FIELD_NUMBER: _ClassVar[int]
    from_number: int
    def __init__(self, from_number: _Optional[int] = ...) -> None: ...

class WatchStepsResponse(_message.Message):
    __slots__ = ("stamp", "steps")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    STEPS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    steps: _containers.RepeatedCompositeFieldContainer[Step]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., steps: _Optional[_Iterable[_Union[Step, _Mapping]]] = ...) -> None: ...

class UndoRequest(_message.Message):
    __slots__ = ("only_mine", "number", "request_id")
    ONLY_MINE_FIELD_NUMBER: _ClassVar[int]
    NUMBER_FIELD_NUMBER: _ClassVar[int]
    REQUEST_ID_FIELD_NUMBER: _ClassVar[int]
    only_mine: bool
    number: int
    request_id: str
    def __init__(self, only_mine: bool = ..., number: _Optional[int] = ..., request_id: _Optional[str] = ...) -> None: ...

class UndoResponse(_message.Message):
    __slots__ = ("stamp", "step", "undone")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    STEP_FIELD_NUMBER: _ClassVar[int]
    UNDONE_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    step: Step
    undone: Step
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., step: _Optional[_Union[Step, _Mapping]] = ..., undone: _Optional[_Union[Step, _Mapping]] = ...) -> None: ...

class RedoRequest(_message.Message):
    __slots__ = ("only_mine", "number", "request_id")
    ONLY_MINE_FIELD_NUMBER: _ClassVar[int]
    NUMBER_FIELD_NUMBER: _ClassVar[int]
    REQUEST_ID_FIELD_NUMBER: _ClassVar[int]
    only_mine: bool
    number: int
    request_id: str
    def __init__(self, only_mine: bool = ..., number: _Optional[int] = ..., request_id: _Optional[str] = ...) -> None: ...

class RedoResponse(_message.Message):
    __slots__ = ("stamp", "step", "redone")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    STEP_FIELD_NUMBER: _ClassVar[int]
    REDONE_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    step: Step
    redone: Step
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., step: _Optional[_Union[Step, _Mapping]] = ..., redone: _Optional[_Union[Step, _Mapping]] = ...) -> None: ...

class Checkpoint(_message.Message):
    __slots__ = ("name", "author", "time", "tick", "node_count", "automatic")
    NAME_FIELD_NUMBER: _ClassVar[int]
    AUTHOR_FIELD_NUMBER: _ClassVar[int]
    TIME_FIELD_NUMBER: _ClassVar[int]
    TICK_FIELD_NUMBER: _ClassVar[int]
    NODE_COUNT_FIELD_NUMBER: _ClassVar[int]
    AUTOMATIC_FIELD_NUMBER: _ClassVar[int]
    name: str
    author: str
    time: _timestamp_pb2.Timestamp
    tick: int
    node_count: int
    automatic: bool
    def __init__(self, name: _Optional[str] = ..., author: _Optional[str] = ..., time: _Optional[_Union[_timestamp_pb2.Timestamp, _Mapping]] = ..., tick: _Optional[int] = ..., node_count: _Optional[int] = ..., automatic: bool = ...) -> None: ...

class CreateCheckpointRequest(_message.Message):
    __slots__ = ("name", "request_id")
    NAME_FIELD_NUMBER: _ClassVar[int]
    REQUEST_ID_FIELD_NUMBER: _ClassVar[int]
    name: str
    request_id: str
    def __init__(self, name: _Optional[str] = ..., request_id: _Optional[str] = ...) -> None: ...

class CreateCheckpointResponse(_message.Message):
    __slots__ = ("stamp", "checkpoint")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    CHECKPOINT_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    checkpoint: Checkpoint
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., checkpoint: _Optional[_Union[Checkpoint, _Mapping]] = ...) -> None: ...

class ListCheckpointsRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class ListCheckpointsResponse(_message.Message):
    __slots__ = ("stamp", "checkpoints")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    CHECKPOINTS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    checkpoints: _containers.RepeatedCompositeFieldContainer[Checkpoint]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., checkpoints: _Optional[_Iterable[_Union[Checkpoint, _Mapping]]] = ...) -> None: ...

class RestoreCheckpointRequest(_message.Message):
    __slots__ = ("name", "request_id")
    NAME_FIELD_NUMBER: _ClassVar[int]
    REQUEST_ID_FIELD_NUMBER: _ClassVar[int]
    name: str
    request_id: str
    def __init__(self, name: _Optional[str] = ..., request_id: _Optional[str] = ...) -> None: ...

class RestoreCheckpointResponse(_message.Message):
    __slots__ = ("stamp", "checkpoint", "before")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    CHECKPOINT_FIELD_NUMBER: _ClassVar[int]
    BEFORE_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    checkpoint: Checkpoint
    before: Checkpoint
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., checkpoint: _Optional[_Union[Checkpoint, _Mapping]] = ..., before: _Optional[_Union[Checkpoint, _Mapping]] = ...) -> None: ...

class RemoveCheckpointRequest(_message.Message):
    __slots__ = ("name",)
    NAME_FIELD_NUMBER: _ClassVar[int]
    name: str
    def __init__(self, name: _Optional[str] = ...) -> None: ...

class RemoveCheckpointResponse(_message.Message):
    __slots__ = ("stamp", "checkpoint")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    CHECKPOINT_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    checkpoint: Checkpoint
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., checkpoint: _Optional[_Union[Checkpoint, _Mapping]] = ...) -> None: ...
