"""A bare bridge: what a WebSocket client sends comes back for each sample that the kernel's client hears."""

import asyncio
import sys
import threading

import virtualrobot
from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed


async def main(address: str, stream: str) -> None:
    """Serve until the process ends."""
    loop = asyncio.get_running_loop()
    with virtualrobot.connect(address) as client:

        async def told(socket: ServerConnection) -> None:
            data = await socket.recv()
            came: asyncio.Queue[None] = asyncio.Queue()
            over = threading.Event()

            def hear() -> None:
                with client.streams.watch(stream) as watch:
                    while not over.is_set():
                        if watch.next(1.0) is not None:
                            loop.call_soon_threadsafe(came.put_nowait, None)

            hearing = asyncio.create_task(asyncio.to_thread(hear))
            try:
                while True:
                    await came.get()
                    await socket.send(data)
            except ConnectionClosed:
                over.set()
                await hearing

        async with serve(told, "127.0.0.1", 0, max_size=None, compression=None) as server:
            print("listening on", next(iter(server.sockets)).getsockname()[1], flush=True)
            await server.wait_closed()


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:]))
