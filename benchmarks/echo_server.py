"""A bare grpc.aio server that only answers: the peer of the kernel's API. Run as a process by `processes.echo`."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator

import grpc

MESSAGE = bytes(range(120))
"""About what a stamp with seven joints takes."""


async def unary(request: bytes, context: grpc.aio.ServicerContext) -> bytes:
    """Return the request."""
    return request


async def stream(request: bytes, context: grpc.aio.ServicerContext) -> AsyncIterator[bytes]:
    """Yield as many messages as the request's number says."""
    for _ in range(int(request)):
        yield MESSAGE


async def main() -> None:
    """Serve until the process is ended."""
    server = grpc.aio.server()
    handlers = {
        "Unary": grpc.unary_unary_rpc_method_handler(unary),
        "Stream": grpc.unary_stream_rpc_method_handler(stream),
    }
    server.add_generic_rpc_handlers((grpc.method_handlers_generic_handler("Echo", handlers),))
    port = server.add_insecure_port("127.0.0.1:0")
    await server.start()
    print(f"listening on 127.0.0.1:{port}", flush=True)
    await server.wait_for_termination()


if __name__ == "__main__":
    asyncio.run(main())
