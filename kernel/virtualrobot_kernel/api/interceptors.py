"""What every call passes: the token, and the mapping of errors to statuses."""

from __future__ import annotations

import asyncio
import hmac
import logging
from collections.abc import AsyncIterator, Awaitable, Callable
from typing import Any, NoReturn

import grpc

from virtualrobot_kernel.api.status import trailers
from virtualrobot_kernel.errors import KernelError, Reason

OPEN = "/grpc.health.v1.Health/"
"""Calls of this service need no token."""

CLOSE_SECONDS = 1.0
"""How long an ending kernel waits for clients to be told."""

log = logging.getLogger(__name__)
Continuation = Callable[[grpc.HandlerCallDetails], Awaitable[grpc.RpcMethodHandler | None]]


class Token(grpc.aio.ServerInterceptor):
    """Lets calls pass that carry `authorization: Bearer <token>`."""

    def __init__(self, token: str) -> None:
        """Demand this token."""
        self._wanted = f"Bearer {token}".encode()

    async def intercept_service(
        self, continuation: Continuation, handler_call_details: grpc.HandlerCallDetails
    ) -> grpc.RpcMethodHandler | None:
        """Return the call's own handler, or one that refuses."""
        handler = await continuation(handler_call_details)
        details: Any = handler_call_details
        if handler is None or details.method.startswith(OPEN):
            return handler
        given = dict(details.invocation_metadata or ()).get("authorization")
        if given is not None and hmac.compare_digest(_bytes(given), self._wanted):
            return handler
        said = "a wrong one" if given is not None else "none"
        error = KernelError(
            f"this kernel wants its token as metadata 'authorization: Bearer <token>'; the call has {said}. "
            "The token is in the file that the kernel names when it starts",
            reason=Reason.UNAUTHENTICATED,
        )

        async def refuse(_: object, context: grpc.aio.ServicerContext) -> NoReturn:
            await _abort(context, error)

        return _like(handler, refuse, refuse)


class Errors(grpc.aio.ServerInterceptor):
    """Turns KernelErrors into statuses with ErrorInfo, faults into INTERNAL, and an ending kernel into UNAVAILABLE."""

    def __init__(self) -> None:
        """Begin with no call under way."""
        self._calls: set[asyncio.Task[Any]] = set()
        self._closing = False

    async def close(self) -> None:
        """End every call under way with UNAVAILABLE, and refuse new ones; call it in the server's loop."""
        self._closing = True
        calls = tuple(self._calls)
        for call in calls:
            call.cancel()
        if calls:
            await asyncio.wait(calls, timeout=CLOSE_SECONDS)

    async def intercept_service(
        self, continuation: Continuation, handler_call_details: grpc.HandlerCallDetails
    ) -> grpc.RpcMethodHandler | None:
        """Return the call's handler, guarded."""
        handler = await continuation(handler_call_details)
        if handler is None:
            return None
        whole: Any = handler.stream_unary if handler.request_streaming else handler.unary_unary
        parts: Any = handler.stream_stream if handler.request_streaming else handler.unary_stream
        method = handler_call_details.method  # pyright: ignore[reportAttributeAccessIssue] an untyped named tuple

        async def answer(request: Any, context: grpc.aio.ServicerContext) -> Any:  # noqa: ANN401 any message
            async with _Guard(self, method, context):
                return await whole(request, context)

        async def stream(request: Any, context: grpc.aio.ServicerContext) -> AsyncIterator[Any]:  # noqa: ANN401
            async with _Guard(self, method, context):
                async for message in parts(request, context):
                    yield message

        # Handlers of grpcio's own services (health, reflection) write to the context instead of yielding.
        return handler if not method.startswith("/virtualrobot.") else _like(handler, answer, stream)


class _Guard:
    """Around one call: maps what it raises, and lets `Errors.close` end it."""

    def __init__(self, errors: Errors, method: str, context: grpc.aio.ServicerContext) -> None:
        self._errors, self._method, self._context = errors, method, context
        self._task = asyncio.current_task()

    async def __aenter__(self) -> None:
        if self._errors._closing:
            await _abort(self._context, ENDING)
        if self._task is not None:
            self._errors._calls.add(self._task)

    async def __aexit__(self, kind: type[BaseException] | None, error: BaseException | None, _: object) -> None:
        if self._task is not None:
            self._errors._calls.discard(self._task)
        if isinstance(error, KernelError):
            await _abort(self._context, error)
        if isinstance(error, asyncio.CancelledError) and self._errors._closing:
            if self._task is not None:
                self._task.uncancel()
            await _abort(self._context, ENDING)
        if isinstance(error, Exception) and not isinstance(error, grpc.aio.AbortError):
            log.exception("%s failed inside the kernel", self._method, exc_info=error)
            fault = KernelError(f"the kernel failed: {type(error).__name__}: {error}", reason=Reason.INTERNAL)
            await _abort(self._context, fault)


ENDING = KernelError("the kernel is ending", reason=Reason.SHUTTING_DOWN)


async def _abort(context: grpc.aio.ServicerContext, error: KernelError) -> NoReturn:
    code, message, metadata = trailers(error)
    await context.abort(code, message, metadata)


def _bytes(value: str | bytes) -> bytes:
    return value if isinstance(value, bytes) else value.encode()


def _like(handler: Any, unary: Any, stream: Any) -> grpc.RpcMethodHandler:  # noqa: ANN401 grpcio has no types for these
    """Return a handler of the same shape as `handler` that calls other functions."""
    make: Any = {
        (False, False): grpc.unary_unary_rpc_method_handler,
        (False, True): grpc.unary_stream_rpc_method_handler,
        (True, False): grpc.stream_unary_rpc_method_handler,
        (True, True): grpc.stream_stream_rpc_method_handler,
    }[(handler.request_streaming, handler.response_streaming)]
    function = stream if handler.response_streaming else unary
    return make(
        function,
        request_deserializer=handler.request_deserializer,
        response_serializer=handler.response_serializer,
    )
