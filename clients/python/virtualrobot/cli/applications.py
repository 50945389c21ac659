"""Commands of applications, found by entry points: each a name and a `click.Command`."""

from __future__ import annotations

from collections.abc import Container
from importlib.metadata import EntryPoint, entry_points

import click

from virtualrobot.errors import VirtualRobotError, WrongStateError

GROUP = "virtualrobot.commands"


def find_applications(taken: Container[str]) -> dict[str, EntryPoint]:
    """Return the commands of installed applications by name: those that come with this library, then by package.

    A name belongs to the first that has it, and none of those that are `taken` is among them.
    """
    found = sorted(entry_points(group=GROUP), key=lambda entry: (package(entry) != "virtualrobot", package(entry)))
    by_name: dict[str, EntryPoint] = {}
    for entry in found:
        if entry.name not in taken:
            by_name.setdefault(entry.name, entry)
    return by_name


def package(entry: EntryPoint) -> str:
    """Return the name of the installed package that has an entry point."""
    return entry.dist.name if entry.dist is not None else ""


def load(entry: EntryPoint) -> click.Command:
    """Return the command of an entry point.

    Raises:
        WrongStateError: when it cannot be imported, or is no command: nobody else's suffers from it.
    """
    try:
        command = entry.load()
        if not isinstance(command, click.Command):
            raise TypeError(f"{entry.value} is no click command but {command!r}")
    except (Exception, SystemExit) as error:
        said = f"the command {entry.name!r} of the package {package(entry)!r} cannot be loaded"
        raise WrongStateError(f"{said}: {type(error).__name__}: {error}") from error
    return command


def short_help(entry: EntryPoint) -> str:
    """Return the line of help of an entry point's command, or why there is none."""
    try:
        return load(entry).get_short_help_str(limit=80)
    except VirtualRobotError as error:
        return str(error)
