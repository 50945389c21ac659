"""Preparation of figures for the guard in a worker, before the command that brings them to it."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence

from virtualrobot_kernel.api.kernel_services import KernelServices
from virtualrobot_kernel.collision.readiness import is_to_be_ready, make_ready
from virtualrobot_kernel.world.commands import Command


async def ready_for_guard(kernel: KernelServices, commands: Sequence[Command]) -> None:
    """Wait until the world thread will find made what a guard needs of these commands."""
    snapshot = kernel.world.snapshot
    if is_to_be_ready(snapshot, commands):
        run = asyncio.get_running_loop().run_in_executor
        await run(kernel.workers, make_ready, kernel.collisions.shapes, snapshot, commands)
