"""`virtualrobot plugins` and `kinematics`: which components there are, and which one a robot has."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import click

from virtualrobot.cli.names import ROBOT
from virtualrobot.cli.options import Target, target_options
from virtualrobot.cli.settings import settings_from, settings_lines, settings_option

if TYPE_CHECKING:
    from virtualrobot.plugins import Component, ComponentUse, Plugin
    from virtualrobot.robots.robot import Robot


_EXAMPLES = """
\b
Examples; 'virtualrobot plugins --settings' shows the components and their settings:
  virtualrobot kinematics arm
  virtualrobot kinematics arm chain
"""


@click.command()
@click.option("--reload", is_flag=True, help="Look for plugins that were installed since the kernel's start.")
@click.option("--settings", is_flag=True, help="Show the settings of each component too.")
@target_options
def plugins(target: Target, reload: bool, settings: bool) -> None:
    """Show the kernel's plugins and their components: where these run, who uses them, and what failed."""
    with target.connect() as client:
        found = client.plugins.reload() if reload else client.plugins.list()
    click.echo("\n".join(describe(found, settings)))


@click.command(epilog=_EXAMPLES)
@click.argument("robot", type=ROBOT)
@click.argument("component", required=False)
@settings_option
@target_options
def kinematics(target: Target, robot: str, component: str | None, values: tuple[str, ...]) -> None:
    """Show which component solves the kinematics of ROBOT, or give it COMPONENT.

    With --set alone the robot's own component is made anew with these settings. The component is tried on the robot
    first; the numbers of that check are printed.
    """
    with target.connect() as client:
        handle = client.robot(robot)
        if component is None and not values:
            click.echo("\n".join(_chosen(handle)))
            return
        name = component or handle.kinematics
        schemas = {known.name: known.settings_schema for known in client.plugins.components("kinematics")}
        # An unknown name is refused by the kernel, which tells the right ones.
        click.echo(repr(handle.set_kinematics(name, settings_from(values, schemas.get(name, {})))))


def describe(found: Sequence[Plugin], settings: bool) -> Iterator[str]:
    """Yield plugins and their components as lines."""
    from virtualrobot.tables import aligned

    components = [(plugin, component) for plugin in found for component in plugin.components]
    # One table, so that the columns of all plugins are alike.
    lines = aligned([_row(component) for _, component in components], left=5) if components else []
    line_of = {id(component): line for (_, component), line in zip(components, lines, strict=True)}
    for plugin in found:
        state = "loaded" if plugin.ok else f"{plugin.state}: {plugin.reason}"
        yield f"{plugin.name} {plugin.version} ({plugin.package})  {state}"
        for component in plugin.components:
            yield f"  {line_of[id(component)]}"
            for use in component.uses:
                yield f"    {_used(use)}"
            if settings:
                yield from (f"    {line}" for line in settings_lines(component.settings_schema))


def _row(component: Component) -> list[str]:
    where = component.isolation.replace("_", " ")
    if component.isolation == "process":
        where += f", {component.deadline:g} s a call"
    return [component.kind, component.name, where, " ".join(component.endings), component.description]


def _used(use: ComponentUse) -> str:
    calls = f"{use.calls} calls" + (f" of {1e3 * use.mean_call_time:.3f} ms" if use.calls else "")
    whom = f"{use.robot}, group {use.group}" if use.group else use.robot or use.sensor
    words = [f"for {whom}: {calls}" if whom else calls]
    words += [f"process {use.process_id}"] if use.process_id else []
    words += [f"not asked any more: {use.fault}"] if use.fault else []
    return ", ".join(words)


def _chosen(robot: Robot) -> Iterator[str]:
    """Yield which component a robot has, with its settings, as lines."""
    from virtualrobot.cli.settings import shown

    yield robot.kinematics
    yield from (f"  {name} = {shown(value)}" for name, value in robot.kinematics_settings.items())
    if robot.kinematics_fault:
        yield f"  not asked any more: {robot.kinematics_fault}"
