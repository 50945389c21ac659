"""Names as arguments of commands: robots, nodes, signals, sensors and models; they complete from the kernel."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

import click
from click.shell_completion import CompletionItem

from virtualrobot.cli.options import Target
from virtualrobot.errors import VirtualRobotError

if TYPE_CHECKING:
    from virtualrobot.connection import Client


class Name(click.ParamType):
    """Name of something in the kernel; not empty, and whether there is such a thing the kernel tells."""

    def __init__(self, name: str, known: Callable[[Client], Iterable[str]]) -> None:
        """Complete names from those that are `known`."""
        self.name = name
        self._known = known

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the name."""
        if not value.strip():
            self.fail(f"is empty; give the name of a {self.name}", param, ctx)
        return value

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        """Return the names that begin so; none where no kernel answers."""
        target = ctx.find_object(Target) or Target(ctx.params.get("address"), ctx.params.get("token_file"))
        try:
            with target.connect() as client:
                return [CompletionItem(name) for name in self._known(client) if name.startswith(incomplete)]
        except (VirtualRobotError, OSError):
            return []


class File(Name):
    """Path of a file, or a model by its name."""

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        """Return models once their prefix is typed, and leave files to the shell before."""
        if incomplete.startswith(MODEL):
            return super().shell_complete(ctx, param, incomplete)
        return [CompletionItem(incomplete, type="file"), CompletionItem(MODEL)]


MODEL = "model://"
"""Prefix of models that the kernel knows by name."""


def _nodes(client: Client) -> Iterable[str]:
    return (node.name for node in client.scene.nodes())


def _planners(client: Client) -> Iterable[str]:
    from virtualrobot.motions.paths import PLANNERS

    return PLANNERS


ROBOT = Name("robot", lambda client: (robot.name for robot in client.robots()))
NODE = Name("node", _nodes)
SIGNAL = Name("signal", lambda client: client.signals)
SENSOR = Name("sensor", lambda client: (status.name for status in client.sensors.statuses()))
PART = Name("part", lambda client: (node.name for node in client.scene.nodes() if node.kind == "part"))
TARGET = Name(
    "posture or target",
    lambda client: (*client.targets, *(name for robot in client.robots() for name in robot.postures)),
)
VIEWPOINT = Name("viewpoint", lambda client: client.scene.viewpoints())
TOOL = Name("tool", lambda client: (tool for robot in client.robots() for tool in robot.tools))
GROUP = Name("group", lambda client: (group for robot in client.robots() for group in robot.groups))
LINK = Name("link", lambda client: (link for robot in client.robots() for link in robot.links))
CHECKPOINT = Name("checkpoint", lambda client: client.history.checkpoints)
PLANNER = Name("planner", _planners)
FILE = Name("file", lambda client: ())
SOURCE = File("file", lambda client: (MODEL + model.name for model in client.models()))
