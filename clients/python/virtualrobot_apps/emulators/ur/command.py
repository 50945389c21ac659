"""`virtualrobot emulate ur`: a controller of Universal Robots whose arm is the twin in a kernel, or one of its own."""

from __future__ import annotations

import queue
import signal
import sys
import threading
from contextlib import ExitStack, suppress

import click
from virtualrobot.cli.names import ROBOT
from virtualrobot.cli.options import GO_ON, FiniteRange, Target, target_options

# What emulates is loaded as the command runs: the command line shows its help without it.
MODELS = ("ur3", "ur5", "ur10", "ur3e", "ur5e", "ur10e", "ur16e")
HOME = (0.0, -1.57, 1.57, -1.57, -1.57, 0.0)


@click.command()
@click.argument("robot", type=ROBOT, required=False)
@click.option("--model", type=click.Choice(MODELS), help="The arm's lengths [those that ROBOT has, else ur5e].")
@click.option("--host", default="127.0.0.1", show_default=True, help="The address to listen at, ports 29999 to 30004.")
@click.option("--rate", type=FiniteRange(10.0, 500.0), default=500.0, show_default=True, help="Cycles a second (Hz).")
@click.option(
    "--lag", type=FiniteRange(0.0, 1.0), default=0.02, show_default=True, help="Lag (s) of an arm of its own."
)
@click.option("--until-input-ends", is_flag=True, help="End with the standard input: with the program that started it.")
@target_options
def ur(
    target: Target, robot: str | None, model: str | None, host: str, rate: float, lag: float, until_input_ends: bool
) -> None:
    """Emulate a controller of Universal Robots, which moves ROBOT, until Ctrl-C.

    Lines that are typed meanwhile are orders: `protective stop`, `safeguard stop`, `emergency stop`, `release`,
    `power off`, `power on`, `brake release`, `local`, `remote`, `close popup`, `input 3 on`, `input 3 off`,
    `analog 0 3.3`, `speed 0.5`.
    """
    from virtualrobot_apps.emulators.body import ArmLimits, Body, SimulatedArm, Twin
    from virtualrobot_apps.emulators.ur.controller import Controller
    from virtualrobot_apps.emulators.ur.forces import Forces, Unmeasured, Wrist
    from virtualrobot_apps.emulators.ur.kinematics import MODELS as LENGTHS
    from virtualrobot_apps.emulators.ur.lengths import USUAL, model_of
    from virtualrobot_apps.emulators.ur.orders import obey
    from virtualrobot_apps.emulators.ur.server import Server
    from virtualrobot_apps.emulators.ur.touches import Touches

    with ExitStack() as stack:
        body: Body = SimulatedArm(HOME, ArmLimits.usual(6, lag))
        touches, forces = None, Forces()
        if robot is not None:
            client = stack.enter_context(target.connect("UR emulator"))
            if client.clock.mode == "stepped":
                raise click.UsageError(f"time stands still, and nothing would move; {GO_ON}")
            arm = client.robot(robot)
            stack.enter_context(arm.lease())
            body = twin = Twin(arm)
            touches = Touches(client, arm, twin)
            if model is None and (model := model_of(arm)) is None:
                said = f"{robot} has the lengths of none of {', '.join(MODELS)}: poses are those of a {USUAL}"
                click.echo(f"{said}; --model chooses another one", err=True)
            forces = Forces(Wrist(client, arm, twin, LENGTHS[model or USUAL]))
            with suppress(Unmeasured):
                forces.find()
        stack.callback(body.close)
        try:
            server = Server(Controller(body, model or USUAL, rate=rate), host, click.echo)
        except ValueError as error:
            raise click.ClickException(str(error)) from error
        except OSError as error:
            raise click.ClickException(f"the ports 29999 to 30004 of {host} can't be had: {error}") from error
        server.controller.touches, server.controller.forces = touches, forces
        if robot is not None:
            server.controller.begun = lambda program: program.tell(client, robot)
        stack.callback(server.close)
        over = threading.Event()
        signal.signal(signal.SIGTERM, lambda *_: over.set())
        click.echo(f"UR listens at {host}, ports 29999 to 30004; Ctrl-C ends it")
        orders: queue.SimpleQueue[str] = queue.SimpleQueue()
        ends = over if until_input_ends else None
        threading.Thread(target=_read_orders, args=(orders, ends), daemon=True).start()

        def ended() -> bool:
            while not orders.empty():
                said = obey(server.controller, orders.get())
                if said:
                    click.echo(said, err=True)
            return over.is_set()

        with suppress(KeyboardInterrupt):
            server.run(ended)
        if server.controller.off:
            click.echo("UR was shut down by its dashboard")


def _read_orders(orders: queue.SimpleQueue[str], ends: threading.Event | None) -> None:
    for line in sys.stdin:
        orders.put(line)
    if ends is not None:
        ends.set()
