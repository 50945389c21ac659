"""Files of programs: all below one folder, which whoever starts the program has named."""

from __future__ import annotations

from pathlib import Path


class FileRefused(Exception):
    """A name leads out of the folder."""


def below(folder: Path, name: str) -> Path:
    """Return the file of a name such as `HOME:/log/day.txt`: below the folder, whatever the disk before the colon.

    Raises FileRefused where it leads out of the folder, also by links.
    """
    disk, colon, rest = name.replace("\\", "/").rpartition(":")
    place = (folder / (rest if colon else disk or rest).strip("/")).resolve()
    if not place.is_relative_to(folder.resolve()):
        raise FileRefused(f"{name!r} leads out of {folder}")
    return place
