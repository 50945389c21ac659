"""Command `virtualrobot repair`: a project folder whose journal is damaged."""

from __future__ import annotations

from pathlib import Path

import click

from virtualrobot.cli.serve import kernel_program


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
def repair(folder: Path) -> None:
    """Make the journal of the project FOLDER anew of all that can be read of it, when it is damaged.

    The world goes back to the last change before which none is missing. What is lost is told; the damaged files are
    kept as they are, in a folder beside. A journal that is sound is left alone.
    """
    click.echo(kernel_program("repair")(folder))
