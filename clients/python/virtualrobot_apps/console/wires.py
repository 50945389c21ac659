"""Ways to write a call in HTTP: Connect, gRPC-Web, JSON in lines, and forms.

Connect: https://connectrpc.com/docs/protocol; gRPC-Web: https://github.com/grpc/grpc/blob/master/doc/PROTOCOL-WEB.md.
"""

from __future__ import annotations

import base64
import binascii
import struct
from abc import ABC, abstractmethod
from collections.abc import AsyncIterator
from urllib.parse import parse_qsl

from virtualrobot_apps.console.contract import Answer, Method
from virtualrobot_apps.console.refusal import Refusal, end_of

HEAD = struct.Struct(">BI")
"""Before each message of a stream: flags, and how many bytes follow."""

_COMPRESSED, _END_OF_CONNECT, _END_OF_GRPC_WEB = 1, 2, 0x80


class Limit:
    """Greatest size of a message to the kernel (bytes), by its name among the kernel's limits."""

    def __init__(self, most: int) -> None:
        """Allow so many bytes."""
        self.most = most

    def check(self, asked: int) -> None:
        """Refuse what is larger as TOO_LARGE."""
        if asked > self.most:
            message = f"a message may have {self.most} bytes (limit message_bytes), not {asked}"
            metadata = {"limit_name": "message_bytes", "limit": str(self.most), "asked": str(asked)}
            raise Refusal.of("TOO_LARGE", message, metadata)


class Wire(ABC):
    """One way to write a call.

    Attributes:
        content_type: that of the answer.
        is_json: whether messages are JSON.
        tells_by_status: a refusal before the first answer is an HTTP status with Connect's error as JSON.
    """

    tells_by_status = False

    def __init__(self, method: Method, content_type: str, limit: Limit) -> None:
        """Write calls of `method`, as JSON where the type says so."""
        self.content_type = content_type
        self._method, self._limit = method, limit
        self.is_json = content_type.endswith("json")

    @abstractmethod
    def requests(self, chunks: AsyncIterator[bytes]) -> AsyncIterator[bytes]:
        """Yield the encoded requests that the bytes of a body are."""

    @abstractmethod
    def answer(self, answer: Answer) -> bytes:
        """Return the bytes of an answer."""

    @abstractmethod
    def end(self, refusal: Refusal | None) -> bytes:
        """Return the bytes of the end."""

    async def _decoded(self, data: bytes) -> bytes:
        return await self._method.read_json(data) if self.is_json else data

    def _encoded(self, answer: Answer) -> bytes:
        return answer.json if self.is_json else answer.data


class Whole(Wire):
    """The body is one request, and so is the answer (Connect's unary calls), or a line of JSON for each answer."""

    tells_by_status = True

    def __init__(self, method: Method, content_type: str, limit: Limit) -> None:
        """Answer streams in lines."""
        super().__init__(method, content_type, limit)
        if method.streams_answers:
            self.content_type = "application/x-ndjson"

    async def requests(self, chunks: AsyncIterator[bytes]) -> AsyncIterator[bytes]:
        """Yield the body."""
        body = bytearray()
        async for chunk in chunks:
            self._limit.check(len(body) + len(chunk))
            body += chunk
        yield await self._decoded(bytes(body))

    def answer(self, answer: Answer) -> bytes:
        """Return the answer, of a stream as a line."""
        return self._encoded(answer) + b"\n" * self._method.streams_answers

    def end(self, refusal: Refusal | None) -> bytes:
        """Return nothing, or a line with the error in place of an answer."""
        return b"" if refusal is None else end_of(refusal) + b"\n"


class Form(Whole):
    """The body is a form whose field `json` is the request: what Octave can send.

    A refusal is the answer `{"error": ERROR}`: Octave and MATLAB tell programs nothing of what comes with a status.
    """

    tells_by_status = False

    def __init__(self, method: Method, content_type: str, limit: Limit) -> None:
        """Answer as JSON, whatever the type of the form."""
        super().__init__(method, "application/json", limit)

    async def _decoded(self, data: bytes) -> bytes:
        try:
            fields = parse_qsl(data.decode("ascii"), keep_blank_values=True, max_num_fields=2)
        except ValueError:
            fields = []
        if [name for name, _ in fields] != ["json"]:
            raise Refusal.of(
                "INVALID_ARGUMENT", "a form has one field, json, whose text is the request", {"field": "json"}
            )
        return await super()._decoded(fields[0][1].encode())


class Enveloped(Wire):
    """Connect's streams: before each message stands how long it is."""

    async def requests(self, chunks: AsyncIterator[bytes]) -> AsyncIterator[bytes]:
        """Yield the messages."""
        rest = bytearray()
        async for chunk in chunks:
            rest += chunk
            while len(rest) >= HEAD.size:
                flags, size = HEAD.unpack_from(rest)
                if flags & _COMPRESSED:
                    raise Refusal("unimplemented", "messages are not compressed here")
                self._limit.check(size)
                if len(rest) < HEAD.size + size:
                    break
                message = bytes(rest[HEAD.size : HEAD.size + size])
                del rest[: HEAD.size + size]
                if not flags:
                    yield await self._decoded(message)
        if rest:
            raise Refusal.of("INVALID_ARGUMENT", "the body ends within a message")

    def answer(self, answer: Answer) -> bytes:
        """Return the answer in its envelope."""
        return self._enveloped(0, self._encoded(answer))

    def end(self, refusal: Refusal | None) -> bytes:
        """Return the last envelope, with the error."""
        return self._enveloped(_END_OF_CONNECT, end_of(refusal))

    def _enveloped(self, flags: int, data: bytes) -> bytes:
        return HEAD.pack(flags, len(data)) + data


class GrpcWeb(Enveloped):
    """gRPC-Web, in bytes or, for old browsers, in base64."""

    def __init__(self, method: Method, content_type: str, limit: Limit) -> None:
        """Write base64 where the type is grpc-web-text."""
        super().__init__(method, content_type, limit)
        self._is_text = content_type.startswith("application/grpc-web-text")

    async def requests(self, chunks: AsyncIterator[bytes]) -> AsyncIterator[bytes]:
        """Yield the messages."""
        async for message in super().requests(_from_base64(chunks) if self._is_text else chunks):
            yield message

    def end(self, refusal: Refusal | None) -> bytes:
        """Return the trailers."""
        trailers = b"grpc-status: 0\r\n" if refusal is None else refusal.trailers()
        return self._enveloped(_END_OF_GRPC_WEB, trailers)

    def _enveloped(self, flags: int, data: bytes) -> bytes:
        envelope = super()._enveloped(flags, data)
        return base64.b64encode(envelope) if self._is_text else envelope


async def _from_base64(chunks: AsyncIterator[bytes]) -> AsyncIterator[bytes]:
    rest = b""
    async for chunk in chunks:
        rest += chunk
        whole = len(rest) - len(rest) % 4
        try:
            yield base64.b64decode(rest[:whole], validate=True)
        except binascii.Error:
            raise Refusal.of("INVALID_ARGUMENT", "the body of grpc-web-text is no base64") from None
        rest = rest[whole:]


_KINDS: dict[str, type[Wire]] = {
    "application/json": Whole,
    "application/proto": Whole,
    "application/x-www-form-urlencoded": Form,
    "application/connect+json": Enveloped,
    "application/connect+proto": Enveloped,
    "application/grpc-web": GrpcWeb,
    "application/grpc-web+json": GrpcWeb,
    "application/grpc-web+proto": GrpcWeb,
    "application/grpc-web-text": GrpcWeb,
    "application/grpc-web-text+proto": GrpcWeb,
}
CONTENT_TYPES = tuple(_KINDS)


def wire_of(method: Method, content_type: str, limit: Limit) -> Wire | None:
    """Return how a body of a content type is read and answered; None for types that nobody knows."""
    name = content_type.partition(";")[0].strip().lower()
    kind = _KINDS.get(name)
    if kind is None or (kind is Whole and name.endswith("proto") and method.streams_answers):
        return None  # lines hold JSON alone
    return kind(method, name, limit)
