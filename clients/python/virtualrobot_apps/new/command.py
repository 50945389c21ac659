"""`virtualrobot new`: writes a ready cell, as a start for your own."""

from __future__ import annotations

import shutil
from pathlib import Path

import click

CELLS = Path(__file__).parent / "cells"
"""Folder with a folder for each cell: its files are copied as they are."""


def names() -> list[str]:
    """Return the names of the cells."""
    return sorted(cell.name for cell in CELLS.iterdir() if (cell / "cell.yaml").exists())


def about(name: str) -> str:
    """Return what a cell is, in one line: the first of its scene file."""
    return (CELLS / name / "cell.yaml").read_text("utf-8").partition("\n")[0].removeprefix("# ")


def write(name: str, folder: Path) -> list[Path]:
    """Copy the files of a cell into a folder, which is made; return them.

    Raises:
        UsageError: when there is something in the folder.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise click.UsageError(f"{folder} is there already; give the name of a new folder")
    folder.mkdir(parents=True, exist_ok=True)
    files = sorted(file for file in (CELLS / name).iterdir() if file.is_file())
    return [Path(shutil.copyfile(file, folder / file.name)) for file in files]


class _Folder(click.Path):
    """A folder with a name; an empty word would be the folder that one stands in."""

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """Return the path; raise BadParameter for an empty word."""
        if value == "":
            self.fail("the name of the folder is empty; leave it out for a folder called as the cell", param, ctx)
        return Path(str(value))


@click.command(short_help="Write a ready cell: a scene, a program and a test.")
@click.argument("cell", type=click.Choice(names()), required=False)
@click.argument("folder", type=_Folder(), required=False)
def new(cell: str | None, folder: Path | None) -> None:
    """Write the ready CELL into FOLDER: a scene, a program and a test that pass as they are; without CELL list all.

    FOLDER is called as the cell by default. No kernel is needed.
    """
    if cell is None:
        click.echo("\n".join(f"{name:<16}  {about(name)}" for name in names()))
        return
    files = write(cell, folder or Path(cell))
    where = files[0].parent
    click.echo(f"written: {', '.join(file.name for file in files)} in {where}")
    click.echo(f"See it:   virtualrobot serve {where / 'cell.yaml'}")
    click.echo(f"Test it:  python -m pytest {where}")
    click.echo(f"More is told in {where / 'README.md'}.")
