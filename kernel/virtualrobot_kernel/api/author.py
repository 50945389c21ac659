"""Author of a command: kept in the journal with it, so that it tells who did what."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from virtualrobot_kernel.api.token_table import CALLER


def author(context: Any) -> str:  # noqa: ANN401 grpc.aio.ServicerContext, which servicers need not know
    """Return the name that the client gives itself (metadata `client-name`), its machine and its port.

    Before it stands the name of the call's token, which nobody gives himself; the kernel's own has none.
    """
    metadata = dict(context.invocation_metadata() or ())
    said, place = str(metadata.get("client-name", "client")), context.peer()
    token = CALLER.get().name
    # Who has the kernel's own token does not give itself the name of another.
    return f"{token} with {said} at {place}" if token else f"{said.replace(' with ', ' ')} at {place}"


def person(context: Any) -> str:  # noqa: ANN401 grpc.aio.ServicerContext, which servicers need not know
    """Return the author without the port, which differs between equal runs: for what becomes part of the state."""
    return author(context).rpartition(":")[0]


def is_mine(context: Any) -> Callable[[str], bool]:  # noqa: ANN401 grpc.aio.ServicerContext, which servicers need not know
    """Return what says whether an author is the client that calls.

    Whoever gives itself a name is known by it and its machine, whatever its connection; others by their connection.
    """
    if "client-name" not in dict(context.invocation_metadata() or ()):
        me = author(context)
        return lambda other: other == me
    me = person(context)
    return lambda other: other.rpartition(":")[0] == me
