"""`virtualrobot rapid`: checks and runs programs in RAPID."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from pathlib import Path
from shutil import copytree
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, TypeAlias

import click
from virtualrobot.cli.options import Target, target_options

from virtualrobot_apps.emulators.egm.command import devices_option
from virtualrobot_apps.languages.core.command import (
    Decorated,
    at_work,
    faulty,
    lay_out,
    only_robot,
    set_signals,
    told,
    trial_options,
)

if TYPE_CHECKING:
    from virtualrobot import Client

    from virtualrobot_apps.languages.rapid.cell import Cell
    from virtualrobot_apps.languages.rapid.task import Loaded

Part: TypeAlias = tuple[str, str | None, tuple[Path, ...]]
"""Name, robot and files of a task."""

_EXAMPLES = """
\b
Examples:
  virtualrobot rapid check palletize.mod
  virtualrobot rapid check main.mod tools.sys --signal doGripper --signal diPart
  virtualrobot rapid check palletize.mod --run --robot arm --set diPart=on --times
  virtualrobot rapid format palletize.mod tools.sys
  virtualrobot rapid run palletize.mod --robot arm --create-signals
  virtualrobot rapid run log.mod --files log --answer yes
  virtualrobot rapid run guided.mod --robot arm --egm UCdevice=127.0.0.1:6510
  virtualrobot rapid run --task T_ROB_L@left=left.mod --task T_ROB_R@right=right.mod --static T_WATCH=watch.mod
"""

_files = click.argument("files", nargs=-1, required=True, metavar="FILE...", type=click.Path(path_type=Path))
_signals = click.option("--signal", "signals", metavar="NAME", multiple=True, help="The world has this signal.")


def _folder(told: str) -> Callable[[Decorated], Decorated]:
    """Return the option of the folder in which a program's files are."""
    existing = click.Path(path_type=Path, exists=True, file_okay=False)
    return click.option("--files", "folder", metavar="FOLDER", type=existing, help=told)


def _several(function: Decorated) -> Decorated:
    """Add the options of several tasks to a command: tasks, static."""
    tasks = click.option(
        "--task",
        "tasks",
        metavar="NAME[@ROBOT]=FILE[,FILE...]",
        multiple=True,
        help="Another task that runs beside, and moves another arm or none; FILEs are the task T_ROB1.",
    )
    static = click.option(
        "--static",
        metavar="NAME=FILE[,FILE...]",
        multiple=True,
        help="A task without a robot that begins its procedure again and again until the others have ended.",
    )
    return tasks(static(function))


def _units(ctx: click.Context, option: click.Parameter, given: tuple[str, ...]) -> dict[str, str]:
    """Return robots by the names of the mechanical units that they are, given as [UNIT=]ROBOT."""
    found: dict[str, str] = {}
    for text in given:
        unit, _, robot = text.rpartition("=")
        if not robot or unit.lower() in map(str.lower, found):
            raise click.BadParameter(f"an external axis is given as [UNIT=]ROBOT, each unit once, not {text!r}")
        found[unit or robot] = robot
    return found


_external = click.option(
    "--external",
    metavar="[UNIT=]ROBOT",
    multiple=True,
    callback=_units,
    help="A rail or positioner whose joints are the next external axes of the arm; may be given again.",
)


@click.group(epilog=_EXAMPLES, short_help="Check, format and run programs in RAPID, ABB's language.")
@target_options
@click.pass_context
def rapid(ctx: click.Context, target: Target) -> None:
    """Programs in RAPID, the language of ABB's controllers: modules in files, which together are one program."""
    ctx.obj = target


@rapid.command()
@click.argument("files", nargs=-1, metavar="[FILE]...", type=click.Path(path_type=Path))
@_signals
@_several
@trial_options
@_external
@click.option("--answer", "answers", metavar="TEXT", multiple=True, help="With --run: as that of run.")
@_folder("With --run: let it use files below a copy of this folder.")
@target_options
def check(
    target: Target,
    files: tuple[Path, ...],
    signals: tuple[str, ...],
    tasks: tuple[str, ...],
    static: tuple[str, ...],
    runs: bool,
    robot: str | None,
    given: tuple[str, ...],
    longest: float,
    times: bool,
    external: dict[str, str],
    answers: tuple[str, ...],
    folder: Path | None,
) -> int:
    """Tell what is wrong in the program that FILEs make together, with exit code 0 or 1; needs no kernel.

    Looked at are words, names, types and arguments, and whether all that is used works here. With --run the program is
    run, too, in a copy of a kernel's world: collisions, places out of reach, limits and singularities are told.
    """
    from virtualrobot_apps.languages.core.diagnostics import ProgramError
    from virtualrobot_apps.languages.core.source import read_source
    from virtualrobot_apps.languages.rapid.task import load_tasks

    parts, steady = _parts(files, robot, tasks, static)
    sources = {name: [read_source(one) for one in of] for name, _, of in parts + steady}
    try:
        programs = load_tasks(sources, signals)
    except ProgramError as error:
        return faulty(error)
    counted = sum(len(scope.routines) for one in programs.values() for scope in one.checked.modules)
    named = ", ".join(sorted({use.name for one in programs.values() for use in one.signals.values()}))
    click.echo(
        f"no fault in {counted} routine{'s' * (counted != 1)}" + (f"; signals of the world: {named}" if named else "")
    )
    if not runs:
        return 0
    from virtualrobot_apps.languages.core.task import Task
    from virtualrobot_apps.languages.core.trial import Moving, Trial, copied_world

    with target.connect() as live, copied_world(live) as client, TemporaryDirectory() as copy:
        if folder is not None:
            copytree(folder, copy, dirs_exist_ok=True)
        parts = _with_robot(client, parts, files) + steady
        programs = load_tasks(sources, list(client.signals))
        add_signals(client, programs.values())
        set_signals(client, given)
        copied = Path(copy) if folder is not None else None
        cell = _cell(client, parts, programs, answers, copied, shows=False, external=external)
        worlds: dict[Task, Moving] = {one: one.signals for one in cell.tasks.values()}
        still = [cell.tasks[name.lower()] for name, _, _ in steady]
        trial = Trial(client, worlds, longest, static=still)
        trial.run(lambda: cell.run(static=still))
        return told(trial, times)


@rapid.command("format")
@_files
@click.option("--check", "only_check", is_flag=True, help="Change no file, and tell which would be changed.")
def format_files(files: tuple[Path, ...], only_check: bool) -> int:
    """Lay FILEs out: two spaces for each level, spaces between words, reserved words in capital letters.

    Lines stay lines, and comments what they are. A file that can't be parsed is left as it is, and its faults are told,
    with exit code 1.
    """
    from virtualrobot_apps.languages.rapid.layout import formatted

    return lay_out(files, formatted, only_check)


@rapid.command()
@click.argument("files", nargs=-1, metavar="[FILE]...", type=click.Path(path_type=Path))
@click.option("--robot", metavar="NAME", help="The arm that it moves [the only robot].")
@_external
@click.option("--routine", default="main", show_default=True, help="The procedure that it begins with.")
@click.option(
    "--listen",
    metavar="[ADDRESS]",
    is_flag=False,
    flag_value="127.0.0.1",
    help="Let its sockets listen, at this address [127.0.0.1]: whoever connects moves the robot.",
)
@_folder("Let it use files, below this folder, whatever disk it names.")
@click.option(
    "--answer",
    "answers",
    metavar="TEXT",
    multiple=True,
    help="What is answered on the pendant, one after the other [lines of the standard input].",
)
@_several
@devices_option
@click.option("--continuous", is_flag=True, help="Begin again each time that it ends, also by ExitCycle.")
@click.option("--create-signals", is_flag=True, help="Add the signals that it names and the world has not.")
@click.option("--save", is_flag=True, help="Write persistents that it has changed back into its files when it ends.")
@target_options
def run(
    target: Target,
    files: tuple[Path, ...],
    robot: str | None,
    external: dict[str, str],
    routine: str,
    listen: str | None,
    folder: Path | None,
    answers: tuple[str, ...],
    tasks: tuple[str, ...],
    static: tuple[str, ...],
    devices: tuple[tuple[str, tuple[str, int]], ...],
    continuous: bool,
    create_signals: bool,
    save: bool,
) -> int:
    """Run the program that FILEs make together, and show what it writes on its pendant; Ctrl-C stops it on its path.

    It is checked first, and nothing moves where something is wrong. Several tasks run side by side, share persistents
    and meet by WaitSyncTask; the error of one stops all.
    """
    from virtualrobot_apps.languages.core.source import read_source
    from virtualrobot_apps.languages.rapid.task import load_tasks

    parts, steady = _parts(files, robot, tasks, static)
    with target.connect() as client:
        parts = _with_robot(client, parts, files) + steady
        programs = load_tasks({name: map(read_source, of) for name, _, of in parts}, list(client.signals))
        if create_signals:
            add_signals(client, programs.values())
        asked = answers or sys.stdin
        cell = _cell(client, parts, programs, asked, folder, listen=listen, egm=dict(devices), external=external)
        with at_work(client), _saving(cell) if save else nullcontext():
            cell.run(routine, [cell.tasks[name.lower()] for name, _, _ in steady], forever=continuous)
    return 0


@contextmanager
def _saving(cell: Cell) -> Iterator[None]:
    """Write the persistents that the tasks of a cell change in a block into their files, however it ends."""
    from virtualrobot_apps.languages.rapid.saving import Persistents

    for task in cell.tasks.values():
        task.prepare_alone()
    kept = Persistents(cell.tasks.values())
    try:
        yield
    finally:
        for file, count in kept.save():
            click.echo(f"{count} persistent{'s' * (count != 1)} saved in {file}", err=True)


def _parts(
    files: tuple[Path, ...], robot: str | None, tasks: tuple[str, ...], static: tuple[str, ...]
) -> tuple[list[Part], list[Part]]:
    """Return name, robot and files of each task, and of the static ones; FILEs are the last task, T_ROB1."""
    parts = [_part(text) for text in tasks]
    parts += [("T_ROB1", robot, files)] if files else []
    if not parts:
        raise click.UsageError("name the program's files, or give each task by --task NAME[@ROBOT]=FILE")
    if robot is not None and not files:
        raise click.UsageError("--robot is that of the task T_ROB1, which has no files; write --task NAME@ROBOT=FILE")
    steady = [_part(text) for text in static]
    for name, arm, _ in steady:
        if arm is not None:
            raise click.UsageError(f"the static task {name} moves no robot: leave @{arm} out")
    names, arms = [name for name, _, _ in parts + steady], [arm for _, arm, _ in parts if arm is not None]
    for twice, what in ((names, "two tasks are called {}"), (arms, "two tasks move the robot {}")):
        found = next((one for number, one in enumerate(twice) if one in twice[:number]), None)
        if found is not None:
            raise click.UsageError(what.format(found))
    return parts, steady


def _with_robot(client: Client, parts: list[Part], files: tuple[Path, ...]) -> list[Part]:
    """Return tasks of which the last one, where it has FILEs and no robot, has the only one that no other one moves."""
    if not files or parts[-1][1] is not None:
        return parts
    return [*parts[:-1], ("T_ROB1", only_robot(client, None, [arm for _, arm, _ in parts]), files)]


def add_signals(client: Client, programs: Iterable[Loaded]) -> None:
    """Add the signals that programs name and the world has not."""
    from virtualrobot_apps.languages.rapid.symbols import first_value

    named = {lower: use for program in programs for lower, use in program.signals.items()}
    for lower in sorted(named.keys() - {name.lower() for name in client.signals}):
        client.signals.create(named[lower].name, first_value(named[lower]))


def _cell(
    client: Client,
    parts: list[Part],
    programs: Mapping[str, Loaded],
    answers: Iterable[str],
    folder: Path | None,
    *,
    shows: bool = True,
    listen: str | None = None,
    egm: Mapping[str, tuple[str, int]] | None = None,
    external: Mapping[str, str] | None = None,
) -> Cell:
    """Return the tasks of a run, whose pendants are shown or not."""
    from virtualrobot_apps.languages.rapid.cell import Cell
    from virtualrobot_apps.languages.rapid.signals import Signals
    from virtualrobot_apps.languages.rapid.task import RapidTask
    from virtualrobot_apps.languages.rapid.world import World

    if external and sum(arm is not None for _, arm, _ in parts) != 1:
        raise click.UsageError("--external is for a program with one task that moves a robot")
    cell, answered = Cell(), iter(answers)
    for name, arm, _ in parts:
        where = f"{name}: " if len(parts) > 1 else ""
        note = _teller(f"note: {where}", err=True)
        world = Signals(client) if arm is None else World(client, arm, note, external)
        write = _teller(where) if shows else _nothing
        RapidTask(programs[name], world, write, listen, files=folder, answers=answered, name=name, cell=cell, egm=egm)
    return cell


def _nothing(line: str) -> None:
    """Show nothing."""


def _teller(before: str, err: bool = False) -> Callable[[str], None]:
    """Return what shows a line on the terminal, with words before it."""
    return lambda line: click.echo(before + line, err=err)


def _part(text: str) -> Part:
    """Return name, robot and files of a task that is given as NAME[@ROBOT]=FILE[,FILE...]."""
    match = re.fullmatch(r"(?P<name>\w+)(@(?P<robot>[^=]+))?=(?P<files>.+)", text)
    if match is None:
        raise click.UsageError(f"a task is given as NAME[@ROBOT]=FILE[,FILE...], not {text!r}")
    return match["name"], match["robot"], tuple(Path(one) for one in match["files"].split(","))
