"""`virtualrobot emulate egm`."""

from __future__ import annotations

import math
import sys
import threading
from contextlib import ExitStack, suppress
from typing import Any

import click
from virtualrobot.cli.names import ROBOT
from virtualrobot.cli.options import GO_ON, FiniteRange, Numbers, Target, degrees_option, target_options

_EXAMPLES = """
\b
Examples:
  virtualrobot emulate egm arm
  virtualrobot emulate egm --at 0,-30,30,0,45,0 --degrees --to 192.168.125.99:6510
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


class Device(Place):
    """A UDP device by which a program in RAPID is guided: its name, and host and port of the computer."""

    name = "name=host:port"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> Any:  # noqa: ANN401
        """Return the name, and host and port."""
        if isinstance(value, tuple):
            return value
        name, equals, place = str(value).partition("=")
        if not (name and equals):
            self.fail(f"{value!r} is not NAME=HOST:PORT, such as UCdevice=127.0.0.1:6510", param, ctx)
        return name, super().convert(place, param, ctx)


devices_option = click.option(
    "--egm",
    "devices",
    metavar="NAME=HOST:PORT",
    type=Device(),
    multiple=True,
    help="Let EGM speak to this computer by the UDP device NAME: whoever answers there moves the robot.",
)
"""Option of commands that run programs in RAPID."""


@click.command(epilog=_EXAMPLES)
@click.argument("robot", type=ROBOT, required=False)
@click.option("--to", type=Place(), default="127.0.0.1:6510", help="Where the program listens [127.0.0.1:6510].")
@click.option("--rate", type=FiniteRange(1.0, 250.0), default=250.0, help="Packets a second [250].")
@click.option("--timeout", type=FiniteRange(0.01, 60.0), default=1.0, help="Stop after s without an answer [1].")
@click.option("--at", type=Numbers(), help="Without ROBOT: where the arm's joints stand, in rad [six zeros].")
@degrees_option
@click.option("--until-input-ends", is_flag=True, help="End with the standard input: with the program that started it.")
@target_options
def egm(
    target: Target,
    robot: str | None,
    to: tuple[str, int],
    rate: float,
    timeout: float,
    at: tuple[float, ...] | None,
    degrees: bool,
    until_input_ends: bool,
) -> None:
    """Emulate an ABB controller with Externally Guided Motion, which moves ROBOT, until Ctrl-C.

    It sends its joints to the program, and the robot goes where the answers say. What the kernel refuses is told here.
    """
    if robot is not None and at is not None:
        raise click.UsageError("--at goes with an arm of its own, without ROBOT; move ROBOT to where it shall be")
    import numpy as np

    from virtualrobot_apps.emulators import cyclic
    from virtualrobot_apps.emulators.body import SimulatedArm, Twin
    from virtualrobot_apps.emulators.egm.controller import EgmController

    with ExitStack() as stack:
        if robot is None:
            stands = np.zeros(6) if at is None else np.array(at) * (math.radians(1.0) if degrees else 1.0)
            body = SimulatedArm(stands)
        else:
            client = stack.enter_context(target.connect("EGM emulator"))
            if client.clock.mode == "stepped":
                raise click.UsageError(f"time stands still, and nothing would move; {GO_ON}")
            body = Twin(client.robot(robot), timeout, client.scene.pose(robot))
        try:
            controller = EgmController(body, to, rate, timeout, lambda words: click.echo(words))
        except OSError as error:
            raise click.ClickException(f"{to[0]}:{to[1]} cannot be spoken to: {error}") from error
        stack.callback(controller.close)
        click.echo(f"EGM speaks to {to[0]}:{to[1]}, {rate:g} times a second; Ctrl-C ends it")
        over = threading.Event()
        if until_input_ends:
            threading.Thread(target=_await_end, args=(over,), daemon=True).start()
        with suppress(KeyboardInterrupt):
            cyclic.run(controller.cycle, controller.period, over)


def _await_end(over: threading.Event) -> None:
    for _ in sys.stdin:
        pass
    over.set()
