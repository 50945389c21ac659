"""One channel to a kernel: adds token, leases and a time limit to each call and turns statuses into exceptions."""

from __future__ import annotations

import math
import re
import ssl
import threading
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, Generic, TypeVar

import grpc
from google.rpc import error_details_pb2
from grpc_status import rpc_status

from virtualrobot._wire import interruptions
from virtualrobot._wire.descriptions import Descriptions
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
    WrongStateError,
)
from virtualrobot.progress import OnProgress, Progress
from virtualrobot.session import is_loopback

Message = TypeVar("Message")
Listener = Callable[[str, Any], None]
"""Function that is told the method and each answer of a channel's calls."""

MAX_MESSAGE_BYTES = 256 * 1024 * 1024
LEASE_KEY = "virtualrobot-lease"
NAME_KEY = "client-name"
WAITED = {
    "/virtualrobot.v1.MotionService/StartMotion": "planning",
    "/virtualrobot.v1.MotionService/AppendMotion": "planning",
    "/virtualrobot.v1.MotionService/PlanMotion": "planning",
    "/virtualrobot.v1.MotionService/CheckMotion": "checking the motion",
    "/virtualrobot.v1.RobotService/SolveInverse": "solving",
    "/virtualrobot.v1.SceneService/ImportModel": "loading the model",
    "/virtualrobot.v1.SceneService/LoadScene": "loading the scene",
    "/virtualrobot.v1.SceneService/ExportModel": "exporting",
    "/virtualrobot.v1.AssetService/UploadAsset": "sending files",
}
"""Calls with one answer that may take long, and what they do, in words."""

TOLD_AFTER_SECONDS, TOLD_EVERY_SECONDS = 0.5, 0.25
"""Time after which a call is told of, and from then on from one time to the next."""

_CLOSE_SECONDS = 1.0
_TOKEN_KEY = "authorization"
_RECONNECT_MILLISECONDS = 200
_OVER_MESSAGE_LIMIT = re.compile(r"SERVER: Received message larger than max \((\d+) vs")
_NO_ERROR_INFO: dict[grpc.StatusCode, type[VirtualRobotError]] = {
    grpc.StatusCode.INVALID_ARGUMENT: InvalidArgumentError,
    grpc.StatusCode.UNAUTHENTICATED: AuthenticationError,
    grpc.StatusCode.RESOURCE_EXHAUSTED: TooLargeError,
    grpc.StatusCode.INTERNAL: KernelFaultError,
}


class Stream(Generic[Message]):
    """Messages of a watch or download as they come; ends when the kernel ends it or `cancel` is called."""

    def __init__(self, call: Any, address: str, saw: Callable[[Message], None]) -> None:  # noqa: ANN401 grpcio has no type for a running call
        """Read from a running call to the kernel at `address`; `saw` is told each message."""
        self._call = call
        self._address = address
        self._saw = saw
        self._cancelled = False

    def __iter__(self) -> Iterator[Message]:
        """Return itself."""
        return self

    def __next__(self) -> Message:
        """Wait for the next message."""
        try:
            with interruptions.waited_for(self._call):
                message = next(self._call)
        except grpc.RpcError as error:
            if self._cancelled:
                raise StopIteration from None
            raise translated(error, self._address) from None
        self._saw(message)
        return message

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

    def __repr__(self) -> str:
        """Return a line for people."""
        return f"<Stream from {self._address}>"


class Waiting:
    """One call as its listener is told of it, once it has taken long."""

    def __init__(self, what: str, on_progress: OnProgress | None) -> None:
        """Begin now; without a listener nothing is told."""
        self._what, self._on_progress, self._began = what, on_progress, time.monotonic()
        self._told = False

    @property
    def seconds(self) -> float:
        """Time (s) until it is to be told of next."""
        return TOLD_EVERY_SECONDS if self._told else TOLD_AFTER_SECONDS

    def tell(self, detail: str = "") -> None:
        """Tell how far the call is, if it has taken long."""
        elapsed = time.monotonic() - self._began
        if self._on_progress is not None and elapsed >= TOLD_AFTER_SECONDS:
            self._told = True
            self._on_progress(Progress(self._what, elapsed, detail))

    def end(self) -> None:
        """Tell that the call has ended, if it was told of."""
        if self._on_progress is not None and self._told:
            self._on_progress(Progress(self._what, time.monotonic() - self._began, ended=True))


class Channel:
    """A gRPC channel whose calls carry token and leases, have a time limit and raise exceptions of this library.

    It wraps the calls itself: grpcio's own interceptors make each call anew, which costs time, and a call on a channel
    that was closed crashes the process (grpcio 1.85).
    """

    def __init__(
        self, channel: grpc.Channel, address: str, token: str | None, timeout_seconds: float, name: str = ""
    ) -> None:
        """Wrap a channel to `address`; `name` is what the client calls itself."""
        self._channel = channel
        self._address = address
        # Never changed but replaced, since other threads call meanwhile.
        self._metadata: tuple[tuple[str, str], ...] = ((_TOKEN_KEY, f"Bearer {token}"),) if token else ()
        if name:
            self._metadata = (*self._metadata, (NAME_KEY, name.encode("ascii", "backslashreplace").decode()))
        self._timeout_seconds = timeout_seconds
        self.descriptions = Descriptions()
        self.listener: Listener | None = None
        self.on_progress: OnProgress | None = None
        self.find_token: Callable[[], str] | None = None
        """Reads the token again from where it came; a kernel that was started anew may have another one."""
        self.kept_out: int | None = None
        """Thread that must not wait for a kernel: that of an event loop."""
        self._closed = self._answered = False
        self._carrying = threading.Lock()

    def carry(self, lease: str) -> None:
        """Send the token of a lease with each call from now on."""
        with self._carrying:
            self._metadata = (*self._metadata, (LEASE_KEY, lease))

    def drop(self, lease: str) -> None:
        """Send the token of a lease no more."""
        with self._carrying:
            self._metadata = tuple(entry for entry in self._metadata if entry != (LEASE_KEY, lease))

    def unary_unary(self, method: str, **options: Any) -> Callable[..., Any]:  # noqa: ANN401 as the generated stubs call it
        """Return the function that makes a call with one answer."""
        return self._whole(method, self._channel.unary_unary(method, **options))

    def stream_unary(self, method: str, **options: Any) -> Callable[..., Any]:  # noqa: ANN401
        """Return the function that makes a call with many requests and one answer."""
        return self._whole(method, self._channel.stream_unary(method, **options))

    def unary_stream(self, method: str, **options: Any) -> Callable[..., Stream[Any]]:  # noqa: ANN401
        """Return the function that makes a call with many answers; it has no time limit unless one is given."""
        return self._streaming(method, self._channel.unary_stream(method, **options))

    def stream_stream(self, method: str, **options: Any) -> Callable[..., Stream[Any]]:  # noqa: ANN401
        """Return the function that makes a call with many requests and many answers, without a time limit."""
        return self._streaming(method, self._channel.stream_stream(method, **options))

    def _saw(self, method: str, message: Any, asked_at: float = -math.inf) -> None:  # noqa: ANN401 any answer
        if (stamp := getattr(message, "stamp", None)) is not None:
            self.descriptions.saw(stamp, asked_at)
        if self.listener is not None:
            self.listener(method, message)

    def _streaming(self, method: str, call: Callable[..., Any]) -> Callable[..., Stream[Any]]:
        saw = partial(self._saw, method)

        def start(request: object, timeout: float | None = None) -> Stream[Any]:
            self._check_open()
            return Stream(call(request, timeout=timeout, metadata=self._metadata), self._address, saw)

        return start

    def _whole(self, method: str, call: Callable[..., Any]) -> Callable[..., Any]:
        ask = partial(self._waited, WAITED[method]) if method in WAITED else interruptions.answer

        def make(request: object, timeout: float | None = None) -> Any:  # noqa: ANN401 the answer
            limit = self._timeout_seconds if timeout is None else timeout
            self._check_open()
            asked_at = time.monotonic()
            try:
                try:
                    answer = ask(call, request, timeout=limit, metadata=self._metadata)
                except grpc.RpcError as error:
                    if self._answered and _nothing_listened(error):
                        # So it was when grpc tried last, perhaps long ago. It has begun to try again; nothing was sent.
                        time.sleep(1.5e-3 * _RECONNECT_MILLISECONDS)
                    elif isinstance(request, Iterator) or not self._has_another_token(error):
                        raise
                    answer = ask(call, request, timeout=limit, metadata=self._metadata)
            except grpc.RpcError as error:
                # The cause would tell the same once more, in 20 lines of grpc's.
                raise translated(error, self._address) from None
            self._answered = True
            self._saw(method, answer, asked_at)
            return answer

        return make

    def _has_another_token(self, error: grpc.RpcError) -> bool:
        """Return whether a kernel that has refused a call may take the token that is found now."""
        call: Any = error
        if self.find_token is None or call.code() is not grpc.StatusCode.UNAUTHENTICATED:
            return False
        try:
            token = self.find_token()
        except ValueError:
            return False
        entry = (_TOKEN_KEY, f"Bearer {token}")
        with self._carrying:
            if not token or entry in self._metadata:
                return False
            self._metadata = (entry, *(other for other in self._metadata if other[0] != _TOKEN_KEY))
        return True

    def _waited(self, what: str, call: Any, request: object, **options: Any) -> Any:  # noqa: ANN401
        """Return the answer of a call, and tell while it takes long; Ctrl-C and what the listener raises cancel it."""
        running = call.future(request, **options)
        waiting = Waiting(what, self.on_progress)
        try:
            with interruptions.waited_for(running):
                while True:
                    try:
                        return running.result(timeout=waiting.seconds)
                    except grpc.FutureTimeoutError:
                        waiting.tell()
        except BaseException:
            running.cancel()
            raise
        finally:
            waiting.end()

    def close(self) -> None:
        """Close the channel; calls under way end."""
        self._closed = True
        without_hanging(self._channel.close)

    def _check_open(self) -> None:
        if self._closed:
            raise ClientClosedError("this client is closed: connect again")
        if self.kept_out == threading.get_ident():
            raise WrongStateError(
                "this asks the kernel, for which the event loop would wait: await it by virtualrobot.aio"
            )

    def __repr__(self) -> str:
        """Return a line for people."""
        return f"<Channel to {self._address}{', closed' * self._closed}>"


def without_hanging(end: Callable[[], object]) -> None:
    """End something of a channel, and wait for it only for a moment.

    Where Ctrl-C struck within a call, a lock of grpc's may be held for ever by the thread that was in it, and whatever
    else needs it waits without end: so it is left to the end of the process.
    """
    ending = threading.Thread(target=end, daemon=True)
    ending.start()
    ending.join(_CLOSE_SECONDS)


def open_channel(
    address: str, host: str, token: str | None, root_certificate: Path | None, timeout_seconds: float, name: str = ""
) -> Channel:
    """Return a channel to `address`, in the clear on this machine and by TLS beyond it or with `root_certificate`.

    Raises:
        InvalidArgumentError: when the certificate cannot be read or is none.
    """
    options, credentials = way_to(host, root_certificate)
    if credentials is None:
        channel = grpc.insecure_channel(address, options)
    else:
        channel = grpc.secure_channel(address, credentials, options)
    return Channel(channel, address, token, timeout_seconds, name)


def way_to(host: str, root_certificate: Path | None) -> tuple[list[tuple[str, int]], grpc.ChannelCredentials | None]:
    """Return the options of a channel to a kernel at `host`, and its credentials; None: in the clear.

    Raises:
        InvalidArgumentError: when the certificate cannot be read or is none.
    """
    options = [
        ("grpc.max_receive_message_length", MAX_MESSAGE_BYTES),
        ("grpc.max_send_message_length", MAX_MESSAGE_BYTES),
        # After a lost connection the next call shall try at once and not after minutes: meanwhile all are refused.
        ("grpc.initial_reconnect_backoff_ms", _RECONNECT_MILLISECONDS),
        ("grpc.max_reconnect_backoff_ms", _RECONNECT_MILLISECONDS),
        # What a watch's reader leaves unread waits in a window; a small one lets the kernel skip states early. By
        # default it grows to megabytes: seconds of stale states. Measured: files travel as fast as before.
        ("grpc.http2.bdp_probe", 0),
        ("grpc.http2.lookahead_bytes", 4096),
    ]
    local = is_loopback(host)
    if local:
        # A proxy set for the web must not stand between programs on one machine.
        options.append(("grpc.enable_http_proxy", 0))
    if local and root_certificate is None:
        return options, None
    pem = None if root_certificate is None else _certificate(root_certificate)
    return options, grpc.ssl_channel_credentials(pem)


def translated(error: grpc.RpcError, address: str) -> VirtualRobotError:
    """Return the exception that a failed call to the kernel at `address` raises."""
    call: Any = error
    code, text = call.code(), call.details() or ""
    status = rpc_status.from_call(call)
    for detail in status.details if status is not None else ():
        info = error_details_pb2.ErrorInfo()
        if detail.Unpack(info) and info.domain == "virtualrobot":
            kind = BY_REASON.get(info.reason, VirtualRobotError)
            return kind(text, info.reason, dict(info.metadata), code.name)
    if code is grpc.StatusCode.UNAVAILABLE:
        said = f"no kernel answers at {address}: {_cause(text)}"
        if _nothing_listened(error):
            return KernelGoneError(f"{said}; start one with 'virtualrobot serve'", "NOT_RUNNING", code=code.name)
        return KernelGoneError(said, "NO_CONNECTION", code=code.name)
    if code is grpc.StatusCode.DEADLINE_EXCEEDED:
        return CallTimeoutError(f"the kernel at {address} did not answer in time", code=code.name)
    if code is grpc.StatusCode.UNIMPLEMENTED:
        return VersionError(f"what listens at {address} does not know this call: {text}", code=code.name)
    if code is grpc.StatusCode.CANCELLED:
        return ClientClosedError("the call was cancelled by this client", code=code.name)
    if large := _OVER_MESSAGE_LIMIT.match(text):
        return _too_large(int(large[1]), code.name)
    return _NO_ERROR_INFO.get(code, VirtualRobotError)(text or code.name, code=code.name)


def _too_large(asked: int, code: str) -> TooLargeError:
    """Return the error of a message that gRPC has not let through to the kernel, which would name the limit."""
    text = f"a message of {asked} bytes is over the limit 'message_bytes' of this kernel: client.info.limits tells it"
    return TooLargeError(text, "TOO_LARGE", {"limit_name": "message_bytes", "asked": str(asked)}, code)


def _nothing_listened(error: grpc.RpcError) -> bool:
    call: Any = error
    return call.code() is grpc.StatusCode.UNAVAILABLE and "Connection refused" in (call.details() or "")


def _cause(text: str) -> str:
    """Return the telling end of gRPC's words for a connection that failed."""
    for sign, cause in (
        ("Connection refused", "nothing listens there"),
        ("WRONG_VERSION_NUMBER", "it does not speak TLS"),
        (
            "CERTIFICATE_VERIFY_FAILED",
            "its certificate is signed by nobody that this program trusts: give the root certificate of who has signed "
            "it (`root_certificate`, `--certificate`)",
        ),
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
