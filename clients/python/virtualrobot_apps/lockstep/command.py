"""`virtualrobot lockstep`."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

import click
from virtualrobot.cli.options import FiniteRange, Target, WholeRange, target_options
from virtualrobot.cli.own_kernel import interrupt_when_terminated

if TYPE_CHECKING:
    from virtualrobot_apps.lockstep.wire import Wire

ABOVE_ZERO = FiniteRange(0.0, min_open=True)

_EXAMPLES = """
\b
Examples:
  virtualrobot lockstep ugv -- python controller.py
  virtualrobot lockstep ugv --sensor ugv.lidar -- octave --quiet controller.m
  virtualrobot lockstep ugv --port 5600
  virtualrobot lockstep ugv --fmu controller.fmu
"""


@click.command(epilog=_EXAMPLES, short_help="Let time wait for an outside controller of a robot.")
@click.argument("robot")
@click.argument("program", nargs=-1, metavar="[-- PROGRAM [ARGUMENT]...]")
@click.option("--port", type=WholeRange(0, 65535), help="Wait for a controller at this port instead (0: a free one).")
@click.option(
    "--fmu",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE.fmu",
    help="The controller is this FMU for co-simulation (FMI 2.0 or 3.0).",
)
@click.option("--period", type=ABOVE_ZERO, default=0.05, help="From one command to the next, simulation time [0.05 s].")
@click.option("--timeout", type=ABOVE_ZERO, default=10.0, help="How long to wait for each command [10 s].")
@click.option("--seconds", type=ABOVE_ZERO, help="Of simulation time [until the controller ends].")
@click.option("--sensor", "sensors", multiple=True, metavar="NAME", help="Tell its readings, too; may be given again.")
@click.option(
    "--pace", type=FiniteRange(0.0), default=0.0, help="Simulated seconds a second at most [as fast as it goes]."
)
@target_options
def lockstep(
    target: Target,
    robot: str,
    program: tuple[str, ...],
    port: int | None,
    fmu: Path | None,
    period: float,
    timeout: float,
    seconds: float | None,
    sensors: tuple[str, ...],
    pace: float,
) -> None:
    """Control ROBOT by a PROGRAM of one's own in lockstep: it gets the state, and time waits for its command.

    The program reads a line of JSON from its input for each state, and writes one to its output for each command:
    {"twist": [0.3, 0, 0.1]}, {"positions": {...}}, {"velocities": {...}}, with "signals" and "done".
    """
    from virtualrobot_apps.lockstep.exchange import Lockstep
    from virtualrobot_apps.lockstep.wire import ProgramWire, SocketWire, listen
    from virtualrobot_apps.pace import Pace

    interrupt_when_terminated()  # so that the robot comes to rest, and time goes on for everybody
    if bool(program) + (port is not None) + (fmu is not None) != 1:
        raise click.UsageError("say which controller: a PROGRAM behind --, a --port at which one connects, or an --fmu")
    with target.connect() as client:
        steps = Lockstep(client, robot, period, sensors)
        wire: Wire
        if fmu is not None:
            wire = _fmu_wire(fmu, period)
        elif port is None:
            wire = ProgramWire(program)
        else:
            with closing(listen(port)) as server:
                click.echo(f"waiting for a controller at 127.0.0.1:{server.getsockname()[1]}")
                wire = SocketWire(server, timeout)
        with closing(wire):
            run = steps.run(wire, timeout, seconds, Pace(pace).keep)
    click.echo(f"{run.steps} steps, {run.seconds:.3f} s: {run.end}")


def _fmu_wire(file: Path, period: float) -> Wire:
    from importlib.util import find_spec

    from virtualrobot_apps.fmi.wire import FmuWire

    if find_spec("fmpy") is None:
        raise click.UsageError("FMPy is not installed: pip install 'virtualrobot[fmi]'")
    return FmuWire(file, period)
