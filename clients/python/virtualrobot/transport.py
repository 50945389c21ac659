"""One channel to a kernel: adds the token and a time limit to each call and turns statuses into exceptions."""

from __future__ import annotations

import ipaddress
import ssl
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Generic, NamedTuple, TypeVar

import grpc
from google.rpc import error_details_pb2
from grpc_status import rpc_status

from virtualrobot.errors import (
    BY_REASON,
    AuthenticationError,
    CallTimeoutError,
    ClientClosedError,
    InvalidArgumentError,
    KernelFaultError,
    KernelGoneError,
    TooLargeError,
    VersionError,
    VirtualRobotError,
)

Message = TypeVar("Message")
MAX_MESSAGE_BYTES = 256 * 1024 * 1024
_NO_ERROR_INFO: dict[grpc.StatusCode, type[VirtualRobotError]] = {
    grpc.StatusCode.INVALID_ARGUMENT: InvalidArgumentError,
    grpc.StatusCode.UNAUTHENTICATED: AuthenticationError,
    grpc.StatusCode.RESOURCE_EXHAUSTED: TooLargeError,
    grpc.StatusCode.INTERNAL: KernelFaultError,
}


class _Details(NamedTuple):
    """What grpcio wants to know of a call; the names are its own."""

    method: str
    timeout: float | None
    metadata: tuple[tuple[str, str | bytes], ...]
    credentials: grpc.CallCredentials | None
    wait_for_ready: bool | None
    compression: grpc.Compression | None


class Stream(Generic[Message]):
    """Messages of a watch or download as they come; ends when the kernel ends it or `cancel` is called."""

    def __init__(self, call: Any, address: str) -> None:  # noqa: ANN401 grpcio has no type for a running call
        """Read from a running call to the kernel at `address`."""
        self._call = call
        self._address = address
        self._cancelled = False

    def __iter__(self) -> Iterator[Message]:
        """Return itself."""
        return self

    def __next__(self) -> Message:
        """Wait for the next message."""
        try:
            return next(self._call)
        except grpc.RpcError as error:
            if self._cancelled:
                raise StopIteration from None
            raise translated(error, self._address) from error

    def cancel(self) -> None:
        """End the stream; the kernel is told."""
        self._cancelled = True
        self._call.cancel()

    def __enter__(self) -> Stream[Message]:
        """Return itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """End the stream."""
        self.cancel()


class _Interceptor(
    grpc.UnaryUnaryClientInterceptor, grpc.UnaryStreamClientInterceptor, grpc.StreamUnaryClientInterceptor
):
    """What every call passes."""

    def __init__(self, address: str, token: str | None, timeout_seconds: float) -> None:
        self._address = address
        self._metadata = (("authorization", f"Bearer {token}"),) if token else ()
        self._timeout_seconds = timeout_seconds

    def _details(self, details: Any, timeout: float | None) -> Any:  # noqa: ANN401 grpcio's types have no fields
        return _Details(
            details.method,
            details.timeout if details.timeout is not None else timeout,
            (*(details.metadata or ()), *self._metadata),
            details.credentials,
            details.wait_for_ready,
            details.compression,
        )

    def _whole(self, continuation: Callable[..., Any], details: Any, request: Any) -> Any:  # noqa: ANN401
        outcome = continuation(self._details(details, self._timeout_seconds), request)
        if (error := outcome.exception()) is not None:
            raise translated(error, self._address) from error
        return outcome

    def intercept_unary_unary(self, continuation: Callable[..., Any], client_call_details: Any, request: Any) -> Any:  # noqa: ANN401
        return self._whole(continuation, client_call_details, request)

    def intercept_stream_unary(
        self,
        continuation: Callable[..., Any],
        client_call_details: Any,  # noqa: ANN401
        request_iterator: Any,  # noqa: ANN401
    ) -> Any:  # noqa: ANN401
        return self._whole(continuation, client_call_details, request_iterator)

    def intercept_unary_stream(self, continuation: Callable[..., Any], client_call_details: Any, request: Any) -> Any:  # noqa: ANN401
        outcome = continuation(self._details(client_call_details, None), request)
        if not hasattr(outcome, "cancel") or not hasattr(outcome, "initial_metadata"):
            raise translated(outcome.exception(), self._address)
        return Stream(outcome, self._address)


def open_channel(
    address: str, host: str, token: str | None, root_certificate: Path | None, timeout_seconds: float
) -> grpc.Channel:
    """Return a channel to `address`, in the clear on this machine and by TLS beyond it or with `root_certificate`.

    Raises:
        InvalidArgumentError: when the certificate cannot be read or is none.
    """
    options = [
        ("grpc.max_receive_message_length", MAX_MESSAGE_BYTES),
        ("grpc.max_send_message_length", MAX_MESSAGE_BYTES),
        # After a lost connection the next call shall try at once and not after minutes.
        ("grpc.max_reconnect_backoff_ms", 1000),
    ]
    local = is_loopback(host)
    if local:
        # A proxy set for the web must not stand between programs on one machine.
        options.append(("grpc.enable_http_proxy", 0))
    if local and root_certificate is None:
        channel = grpc.insecure_channel(address, options)
    else:
        pem = None if root_certificate is None else _certificate(root_certificate)
        channel = grpc.secure_channel(address, grpc.ssl_channel_credentials(pem), options)
    return grpc.intercept_channel(channel, _Interceptor(address, token, timeout_seconds))


def is_loopback(host: str) -> bool:
    """Return whether `host` is this machine by its loopback interface."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def translated(error: BaseException, address: str) -> BaseException:
    """Return the exception that a failed call to the kernel at `address` raises."""
    if isinstance(error, ValueError) and "closed channel" in str(error):
        return ClientClosedError("this client is closed: connect again")
    if not isinstance(error, grpc.RpcError):
        return error
    call: Any = error
    code, text = call.code(), call.details() or ""
    status = rpc_status.from_call(call)
    for detail in status.details if status is not None else ():
        info = error_details_pb2.ErrorInfo()
        if detail.Unpack(info) and info.domain == "virtualrobot":
            kind = BY_REASON.get(info.reason, VirtualRobotError)
            return kind(text, info.reason, dict(info.metadata), code.name)
    if code is grpc.StatusCode.UNAVAILABLE:
        return KernelGoneError(
            f"no kernel answers at {address}: {_cause(text)}; start one with 'virtualrobot serve'", code=code.name
        )
    if code is grpc.StatusCode.DEADLINE_EXCEEDED:
        return CallTimeoutError(f"the kernel at {address} did not answer in time", code=code.name)
    if code is grpc.StatusCode.UNIMPLEMENTED:
        return VersionError(f"what listens at {address} does not know this call: {text}", code=code.name)
    if code is grpc.StatusCode.CANCELLED:
        return ClientClosedError("the call was cancelled by this client", code=code.name)
    return _NO_ERROR_INFO.get(code, VirtualRobotError)(text or code.name, code=code.name)


def _cause(text: str) -> str:
    """Return the telling end of gRPC's words for a connection that failed."""
    for sign, cause in (
        ("Connection refused", "nothing listens there"),
        ("WRONG_VERSION_NUMBER", "it does not speak TLS"),
        ("CERTIFICATE_VERIFY_FAILED", "its certificate is not signed by the given root certificate"),
        ("DNS resolution failed", "the host name is unknown"),
        ("Socket closed", "the connection was closed"),
    ):
        if sign in text:
            return cause
    return text.rpartition("last error: ")[2] or "no connection"


def _certificate(path: Path) -> bytes:
    try:
        pem = path.read_bytes()
        ssl.create_default_context(cadata=pem.decode("ascii"))
    except (OSError, UnicodeDecodeError, ssl.SSLError) as error:
        raise InvalidArgumentError(f"{path} is no root certificate in PEM: {error}") from error
    return pem
