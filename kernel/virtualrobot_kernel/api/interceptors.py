"""Interceptors of every call: decoding, the mapping of errors to statuses, leases. Tokens have theirs in `roles.py`."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterable, AsyncIterator, Callable, Iterable
from contextlib import aclosing, asynccontextmanager, nullcontext
from functools import partial
from inspect import isawaitable
from typing import Any, NoReturn

import grpc
from google.protobuf.descriptor import ServiceDescriptor
from google.protobuf.message import DecodeError, Message
from virtualrobot.v1 import lease_pb2, motion_pb2, robot_pb2

from virtualrobot_kernel.api.client_load import ClientLoad
from virtualrobot_kernel.api.convert.expansion import named_robots
from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.api.lease_table import CARRIED
from virtualrobot_kernel.api.limits import Limits
from virtualrobot_kernel.api.publications import Publications, ending
from virtualrobot_kernel.api.roles import Continuation, abort, check_commands
from virtualrobot_kernel.api.token_table import CALLER, Account, withdrawn
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.world.affected_robots import named_nodes

LEASE_KEY = "virtualrobot-lease"
"""Metadata key of a lease's token; a call may have several."""

DEEPEST_MESSAGE = 100
"""Greatest depth of nested messages that protobuf decodes."""


NAMED: dict[type, Callable[[Any], Iterable[str]]] = {
    motion_pb2.StartMotionRequest: lambda request: (
        named_robots(request.spec.steps, request.spec.programs) | {move.robot for move in request.spec.moves}
    ),
    motion_pb2.AppendMotionRequest: lambda request: named_robots(request.steps, request.programs),
    robot_pb2.SetKinematicsRequest: lambda request: (request.choice.robot,),
}
"""Robots of requests whose commands come late, after planning or trying: refused before that work is done.

What is refused in the end is decided by the commands themselves, right before they are applied
(`world/affected_robots.py`).
"""

WORK = {
    "/virtualrobot.v1.MotionService/StartMotion": "planning",
    "/virtualrobot.v1.MotionService/AppendMotion": "planning",
    "/virtualrobot.v1.MotionService/PlanMotion": "planning",
    "/virtualrobot.v1.MotionService/CheckMotion": "checking a motion",
    "/virtualrobot.v1.ProposalService/CreateProposal": "planning",
    "/virtualrobot.v1.ProposalService/UpdateProposal": "planning",
    "/virtualrobot.v1.ProposalService/UndoProposal": "planning",
    "/virtualrobot.v1.PathService/FindPath": "looking for a path",
    "/virtualrobot.v1.PathService/FindToolPath": "looking for a way along a tool path",
    "/virtualrobot.v1.SceneService/ImportModel": "loading a model",
    "/virtualrobot.v1.SceneService/LoadScene": "loading a scene",
}
"""Calls that may take long, and what they do, as the page tells who looks at it."""

log = logging.getLogger(__name__)


class Errors(grpc.aio.ServerInterceptor):
    """Interceptor that decodes requests, turns KernelErrors into statuses with ErrorInfo and faults into INTERNAL.

    Calls to an ending kernel are refused, except those of grpcio's own services (health, reflection).
    """

    def __init__(self, publications: Publications, kernel: KernelServices) -> None:
        """Refuse calls once `publications` are closed, and more than the kernel's limits allow.

        The page is told of calls that may take long. When a token is withdrawn its calls end.
        """
        self._publications, self._under_way, self._tokens = publications, kernel.view.under_way, kernel.tokens
        self._limits, self._load = kernel.limits, ClientLoad(kernel.limits)
        self._guarded: dict[str, grpc.RpcMethodHandler] = {}
        self._running: dict[asyncio.Task[object], Account] = {}
        kernel.tokens.subscribe(self._end_calls)

    def end(self) -> None:
        """End calls that still wait for something once `publications` are closed: as SHUTTING_DOWN."""
        for task in self._running:
            task.cancel()

    def _end_calls(self, account: Account) -> None:
        for task, caller in self._running.items():
            if caller is account and task is not asyncio.current_task():
                task.cancel()

    async def intercept_service(
        self, continuation: Continuation, handler_call_details: grpc.HandlerCallDetails
    ) -> grpc.RpcMethodHandler | None:
        """Return the call's handler, guarded; made once for each method."""
        method: str = handler_call_details.method  # pyright: ignore[reportAttributeAccessIssue] an untyped named tuple
        guarded = self._guarded.get(method)
        if guarded is None:
            handler = await continuation(handler_call_details)
            if handler is None:
                return None
            guarded = self._guarded[method] = self._guard(handler, method)
        return guarded

    def _guard(self, handler: Any, method: str) -> grpc.RpcMethodHandler:  # noqa: ANN401 grpcio has no types for it
        whole = handler.stream_unary if handler.request_streaming else handler.unary_unary
        parts = handler.stream_stream if handler.request_streaming else handler.unary_stream
        decode = partial(_Decoding if handler.request_streaming else _decoded, limits=self._limits)
        is_stream = handler.request_streaming or handler.response_streaming

        async def answer(request: Any, context: grpc.aio.ServicerContext) -> Any:  # noqa: ANN401 bytes, or many
            async with self._told(method, context, is_stream):
                return await whole(decode(request, handler.request_deserializer), context)

        async def stream(request: Any, context: grpc.aio.ServicerContext) -> None:  # noqa: ANN401 bytes, or many
            async with self._told(method, context, is_stream):
                answers = parts(decode(request, handler.request_deserializer), context)
                if isawaitable(answers):  # as of grpcio's health service, which writes to the context by itself
                    return await answers
                async with aclosing(answers) as messages:
                    async for message in messages:
                        try:
                            await context.write(message)
                        except grpc.aio.InternalError:  # who reads has gone in the middle of a message
                            return log.debug("%s: its reader has gone", method)

        # Decoded here and not by grpcio, which would answer UNKNOWN and log a traceback of what cannot be decoded.
        return _like(handler, answer, stream, decoded=True)

    @asynccontextmanager
    async def _told(self, method: str, context: grpc.aio.ServicerContext, is_stream: bool) -> AsyncIterator[None]:
        """Abort the call with the status that tells what is raised in this context, or what ends it."""
        task, caller = asyncio.current_task(), CALLER.get()
        assert task is not None
        self._running[task] = caller
        try:
            if self._publications.closed and method.startswith("/virtualrobot."):
                raise ending()
            if not self._tokens.holds(caller):
                raise withdrawn(caller)
            with (
                self._load.of(caller.name or context.peer(), method, is_stream),
                self._under_way.doing(WORK[method]) if method in WORK else nullcontext(),
            ):
                yield
        except asyncio.CancelledError:
            if not self._publications.closed and self._tokens.holds(caller):
                raise  # the caller has gone
            await abort(context, ending() if self._publications.closed else withdrawn(caller))
        except Exception as error:
            await _told(error, method, context)
        finally:
            del self._running[task]


class Leasing(grpc.aio.ServerInterceptor):
    """Interceptor of the option `needs_lease`: such calls touch robots that are free, or leased by what they carry.

    Calls of other methods pass as they are, and count as carrying no lease.
    """

    def __init__(self, services: Iterable[ServiceDescriptor], kernel: KernelServices) -> None:
        """Guard the methods of these services that have the option."""
        self._kernel = kernel
        self._methods = {
            f"/{service.full_name}/{method.name}"
            for service in services
            for method in service.methods
            if method.GetOptions().Extensions[lease_pb2.needs_lease]  # pyright: ignore[reportArgumentType] its stub
        }

    async def intercept_service(
        self, continuation: Continuation, handler_call_details: grpc.HandlerCallDetails
    ) -> grpc.RpcMethodHandler | None:
        """Return the call's own handler, or one that looks at the leases first."""
        handler: Any = await continuation(handler_call_details)
        method: str = handler_call_details.method  # pyright: ignore[reportAttributeAccessIssue] an untyped named tuple
        if handler is None or method not in self._methods:
            return handler
        whole = handler.stream_unary if handler.request_streaming else handler.unary_unary
        parts = handler.stream_stream if handler.request_streaming else handler.unary_stream

        async def answer(request: Any, context: grpc.aio.ServicerContext) -> Any:  # noqa: ANN401 any message
            self._carry(request, context)
            return await whole(request, context)

        async def stream(request: Any, context: grpc.aio.ServicerContext) -> Any:  # noqa: ANN401 any message
            self._carry(request, context)
            async with aclosing(parts(request, context)) as messages:
                async for message in messages:
                    yield message

        return _like(handler, answer, stream)

    def _carry(self, request: Any, context: grpc.aio.ServicerContext) -> None:  # noqa: ANN401 any message
        """Note the leases of a call for its commands; raise KernelError when they, or its role, do not do."""
        tokens = tuple(str(value) for key, value in context.invocation_metadata() or () if key == LEASE_KEY)
        caller = CALLER.get()
        check_commands(request, caller)
        named = NAMED[type(request)](request) if type(request) in NAMED else ()
        snapshot = self._kernel.world.snapshot
        robots = named_nodes(snapshot.structure, named)
        self._kernel.leases.check(snapshot, robots, tokens, caller.moves_leased_only)
        CARRIED.set(tokens)


async def _told(error: Exception, method: str, context: grpc.aio.ServicerContext) -> NoReturn:
    """Abort the call with the status that tells `error`."""
    if isinstance(error, grpc.aio.AbortError):
        raise error
    if not isinstance(error, KernelError):
        log.exception("%s failed inside the kernel", method, exc_info=error)
        error = KernelError(f"the kernel failed: {type(error).__name__}: {error}", reason=Reason.INTERNAL)
    await abort(context, error)


def _decoded(data: bytes, decode: Callable[[bytes], Message], limits: Limits) -> Message:
    """Return the message; raise KernelError when the bytes are none, or too many."""
    if len(data) > limits.message_bytes:
        raise limits.refusal("message_bytes", len(data), "a message may have {limit} bytes, not {asked}")
    try:
        return decode(data)
    except DecodeError as error:
        raise KernelError(
            f"the {len(data)} bytes of the request are not decodable: {error}; messages may be nested "
            f"{DEEPEST_MESSAGE} deep, and texts must be UTF-8",
            bytes=len(data),
        ) from error


class _Decoding:
    """Decoded messages of a client's stream; no generator, which would need to be closed."""

    def __init__(self, data: AsyncIterable[bytes], decode: Callable[[bytes], Message], limits: Limits) -> None:
        self._data, self._decode, self._limits = aiter(data), decode, limits

    def __aiter__(self) -> _Decoding:
        return self

    async def __anext__(self) -> Message:
        return _decoded(await anext(self._data), self._decode, self._limits)


def _like(handler: Any, unary: Any, stream: Any, decoded: bool = False) -> grpc.RpcMethodHandler:  # noqa: ANN401 grpcio has no types for these
    """Return a handler of the same shape as `handler` that calls other functions; `decoded`: they take bytes."""
    make: Any = {
        (False, False): grpc.unary_unary_rpc_method_handler,
        (False, True): grpc.unary_stream_rpc_method_handler,
        (True, False): grpc.stream_unary_rpc_method_handler,
        (True, True): grpc.stream_stream_rpc_method_handler,
    }[(handler.request_streaming, handler.response_streaming)]
    function = stream if handler.response_streaming else unary
    return make(
        function,
        request_deserializer=None if decoded else handler.request_deserializer,
        response_serializer=handler.response_serializer,
    )
