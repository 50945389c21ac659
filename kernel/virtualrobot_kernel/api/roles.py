"""Roles: who may make which call, and give which command. What each needs says the contract, by two options.

`needs_role` of a method is looked at before a message is waited for; `command_needs_role` of a command, or of a step of
a program, once the request is decoded.
"""

from __future__ import annotations

import logging
from collections.abc import Awaitable, Callable, Iterable, Iterator
from functools import cache
from typing import Any, NoReturn

import grpc
from google.protobuf.descriptor import Descriptor, ServiceDescriptor
from google.protobuf.message import Message
from virtualrobot.v1 import scene_pb2, token_pb2

from virtualrobot_kernel.api.status import trailers
from virtualrobot_kernel.api.token_table import CALLER, Account, Role, TokenTable, role_too_low
from virtualrobot_kernel.errors import KernelError, Reason
from virtualrobot_kernel.messages.fields import is_map

OPEN = "/grpc.health.v1.Health/Check"
"""Method that needs no token; a watch would, since it stays."""

MOST_LOGGED = 10_000
"""Greatest number of refusals that are remembered as logged."""

log = logging.getLogger(__name__)
Continuation = Callable[[grpc.HandlerCallDetails], Awaitable[grpc.RpcMethodHandler | None]]
_logged: set[tuple[str, str]] = set()


class Tokens(grpc.aio.ServerInterceptor):
    """Interceptor that lets calls pass which carry `authorization: Bearer <token>` of a role that may make them."""

    def __init__(self, services: Iterable[ServiceDescriptor], tokens: TokenTable) -> None:
        """Demand one of these tokens, and the role that the services' methods need."""
        self._tokens = tokens
        self._needs = roles_of(services)

    async def intercept_service(
        self, continuation: Continuation, handler_call_details: grpc.HandlerCallDetails
    ) -> grpc.RpcMethodHandler | None:
        """Return the call's own handler, or one that refuses; note whose call it is."""
        handler = await continuation(handler_call_details)
        details: Any = handler_call_details
        if handler is None or details.method == OPEN:
            return handler
        given = _bytes(dict(details.invocation_metadata or ()).get("authorization", b""))
        account = self._tokens.find(given.removeprefix(b"Bearer ")) if given.startswith(b"Bearer ") else None
        if account is None:
            said = "a wrong one" if given else "none"
            return _refusing(
                KernelError(
                    f"this kernel wants its token as metadata 'authorization: Bearer <token>'; the call has {said}. "
                    "The token is in the file that the kernel names when it starts",
                    reason=Reason.UNAUTHENTICATED,
                )
            )
        needs = self._needs.get(details.method, Role.OBSERVER)
        if account.role < needs:
            return _refusing(refused(details.method.rpartition("/")[2], needs, account))
        # The whole call is one task, this among it.
        CALLER.set(account)
        return handler


def _needed(field: Any) -> Role | None:  # noqa: ANN401 protobuf has two classes for it
    """Return the role that a command or step needs by its field; None where it needs no more than its call."""
    number = field.GetOptions().Extensions[token_pb2.command_needs_role]
    return Role(number) if number else None


_by_name = ((field.name, _needed(field)) for field in scene_pb2.Command.DESCRIPTOR.fields)
_COMMANDS = {name: needs for name, needs in _by_name if needs}


def roles_of(services: Iterable[ServiceDescriptor]) -> dict[str, Role]:
    """Return the least role of each method, by its path; a method that does not say one is for admins."""
    said = {
        f"/{service.full_name}/{method.name}": method.GetOptions().Extensions[token_pb2.needs_role]  # pyright: ignore[reportArgumentType] its stub
        for service in services
        for method in service.methods
    }
    return {path: Role(number) if number else Role.ADMIN for path, number in said.items()}


def check_commands(request: object, account: Account) -> None:
    """Raise KernelError when a command, or a step, of a request needs another role than the caller's.

    A stream of requests has none: what a client streams are setpoints and files.
    """
    if account.role is Role.ADMIN or not isinstance(request, Message):
        return
    for name, needs in commands_in(request):
        if account.role < needs:
            raise refused(f"the command {name!r}", needs, account, command=name)


def commands_in(message: Message) -> Iterator[tuple[str, Role]]:
    """Yield the names of commands and steps in a message that say which role they need, and that role."""
    if isinstance(message, scene_pb2.ApplyRequest):  # it may have 20,000, of which each kind is looked at once
        given = {command.WhichOneof("command") for command in message.commands}
        yield from ((name, needs) for name, needs in _COMMANDS.items() if name in given)
        return
    for field, value in message.ListFields():
        if needs := _needed(field):
            yield field.name, needs
        if field.message_type is not None and may_command(field.message_type):
            for one in (value,) if isinstance(value, Message) else value.values() if is_map(field) else value:
                yield from commands_in(one)


@cache
def may_command(kind: Descriptor) -> bool:
    """Return whether messages of a kind may have commands in them, however deep; so no array is gone through."""
    seen: set[str] = set()
    open_kinds = [kind]
    while open_kinds:
        for field in open_kinds.pop().fields:
            if _needed(field):
                return True
            if field.message_type is not None and field.message_type.full_name not in seen:
                seen.add(field.message_type.full_name)
                open_kinds.append(field.message_type)
    return False


def refused(what: str, needs: Role, account: Account, **metadata: str) -> KernelError:
    """Return the error of a call that its role may not make; log the first of its kind of each token."""
    error = role_too_low(what, needs, account, **metadata)
    if (account.name, what) not in _logged and len(_logged) < MOST_LOGGED:
        _logged.add((account.name, what))
        log.warning("refused: %s", error)
    return error


async def abort(context: grpc.aio.ServicerContext, error: KernelError) -> NoReturn:
    """End a call with the status of an error."""
    code, message, metadata = trailers(error)
    await context.abort(code, message, metadata)


def _refusing(error: KernelError) -> grpc.RpcMethodHandler:
    async def refuse(_: object, context: grpc.aio.ServicerContext) -> NoReturn:
        await abort(context, error)

    # Whatever the method: so that it is refused at once, before a message is waited for, let alone decoded.
    return grpc.stream_stream_rpc_method_handler(refuse)


def _bytes(value: str | bytes) -> bytes:
    return value if isinstance(value, bytes) else value.encode()
