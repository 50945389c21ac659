"""Refusals on the wire: a KernelError becomes one gRPC status with a `google.rpc.ErrorInfo`."""

from __future__ import annotations

import grpc
from google.protobuf.any_pb2 import Any
from google.rpc import error_details_pb2, status_pb2

from virtualrobot_kernel.errors import KernelError, Reason

DOMAIN = "virtualrobot"
LONGEST_VALUE = 500
"""Metadata values are cut after this many characters: gRPC's trailers are limited to 8 KiB."""

CODES = {
    Reason.INVALID_ARGUMENT: grpc.StatusCode.INVALID_ARGUMENT,
    Reason.UNKNOWN_NAME: grpc.StatusCode.NOT_FOUND,
    Reason.NAME_TAKEN: grpc.StatusCode.ALREADY_EXISTS,
    Reason.STALE_REVISION: grpc.StatusCode.ABORTED,
    Reason.LIMIT_EXCEEDED: grpc.StatusCode.OUT_OF_RANGE,
    Reason.UNREACHABLE: grpc.StatusCode.OUT_OF_RANGE,
    Reason.SINGULARITY: grpc.StatusCode.OUT_OF_RANGE,
    Reason.ROBOT_BUSY: grpc.StatusCode.ABORTED,
    Reason.WRONG_STATE: grpc.StatusCode.FAILED_PRECONDITION,
    Reason.MALFORMED_FILE: grpc.StatusCode.INVALID_ARGUMENT,
    Reason.MISSING_FILE: grpc.StatusCode.NOT_FOUND,
    Reason.MALFORMED_ASSET: grpc.StatusCode.INVALID_ARGUMENT,
    Reason.UNKNOWN_ASSET: grpc.StatusCode.NOT_FOUND,
    Reason.TOO_LARGE: grpc.StatusCode.RESOURCE_EXHAUSTED,
    Reason.UNAUTHENTICATED: grpc.StatusCode.UNAUTHENTICATED,
    Reason.SHUTTING_DOWN: grpc.StatusCode.UNAVAILABLE,
    Reason.INTERNAL: grpc.StatusCode.INTERNAL,
    Reason.PLUGIN_FAILED: grpc.StatusCode.FAILED_PRECONDITION,
    Reason.LEASED: grpc.StatusCode.PERMISSION_DENIED,
    Reason.LEASE_ENDED: grpc.StatusCode.FAILED_PRECONDITION,
}


def trailers(error: KernelError) -> tuple[grpc.StatusCode, str, tuple[tuple[str, bytes], ...]]:
    """Return code, message and trailing metadata of a refused call."""
    code = CODES[error.reason]
    message = _cut(str(error), 4 * LONGEST_VALUE)
    metadata = {key: _cut(value, LONGEST_VALUE) for key, value in error.metadata.items()}
    info = error_details_pb2.ErrorInfo(reason=error.reason.name, domain=DOMAIN, metadata=metadata)
    detail = Any()
    detail.Pack(info)
    status = status_pb2.Status(code=code.value[0], message=message, details=[detail])
    return code, message, (("grpc-status-details-bin", status.SerializeToString()),)


def _cut(text: str, length: int) -> str:
    return text if len(text) <= length else text[: length - 1] + "…"
