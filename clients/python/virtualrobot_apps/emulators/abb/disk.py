"""Disks of an emulated ABB controller: all of them are one folder."""

from __future__ import annotations

import re
from pathlib import Path

from virtualrobot_apps.emulators.abb.refused import Refused
from virtualrobot_apps.languages.core.files import FileRefused, below

DISKS = {"home": "HOME:", "temp": "TEMP:", "ramdisk": "RAMDISK:"}
"""Names of disks as a program of the controller writes them, by the variables that clients ask for."""


def place(folder: Path, name: str, *, bare: bool = False) -> Path:
    """Return the file of a name such as `$HOME/a.mod`, `HOME:/a.mod` or `/HOME:/a.mod`, always below the folder.

    `bare`: so is `HOME/a.mod`, as clients of Robot Web Services 2.0 write it.
    """
    named = f"|(?i:{'|'.join(DISKS)})" if bare else ""
    rest = re.sub(rf"^/*(\$\w+|\w+:{named})(?=/|$)", "", name.replace("\\", "/"))
    try:
        if ":" in rest or "\0" in rest:
            raise FileRefused(f"{name!r} has a colon or a NUL that is not after a disk")
        return below(folder, rest)
    except (FileRefused, OSError, ValueError) as error:
        raise Refused("INVALIDARG", str(error), 403 if isinstance(error, FileRefused) else 400) from None
