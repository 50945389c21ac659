"""Parts of the commands of all languages: options, faults that are shown, trials, and a run that Ctrl-C stops."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click
from virtualrobot.cli.options import GO_ON
from virtualrobot.cli.signals import signal_value

if TYPE_CHECKING:
    from virtualrobot import Client

    from virtualrobot_apps.languages.core.diagnostics import ProgramError
    from virtualrobot_apps.languages.core.source import Source
    from virtualrobot_apps.languages.core.trial import Trial
    from virtualrobot_apps.languages.urscript.trial import Played

Decorated = TypeVar("Decorated", bound=Callable[..., Any])

LONGEST = 300.0
"""Time (s of the simulation) after which a trial is given up, unless somebody says another one."""


longest_option = click.option(
    "--longest",
    metavar="SECONDS",
    type=click.FloatRange(min=0.0, min_open=True),
    default=LONGEST,
    show_default=True,
    help="With --run: time of the simulation after which it is given up.",
)
times_option = click.option("--times", is_flag=True, help="With --run: show the time that each line takes.")


def trial_options(function: Decorated) -> Decorated:
    """Add the options of a trial to a command: runs, robot, given, longest, times."""
    options = [
        click.option("--run", "runs", is_flag=True, help="Run it in a kernel of its own, in a copy of the world."),
        click.option("--robot", metavar="NAME", help="With --run: the arm that it moves [the only robot]."),
        click.option(
            "--set", "given", metavar="NAME=VALUE", multiple=True, help="With --run: the value of a signal there."
        ),
        longest_option,
        times_option,
    ]
    for option in reversed(options):
        function = option(function)
    return function


def faulty(error: ProgramError) -> int:
    """Show the faults of a program that can't be run as it is, and return the exit code, 1."""
    for one in error.diagnostics:
        click.echo(str(one))
    click.echo(f"{len(error.diagnostics)} fault{'s' * (len(error.diagnostics) != 1)}")
    return 1


def lay_out(files: Iterable[Path], formatted: Callable[[Source], str], only_check: bool) -> int:
    """Write files anew as `formatted` lays them out, or only tell which would be changed; return the exit code.

    Faults of a file that can't be parsed are shown, and it is left as it is: exit code 1.
    """
    from virtualrobot_apps.languages.core.diagnostics import ProgramError
    from virtualrobot_apps.languages.core.source import encoded_like, read_source

    count = changed = faulty = 0
    for file in files:
        count += 1
        source = read_source(file)
        before = file.read_bytes()
        try:
            after = encoded_like(formatted(source), before)
        except ProgramError as error:
            for one in error.diagnostics:
                click.echo(str(one))
            faulty += 1
            continue
        if after != before:
            changed += 1
            click.echo(f"{file} {'would be changed' if only_check else 'changed'}")
            if not only_check:
                file.write_bytes(after)
    said = f"{changed} of {count} file{'s' * (count != 1)} {'would be ' * only_check}changed"
    click.echo(said + (f"; {faulty} left as {'it is' if faulty == 1 else 'they are'}" if faulty else ""))
    return 1 if faulty or (only_check and changed) else 0


def only_robot(client: Client, name: str | None, others: Collection[str | None] = ()) -> str:
    """Return a robot's name, or that of the only one besides `others`; raises UsageError where it isn't only one."""
    names = [one.name for one in client.robots() if one.name not in others] if name is None else [name]
    if len(names) != 1:
        raise click.UsageError(f"name the arm by --robot; there are {', '.join(names) or 'none'}")
    return names[0]


@contextmanager
def at_work(client: Client) -> Iterator[None]:
    """Have a program run for the length of a block: tell where time stands still, and end by Ctrl-C with 130.

    Where somebody else stops it (`virtualrobot tasks stop`) it ends with 1.
    """
    from virtualrobot_apps.languages.core.task import TaskStopped

    if client.clock.mode == "stepped":
        click.echo(f"time stands still: the program goes on with each 'virtualrobot step'; {GO_ON}", err=True)
    try:
        yield
    except KeyboardInterrupt:
        click.echo("stopped", err=True)
        raise click.exceptions.Exit(130) from None
    except TaskStopped as stopped:
        click.echo(str(stopped), err=True)
        raise click.exceptions.Exit(1) from None


def set_signals(client: Client, given: Iterable[str]) -> None:
    """Set signals that are given as NAME=VALUE."""
    for one in given:
        name, equals, value = one.partition("=")
        if not equals:
            raise click.UsageError(f"--set takes NAME=VALUE, as doReady=on, not {one!r}")
        client.signals[name] = signal_value(client.signals[name], value)


def told(trial: Trial | Played, times: bool) -> int:
    """Show what a trial has found, and return the exit code: 0 without a finding, or 1."""
    for one in trial.findings:
        click.echo(str(one))
    if times:
        for place, seconds in trial.seconds.items():
            click.echo(f"{seconds:9.3f} s  {place}")
    count = len(trial.findings)
    said = f"{count} fault{'s' * (count != 1)}" if count else "no fault"
    click.echo(f"{said} in a run of {trial.duration:.3f} s")
    return 1 if count else 0
