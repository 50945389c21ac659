"""Options of `check --run` in all languages, and what it shows."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

import click
from virtualrobot.cli.signals import signal_value
from virtualrobot.connection import Client

from virtualrobot_apps.languages.core.trial import LONGEST, Trial

Decorated = TypeVar("Decorated", bound=Callable[..., Any])


def trial_options(function: Decorated) -> Decorated:
    """Add the options of a trial to a command: runs, robot, given, longest, times."""
    options = [
        click.option("--run", "runs", is_flag=True, help="Run it in a kernel of its own, in a copy of the world."),
        click.option("--robot", metavar="NAME", help="With --run: the arm that it moves [the only robot]."),
        click.option(
            "--set", "given", metavar="NAME=VALUE", multiple=True, help="With --run: the value of a signal there."
        ),
        click.option(
            "--longest",
            metavar="SECONDS",
            type=click.FloatRange(min=0.0, min_open=True),
            default=LONGEST,
            show_default=True,
            help="With --run: time of the simulation after which it is given up.",
        ),
        click.option("--times", is_flag=True, help="With --run: show the time that each line takes."),
    ]
    for option in reversed(options):
        function = option(function)
    return function


def only_robot(client: Client, name: str | None) -> str:
    """Return a robot's name, or that of the only one; raises UsageError where there is another number of them."""
    names = [one.name for one in client.robots()] if name is None else [name]
    if len(names) != 1:
        raise click.UsageError(f"name the arm by --robot; there are {', '.join(names) or 'none'}")
    return names[0]


def set_signals(client: Client, given: Iterable[str]) -> None:
    """Set signals that are given as NAME=VALUE."""
    for one in given:
        name, equals, value = one.partition("=")
        if not equals:
            raise click.UsageError(f"--set takes NAME=VALUE, as doReady=on, not {one!r}")
        client.signals[name] = signal_value(client.signals[name], value)


def told(trial: Trial, times: bool) -> int:
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
