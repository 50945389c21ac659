"""`virtualrobot jog`."""

from __future__ import annotations

import math
import sys

import click

from virtualrobot.cli.key_hold import check_terminal, hold_option
from virtualrobot.cli.move import start_and_follow
from virtualrobot.cli.names import NODE, ROBOT
from virtualrobot.cli.options import GO_ON, Numbers, Target, degrees_option, target_options
from virtualrobot.cli.orders import Part, angles, group_options, part_of

_EXAMPLES = """
\b
Examples:
  virtualrobot jog arm joint_1 --velocity -0.2
  virtualrobot jog arm --along 0,0,1 --frame tool --velocity 0.05
  virtualrobot jog arm --about 0,0,1 --node table --distance 90 --degrees
"""


@click.command(epilog=_EXAMPLES)
@click.argument("robot", type=ROBOT)
@click.argument("joint", required=False)
@click.option("--along", type=Numbers(3), metavar="X,Y,Z", help="The tool centre point moves in this direction.")
@click.option("--about", type=Numbers(3), metavar="X,Y,Z", help="The tool centre point turns about this axis.")
@click.option(
    "--frame", type=click.Choice(["base", "tool", "world"]), help="In whose axes the direction is given [base]."
)
@click.option("--node", type=NODE, help="In the axes of this node instead.")
@click.option("--velocity", type=float, help="m/s or rad/s [0.1 or 0.25]; a joint needs one, with the sign of its way.")
@click.option("--distance", type=float, help="m or rad [as far as it goes].")
@click.option("--keys", is_flag=True, help="Jog by the keys of this terminal until q; it tells which do what.")
@click.option("--preempt", is_flag=True, help="Stop what the robot does and take over.")
@hold_option
@group_options
@degrees_option
@target_options
def jog(
    target: Target,
    robot: str,
    joint: str | None,
    along: tuple[float, ...] | None,
    about: tuple[float, ...] | None,
    frame: str | None,
    node: str | None,
    velocity: float | None,
    distance: float | None,
    keys: bool,
    preempt: bool,
    hold: bool,
    degrees: bool,
    group: Part,
) -> None:
    """Move a joint, or the tool centre point in one direction, until its distance or until it can go no farther.

    Ctrl-C, like a key that is released, stops it on its path.
    """
    if keys:
        if joint is not None or along or about or frame or node or velocity is not None or distance is not None or hold:
            raise click.UsageError("with --keys the keys say what moves, and how far")
        if sys.stdin is None or not sys.stdin.isatty():
            raise click.UsageError("--keys needs a terminal; without one give JOINT, --along or --about")
        from virtualrobot.cli.key_jog import jog_by_keys

        with target.connect() as client:
            if client.clock.mode == "stepped":
                raise click.UsageError(f"time stands still, and keys would move nothing; {GO_ON}")
            jog_by_keys(part_of(client.robot(robot), group))
        return
    if (joint is not None) + (along is not None) + (about is not None) != 1:
        raise click.UsageError("say what moves, in one way: a JOINT, --along, --about, or --keys")
    if joint is not None and (frame or node):
        raise click.UsageError("--frame and --node go with --along or --about")
    if joint is not None and velocity is None:
        raise click.UsageError("a joint needs a --velocity, whose sign says which way")
    if frame and node:
        raise click.UsageError("--frame or --node, not both")
    check_terminal(hold)
    with target.connect() as client:
        handle = part_of(client.robot(robot), group)
        turns = about is not None or joint in angles(handle)
        unit = math.radians(1.0) if degrees and turns else 1.0
        speed = None if velocity is None else unit * velocity
        way = None if distance is None else unit * distance
        if joint is not None and speed is not None:
            order = handle.joint_jog(joint, speed, way)
        else:
            order = handle.cartesian_jog(along, rotation=about, frame=frame, node=node, velocity=speed, distance=way)
        if client.clock.mode == "stepped":
            click.echo(f"time stands still: the motion goes on with each 'virtualrobot step'; {GO_ON}", err=True)
        start_and_follow(handle, order, preempt, no_wait=False, hold=hold)
