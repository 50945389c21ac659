"""`virtualrobot proposal`: motions that several people see, change and approve before anything moves."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from virtualrobot.cli.key_hold import check_terminal, hold_option
from virtualrobot.cli.move import follow_to_its_end, show_notes
from virtualrobot.cli.options import GO_ON, Target, target_options
from virtualrobot.cli.orders import Order, order_options

if TYPE_CHECKING:
    from virtualrobot.motions.proposals import Proposal

_EXAMPLES = """
\b
Examples:
  virtualrobot proposal create arm --pose 0.5,0,0.3 --linear --title "to the press"
  virtualrobot proposal list
  virtualrobot proposal change proposal-1 arm --pose 0.5,0.1,0.3 --linear
  virtualrobot proposal approve proposal-1 2 --hold
"""

title_option = click.option("--title", default="", help="What it is for, one line of up to 200 characters.")


@click.group(epilog=_EXAMPLES)
def proposal() -> None:
    """Show, make, change, approve or reject proposals of motions, which all clients of a kernel share."""


@proposal.command("list")
@target_options
def list_proposals(target: Target) -> None:
    """Show the proposals, oldest first."""
    from virtualrobot.tables import aligned

    with target.connect() as client:
        found = client.proposals.list()
    if not found:
        click.echo("nobody has proposed anything yet")
        return
    rows = [
        [one.id, str(one.revision), one.state, ", ".join(one.robots) or "-", one.title or "-", one.changed_by]
        for one in found
    ]
    click.echo("\n".join(aligned([["proposal", "revision", "state", "robots", "for", "by"], *rows], left=6)))


@proposal.command()
@click.argument("id")
@target_options
def show(target: Target, id: str) -> None:
    """Show the proposal ID: what its check has found, and its motion as a program."""
    with target.connect() as client:
        found = client.proposals.get(id)
        text = client.proposals.program(found).text
    tell(found)
    click.echo(f"made by {found.author}, changed last by {found.changed_by}")
    if found.motion_id:
        click.echo(f"approved, and started as {found.motion_id}")
    if found.reason:
        click.echo(f"because: {found.reason}")
    click.echo(text)


@proposal.command()
@order_options
@title_option
@target_options
def create(target: Target, robot: str, order: Order, title: str) -> None:
    """Propose a move. Nothing moves."""
    with target.connect() as client:
        tell(client.proposals.create([order.move(client.robot(robot))], title))


@proposal.command()
@click.argument("file", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@title_option
@target_options
def program(target: Target, file: Path, title: str) -> None:
    """Propose the program that FILE says. Nothing moves."""
    with target.connect() as client:
        tell(client.proposals.create(client.read_program(file), title))


@proposal.command()
@click.argument("id")
@order_options
@target_options
def change(target: Target, id: str, robot: str, order: Order) -> None:
    """Give the proposal ID another move, and propose it again."""
    with target.connect() as client:
        tell(client.proposals.update(id, [order.move(client.robot(robot))]))


@proposal.command()
@click.argument("id")
@target_options
def renew(target: Target, id: str) -> None:
    """Plan and check the motion of the proposal ID on the world as it is, and propose it again."""
    with target.connect() as client:
        tell(client.proposals.update(id))


@proposal.command()
@click.argument("id")
@target_options
def undo(target: Target, id: str) -> None:
    """Take back the last change of the proposal ID."""
    with target.connect() as client:
        tell(client.proposals.undo(id))


@proposal.command()
@click.argument("id")
@click.option("--reason", default="", help="Why, one line of up to 200 characters.")
@target_options
def reject(target: Target, id: str, reason: str) -> None:
    """Turn the proposal ID down."""
    with target.connect() as client:
        tell(client.proposals.reject(id, reason))


@proposal.command()
@click.argument("id")
@click.argument("revision", type=click.IntRange(min=1))
@hold_option
@click.option("--no-wait", is_flag=True, help="Return at once; the motion goes on.")
@target_options
def approve(target: Target, id: str, revision: int, hold: bool, no_wait: bool) -> None:
    """Start the plan of the proposal ID as it was seen at REVISION, which 'list' and 'show' tell.

    Refused where somebody has changed it meanwhile, and where it would touch something now.
    """
    from dataclasses import replace

    check_terminal(hold, no_wait)
    with target.connect() as client:
        if client.clock.mode == "stepped" and not no_wait:
            click.echo(f"time stands still: the motion goes on with each 'virtualrobot step'; {GO_ON}", err=True)
        seen = replace(client.proposals.get(id), revision=revision)
        on_disconnect = "continue" if no_wait else "stop"
        motion = client.proposals.approve(seen, wait=False, hold=hold, on_disconnect=on_disconnect)
        show_notes(motion)
        follow_to_its_end(motion, no_wait, hold)


@proposal.command()
@target_options
def watch(target: Target) -> None:
    """Show all proposals, then each that changes, a line for each, until Ctrl-C."""
    with target.connect() as client, client.proposals.watch() as changes:
        for one in changes:
            for changed in one.proposals:
                tell(changed)
            for id in one.removed:
                click.echo(f"{id} is forgotten")


def tell(one: Proposal) -> None:
    """Print a line of a proposal, and what it violates."""
    title = f" ({one.title})" if one.title else ""
    check = one.check
    found = f"takes {check.duration:.3f} s and touches nothing" if check.ok else str(check.first_violation)
    click.echo(f"{one.id}, revision {one.revision}{title}, is {one.state}: {found}")
