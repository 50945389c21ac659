"""`virtualrobot demo fetch`: starts a kernel, lets a mobile manipulator fetch something in it, and ends it."""

from __future__ import annotations

import click
from virtualrobot.cli.options import Target, WholeRange, target_options

from virtualrobot_apps.vehicles.command import HEADLESS, SPEED, pace_of, stepped


@click.command()
@click.option("--seed", type=WholeRange(0), default=1, show_default=True, help="Where on the shelf it stands.")
@HEADLESS
@SPEED
@target_options
def fetch(target: Target, seed: int, headless: bool, speed: float | None) -> None:
    """Watch a Husky with an arm drive to a shelf, look, grasp what stands there, and bring it to a table.

    In steps, as fast as the wall clock, without viewer as fast as it can. Starts a kernel of its own and ends it; with
    --address the room replaces the world of a kernel that runs already. Needs the extras `mapping`, `navigation` and
    `seeing`.
    """
    from virtualrobot_apps.demos.mapping import octree_map
    from virtualrobot_apps.seeing.navigation.command import check_packages

    check_packages()
    octree_map.library()  # before a kernel is started for nothing
    from virtualrobot_apps.demos.fetch import run

    with stepped(target, None, headless) as client:
        run.main(client, seed, pace_of(speed, headless))
