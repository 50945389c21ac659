"""`virtualrobot demo bins`: starts a kernel, lets boxes fall and an arm carry them by friction in it, and ends it."""

from __future__ import annotations

import click
from virtualrobot.cli.options import FiniteRange, Target, WholeRange, target_options

from virtualrobot_apps.vehicles.command import pace_of, stepped

ENGINES = click.Choice(["mujoco", "bullet"])


@click.command()
@click.option("--boxes", type=WholeRange(1, 20), default=8, show_default=True, help="How many.")
@click.option("--seed", type=WholeRange(0), default=1, show_default=True, help="How they lie on the belt.")
@click.option("--physics", type=ENGINES, default="mujoco", show_default=True, help="By which.")
@click.option("--effort", type=FiniteRange(0.1, 120.0), default=20.0, show_default=True, help="N, of the motor.")
@click.option("--headless", is_flag=True, help="Open no viewer.")
@click.option("--speed", type=FiniteRange(0.01, 100.0), help="Simulated seconds for each second of the wall clock.")
@target_options
def bins(
    target: Target, boxes: int, seed: int, physics: str, effort: float, headless: bool, speed: float | None
) -> None:
    """Watch boxes fall from a conveyor into a bin, and an arm bring them to another one, held by friction alone.

    In steps, as fast as the wall clock, without viewer as fast as it can. Starts a kernel of its own and ends it; with
    --address the cell replaces the world of a kernel that runs already.
    """
    from virtualrobot_apps.demos.bins import run

    with stepped(target, None, headless) as client:
        run.main(client, boxes, seed, physics, pace_of(speed, headless), effort)
