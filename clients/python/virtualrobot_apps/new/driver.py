"""`virtualrobot driver`: real robots connected, and `new`, which writes a driver as a start for your own."""

from __future__ import annotations

import importlib.util
import keyword
import re
from pathlib import Path

import click
from virtualrobot.cli.drivers import CONNECTING

from virtualrobot_apps.new.writing import Folder, write

DRIVERS = Path(__file__).parent / "drivers"
"""Folder with what all drivers begin with (`common`), and a folder for each pace."""
BUNDLED = ("abb_egm", "crs", "dynamixel", "kuka_rsi", "loopback", "ros_trajectory", "serial_line", "ur_rtde")
"""Names of the bundled drivers, which no other may have."""
_NAME = re.compile(r"[a-z][a-z0-9_]*")


class _Name(click.ParamType):
    """The name of a driver, which is that of its module too."""

    name = "name"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the name; raise BadParameter where it can be no module's, or is one's that is there."""
        name = str(value)
        if not _NAME.fullmatch(name) or keyword.iskeyword(name):
            self.fail(f"{name!r} is no name; it is made of small letters, digits and _, a letter first", param, ctx)
        if name == "board" or importlib.util.find_spec(name) is not None:
            self.fail(f"there is a module {name!r} already; take another name", param, ctx)
        if name in BUNDLED:
            self.fail(f"{name!r} is a bundled driver; take another name", param, ctx)
        return name


@click.group()
def driver() -> None:
    """Drivers of real robots."""


for command in CONNECTING:
    driver.add_command(command)


@driver.command(short_help="Write a driver of your own: a plugin with its test.")
@click.argument("name", type=_Name())
@click.argument("folder", type=Folder(), required=False)
@click.option(
    "--pace",
    type=click.Choice(["host", "jobs"]),
    default="host",
    help="Its controller follows setpoints (host, the default), or plans by itself (jobs).",
)
def new(name: str, folder: Path | None, pace: str) -> None:
    """Write the driver NAME into FOLDER: a package with the driver, a board that is computed, and a test that passes.

    FOLDER is called as the driver by default. No kernel is needed.
    """
    words = {
        "my_robot": name,
        "my-robot": name.replace("_", "-"),
        "MyRobot": "".join(part.capitalize() for part in name.split("_")),
    }
    files = write([DRIVERS / "common", DRIVERS / pace], folder or Path(name), words)
    where = files[0].parent
    click.echo(f"written: {', '.join(file.name for file in files)} in {where}")
    click.echo(f"Test it:     python -m pytest {where}")
    click.echo(f"Install it:  pip install -e {where}")
    click.echo(f"More is told in {where / 'README.md'}.")
