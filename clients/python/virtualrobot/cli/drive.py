"""`virtualrobot drive`."""

from __future__ import annotations

import math

import click

from virtualrobot.cli.names import ROBOT
from virtualrobot.cli.options import GO_ON, FiniteRange, Target, degrees_option, target_options

_EXAMPLES = """
\b
Examples:
  virtualrobot drive husky --forward 0.5 --seconds 4
  virtualrobot drive husky --turn 30 --degrees --seconds 3
  virtualrobot drive platform --left 0.2 --seconds 2
  virtualrobot drive racecar --to 2 1 --heading 90 --degrees --reverse
  virtualrobot drive racecar --to 2 1 --check
"""


@click.command(epilog=_EXAMPLES)
@click.argument("robot", type=ROBOT)
@click.option("--forward", type=float, default=0.0, metavar="SPEED", help="m/s; backwards below 0 [0].")
@click.option("--left", type=float, default=0.0, metavar="SPEED", help="m/s to the left, for crafts that can [0].")
@click.option("--turn", type=float, default=0.0, metavar="SPEED", help="rad/s to the left [0].")
@click.option("--seconds", type=FiniteRange(0.0, min_open=True), help="How long.")
@click.option(
    "--to", "place", type=float, nargs=2, metavar="X Y", help="Instead of speeds, where to (m): a planned way."
)
@click.option("--heading", type=float, help="How far it is turned to the left there [as the way comes].")
@click.option("--reverse", is_flag=True, help="It may go back on its way, too.")
@click.option("--radius", type=FiniteRange(0.0, min_open=True), help="Of the arcs in m [as narrow as it turns].")
@click.option("--check", is_flag=True, help="Only tell the way and what it would touch; nothing moves.")
@click.option("--preempt", is_flag=True, help="Stop what the robot does and take over.")
@degrees_option
@target_options
def drive(
    target: Target,
    robot: str,
    forward: float,
    left: float,
    turn: float,
    seconds: float | None,
    place: tuple[float, float] | None,
    heading: float | None,
    reverse: bool,
    radius: float | None,
    check: bool,
    preempt: bool,
    degrees: bool,
) -> None:
    """Drive a craft for some seconds of simulation time, or to a place, and tell where it rests.

    Ctrl-C stops it.
    """
    unit = math.radians(1.0) if degrees else 1.0
    if (seconds is None) == (place is None):
        raise click.UsageError("give --seconds for speeds, or --to for a place")
    if place is not None and (forward or left or turn):
        raise click.UsageError("--to plans its own speeds; leave --forward, --left and --turn out, or give --seconds")
    with target.connect() as client:
        craft, way = client.robot(robot), None
        if place is not None:
            way = craft.way_to(
                *place, None if heading is None else heading * unit, reverse=reverse, turning_radius=radius
            )
            word = f"{way.word}, " if way.word else ""
            click.echo(f"the way: {word}{len(way.parts)} parts, {way.length:.3f} m")
            if check:
                found = way.check().first_violation
                click.echo("it touches nothing" if found is None else found.message)
                return
        if client.clock.mode == "stepped":
            raise click.UsageError(f"time stands still, and nothing would drive; {GO_ON}")
        if way is not None:
            way.start(preempt=preempt)
            x, y, angle = craft.way([]).begin
        else:
            assert seconds is not None  # or there is a place
            x, y, angle = craft.drive(forward, turn * unit, left=left, seconds=seconds, preempt=preempt).positions
        click.echo(f"{robot} rests at {x:.3f}, {y:.3f} m, heading {angle / unit:.3f} {'°' if degrees else 'rad'}")
