"""`virtualrobot tasks`: programs of robots' languages at work, which anybody sees, stops and answers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from virtualrobot.cli.options import Target, target_options

if TYPE_CHECKING:
    from virtualrobot.tasks import ProgramTask

_EXAMPLES = """
\b
Examples:
  virtualrobot tasks
  virtualrobot tasks show T_ROB1
  virtualrobot tasks watch
  virtualrobot tasks stop T_ROB1
  virtualrobot tasks answer T_ROB1 yes
"""


@click.group(invoke_without_command=True, epilog=_EXAMPLES)
@target_options
@click.pass_context
def tasks(ctx: click.Context, target: Target) -> None:
    """Show, stop or answer programs of robots' languages, whoever runs them; without a command: show them."""
    ctx.obj = target
    if ctx.invoked_subcommand is not None:
        return
    from virtualrobot.tables import aligned

    with target.connect() as client:
        found = client.tasks.list()
    if not found:
        click.echo("no program is at work")
        return
    rows = [
        [one.name, one.id, one.language, one.robot or "-", _state(one), one.program_pointer or "-", one.author]
        for one in found
    ]
    heads = ["task", "record", "language", "robot", "state", "program pointer", "by"]
    click.echo("\n".join(aligned([heads, *rows], left=7)))


@tasks.command()
@click.argument("name")
@target_options
def show(target: Target, name: str) -> None:
    """Show the task NAME, or of the record NAME: files, pointers, the last lines of its pendant and what it asks."""
    with target.connect() as client:
        one = client.tasks.get(name)
    click.echo(f"{one.name} ({one.id}): {_state(one)}; {one.language} of {one.author}")
    click.echo(f"files: {', '.join(one.files) or '-'}; robot: {one.robot or '-'}")
    click.echo(f"program pointer: {one.program_pointer or '-'}; motion pointer: {one.motion_pointer or '-'}")
    for line in one.lines:
        click.echo(f"| {line}")
    if one.question:
        click.echo(f"asks: {one.question}" + (f" [{', '.join(one.choices)}]" if one.choices else ""))


@tasks.command()
@target_options
def watch(target: Target) -> None:
    """Show all tasks, then each that changes, a line for each, until Ctrl-C."""
    with target.connect() as client:
        for changed in client.tasks.watch():
            for one in changed:
                at = one.program_pointer or "-"
                click.echo(
                    f"{one.name} ({one.id}): {_state(one)} at {at}" + (f" | {one.lines[-1]}" if one.lines else "")
                )


@tasks.command()
@click.argument("name")
@target_options
def stop(target: Target, name: str) -> None:
    """Stop the task NAME, or of the record NAME: before its next statement; its robot brakes on its path."""
    with target.connect() as client:
        client.tasks.stop(name)
    click.echo(f"{name} was told to stop")


@tasks.command()
@click.argument("name")
@click.argument("text")
@target_options
def answer(target: Target, name: str, text: str) -> None:
    """Answer TEXT to what the task NAME, or of the record NAME, asks on its pendant."""
    with target.connect() as client:
        client.tasks.answer(name, text)
    click.echo(f"{name} was answered {text!r}")


def _state(one: ProgramTask) -> str:
    """Return how a task is, and that its client is gone where that is so."""
    return one.state if one.is_held or one.is_over else f"{one.state}, and its client is gone"
