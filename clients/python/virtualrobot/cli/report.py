"""Command `virtualrobot report`: what a report of a fault needs, in one file."""

from __future__ import annotations

from pathlib import Path

import click

from virtualrobot.cli.options import Target, target_options
from virtualrobot.cli.serve import kernel_program


@click.command()
@click.argument("archive", type=click.Path(dir_okay=False, path_type=Path))
@click.option(
    "--data",
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    help="Of this project folder, on this machine, instead of a kernel that runs.",
)
@target_options
def report(target: Target, archive: Path, data: Path | None) -> None:
    """Write scene, journal, versions, plugins and log to ARCHIVE, a zip file, which `virtualrobot replay` shows.

    It has no token. Look into it before you give it away: it has all that the cell is made of.
    """
    there = archive.exists()
    if data is not None:
        kernel_program("report")(data, archive)
    else:
        with target.connect() as client:
            client.report(archive)
    click.echo(f"{'replaced' if there else 'written'}: {archive} ({archive.stat().st_size / 1e6:.1f} MB)")
