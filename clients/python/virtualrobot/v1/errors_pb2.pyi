from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from typing import ClassVar as _ClassVar

DESCRIPTOR: _descriptor.FileDescriptor

class ErrorReason(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    ERROR_REASON_UNSPECIFIED: _ClassVar[ErrorReason]
    ERROR_REASON_INVALID_ARGUMENT: _ClassVar[ErrorReason]
    ERROR_REASON_UNKNOWN_NAME: _ClassVar[ErrorReason]
    ERROR_REASON_NAME_TAKEN: _ClassVar[ErrorReason]
    ERROR_REASON_STALE_REVISION: _ClassVar[ErrorReason]
    ERROR_REASON_LIMIT_EXCEEDED: _ClassVar[ErrorReason]
    ERROR_REASON_UNREACHABLE: _ClassVar[ErrorReason]
    ERROR_REASON_SINGULARITY: _ClassVar[ErrorReason]
    ERROR_REASON_ROBOT_BUSY: _ClassVar[ErrorReason]
    ERROR_REASON_WRONG_STATE: _ClassVar[ErrorReason]
    ERROR_REASON_MALFORMED_FILE: _ClassVar[ErrorReason]
    ERROR_REASON_MISSING_FILE: _ClassVar[ErrorReason]
    ERROR_REASON_MALFORMED_ASSET: _ClassVar[ErrorReason]
    ERROR_REASON_UNKNOWN_ASSET: _ClassVar[ErrorReason]
    ERROR_REASON_TOO_LARGE: _ClassVar[ErrorReason]
    ERROR_REASON_UNAUTHENTICATED: _ClassVar[ErrorReason]
    ERROR_REASON_SHUTTING_DOWN: _ClassVar[ErrorReason]
    ERROR_REASON_INTERNAL: _ClassVar[ErrorReason]
    ERROR_REASON_PLUGIN_FAILED: _ClassVar[ErrorReason]
    ERROR_REASON_LEASED: _ClassVar[ErrorReason]
    ERROR_REASON_LEASE_ENDED: _ClassVar[ErrorReason]
    ERROR_REASON_COLLISION: _ClassVar[ErrorReason]
    ERROR_REASON_PLAN_OUTDATED: _ClassVar[ErrorReason]
    ERROR_REASON_CONFLICT: _ClassVar[ErrorReason]
    ERROR_REASON_ROLE_TOO_LOW: _ClassVar[ErrorReason]
    ERROR_REASON_TOO_MANY_CALLS: _ClassVar[ErrorReason]
    ERROR_REASON_DRIVER_FAULT: _ClassVar[ErrorReason]
ERROR_REASON_UNSPECIFIED: ErrorReason
ERROR_REASON_INVALID_ARGUMENT: ErrorReason
ERROR_REASON_UNKNOWN_NAME: ErrorReason
ERROR_REASON_NAME_TAKEN: ErrorReason
ERROR_REASON_STALE_REVISION: ErrorReason
ERROR_REASON_LIMIT_EXCEEDED: ErrorReason
ERROR_REASON_UNREACHABLE: ErrorReason
ERROR_REASON_SINGULARITY: ErrorReason
ERROR_REASON_ROBOT_BUSY: ErrorReason
ERROR_REASON_WRONG_STATE: ErrorReason
ERROR_REASON_MALFORMED_FILE: ErrorReason
ERROR_REASON_MISSING_FILE: ErrorReason
ERROR_REASON_MALFORMED_ASSET: ErrorReason
ERROR_REASON_UNKNOWN_ASSET: ErrorReason
ERROR_REASON_TOO_LARGE: ErrorReason
ERROR_REASON_UNAUTHENTICATED: ErrorReason
ERROR_REASON_SHUTTING_DOWN: ErrorReason
ERROR_REASON_INTERNAL: ErrorReason
ERROR_REASON_PLUGIN_FAILED: ErrorReason
ERROR_REASON_LEASED: ErrorReason
ERROR_REASON_LEASE_ENDED: ErrorReason
ERROR_REASON_COLLISION: ErrorReason
ERROR_REASON_PLAN_OUTDATED: ErrorReason
ERROR_REASON_CONFLICT: ErrorReason
ERROR_REASON_ROLE_TOO_LOW: ErrorReason
ERROR_REASON_TOO_MANY_CALLS: ErrorReason
ERROR_REASON_DRIVER_FAULT: ErrorReason
