"""`virtualrobot demo patrol`: starts a kernel, lets a vehicle go its rounds in it, and ends it."""

from __future__ import annotations

import click
from virtualrobot.cli.options import Target, WholeRange, target_options

from virtualrobot_apps.vehicles.command import HEADLESS, SPEED, pace_of, stepped


@click.command()
@click.option("--seed", type=WholeRange(0), default=1, show_default=True, help="What changes, and where.")
@HEADLESS
@SPEED
@target_options
def patrol(target: Target, seed: int, headless: bool, speed: float | None) -> None:
    """Watch a vehicle go its rounds through a room, compare scans, and say what has come and what is gone.

    In steps, as fast as the wall clock, without viewer as fast as it can. Starts a kernel of its own and ends it; with
    --address the room replaces the world of a kernel that runs already. Needs the extras `navigation` and `seeing`.
    """
    from virtualrobot_apps.seeing.navigation.command import check_packages

    check_packages()
    check_packages("seeing")
    from virtualrobot_apps.demos.patrol import run

    with stepped(target, None, headless) as client:
        run.main(client, seed, pace_of(speed, headless))
