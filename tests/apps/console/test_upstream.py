"""Streams of requests to a kernel: answered, refused, left by who reads, and cut off; nothing of them stays behind."""

from __future__ import annotations

import asyncio
import gc
from collections.abc import AsyncIterator
from contextlib import aclosing
from typing import Any

import grpc
import pytest
from virtualrobot.v1 import motion_pb2
from virtualrobot_apps.console.contract import methods
from virtualrobot_apps.console.refusal import Refusal
from virtualrobot_apps.console.upstream import Upstream

METHOD = "StreamSetpoints"


async def counted(requests: AsyncIterator[motion_pb2.StreamSetpointsRequest], _: object) -> AsyncIterator[Any]:
    """Answer each request with how many values it has."""
    async for one in requests:
        yield motion_pb2.StreamSetpointsResponse(setpoint_count=len(one.values))


async def started() -> tuple[grpc.aio.Server, int]:
    """Return a server of one method in this process, and its port."""
    server = grpc.aio.server()
    handler = grpc.stream_stream_rpc_method_handler(
        counted,  # pyright: ignore[reportArgumentType] its own types are those of the other servers
        request_deserializer=motion_pb2.StreamSetpointsRequest.FromString,
        response_serializer=motion_pb2.StreamSetpointsResponse.SerializeToString,
    )
    service = grpc.method_handlers_generic_handler("virtualrobot.v1.MotionService", {METHOD: handler})
    server.add_generic_rpc_handlers((service,))
    port = server.add_insecure_port("127.0.0.1:0")
    await server.start()
    return server, port


async def come(*said: int | Refusal, end: bool = False) -> AsyncIterator[bytes]:
    """Yield requests of so many values, raise refusals; then end, or wait for ever."""
    for one in said:
        if isinstance(one, Refusal):
            raise one
        yield motion_pb2.StreamSetpointsRequest(values=[0.0] * one).SerializeToString()
    if not end:
        await asyncio.Event().wait()


async def streams() -> list[str]:
    """Return what the loop complains of while four streams go and end, each in its way."""
    complaints: list[str] = []
    asyncio.get_running_loop().set_exception_handler(lambda _, about: complaints.append(about["message"]))
    server, port = await started()
    upstream, method = Upstream(f"127.0.0.1:{port}", None), methods()[f"/virtualrobot.v1.MotionService/{METHOD}"]

    answers = [
        motion_pb2.StreamSetpointsResponse.FromString(answer.data).setpoint_count
        async for answer in upstream.call(method, come(1, 2, end=True), ())
    ]
    assert answers == [1, 2]
    with pytest.raises(Refusal, match="no setpoint"):
        async for _ in upstream.call(method, come(1, Refusal.of("INVALID_ARGUMENT", "no setpoint")), ()):
            pass
    async with aclosing(upstream.call(method, come(1), ())) as left:
        await anext(left)
    cut = upstream.call(method, come(1), ())
    await anext(cut)
    await server.stop(None)
    with pytest.raises(Refusal) as refused:
        await anext(cut)
    assert refused.value.code == "unavailable"
    await upstream.close()
    assert asyncio.all_tasks() == {asyncio.current_task()}
    gc.collect()
    await asyncio.sleep(0)
    return complaints


def test_a_call_that_ends_leaves_nothing_that_waits() -> None:
    assert asyncio.run(streams()) == []
