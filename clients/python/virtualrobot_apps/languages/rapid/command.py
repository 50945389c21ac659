"""`virtualrobot rapid`: checks and runs programs in RAPID."""

from __future__ import annotations

import sys
from pathlib import Path

import click
from virtualrobot.cli.options import GO_ON, Target, target_options

_EXAMPLES = """
\b
Examples:
  virtualrobot rapid check palletize.mod
  virtualrobot rapid check main.mod tools.sys --signal doGripper --signal diPart
  virtualrobot rapid run palletize.mod --robot arm --create-signals
  virtualrobot rapid run log.mod --files log --answer yes
"""

_files = click.argument("files", nargs=-1, required=True, metavar="FILE...", type=click.Path(path_type=Path))
_signals = click.option("--signal", "signals", metavar="NAME", multiple=True, help="The world has this signal.")


@click.group(epilog=_EXAMPLES, short_help="Check and run programs in RAPID, the language of ABB's controllers.")
@target_options
@click.pass_context
def rapid(ctx: click.Context, target: Target) -> None:
    """Programs in RAPID, the language of ABB's controllers: modules in files, which together are one program."""
    ctx.obj = target


@rapid.command()
@_files
@_signals
@target_options
def check(target: Target, files: tuple[Path, ...], signals: tuple[str, ...]) -> int:
    """Tell what is wrong in the program that FILEs make together, with exit code 0 or 1; needs no kernel.

    Looked at are words, names, types and arguments, and whether all that is used works here.
    """
    from virtualrobot_apps.languages.core.diagnostics import ProgramError
    from virtualrobot_apps.languages.rapid.task import load_files

    try:
        program = load_files(files, signals)
    except ProgramError as error:
        for one in error.diagnostics:
            click.echo(str(one))
        click.echo(f"{len(error.diagnostics)} fault{'s' * (len(error.diagnostics) != 1)}")
        return 1
    counted = sum(len(scope.routines) for scope in program.checked.modules)
    named = ", ".join(sorted(use.name for use in program.signals.values()))
    click.echo(
        f"no fault in {counted} routine{'s' * (counted != 1)}" + (f"; signals of the world: {named}" if named else "")
    )
    return 0


@rapid.command()
@_files
@click.option("--robot", metavar="NAME", help="The arm that it moves [the only robot].")
@click.option("--routine", default="main", show_default=True, help="The procedure that it begins with.")
@click.option(
    "--listen",
    metavar="[ADDRESS]",
    is_flag=False,
    flag_value="127.0.0.1",
    help="Let its sockets listen, at this address [127.0.0.1]: whoever connects moves the robot.",
)
@click.option(
    "--files",
    "folder",
    metavar="FOLDER",
    type=click.Path(path_type=Path, exists=True, file_okay=False),
    help="Let it use files, below this folder, whatever disk it names.",
)
@click.option(
    "--answer",
    "answers",
    metavar="TEXT",
    multiple=True,
    help="What is answered on the pendant, one after the other [lines of the standard input].",
)
@click.option("--create-signals", is_flag=True, help="Add the signals that it names and the world has not.")
@target_options
def run(
    target: Target,
    files: tuple[Path, ...],
    robot: str | None,
    routine: str,
    listen: str | None,
    folder: Path | None,
    answers: tuple[str, ...],
    create_signals: bool,
) -> int:
    """Run the program that FILEs make together, and show what it writes on its pendant; Ctrl-C stops it on its path.

    It is checked first, and nothing moves where something is wrong.
    """
    from virtualrobot_apps.languages.rapid.symbols import first_value
    from virtualrobot_apps.languages.rapid.task import RapidTask, load_files
    from virtualrobot_apps.languages.rapid.world import World

    with target.connect() as client:
        if robot is None:
            names = [one.name for one in client.robots()]
            if len(names) != 1:
                raise click.UsageError(f"name the arm by --robot; there are {', '.join(names) or 'none'}")
            robot = names[0]
        known = {name.lower() for name in client.signals}
        program = load_files(files, list(client.signals))
        if create_signals:
            for lower, use in program.signals.items():
                if lower not in known:
                    client.signals.create(use.name, first_value(use))
        if client.clock.mode == "stepped":
            click.echo(f"time stands still: the program goes on with each 'virtualrobot step'; {GO_ON}", err=True)
        world = World(client, robot, lambda note: click.echo(f"note: {note}", err=True))
        try:
            answered = answers or sys.stdin
            RapidTask(program, world, click.echo, listen, files=folder, answers=answered).run(routine)
        except KeyboardInterrupt:
            click.echo("stopped", err=True)
            raise click.exceptions.Exit(130) from None
    return 0
