"""`virtualrobot emulate egm`."""

from __future__ import annotations

import threading
from contextlib import ExitStack, suppress

import click
from virtualrobot.cli.names import ROBOT
from virtualrobot.cli.options import GO_ON, FiniteRange, Target, target_options

_EXAMPLES = """
\b
Examples:
  virtualrobot emulate egm arm
  virtualrobot emulate egm --joints 6 --to 192.168.125.99:6510
"""


class Place(click.ParamType):
    """A host and a port."""

    name = "host:port"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, int]:
        """Return both."""
        if isinstance(value, tuple):
            return value
        host, _, port = str(value).rpartition(":")
        if not (host and port.isascii() and port.isdecimal() and 1 <= int(port) <= 65535):
            self.fail(f"{value!r} is not HOST:PORT, such as 127.0.0.1:6510", param, ctx)
        return host, int(port)


@click.command(epilog=_EXAMPLES)
@click.argument("robot", type=ROBOT, required=False)
@click.option("--to", type=Place(), default="127.0.0.1:6510", help="Where the program listens [127.0.0.1:6510].")
@click.option("--rate", type=FiniteRange(1.0, 250.0), default=250.0, help="Packets a second [250].")
@click.option("--timeout", type=FiniteRange(0.01, 60.0), default=1.0, help="Stop after s without an answer [1].")
@click.option("--joints", type=click.IntRange(1, 12), help="Without ROBOT: an arm with so many joints [6].")
@target_options
def egm(
    target: Target, robot: str | None, to: tuple[str, int], rate: float, timeout: float, joints: int | None
) -> None:
    """Emulate an ABB controller with Externally Guided Motion, which moves ROBOT, until Ctrl-C.

    It sends its joints to the program, and the robot goes where the answers say. What the kernel refuses is told here.
    """
    if robot is not None and joints is not None:
        raise click.UsageError("--joints goes with an arm of its own, without ROBOT")
    import numpy as np

    from virtualrobot_apps.emulators import cyclic
    from virtualrobot_apps.emulators.body import SimulatedArm, Twin
    from virtualrobot_apps.emulators.egm.controller import EgmController

    with ExitStack() as stack:
        if robot is None:
            body = SimulatedArm(np.zeros(joints or 6))
        else:
            client = stack.enter_context(target.connect("EGM emulator"))
            if client.clock.mode == "stepped":
                raise click.UsageError(f"time stands still, and nothing would move; {GO_ON}")
            body = Twin(client.robot(robot), timeout)
        try:
            controller = EgmController(body, to, rate, timeout, lambda words: click.echo(words))
        except OSError as error:
            raise click.ClickException(f"{to[0]}:{to[1]} cannot be spoken to: {error}") from error
        stack.callback(controller.close)
        click.echo(f"EGM speaks to {to[0]}:{to[1]}, {rate:g} times a second; Ctrl-C ends it")
        with suppress(KeyboardInterrupt):
            cyclic.run(controller.cycle, controller.period, threading.Event())
