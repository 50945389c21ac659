"""`virtualrobot map`: starts a kernel, lets an arm map a cell in it, and ends it."""

from __future__ import annotations

from pathlib import Path

import click
from virtualrobot.cli.options import FiniteRange, Target, target_options
from virtualrobot.cli.own_kernel import in_kernel


@click.command(short_help="Watch an arm map a cell by laser or ultrasound.")
@click.option("--ultrasonic", is_flag=True, help="By ultrasound and Bayes' rule, not by a laser and an octree.")
@click.option("--resolution", type=FiniteRange(0.01, 0.2), help="Edge of a voxel in meters.")
@click.option("--model", default="", help="The sensor model, such as `laser`, with its default settings.")
@click.option("--save", type=click.Path(path_type=Path, dir_okay=False), help="Write the map: .bt, .ot or .npz.")
@click.option("--headless", is_flag=True, help="Open no viewer.")
@click.option("--speed", type=FiniteRange(0.01, 100.0), help="Simulated seconds for each second of the wall clock.")
@target_options
def map(
    target: Target,
    ultrasonic: bool,
    resolution: float | None,
    model: str,
    save: Path | None,
    headless: bool,
    speed: float | None,
) -> None:
    """Watch an arm with a laser scan a cell, see its map grow, and how it compares with the true cell.

    Starts a kernel of its own and ends it; with --address the cell replaces the world of a kernel that runs already.
    """
    if save is not None and save.suffix not in ((".npz",) if ultrasonic else (".npz", ".bt", ".ot")):
        raise click.UsageError(f"--save takes a name that ends in .npz{'' if ultrasonic else ', .bt or .ot'}")
    if save is not None and not save.parent.is_dir():
        raise click.UsageError(f"--save: there is no folder {save.parent}")
    from virtualrobot_apps.demos.mapping import map_cell as app
    from virtualrobot_apps.demos.mapping import octree_map

    if not ultrasonic:
        octree_map.library()  # before a kernel is started for nothing
    with in_kernel(target, headless, speed) as client:
        app.main(client, ultrasonic, resolution or 0.0, model, save, headless)
