"""`virtualrobot rapl`: checks and runs programs in RAPL-II."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click
from virtualrobot.cli.options import Target, target_options

from virtualrobot_apps.languages.core.command import at_work, faulty, only_robot, set_signals, told, trial_options

if TYPE_CHECKING:
    from virtualrobot import Client

    from virtualrobot_apps.languages.rapl.program import Loaded

_EXAMPLES = """
\b
Examples:
  virtualrobot rapl check pallet.rpl --locations pallet.loc
  virtualrobot rapl check pallet.rpl place.rpl --locations pallet.loc --run --robot arm --set input_1=on
  virtualrobot rapl run pallet.rpl place.rpl --locations pallet.loc --robot arm --create-signals
"""

_files = click.argument("files", nargs=-1, required=True, metavar="FILE...", type=click.Path(path_type=Path))
_locations = click.option(
    "--locations", metavar="FILE", type=click.Path(path_type=Path), help="The locations, as POINT types them."
)
_names = [
    click.option("--inputs", default="input_{}", show_default=True, metavar="NAME", help="The signal of input {}."),
    click.option("--outputs", default="output_{}", show_default=True, metavar="NAME", help="The signal of output {}."),
]
_pulses = click.option("--pulses", metavar="P1,P2,...", help="Pulses per degree of each joint [of the A255 or A465].")


@click.group(epilog=_EXAMPLES, short_help="Check and run programs in RAPL-II, the language of CRS controllers.")
@target_options
@click.pass_context
def rapl(ctx: click.Context, target: Target) -> None:
    """Programs in RAPL-II, the language of CRS controllers: numbered lines, a program a file, called as the file is."""
    ctx.obj = target


@rapl.command()
@_files
@_locations
@trial_options
@_names[0]
@_names[1]
@_pulses
@target_options
def check(
    target: Target,
    files: tuple[Path, ...],
    locations: Path | None,
    runs: bool,
    robot: str | None,
    given: tuple[str, ...],
    longest: float,
    times: bool,
    inputs: str,
    outputs: str,
    pulses: str | None,
) -> int:
    """Tell what is wrong in the programs of FILEs, with exit code 0 or 1; needs no kernel.

    Looked at are lines, commands and their arguments, and whether the lines, programs, locations and variables are
    there. With --run the first program is run, too, in a copy of a kernel's world: collisions, places out of reach,
    limits and singularities are told.
    """
    from virtualrobot_apps.languages.core.diagnostics import ProgramError
    from virtualrobot_apps.languages.rapl.program import load_files

    try:
        program = load_files(files, locations)
    except ProgramError as error:
        return faulty(error)
    lines = sum(len(one.statements) for one in program.programs.values())
    count = len(program.programs)
    click.echo(f"no fault in {lines} lines of {count} program{'s' * (count != 1)}: {', '.join(program.programs)}")
    if not runs:
        return 0
    from virtualrobot_apps.languages.core.trial import Trial, copied_world
    from virtualrobot_apps.languages.rapl.task import RaplTask
    from virtualrobot_apps.languages.rapl.world import World

    each = _checked(pulses, inputs, outputs)
    with target.connect() as live, copied_world(live) as client:
        name = only_robot(client, robot)
        _create_signals(client, program, name, inputs, outputs)
        set_signals(client, given)
        world = World(client, name, lambda note: click.echo(f"note: {note}", err=True), each)
        task = RaplTask(program, world, lambda _: None, lambda _: "", (inputs, outputs))
        trial = Trial(client, {task: world}, longest)
        trial.run(task.run)
        return told(trial, times)


def _checked(pulses: str | None, inputs: str, outputs: str) -> list[float]:
    """Return the pulses of each joint; raises UsageError where these or the names of signals can't be so."""
    for name in (inputs, outputs):
        if name.count("{}") != 1:
            raise click.UsageError(f"the name of inputs and outputs has {{}} where their number stands, not {name!r}")
    try:
        return [float(one) for one in pulses.split(",")] if pulses else []
    except ValueError:
        raise click.UsageError(f"--pulses takes numbers, as 200,200,200,44.44,22.22, not {pulses}") from None


def _create_signals(client: Client, program: Loaded, robot: str, inputs: str, outputs: str) -> None:
    """Add the inputs and outputs that a program names and the world has not, and a gripper's where the arm has none."""
    from virtualrobot_apps.languages.rapl.task import signals_of
    from virtualrobot_apps.languages.rapl.world import GRIPPER

    names = signals_of(program, inputs, outputs)
    if program.first_use("OPEN", "CLOSE") and not client.robot(robot).state.tool:
        names.append(GRIPPER)
    for name in names:
        if name not in client.signals:
            client.signals.create(name)


@rapl.command()
@_files
@_locations
@click.option("--robot", metavar="NAME", help="The arm that it moves [the only robot].")
@click.option("--program", default="", metavar="NAME", help="The program that it begins with [the first].")
@_names[0]
@_names[1]
@_pulses
@click.option("--create-signals", is_flag=True, help="Add inputs, outputs and a gripper that the world has not.")
@target_options
def run(
    target: Target,
    files: tuple[Path, ...],
    locations: Path | None,
    robot: str | None,
    program: str,
    inputs: str,
    outputs: str,
    pulses: str | None,
    create_signals: bool,
) -> int:
    """Run the programs of FILEs, and show what they show; Ctrl-C stops the arm on its path.

    They are checked first, and nothing moves where something is wrong.
    """
    from virtualrobot_apps.languages.core.pendant import NobodyAnswers, Pendant, Question
    from virtualrobot_apps.languages.core.published import Label, published
    from virtualrobot_apps.languages.rapl.faults import RaplFault
    from virtualrobot_apps.languages.rapl.program import load_files
    from virtualrobot_apps.languages.rapl.task import RaplTask
    from virtualrobot_apps.languages.rapl.world import World

    each = _checked(pulses, inputs, outputs)
    with target.connect() as client:
        robot = only_robot(client, robot)
        loaded = load_files(files, locations)
        if create_signals:
            _create_signals(client, loaded, robot, inputs, outputs)
        world = World(client, robot, lambda note: click.echo(f"note: {note}", err=True), each)
        pendant = Pendant(click.echo, sys.stdin)

        def asked(question: str) -> str:
            click.echo(f"{question} ", nl=False)
            try:
                return pendant.ask(task, Question(question)) or ""
            except NobodyAnswers:
                raise RaplFault(f"the program asks {question!r}, and nobody answers") from None

        task = RaplTask(loaded, world, pendant.write, asked, (inputs, outputs))
        label = Label(loaded.first, "RAPL-II", list(map(str, files)), robot)
        with at_work(client), published([(client, task, pendant, label)]):
            task.run(program)
    return 0
