from virtualrobot.v1 import geometry_pb2 as _geometry_pb2
from virtualrobot.v1 import motion_pb2 as _motion_pb2
from virtualrobot.v1 import token_pb2 as _token_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class ProposalState(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    PROPOSAL_STATE_UNSPECIFIED: _ClassVar[ProposalState]
    PROPOSAL_STATE_PROPOSED: _ClassVar[ProposalState]
    PROPOSAL_STATE_APPROVED: _ClassVar[ProposalState]
    PROPOSAL_STATE_EXECUTED: _ClassVar[ProposalState]
    PROPOSAL_STATE_STOPPED: _ClassVar[ProposalState]
    PROPOSAL_STATE_REJECTED: _ClassVar[ProposalState]
PROPOSAL_STATE_UNSPECIFIED: ProposalState
PROPOSAL_STATE_PROPOSED: ProposalState
PROPOSAL_STATE_APPROVED: ProposalState
PROPOSAL_STATE_EXECUTED: ProposalState
PROPOSAL_STATE_STOPPED: ProposalState
PROPOSAL_STATE_REJECTED: ProposalState

class Proposal(_message.Message):
    __slots__ = ("id", "revision", "title", "spec", "check", "robots", "state", "author", "changed_by", "motion_id", "reason", "undo_count")
    ID_FIELD_NUMBER: _ClassVar[int]
    REVISION_FIELD_NUMBER: _ClassVar[int]
    TITLE_FIELD_NUMBER: _ClassVar[int]
    SPEC_FIELD_NUMBER: _ClassVar[int]
    CHECK_FIELD_NUMBER: _ClassVar[int]
    ROBOTS_FIELD_NUMBER: _ClassVar[int]
    STATE_FIELD_NUMBER: _ClassVar[int]
    AUTHOR_FIELD_NUMBER: _ClassVar[int]
    CHANGED_BY_FIELD_NUMBER: _ClassVar[int]
    MOTION_ID_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    UNDO_COUNT_FIELD_NUMBER: _ClassVar[int]
    id: str
    revision: int
    title: str
    spec: _motion_pb2.MotionSpec
    check: _motion_pb2.CheckMotionResponse
    robots: _containers.RepeatedScalarFieldContainer[str]
    state: ProposalState
    author: str
    changed_by: str
    motion_id: str
    reason: str
    undo_count: int
    def __init__(self, id: _Optional[str] = ..., revision: _Optional[int] = ..., title: _Optional[str] = ..., spec: _Optional[_Union[_motion_pb2.MotionSpec, _Mapping]] = ..., check: _Optional[_Union[_motion_pb2.CheckMotionResponse, _Mapping]] = ..., robots: _Optional[_Iterable[str]] = ..., state: _Optional[_Union[ProposalState, str]] = ..., author: _Optional[str] = ..., changed_by: _Optional[str] = ..., motion_id: _Optional[str] = ..., reason: _Optional[str] = ..., undo_count: _Optional[int] = ...) -> None: ...

class ListProposalsRequest(_message.Message):
    __slots__ = ("ids",)
    IDS_FIELD_NUMBER: _ClassVar[int]
    ids: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, ids: _Optional[_Iterable[str]] = ...) -> None: ...

class ListProposalsResponse(_message.Message):
    __slots__ = ("stamp", "proposals")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    PROPOSALS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    proposals: _containers.RepeatedCompositeFieldContainer[Proposal]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., proposals: _Optional[_Iterable[_Union[Proposal, _Mapping]]] = ...) -> None: ...

class WatchProposalsRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class WatchProposalsResponse(_message.Message):
    __slots__ = ("stamp", "proposals", "removed_ids")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    PROPOSALS_FIELD_NUMBER: _ClassVar[int]
    REMOVED_IDS_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    proposals: _containers.RepeatedCompositeFieldContainer[Proposal]
    removed_ids: _containers.RepeatedScalarFieldContainer[str]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., proposals: _Optional[_Iterable[_Union[Proposal, _Mapping]]] = ..., removed_ids: _Optional[_Iterable[str]] = ...) -> None: ...

class CreateProposalRequest(_message.Message):
    __slots__ = ("spec", "title")
    SPEC_FIELD_NUMBER: _ClassVar[int]
    TITLE_FIELD_NUMBER: _ClassVar[int]
    spec: _motion_pb2.MotionSpec
    title: str
    def __init__(self, spec: _Optional[_Union[_motion_pb2.MotionSpec, _Mapping]] = ..., title: _Optional[str] = ...) -> None: ...

class CreateProposalResponse(_message.Message):
    __slots__ = ("stamp", "proposal")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    PROPOSAL_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    proposal: Proposal
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., proposal: _Optional[_Union[Proposal, _Mapping]] = ...) -> None: ...

class UpdateProposalRequest(_message.Message):
    __slots__ = ("id", "expected_revision", "spec", "title")
    ID_FIELD_NUMBER: _ClassVar[int]
    EXPECTED_REVISION_FIELD_NUMBER: _ClassVar[int]
    SPEC_FIELD_NUMBER: _ClassVar[int]
    TITLE_FIELD_NUMBER: _ClassVar[int]
    id: str
    expected_revision: int
    spec: _motion_pb2.MotionSpec
    title: str
    def __init__(self, id: _Optional[str] = ..., expected_revision: _Optional[int] = ..., spec: _Optional[_Union[_motion_pb2.MotionSpec, _Mapping]] = ..., title: _Optional[str] = ...) -> None: ...

class UpdateProposalResponse(_message.Message):
    __slots__ = ("stamp", "proposal")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    PROPOSAL_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    proposal: Proposal
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., proposal: _Optional[_Union[Proposal, _Mapping]] = ...) -> None: ...

class UndoProposalRequest(_message.Message):
    __slots__ = ("id", "expected_revision")
    ID_FIELD_NUMBER: _ClassVar[int]
    EXPECTED_REVISION_FIELD_NUMBER: _ClassVar[int]
    id: str
    expected_revision: int
    def __init__(self, id: _Optional[str] = ..., expected_revision: _Optional[int] = ...) -> None: ...

class UndoProposalResponse(_message.Message):
    __slots__ = ("stamp", "proposal")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    PROPOSAL_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    proposal: Proposal
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., proposal: _Optional[_Union[Proposal, _Mapping]] = ...) -> None: ...

class RejectProposalRequest(_message.Message):
    __slots__ = ("id", "expected_revision", "reason")
    ID_FIELD_NUMBER: _ClassVar[int]
    EXPECTED_REVISION_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    id: str
    expected_revision: int
    reason: str
    def __init__(self, id: _Optional[str] = ..., expected_revision: _Optional[int] = ..., reason: _Optional[str] = ...) -> None: ...

class RejectProposalResponse(_message.Message):
    __slots__ = ("stamp", "proposal")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    PROPOSAL_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    proposal: Proposal
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., proposal: _Optional[_Union[Proposal, _Mapping]] = ...) -> None: ...
