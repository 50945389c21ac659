"""A bare grpc.aio server that only answers: the peer of the kernel's API. Run as a process by `processes.echo`."""

from __future__ import annotations

import asyncio
import itertools
from collections.abc import AsyncIterator

import grpc
from virtualrobot.v1 import geometry_pb2, robot_pb2


async def unary(request: bytes, context: grpc.aio.ServicerContext) -> bytes:
    """Return the request."""
    return request


async def stream(
    request: bytes, context: grpc.aio.ServicerContext
) -> AsyncIterator[robot_pb2.WatchRobotStatesResponse]:
    """Yield the state of a robot with seven joints, built anew each time, until the reader has enough."""
    place = geometry_pb2.Pose(position=geometry_pb2.Vector3(x=1.0), orientation=geometry_pb2.Quaternion(w=1.0))
    for tick in itertools.count():
        stamp = geometry_pb2.Stamp(tick=tick, simulation_time_seconds=tick * 0.001)
        state = robot_pb2.RobotState(
            name="arm", positions=[0.1] * 7, velocities=[0.1] * 7, world_t_tcp=place, speed_factor=1.0
        )
        yield robot_pb2.WatchRobotStatesResponse(stamp=stamp, robots=[state])


async def both(requests: AsyncIterator[bytes], context: grpc.aio.ServicerContext) -> AsyncIterator[bytes]:
    """Yield each request."""
    async for request in requests:
        yield request


async def main() -> None:
    """Serve until the process is ended."""
    server = grpc.aio.server()
    handlers = {
        "Unary": grpc.unary_unary_rpc_method_handler(unary),
        "Both": grpc.stream_stream_rpc_method_handler(both),
        "Stream": grpc.unary_stream_rpc_method_handler(
            stream, response_serializer=robot_pb2.WatchRobotStatesResponse.SerializeToString
        ),
    }
    server.add_generic_rpc_handlers((grpc.method_handlers_generic_handler("Echo", handlers),))
    port = server.add_insecure_port("127.0.0.1:0")
    await server.start()
    print(f"listening on 127.0.0.1:{port}", flush=True)
    await server.wait_for_termination()


if __name__ == "__main__":
    asyncio.run(main())
