"""The kernel that an application runs in: one of its own, which ends with it, or one that runs already."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import TYPE_CHECKING

import click

from virtualrobot.cli.options import Target

if TYPE_CHECKING:
    from virtualrobot import Client


@contextmanager
def in_kernel(target: Target, headless: bool, speed: float | None, *options: str) -> Iterator[Client]:
    """Give a client of the kernel that `target` names by address, or else of one that ends at the end of the block.

    `speed` is that of its clock; None leaves it. `options` are more ones of `virtualrobot serve`, for one of
    its own. Ctrl-C and SIGTERM end the command with 130.
    """
    from virtualrobot.kernel_process import KernelProcess

    interrupt_when_terminated()  # so that the kernel is ended too
    try:
        if target.address is not None:
            with _connected(target, speed) as client:
                yield client
            return
        click.echo("starting the kernel ...")
        with KernelProcess(*options, headless=headless, say=click.echo) as kernel:
            click.echo(f"kernel at {kernel.address}")
            with _connected(Target(kernel.address), speed) as client:
                yield client
    except KeyboardInterrupt:
        click.echo("\nstopped")
        raise click.exceptions.Exit(130) from None


@contextmanager
def _connected(target: Target, speed: float | None) -> Iterator[Client]:
    with target.connect(click.get_current_context().command_path) as client:
        if speed is not None:
            client.clock.speed_factor = speed
        yield client


def interrupt_when_terminated() -> None:
    """Take SIGTERM, and the SIGHUP of a terminal that is closed, for Ctrl-C from now on; the first one counts."""
    _on_signals(_interrupt)


def _interrupt(_: int, frame: FrameType | None) -> None:
    # Who ends a process often tells it twice: `timeout` tells it and its group, a terminal hangs up besides.
    _on_signals(lambda *_: None)
    ctrl_c = signal.getsignal(signal.SIGINT)
    if not callable(ctrl_c):  # it is ignored, as a shell has it for what runs behind
        raise KeyboardInterrupt
    # That of an event loop cancels its task. What is raised amid the loop may cost a task its end, and then it hangs.
    ctrl_c(signal.SIGINT, frame)


def _on_signals(handler: Callable[[int, FrameType | None], object]) -> None:
    for name in ("SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)  # Windows has no SIGHUP
        if number is not None and signal.getsignal(number) is not signal.SIG_IGN:  # as nohup has it
            signal.signal(number, handler)
