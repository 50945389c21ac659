"""`virtualrobot demo carry`: starts a kernel, lets an arm map, grasp, plan and follow in it, and ends it."""

from __future__ import annotations

from pathlib import Path

import click
from virtualrobot.cli.options import Target, target_options

from virtualrobot_apps.vehicles.command import HEADLESS, PLOT, SPEED, pace_of, stepped


@click.command()
@PLOT
@HEADLESS
@SPEED
@target_options
def carry(target: Target, plot: Path | None, headless: bool, speed: float | None) -> None:
    """Watch an arm map two tables by laser, and carry the prism that it sees from one to the other.

    Twice, without and with avoidance. In steps, as fast as the wall clock, without viewer as fast as it can. Starts a
    kernel of its own and ends it; with --address the cell replaces the world of a kernel that runs already. Needs the
    extras `mapping` and `seeing`.
    """
    from virtualrobot_apps.demos.mapping import octree_map

    octree_map.library()  # before a kernel is started for nothing
    from virtualrobot_apps.demos.carry import run

    with stepped(target, plot, headless) as client:
        run.main(client, pace_of(speed, headless), plot)
