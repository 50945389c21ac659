"""`virtualrobot load`, `save` and `ls`: the scene and its files."""

from __future__ import annotations

from pathlib import Path

import click

from virtualrobot.cli.options import Numbers, Target, degrees_option, named_folders, pose_of_numbers, target_options

_SCENE_ENDINGS = (".yaml", ".yml")


@click.command()
@click.argument("file")
@click.option("--name", default="", help="Its name in the scene [what the file says].")
@click.option("--at", type=Numbers(3, 6), metavar="X,Y,Z[,R,P,Y]", help="Where it goes in its parent's frame.")
@click.option("--parent", default="", help="The node that it is fixed to [world].")
@click.option("--as", "kind", type=click.Choice(["object", "part"]), default="object", help="For meshes: what it is.")
@click.option("--scale", type=Numbers(1, 3), default="1", help="For meshes: one factor or three.")
@click.option(
    "--base",
    type=click.Choice(["fixed", "floating", "planar"]),
    default="fixed",
    help="For robots: whether they may move as a whole.",
)
@click.option(
    "--package", "packages", multiple=True, callback=named_folders, metavar="NAME=FOLDER", help="Where a package is."
)
@click.option("--add", is_flag=True, help="For scene files: add to the world instead of replacing it.")
@degrees_option
@target_options
def load(
    target: Target,
    file: str,
    name: str,
    at: tuple[float, ...] | None,
    parent: str,
    kind: str,
    scale: tuple[float, ...],
    base: str,
    packages: dict[str, Path],
    add: bool,
    degrees: bool,
) -> None:
    """Load a model (URDF, STL, OBJ, DAE, glTF) or a scene file (YAML).

    FILE is a path or a URI such as package://pybullet_data/kuka_iiwa/model.urdf. It is sent to the kernel with all that
    it names.
    """
    is_scene = file.lower().endswith(_SCENE_ENDINGS)
    if is_scene and (name or at or parent):
        raise click.UsageError("--name, --at and --parent are for models; a scene file says where everything is")
    if add and not is_scene:
        raise click.UsageError("--add is for scene files; a model is always added")
    with target.connect() as client:
        if is_scene:
            names = client.scene.load_scene(file, add=add, packages=packages)
            click.echo(f"loaded {file}: {len(names)} nodes")
            return
        node = client.scene.load(
            file,
            name=name,
            pose=None if at is None else pose_of_numbers(at, degrees),
            parent=parent,
            packages=packages,
            base=base,
            as_part=kind == "part",
            scale=scale[0] if len(scale) == 1 else scale,
        )
        click.echo(f"loaded {node.kind} {node.name}")


@click.command()
@click.argument("file", type=click.Path(dir_okay=False, path_type=Path))
@click.option("--bundle", is_flag=True, help="Put the files that it names beside it, under assets/.")
@target_options
def save(target: Target, file: Path, bundle: bool) -> None:
    """Save the world to a scene file (YAML)."""
    with target.connect() as client:
        written = client.scene.save(file, bundle=bundle)
    assets = f" and {len(written) - 1} files under {file.parent / 'assets'}" if len(written) > 1 else ""
    click.echo(f"saved {file}{assets}")


@click.command()
@click.option("--links", is_flag=True, help="Show the links of robots too.")
@target_options
def ls(target: Target, links: bool) -> None:
    """Draw the scene tree with the kind of each node."""
    with target.connect() as client:
        click.echo(client.scene.tree(links))
