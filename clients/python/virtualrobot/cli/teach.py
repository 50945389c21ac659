"""`virtualrobot teach`: where a robot stands gets a name."""

from __future__ import annotations

import click

from virtualrobot.cli.names import NODE, ROBOT
from virtualrobot.cli.options import Target, target_options
from virtualrobot.cli.orders import Part, group_options, part_of

_EXAMPLES = """
\b
Examples:
  virtualrobot teach arm "pick 1" --parent table
  virtualrobot teach arm home --posture
  virtualrobot move arm --to "pick 1" --above 0.1
"""


@click.command(epilog=_EXAMPLES)
@click.argument("robot", type=ROBOT)
@click.argument("called", metavar="[NAME]", required=False)
@click.option("--parent", type=NODE, default="world", help="The node that the target is fixed to [world].")
@click.option("--posture", is_flag=True, help="Its joints alone, as a posture of the robot.")
@click.option("--replace", is_flag=True, help="In place of what has the name already.")
@group_options
@target_options
def teach(
    target: Target, robot: str, called: str | None, parent: str, posture: bool, replace: bool, group: Part
) -> None:
    """Save where ROBOT's tool centre point is as the target NAME; or show its postures and the targets.

    'virtualrobot rename' and 'remove' change targets as any node.
    """
    if posture and (parent != "world" or any(group)):
        raise click.UsageError("--posture goes with no --parent, and is of the whole robot")
    with target.connect() as client:
        handle = client.robot(robot)
        if called is None:
            for known in handle.postures:
                click.echo(f"posture {known}")
            for known in client.targets.values():
                taught = f", taught with {known.robot}" if known.robot else ""
                click.echo(f"target {known.name} in {known.parent}{taught}")
        elif posture:
            handle.postures.add(called, replace=replace)
            click.echo(f"{robot} has the posture {called}")
        else:
            part_of(handle, group).teach(called, parent, replace=replace)
            click.echo(f"taught {called} in {parent}")
