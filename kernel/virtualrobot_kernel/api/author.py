"""Who sent a command: kept in the journal with it."""

from __future__ import annotations

from typing import Any


def author(context: Any) -> str:  # noqa: ANN401 grpc.aio.ServicerContext, which servicers need not know
    """Return who the client says it is (metadata `client-name`), and its address."""
    metadata = dict(context.invocation_metadata() or ())
    return f"{metadata.get('client-name', 'client')} at {context.peer()}"
