"""Refused calls: one exception, said as Connect says errors, as gRPC-Web says them, or as an HTTP status."""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping
from typing import Any
from urllib.parse import quote

import grpc
from google.protobuf.any_pb2 import Any as Packed
from google.rpc import error_details_pb2, status_pb2
from virtualrobot._wire.transport import translated
from virtualrobot.errors import VirtualRobotError
from virtualrobot.v1.errors_pb2 import ErrorReason

DOMAIN = "virtualrobot"
STATUSES = {
    "canceled": 499,
    "unknown": 500,
    "invalid_argument": 400,
    "deadline_exceeded": 504,
    "not_found": 404,
    "already_exists": 409,
    "permission_denied": 403,
    "resource_exhausted": 429,
    "failed_precondition": 400,
    "aborted": 409,
    "out_of_range": 400,
    "unimplemented": 501,
    "internal": 500,
    "unavailable": 503,
    "data_loss": 500,
    "unauthenticated": 401,
}
"""HTTP status of each code of Connect (https://connectrpc.com/docs/protocol#error-codes), in the order of gRPC's
numbers, which begin with 1."""

_CODES = {
    "INVALID_ARGUMENT": "invalid_argument",
    "TOO_LARGE": "resource_exhausted",
    "TOO_MANY_CALLS": "resource_exhausted",
}


def end_of(refusal: Refusal | None) -> bytes:
    """Return the end of a stream as JSON: nothing in it, or Connect's error."""
    return json.dumps({} if refusal is None else {"error": refusal.said()}).encode()


class Refusal(Exception):
    """A call that is refused.

    Attributes:
        code: Connect's word for gRPC's code.
        message: a sentence for people.
        reason: the reason of the contract, "" where it has none.
        metadata: values for programs.
        status: HTTP status.
    """

    def __init__(
        self,
        code: str,
        message: str,
        reason: str = "",
        metadata: Mapping[str, str] | None = None,
        status: int | None = None,
    ) -> None:
        """Keep what is said; without a status it is the code's."""
        super().__init__(message)
        self.code, self.message = code, message
        self.reason, self.metadata = reason, dict(metadata or {})
        self.status = status or STATUSES[code]

    @classmethod
    def of(cls, reason: str, message: str, metadata: Mapping[str, str] | None = None) -> Refusal:
        """Return the refusal with a reason of the contract."""
        return cls(_CODES[reason], message, reason, metadata)

    @classmethod
    def of_kernel(cls, error: grpc.RpcError, address: str) -> Refusal:
        """Return what the kernel at `address`, or the way to it, has refused."""
        return cls.of_client(translated(error, address))

    @classmethod
    def of_client(cls, said: VirtualRobotError) -> Refusal:
        """Return what the client library has refused, or the kernel through it."""
        code = "canceled" if said.code == "CANCELLED" else said.code.lower()
        # The client library has reasons of its own for what no kernel has said.
        reason = said.reason if f"ERROR_REASON_{said.reason}" in ErrorReason.keys() else ""
        return cls(code or "failed_precondition", said.message, reason, said.metadata)

    @property
    def info(self) -> error_details_pb2.ErrorInfo | None:
        """The detail of the contract, where there is a reason."""
        if not self.reason:
            return None
        return error_details_pb2.ErrorInfo(reason=self.reason, domain=DOMAIN, metadata=self.metadata)

    def said(self) -> dict[str, Any]:
        """Return Connect's error: `code`, `message`, and the ErrorInfo encoded and, as `debug`, to be read."""
        said: dict[str, Any] = {"code": self.code, "message": self.message}
        if (info := self.info) is not None:
            readable = {"reason": info.reason, "domain": info.domain, "metadata": self.metadata}
            encoded = base64.b64encode(info.SerializeToString()).decode().rstrip("=")
            said["details"] = [{"type": "google.rpc.ErrorInfo", "value": encoded, "debug": readable}]
        return said

    def json(self) -> bytes:
        """Return Connect's error as JSON."""
        return json.dumps(self.said()).encode()

    def trailers(self) -> bytes:
        """Return the trailers of gRPC-Web."""
        number = 1 + list(STATUSES).index(self.code)
        lines = [f"grpc-status: {number}", f"grpc-message: {quote(self.message, safe=' !#$&()*+,/:;=?@[]')}"]
        if (info := self.info) is not None:
            detail = Packed()
            detail.Pack(info)
            status = status_pb2.Status(code=number, message=self.message, details=[detail])
            encoded = base64.b64encode(status.SerializeToString()).decode().rstrip("=")
            lines.append(f"grpc-status-details-bin: {encoded}")
        return "".join(f"{line}\r\n" for line in lines).encode()
