"""`virtualrobot walls`: what walls and rooms of walls show, as matrices for who draws, and as cameras of the world."""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import click
from virtualrobot.cli.options import Numbers, Target, target_options

if TYPE_CHECKING:
    from virtualrobot_apps.walls.head import Observer

_EXAMPLES = """
\b
Examples:
  virtualrobot walls cave.yaml --head 0.3,0,1.75,0,0,0.2
  virtualrobot walls cave.yaml --listen 127.0.0.1:7700 | my-renderer
  virtualrobot walls cave.yaml --cameras visitor
"""


@click.command(epilog=_EXAMPLES, short_help="Tell what walls before which people stand show, in stereo, too.")
@click.argument("file", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--head", type=Numbers(3, 6), metavar="X,Y,Z[,R,P,Y]", help="The head in the room, m and rad [as FILE].")
@click.option("--listen", metavar="HOST:PORT", help="Hear head and flystick by UDP there, until Ctrl-C.")
@click.option("--cameras", metavar="NAME", help="Add a frame of this name for the room, and a camera for each picture.")
@target_options
def walls(target: Target, file: Path, head: tuple[float, ...] | None, listen: str | None, cameras: str | None) -> None:
    """Print the pictures of the walls that FILE says, a line of JSON for each eye, for the head where it is.

    A line has wall, eye, viewport, projection and view (world to eye), both 4x4 row by row, as OpenGL has them.
    """
    from virtualrobot_apps.walls.cameras import add_cameras
    from virtualrobot_apps.walls.display import gaps
    from virtualrobot_apps.walls.display_file import read_display
    from virtualrobot_apps.walls.head import Listener, Observer

    if listen is not None and (head is not None or cameras is not None):
        raise click.UsageError("--listen hears where the head is; --head and --cameras are for one that stands")
    address = None if listen is None else _address(listen)
    observer = Observer(read_display(file))
    for said in gaps(observer.display):
        click.echo(said, err=True)
    if head is not None:
        from virtualrobot.geometry import pose

        observer.room_t_head = pose(*head)
    if address is None:
        _print(observer)
    else:
        # A head that is heard later may stand elsewhere.
        _show(observer)
    if cameras is not None:
        with target.connect() as client:
            added = add_cameras(client, observer, cameras)
        click.echo(f"added: {', '.join(added)}", err=True)
    if address is not None:
        with Listener(*address) as listener, suppress(KeyboardInterrupt):
            click.echo(f"hearing at {address[0]}:{listener.port}", err=True)
            while True:
                listener.listen(observer, lambda: _show(observer), lambda said: click.echo(said, err=True))


def _address(words: str) -> tuple[str, int]:
    host, separator, port = words.rpartition(":")
    if not separator or not host or not port.isdecimal() or int(port) > 65535:
        raise click.UsageError(f"{words!r} is no address such as 127.0.0.1:7700")
    return host, int(port)


def _show(observer: Observer) -> None:
    """Print the pictures, or say why there are none for this head."""
    from virtualrobot.errors import InvalidArgumentError

    try:
        _print(observer)
    except InvalidArgumentError as error:
        click.echo(str(error), err=True)


def _print(observer: Observer) -> None:
    """Print a line for each picture."""
    import numpy as np

    from virtualrobot_apps.walls.display import views

    room_t_world = np.linalg.inv(observer.world_t_room)
    lines = [
        {
            "wall": one.wall,
            "eye": one.eye,
            "viewport": one.viewport,
            "projection": one.frustum.projection.ravel().tolist(),
            "view": (one.frustum.view @ room_t_world).ravel().tolist(),
        }
        for one in views(observer.display, observer.room_t_head)
    ]
    click.echo("\n".join(map(json.dumps, lines)))
