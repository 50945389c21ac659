"""Author of a command: kept in the journal with it."""

from __future__ import annotations

from typing import Any


def author(context: Any) -> str:  # noqa: ANN401 grpc.aio.ServicerContext, which servicers need not know
    """Return the name that the client gives itself (metadata `client-name`), its machine and its port."""
    metadata = dict(context.invocation_metadata() or ())
    return f"{metadata.get('client-name', 'client')} at {context.peer()}"


def person(context: Any) -> str:  # noqa: ANN401 grpc.aio.ServicerContext, which servicers need not know
    """Return the author without the port, which differs between equal runs: for what becomes part of the state."""
    return author(context).rpartition(":")[0]
