"""`virtualrobot sensor show` and `hide`: what viewers show of sensors."""

from __future__ import annotations

import click

from virtualrobot.cli.options import Target, target_options

_EXAMPLES = """
\b
Examples:
  virtualrobot sensor show lidar
  virtualrobot sensor show lidar --rays --by intensity
  virtualrobot sensor show eye --image
  virtualrobot sensor hide
"""


@click.command(epilog=_EXAMPLES)
@click.argument("name")
@click.option("--points", is_flag=True, help="The echoes of a range sensor as points.")
@click.option("--rays", is_flag=True, help="Its beams as lines.")
@click.option("--by", type=click.Choice(["distance", "intensity"]), default="distance", help="What gives the colour.")
@click.option("--frustum", is_flag=True, help="The pyramid that a camera sees.")
@click.option("--image", is_flag=True, help="Its latest picture, in the pyramid.")
@target_options
def show(target: Target, name: str, points: bool, rays: bool, by: str, frustum: bool, image: bool) -> None:
    """Show what the sensor NAME says, in every open viewer; without options its points, or its pyramid and picture."""
    if not (points or rays or frustum or image):
        points = frustum = image = True
    with target.connect() as client:
        client.view.show_sensor(name, points=points, rays=rays, color_by=by, frustum=frustum, image=image)


@click.command()
@click.argument("names", nargs=-1)
@target_options
def hide(target: Target, names: tuple[str, ...]) -> None:
    """Show nothing of the sensors NAMES, or of none."""
    with target.connect() as client:
        client.view.hide_sensor(*names)
