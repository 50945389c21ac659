"""`virtualrobot demo`: starts a kernel, runs the demo in it, and ends it."""

from __future__ import annotations

import signal
from typing import NoReturn

import click

from virtualrobot.cli.options import Target, target_options


@click.command()
@click.option("--loop", is_flag=True, help="Begin again when both pallets are full.")
@click.option("--headless", is_flag=True, help="Open no viewer.")
@click.option(
    "--speed", type=click.FloatRange(0.01, 100.0), help="Simulated seconds for each second of the wall clock."
)
@target_options
def demo(target: Target, loop: bool, headless: bool, speed: float | None) -> None:
    """Watch an iiwa and a Panda palletize the boxes of a conveyor.

    Starts a kernel of its own and ends it; with --address the demo replaces the world of a kernel that runs already.
    """
    from virtualrobot.kernel_process import KernelProcess

    signal.signal(signal.SIGTERM, _interrupt)  # so that the kernel is ended too
    try:
        if target.address is not None:
            _run(target, loop, headless, speed)
            return
        click.echo("starting the kernel ...")
        with KernelProcess(headless=headless, say=click.echo) as kernel:
            _run(Target(kernel.address), loop, headless, speed)
    except KeyboardInterrupt:
        click.echo("\nstopped")
        raise click.exceptions.Exit(130) from None


def _run(target: Target, loop: bool, headless: bool, speed: float | None) -> None:
    """Run the demo in a kernel."""
    from virtualrobot.apps import demo as app

    with target.connect() as client:
        if speed is not None:
            client.clock.speed_factor = speed
        app.main(client, loop=loop, headless=headless)


def _interrupt(*_: object) -> NoReturn:
    raise KeyboardInterrupt
