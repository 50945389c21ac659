"""Refusals on the wire: a KernelError becomes one gRPC status with a `google.rpc.ErrorInfo`."""

from __future__ import annotations

from itertools import accumulate

import grpc
from google.protobuf.any_pb2 import Any
from google.rpc import error_details_pb2, status_pb2

from virtualrobot_kernel.errors import KernelError, Reason

DOMAIN = "virtualrobot"
LONGEST_MESSAGE = 1800
LONGEST_VALUE = 500
LONGEST_METADATA = 2000
"""Greatest sizes (bytes) of the message, of each value and of all metadata: gRPC's trailers are limited to 8 KiB."""

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
    Reason.COLLISION: grpc.StatusCode.FAILED_PRECONDITION,
    Reason.PLAN_OUTDATED: grpc.StatusCode.ABORTED,
    Reason.CONFLICT: grpc.StatusCode.FAILED_PRECONDITION,
    Reason.ROLE_TOO_LOW: grpc.StatusCode.PERMISSION_DENIED,
    Reason.TOO_MANY_CALLS: grpc.StatusCode.RESOURCE_EXHAUSTED,
    Reason.DRIVER_FAULT: grpc.StatusCode.FAILED_PRECONDITION,
}


def trailers(error: KernelError) -> tuple[grpc.StatusCode, str, tuple[tuple[str, bytes], ...]]:
    """Return code, message and trailing metadata of a refused call."""
    code = CODES[error.reason]
    message = _cut(str(error), LONGEST_MESSAGE)
    metadata = _metadata(error)
    info = error_details_pb2.ErrorInfo(reason=error.reason.name, domain=DOMAIN, metadata=metadata)
    detail = Any()
    detail.Pack(info)
    status = status_pb2.Status(code=code.value[0], message=message, details=[detail])
    return code, message, (("grpc-status-details-bin", status.SerializeToString()),)


def _metadata(error: KernelError) -> dict[str, str]:
    """Return the metadata for programs, as much of it as there is room for."""
    told: dict[str, str] = {}
    room = LONGEST_METADATA
    for key, value in error.metadata.items():
        name, said = _cut(key, LONGEST_VALUE), _cut(value, LONGEST_VALUE)
        size = len(name.encode()) + len(said.encode())
        if size <= room:
            told[name] = said
            room -= size
    return told


def _cut(text: str, most: int) -> str:
    """Return `text` cut to `most` bytes as gRPC writes them: three for each byte that is not printable ASCII.

    What cannot be written in UTF-8 at all, as the half of a surrogate pair, is written in words.
    """
    written = text[: most + 1].encode("utf-8", "backslashreplace").decode()
    ends = accumulate(1 if " " <= c <= "~" and c != "%" else 3 * len(c.encode()) for c in written)
    fit = sum(end <= most for end in ends)
    return written if fit == len(written) else written[: max(0, fit - 9)] + "…"
