"""`virtualrobot demo twin`: starts a kernel and two emulated controllers, runs the demo with them, and ends them."""

from __future__ import annotations

import click
from virtualrobot.cli.options import Target, WholeRange, target_options
from virtualrobot.cli.own_kernel import in_kernel


@click.command()
@click.option("--loops", type=WholeRange(1, 50), default=1, show_default=True, help="Rows of three boxes.")
@click.option("--headless", is_flag=True, help="Open no viewer.")
@target_options
def twin(target: Target, loops: int, headless: bool) -> None:
    """Watch two emulated controllers do what their twins do, and refuse what would collide.

    A controller of Universal Robots (RTDE) and one of ABB (EGM), each in a process of its own, follow the arms of the
    palletizing cell. An order that a carton is in the way of is refused. Starts a kernel of its own and ends it; with
    --address the demo replaces the world of a kernel that runs already.
    """
    from virtualrobot_apps.demos.twin import run

    with in_kernel(target, headless, None) as client:
        run.main(client, loops=loops, headless=headless)
