"""`virtualrobot model`."""

from __future__ import annotations

import sys
from pathlib import Path

import click
from virtualrobot.cli.names import NODE
from virtualrobot.cli.options import Numbers, Target, degrees_option, pose_of_numbers, target_options

_EXAMPLES = """
\b
Examples:
  virtualrobot model bracket bracket.solid --at 0.5,0,0 --watch
  virtualrobot model bracket > bracket.solid
"""


@click.command(epilog=_EXAMPLES, short_help="Give a node the shape that a text describes, or write that text.")
@click.argument("node")
@click.argument("file", required=False, type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--watch", is_flag=True, help="Do it again whenever FILE is saved, until Ctrl-C.")
@click.option("--part", is_flag=True, help="A new node is a part, which robots handle [environment].")
@click.option("--at", type=Numbers(3, 6), metavar="X,Y,Z[,R,P,Y]", help="Where a new node goes in its parent's frame.")
@click.option("--parent", type=NODE, default="world", help="The node that a new one is fixed to [world].")
@degrees_option
@target_options
def model(
    target: Target,
    node: str,
    file: Path | None,
    watch: bool,
    part: bool,
    at: tuple[float, ...] | None,
    parent: str,
    degrees: bool,
) -> None:
    """Give NODE the shape that FILE (.solid) describes, a new node or one that is there; its place stays.

    Without FILE the description that NODE was made by is written to the output, to be changed and given again.
    """
    from virtualrobot_apps.modeller import modelling

    if file is None and (watch or part or at is not None or parent != "world"):
        raise click.UsageError("--watch, --part, --at and --parent are for a FILE that NODE gets its shape of")
    if file is not None and file.suffix.lower() != modelling.ENDING:
        raise click.UsageError(f"{file} is no description of a body: its name ends with {modelling.ENDING}")
    with target.connect() as client:
        if file is None:
            sys.stdout.write(modelling.described(client, node).decode())
            return

        def change() -> None:
            pose = None if at is None else pose_of_numbers(at, degrees)
            modelling.shaped(client, node, file, part=part, pose=pose, parent=parent)
            (mesh,) = [one for one in client.collisions.meshes(node) if one.node == node]
            click.echo(f"{node}: {mesh.mesh_triangles} triangles{f', {mesh.warning}' if mesh.warning else ''}")

        if watch:
            modelling.follow(file, change, lambda said: click.echo(said, err=True))
        else:
            change()
