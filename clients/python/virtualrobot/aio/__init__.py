"""The client library for programs that use asyncio: the same nouns, and what asks the kernel is awaited.

    import asyncio
    from virtualrobot import aio

    async def main():
        async with aio.connect() as client:
            arm = await client.load_robot("package://pybullet_data/kuka_iiwa/model.urdf", name="arm")
            await arm.move_joints([0, 0.5, 0, -1.2, 0, 0.8, 0])

    asyncio.run(main())

Each order runs in a thread of its own meanwhile, through the library itself: nothing differs in arguments, answers and
errors. A task that is cancelled takes its order back as Ctrl-C does: a move that it waits for is cancelled.
"""

from __future__ import annotations

import threading
from functools import partial, wraps
from typing import Any

import virtualrobot
from virtualrobot.aio.faces import BY_NAME, Face, faced
from virtualrobot.aio.orders import Order, Workers

__all__ = ["Face", "Order", "connect"]


@wraps(virtualrobot.connect)
def connect(*arguments: Any, **options: Any) -> Order[Any]:  # noqa: ANN401 as `virtualrobot.connect` has them
    """Connect to a kernel as `virtualrobot.connect` does: `async with aio.connect() as client`, or await it."""
    return Order(partial(_connected, arguments, options), "connect")


async def _connected(arguments: tuple[Any, ...], options: dict[str, Any]) -> Face:
    workers = Workers()
    client = await workers.do(partial(virtualrobot.connect, *arguments, **options))
    client.services.channel.kept_out = threading.get_ident()
    return faced(client, workers)


def __getattr__(name: str) -> type[Face]:
    """Return the class of what tasks see, such as `aio.Robot`, for annotations and `isinstance`."""
    if name not in BY_NAME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return BY_NAME[name]


def __dir__() -> list[str]:
    """Return the public names."""
    return sorted([*__all__, *BY_NAME])
