"""`virtualrobot new`: writes a ready cell, as a start for your own."""

from __future__ import annotations

from pathlib import Path

import click

from virtualrobot_apps.new.writing import Folder, write

CELLS = Path(__file__).parent / "cells"
"""Folder with a folder for each cell: its files are copied as they are."""


def names() -> list[str]:
    """Return the names of the cells."""
    return sorted(cell.name for cell in CELLS.iterdir() if (cell / "cell.yaml").exists())


def about(name: str) -> str:
    """Return what a cell is, in one line: the first of its scene file."""
    return (CELLS / name / "cell.yaml").read_text("utf-8").partition("\n")[0].removeprefix("# ")


@click.command(short_help="Write a ready cell: a scene, a program and a test.")
@click.argument("cell", type=click.Choice(names()), required=False)
@click.argument("folder", type=Folder(), required=False)
def new(cell: str | None, folder: Path | None) -> None:
    """Write the ready CELL into FOLDER: a scene, a program and a test that pass as they are; without CELL list all.

    FOLDER is called as the cell by default. No kernel is needed.
    """
    if cell is None:
        click.echo("\n".join(f"{name:<16}  {about(name)}" for name in names()))
        return
    files = write([CELLS / cell], folder or Path(cell))
    where = files[0].parent
    click.echo(f"written: {', '.join(file.name for file in files)} in {where}")
    click.echo(f"See it:   virtualrobot serve {where / 'cell.yaml'}")
    click.echo(f"Test it:  python -m pytest {where}")
    click.echo(f"More is told in {where / 'README.md'}.")
