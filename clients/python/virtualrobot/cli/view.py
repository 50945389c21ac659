"""`virtualrobot view`: from where the viewer, pictures and films look."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from virtualrobot.cli.options import FiniteRange, Numbers, Target, target_options
from virtualrobot.cli.pictures import PlaceType, three

if TYPE_CHECKING:
    import numpy as np

    from virtualrobot.view.measuring import Place

SIDES = {
    "front": (0.0, -1.0, 0.0),
    "back": (0.0, 1.0, 0.0),
    "left": (-1.0, 0.0, 0.0),
    "right": (1.0, 0.0, 0.0),
    "top": (0.0, 0.0, 1.0),
    "bottom": (0.0, 0.0, -1.0),
    "iso": (0.62, -0.78, 0.5),
}
"""Directions from what is looked at to the eye, in the world's frame; the console's page has the same."""

USUAL_METERS = 3.0
"""Distance where nothing says another one."""


@click.command()
@click.argument("side", required=False, type=click.Choice(list(SIDES)))
@click.option("--from", "eye", type=Numbers(3), metavar="X,Y,Z", help="Where it is looked from, in meters.")
@click.option("--at", "place", type=PlaceType(), metavar="PLACE", help="What is looked at [what is now].")
@click.option(
    "--distance", type=FiniteRange(min=0.0, min_open=True), metavar="METERS", help="How far away [as far as now]."
)
@target_options
def view(
    target: Target, side: str | None, eye: tuple[float, ...] | None, place: Place | None, distance: float | None
) -> None:
    """Show from where the viewer, pictures and films look, or set it: a SIDE, or a point by --from."""
    import numpy as np

    if eye is not None and (side is not None or distance is not None):
        raise click.UsageError("--from says all of where it is looked from: give neither a side nor --distance with it")
    with target.connect() as client:
        now = client.view.read()
        away = now.camera_position - now.camera_target
        is_set = bool(away.any())  # a camera at its own target is refused
        if not (side or eye or place or distance):
            click.echo(_words(now.camera_position, now.camera_target) if is_set else "the world is framed")
            return
        at = now.camera_target if place is None else client.view.measure(("world", (0.0, 0.0, 0.0)), place).second
        if eye is None:
            direction = np.array(SIDES[side]) if side else away if is_set else np.array(SIDES["iso"])
            meters = distance or (float(np.linalg.norm(away)) if is_set else USUAL_METERS)
            eye = tuple(at + direction / np.linalg.norm(direction) * meters)
        client.view.set_camera(eye, at, now.field_of_view)
        now = client.view.read()
    click.echo(_words(now.camera_position, now.camera_target))


def _words(eye: np.ndarray, at: np.ndarray) -> str:
    return f"from {three(eye)} at {three(at)}"
