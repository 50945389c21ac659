"""`virtualrobot program`: programs of the kernel, and curves of CAD files, in the languages of controllers."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click
from virtualrobot.cli.options import Target, target_options

from virtualrobot_apps.curves.command import curves
from virtualrobot_apps.languages.writers.options import LANGUAGES, language_options, wanted, write

if TYPE_CHECKING:
    from virtualrobot_apps.languages.writers.statements import Value

_EXAMPLES = """
\b
Examples:
  virtualrobot program export cell.yaml --as rapid
  virtualrobot program export cell.yaml --as krl --signal 'gripper=$OUT[1]' --tool-state closed=gripper
  virtualrobot program export cell.yaml --as urscript --signal "gripper=standard_out[0]" -o cell.script
  virtualrobot program import cell.mod --robot arm -o again.yaml
  virtualrobot program curves hood.vda --as rapid --curve C1 --tool-axis 0,0,-1 --speed 0.05
"""


@click.group(
    epilog=_EXAMPLES, short_help="Write programs, or curves of CAD files, in a controller's language; read RAPID."
)
@target_options
@click.pass_context
def program(ctx: click.Context, target: Target) -> None:
    """Programs of the kernel (YAML) in the languages of robots' controllers."""
    ctx.obj = target


program.add_command(curves)


@program.command()
@click.argument("file", metavar="FILE", type=click.Path(path_type=Path))
@language_options(required=True)
@click.option(
    "--signal",
    "signals",
    multiple=True,
    metavar="NAME=ADDRESS",
    help="Where a signal is on the controller: standard_out[0], $OUT[1], DO[1], or its name in RAPID.",
)
@click.option(
    "--tool-state",
    "tool_states",
    multiple=True,
    metavar="STATE=SIGNAL[:VALUE]",
    help="The signal, and its value [on], that brings the tool into a state.",
)
@target_options
def export(
    target: Target,
    file: Path,
    language: str,
    robot: str | None,
    output: Path | None,
    signals: tuple[str, ...],
    tool_states: tuple[str, ...],
    signs: str | None,
    coupling: float,
) -> int:
    """Write the program in FILE in the language of a controller.

    It begins where the robot stands now. Repeats, calls, patterns, picks and places become the steps that they stand
    for. What the language can't tell is refused by the step's place; nothing moves.
    """
    from virtualrobot_apps.languages.core.command import only_robot
    from virtualrobot_apps.languages.writers.resolve import robot_program

    of_tool = {state: _value(told) for state, told in map(_pair, tool_states)}
    facts = wanted(dict(map(_pair, signals)), signs, coupling)
    with target.connect() as client:
        read = client.read_program(file)
        named = _robots(json.loads(read.text))
        name = only_robot(client, named.pop() if robot is None and len(named) == 1 else robot)
        resolved = robot_program(client, read, client.robot(name), file.stem, of_tool)
    write(resolved, language, facts, output or file.with_suffix(LANGUAGES[language]))
    return 0


@program.command("import")
@click.argument("files", nargs=-1, required=True, metavar="FILE...", type=click.Path(path_type=Path))
@click.option("--robot", metavar="NAME", help="The arm that it moves [the only robot].")
@click.option("--routine", default="main", show_default=True, help="The procedure that it begins with.")
@click.option("-o", "--output", type=click.Path(path_type=Path), metavar="FILE", help="Where to [FILE's name, .yaml].")
@target_options
def import_(target: Target, files: tuple[Path, ...], robot: str | None, routine: str, output: Path | None) -> int:
    """Write what a program in RAPID gives the arm as a program of the kernel; nothing moves.

    It begins where the robot stands now, with the tool that it has. A program that looks at the world, by a signal
    that it reads or a search, is refused at its line.
    """
    import yaml

    from virtualrobot_apps.languages.core.command import faulty, only_robot
    from virtualrobot_apps.languages.core.diagnostics import ProgramError
    from virtualrobot_apps.languages.rapid.recording import recorded
    from virtualrobot_apps.languages.rapid.task import load_files

    with target.connect() as client:
        name = only_robot(client, robot)
        try:
            loaded = load_files(files, client.signals)
        except ProgramError as error:
            return faulty(error)
        found = recorded(client, name, loaded, routine, lambda note: click.echo(f"note: {note}", err=True), click.echo)
    where = output or files[0].with_suffix(".yaml")
    where.write_text(yaml.safe_dump(json.loads(found.text), sort_keys=False), encoding="utf-8")
    click.echo(f"{len(found)} steps in {where}")
    return 0


def _robots(told: object) -> set[str]:
    """Return the robots that a program names."""
    if isinstance(told, dict):
        robot = told.get("robot")
        return {robot} if isinstance(robot, str) else _robots(list(told.values()))
    return set[str]().union(*map(_robots, told)) if isinstance(told, list) else set()


def _pair(text: str) -> tuple[str, str]:
    """Return what stands before and after =."""
    before, _, after = text.partition("=")
    if not before or not after:
        raise click.UsageError(f"give a name and what it stands for, as gripper=DO[1], not {text!r}")
    return before, after


def _value(text: str) -> tuple[str, Value]:
    """Return a signal, and its value, on without one."""
    signal, _, value = text.partition(":")
    try:
        found = json.loads(value) if value else True
    except ValueError:
        found = None
    if not isinstance(found, bool | int | float):
        raise click.UsageError(f"a signal's value is true, false or a number, not {value!r}")
    return signal, found
