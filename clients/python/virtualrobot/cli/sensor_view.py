"""`virtualrobot sensor show` and `hide`: what viewers show of sensors."""

from __future__ import annotations

import click

from virtualrobot.cli.names import SENSOR
from virtualrobot.cli.options import Target, target_options

_EXAMPLES = """
\b
Examples:
  virtualrobot sensor show lidar
  virtualrobot sensor show lidar --rays --by intensity
  virtualrobot sensor show eye --image
  virtualrobot sensor hide
"""


SHOWN = {"range_sensor": ("--points", "--rays"), "camera_sensor": ("--frustum", "--image")}
"""Options of the command that show something, by kind of sensor."""


@click.command(epilog=_EXAMPLES)
@click.argument("name", type=SENSOR)
@click.option("--points", is_flag=True, help="The echoes of a range sensor as points.")
@click.option("--rays", is_flag=True, help="Its beams as lines.")
@click.option("--by", type=click.Choice(["distance", "intensity"]), default="distance", help="What gives the colour.")
@click.option("--frustum", is_flag=True, help="The pyramid that a camera sees.")
@click.option("--image", is_flag=True, help="Its latest picture, in the pyramid.")
@target_options
def show(target: Target, name: str, points: bool, rays: bool, by: str, frustum: bool, image: bool) -> None:
    """Show what the sensor NAME says, in every open viewer; without options its points, or its pyramid and picture."""
    given = {"--points": points, "--rays": rays, "--frustum": frustum, "--image": image}
    if not any(given.values()):
        points = frustum = image = True
    with target.connect() as client:
        kind = client.sensors[name].status.kind
        if kind not in SHOWN:
            raise click.UsageError(f"{name!r} is a {kind}; range sensors and cameras can be shown")
        for option, wanted in given.items():
            if wanted and option not in SHOWN[kind]:
                raise click.UsageError(f"{option} says nothing of a {kind}; give {' or '.join(SHOWN[kind])}")
        client.view.show_sensor(name, points=points, rays=rays, color_by=by, frustum=frustum, image=image)


@click.command()
@click.argument("names", nargs=-1, type=SENSOR)
@target_options
def hide(target: Target, names: tuple[str, ...]) -> None:
    """Show the sensors NAMES (or all) no longer."""
    with target.connect() as client:
        client.view.hide_sensor(*names)
