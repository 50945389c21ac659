"""Writing of what `new` commands begin with: files that are copied, under other names where they are asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import click


def write(sources: Sequence[Path], folder: Path, names: Mapping[str, str] | None = None) -> list[Path]:
    """Copy the files of folders into one, which is made; return them.

    Args:
        sources: folders; of files of the same name the last one counts.
        folder: must not be there, or be empty.
        names: what each word becomes, in the files and in their names.

    Raises:
        UsageError: when there is something in the folder.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise click.UsageError(f"{folder} is there already; give the name of a new folder")
    folder.mkdir(parents=True, exist_ok=True)

    def renamed(text: str) -> str:
        for word, name in (names or {}).items():
            text = text.replace(word, name)
        return text

    files = {renamed(file.name): file for source in sources for file in source.iterdir() if file.is_file()}
    for name, file in files.items():
        (folder / name).write_bytes(renamed(file.read_text("utf-8")).encode() if names else file.read_bytes())
    return [folder / name for name in sorted(files)]


class Folder(click.Path):
    """A folder with a name; an empty word would be the folder that one stands in."""

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """Return the path; raise BadParameter for an empty word."""
        if value == "":
            self.fail("the name of the folder is empty; leave it out for one of the usual name", param, ctx)
        return Path(str(value))
