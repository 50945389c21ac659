"""`virtualrobot load`, `save`, `export`, `models` and `ls`: the scene and its files."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from virtualrobot.cli.names import FILE, NODE, SOURCE
from virtualrobot.cli.options import Numbers, Target, degrees_option, named_folders, pose_of_numbers, target_options
from virtualrobot.cli.recording import RECORDINGS, export_run, option_of, run_options
from virtualrobot.cli.settings import settings_from, settings_option

if TYPE_CHECKING:
    from virtualrobot.connection import Client

_SCENE_ENDINGS = (".yaml", ".yml")


@click.command()
@click.argument("file", type=SOURCE)
@click.option("--name", type=NODE, help="Its name in the scene [what the file says].")
@click.option("--at", type=Numbers(3, 6), metavar="X,Y,Z[,R,P,Y]", help="Where it goes in its parent's frame.")
@click.option("--parent", type=NODE, help="The node that it is fixed to [world].")
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
@click.option("--srdf", type=FILE, metavar="FILE", help="For robots: groups, postures and links that may touch.")
@settings_option
@click.option("--strict", is_flag=True, help="Refuse a file that there is a warning about.")
@click.option("--add", is_flag=True, help="For scene files: add to the world instead of replacing it.")
@degrees_option
@target_options
def load(
    target: Target,
    file: str,
    name: str | None,
    at: tuple[float, ...] | None,
    parent: str | None,
    kind: str,
    scale: tuple[float, ...],
    base: str,
    packages: dict[str, Path],
    srdf: str | None,
    values: tuple[str, ...],
    strict: bool,
    add: bool,
    degrees: bool,
) -> None:
    """Load a model (URDF, xacro, a mesh or what an importer reads) or a scene file (YAML).

    FILE is a path, a URI such as package://pybullet_data/kuka_iiwa/model.urdf, or model:// with a name that
    'virtualrobot models' shows. It is sent to the kernel with all that it names. --set gives the importer's settings,
    such as arguments.prefix=left_ for xacro.
    """
    is_scene = file.lower().endswith(_SCENE_ENDINGS)
    if is_scene and (name or at or parent or srdf or values):
        raise click.UsageError(
            "--name, --at, --parent, --srdf and --set are for models; a scene file says all that itself"
        )
    if add and not is_scene:
        raise click.UsageError("--add is for scene files; a model is always added")
    with target.connect() as client, _warnings_shown():
        if is_scene:
            names = client.scene.load_scene(file, add=add, packages=packages, strict=strict)
            click.echo(f"loaded {file}: {len(names)} nodes")
            _tell_allowed(client)
            return
        node = client.scene.load(
            file,
            name=name,
            pose=None if at is None else pose_of_numbers(at, degrees),
            parent=parent or "world",
            packages=packages,
            base=base,
            as_part=kind == "part",
            scale=scale[0] if len(scale) == 1 else scale,
            settings=settings_from(values, _importer_schema(client, file)) if values else None,
            srdf=srdf,
            strict=strict,
        )
        click.echo(f"loaded {node.kind} {node.name}")
        _tell_allowed(client)


def _tell_allowed(client: Client) -> None:
    """Show what touches as built, a line for each pair."""
    for pair in client.scene.allowed_pairs:
        click.echo(f"  {pair.first} and {pair.second} may touch: {pair.reason}")


@click.command()
@click.argument("file", type=click.Path(dir_okay=False, path_type=Path))
@click.option("--bundle", is_flag=True, help="Put the files that it names beside it, under assets/.")
@target_options
def save(target: Target, file: Path, bundle: bool) -> None:
    """Save the world to a scene file: FILE ends with .yaml or .yml."""
    if file.suffix.lower() not in _SCENE_ENDINGS:
        raise click.UsageError(f"a scene file ends with .yaml or .yml, for loading it again, got {str(file)!r}")
    with target.connect() as client:
        written = client.scene.save(file, bundle=bundle)
    assets = f" and {len(written) - 1} files under {file.parent / 'assets'}" if len(written) > 1 else ""
    click.echo(f"saved {file}{assets}")


@click.command()
@click.argument("source", type=NODE)
@click.argument("file", type=click.Path(dir_okay=False, path_type=Path))
@click.option("--tolerance", type=click.FloatRange(0.0), default=0.0, help="How far surfaces may be off, in meters.")
@run_options
@target_options
def export(
    target: Target,
    source: str,
    file: Path,
    tolerance: float,
    **options: Any,  # noqa: ANN401 those of recordings
) -> None:
    r"""Write a robot, what hangs below a node, or a run that is over, to FILE, whose ending says which.

    \b
    .urdf                   the robot SOURCE; meshes go beside it
    .glb, .usdz             all that hangs below the node SOURCE; below 'world' hangs the whole scene
    .mcap, .csv, .parquet,  what the project folder SOURCE tells of a run, from 'virtualrobot serve --data SOURCE';
    .glb, .html             the last two as an animated scene
    """
    is_run = file.suffix.lower() != ".glb" or Path(source, "project.json").is_file()
    if is_run and file.suffix.lower() in RECORDINGS:
        if tolerance:
            raise click.UsageError("--tolerance is for nodes, not for recordings")
        export_run(source, file, options)
        return
    for name in options:
        if options[name]:
            raise click.UsageError(
                f"{option_of(name)} is for recordings, not for {file.suffix or 'files without an ending'}"
            )
    node = source
    with target.connect() as client:
        exported = client.scene.export(node, file, tolerance=tolerance)
    for warning in exported.warnings:
        click.echo(f"warning: {warning}", err=True)
    beside = f" and {len(exported.files) - 1} files beside it" if len(exported.files) > 1 else ""
    click.echo(f"exported {node} to {file}{beside}")


@click.command()
@click.option("--search", default="", metavar="WORDS", help="Those with all these words in name, text, maker or kind.")
@click.option("--maker", default="", help="Those of this maker, such as KUKA.")
@target_options
def models(target: Target, search: str, maker: str) -> None:
    """Show the robots and grippers that the kernel knows by name; 'virtualrobot load model://NAME' loads one."""
    from virtualrobot.tables import aligned

    with target.connect() as client:
        known = client.models(search, maker=maker)
    heads = ["name", "model", "axes", "payload", "reach", "comes with"]
    rows = [
        [
            *(model.name, model.description, str(model.axes)),
            f"{model.payload:g} kg" if model.payload else "",
            f"{model.reach:g} m" if model.reach else "",
            model.package if model.installed else f"pip install {model.package}",
        ]
        for model in known
    ]
    click.echo("\n".join(aligned([heads, *rows], left=2)) if rows else "the kernel knows no such model")


@click.command()
@click.option("--links", is_flag=True, help="Show the links of robots too.")
@target_options
def ls(target: Target, links: bool) -> None:
    """Draw the scene tree with the kind of each node."""
    with target.connect() as client:
        click.echo(client.scene.tree(links))


@contextmanager
def _warnings_shown() -> Iterator[None]:
    """Show what the library logs about files."""

    class Shown(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            click.echo(f"warning: {record.getMessage()}", err=True)

    log, handler = logging.getLogger("virtualrobot.files.scene_files"), Shown(logging.INFO)
    level = log.level
    log.addHandler(handler)
    log.setLevel(logging.INFO)
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.setLevel(level)


def _importer_schema(client: Client, file: str) -> dict[str, Any]:
    """Return the schema of the settings of what imports a file; {} where nothing does."""
    uri = next((model.uri for model in client.models() if file == f"model://{model.name}"), file).lower()
    importers = client.plugins.components("importer")
    return next((one.settings_schema for one in importers if any(map(uri.endswith, one.endings))), {})
