from google.protobuf import descriptor_pb2 as _descriptor_pb2
from google.protobuf import timestamp_pb2 as _timestamp_pb2
from virtualrobot.v1 import geometry_pb2 as _geometry_pb2
from virtualrobot.v1 import token_pb2 as _token_pb2
from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class LeaseLoss(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    LEASE_LOSS_UNSPECIFIED: _ClassVar[LeaseLoss]
    LEASE_LOSS_RELEASED: _ClassVar[LeaseLoss]
    LEASE_LOSS_TAKEN: _ClassVar[LeaseLoss]
LEASE_LOSS_UNSPECIFIED: LeaseLoss
LEASE_LOSS_RELEASED: LeaseLoss
LEASE_LOSS_TAKEN: LeaseLoss
NEEDS_LEASE_FIELD_NUMBER: _ClassVar[int]
needs_lease: _descriptor.FieldDescriptor

class Lease(_message.Message):
    __slots__ = ("id", "robots", "owner", "since")
    ID_FIELD_NUMBER: _ClassVar[int]
    ROBOTS_FIELD_NUMBER: _ClassVar[int]
    OWNER_FIELD_NUMBER: _ClassVar[int]
    SINCE_FIELD_NUMBER: _ClassVar[int]
    id: str
    robots: _containers.RepeatedScalarFieldContainer[str]
    owner: str
    since: _timestamp_pb2.Timestamp
    def __init__(self, id: _Optional[str] = ..., robots: _Optional[_Iterable[str]] = ..., owner: _Optional[str] = ..., since: _Optional[_Union[_timestamp_pb2.Timestamp, _Mapping]] = ...) -> None: ...

class AcquireLeaseRequest(_message.Message):
    __slots__ = ("robots", "owner")
    ROBOTS_FIELD_NUMBER: _ClassVar[int]
    OWNER_FIELD_NUMBER: _ClassVar[int]
    robots: _containers.RepeatedScalarFieldContainer[str]
    owner: str
    def __init__(self, robots: _Optional[_Iterable[str]] = ..., owner: _Optional[str] = ...) -> None: ...

class AcquireLeaseResponse(_message.Message):
    __slots__ = ("stamp", "lease", "token")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    LEASE_FIELD_NUMBER: _ClassVar[int]
    TOKEN_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    lease: Lease
    token: str
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., lease: _Optional[_Union[Lease, _Mapping]] = ..., token: _Optional[str] = ...) -> None: ...

class TakeLeaseRequest(_message.Message):
    __slots__ = ("robots", "owner")
    ROBOTS_FIELD_NUMBER: _ClassVar[int]
    OWNER_FIELD_NUMBER: _ClassVar[int]
    robots: _containers.RepeatedScalarFieldContainer[str]
    owner: str
    def __init__(self, robots: _Optional[_Iterable[str]] = ..., owner: _Optional[str] = ...) -> None: ...

class TakeLeaseResponse(_message.Message):
    __slots__ = ("stamp", "lease", "token", "taken_from")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    LEASE_FIELD_NUMBER: _ClassVar[int]
    TOKEN_FIELD_NUMBER: _ClassVar[int]
    TAKEN_FROM_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    lease: Lease
    token: str
    taken_from: _containers.RepeatedCompositeFieldContainer[Lease]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., lease: _Optional[_Union[Lease, _Mapping]] = ..., token: _Optional[str] = ..., taken_from: _Optional[_Iterable[_Union[Lease, _Mapping]]] = ...) -> None: ...

class KeepLeaseAliveRequest(_message.Message):
    __slots__ = ("token",)
    TOKEN_FIELD_NUMBER: _ClassVar[int]
    token: str
    def __init__(self, token: _Optional[str] = ...) -> None: ...

class KeepLeaseAliveResponse(_message.Message):
    __slots__ = ("stamp", "lease", "loss", "reason")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    LEASE_FIELD_NUMBER: _ClassVar[int]
    LOSS_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    lease: Lease
    loss: LeaseLoss
    reason: str
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., lease: _Optional[_Union[Lease, _Mapping]] = ..., loss: _Optional[_Union[LeaseLoss, str]] = ..., reason: _Optional[str] = ...) -> None: ...

class ReleaseLeaseRequest(_message.Message):
    __slots__ = ("token",)
    TOKEN_FIELD_NUMBER: _ClassVar[int]
    token: str
    def __init__(self, token: _Optional[str] = ...) -> None: ...

class ReleaseLeaseResponse(_message.Message):
    __slots__ = ("stamp", "lease")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    LEASE_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    lease: Lease
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., lease: _Optional[_Union[Lease, _Mapping]] = ...) -> None: ...

class ListLeasesRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class ListLeasesResponse(_message.Message):
    __slots__ = ("stamp", "leases")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    LEASES_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    leases: _containers.RepeatedCompositeFieldContainer[Lease]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., leases: _Optional[_Iterable[_Union[Lease, _Mapping]]] = ...) -> None: ...

class WatchLeasesRequest(_message.Message):
    __slots__ = ()
    def __init__(self) -> None: ...

class WatchLeasesResponse(_message.Message):
    __slots__ = ("stamp", "leases")
    STAMP_FIELD_NUMBER: _ClassVar[int]
    LEASES_FIELD_NUMBER: _ClassVar[int]
    stamp: _geometry_pb2.Stamp
    leases: _containers.RepeatedCompositeFieldContainer[Lease]
    def __init__(self, stamp: _Optional[_Union[_geometry_pb2.Stamp, _Mapping]] = ..., leases: _Optional[_Iterable[_Union[Lease, _Mapping]]] = ...) -> None: ...
