"""`virtualrobot view`: from where the viewer, pictures and films look."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from virtualrobot.cli.names import NODE, VIEWPOINT
from virtualrobot.cli.options import FiniteRange, Numbers, Target, target_options
from virtualrobot.cli.pictures import PlaceType, three

if TYPE_CHECKING:
    from virtualrobot.connection import Client
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
@click.option("--saved", type=VIEWPOINT, metavar="NAME", help="From this viewpoint of the scene, along with it.")
@click.option("--follow", type=NODE, metavar="NODE", help="Go along with this node from then on; 'world': with none.")
@click.option("--turn", is_flag=True, help="Turn with the node of --follow, too.")
@click.option("--save", metavar="NAME", help="Save from where it looks then as a viewpoint of the scene.")
@click.option("--list", "listing", is_flag=True, help="Tell the viewpoints of the scene.")
@target_options
def view(
    target: Target,
    side: str | None,
    eye: tuple[float, ...] | None,
    place: Place | None,
    distance: float | None,
    saved: str | None,
    follow: str | None,
    turn: bool,
    save: str | None,
    listing: bool,
) -> None:
    """Show from where the viewer, pictures and films look, or set it: a SIDE, a point by --from, or what is --saved."""
    if eye is not None and (side is not None or distance is not None):
        raise click.UsageError("--from says all of where it is looked from: give neither a side nor --distance with it")
    is_placed = bool(side or eye or place or distance)
    if saved is not None and is_placed:
        raise click.UsageError("--saved says all of where it is looked from: give nothing else of that with it")
    if turn and follow is None:
        raise click.UsageError("--turn needs --follow")
    with target.connect() as client:
        if listing:
            for name, one in client.scene.viewpoints().items():
                click.echo(f"{name} in {one.parent}")
            return
        if saved is not None:
            client.view.look_from(saved)
        elif is_placed:
            _place(client, side, eye, place, distance)
        if follow is not None:
            client.view.follow(follow, turns=turn)
        if save is not None:
            click.echo(f"saved {client.view.save(save).name}")
        found = client.view.eye_and_target()
        along = client.view.read().camera_node
    if found is None:
        click.echo("the world is framed")
    else:
        eye_words, at_words = (three(point.round(9)) for point in found)  # no -0.0000
        click.echo(f"from {eye_words} at {at_words}{f', along with {along}' if along else ''}")


def _place(
    client: Client, side: str | None, eye: tuple[float, ...] | None, place: Place | None, distance: float | None
) -> None:
    """Look from a side or a point; what is not given stays as it is, but that the view goes along with nothing."""
    import numpy as np

    found = client.view.eye_and_target()
    at = np.zeros(3) if found is None else found[1]
    away = None if found is None else found[0] - found[1]
    if place is not None:
        at = client.view.measure(("world", (0.0, 0.0, 0.0)), place).second
    if eye is None:
        direction = np.array(SIDES[side]) if side else np.array(SIDES["iso"]) if away is None else away
        meters = distance or (USUAL_METERS if away is None else float(np.linalg.norm(away)))
        eye = tuple(at + direction / np.linalg.norm(direction) * meters)
    client.view.set_camera(eye, at, client.view.read().field_of_view)
