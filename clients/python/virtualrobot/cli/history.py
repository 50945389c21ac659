"""`virtualrobot history`, `undo`, `redo` and `checkpoint`: what was changed, and the way back."""

from __future__ import annotations

from datetime import datetime
from typing import TYPE_CHECKING

import click

from virtualrobot.cli.names import CHECKPOINT, NODE
from virtualrobot.cli.options import Target, WholeRange, target_options
from virtualrobot.tables import aligned

if TYPE_CHECKING:
    from virtualrobot.history.values import Step

_EXAMPLES = """
\b
Examples:
  virtualrobot history --node table
  virtualrobot history --mine --last 5
  virtualrobot history --since 14:30 --until 15:00
  virtualrobot undo
  virtualrobot undo 17
  virtualrobot checkpoint noon
  virtualrobot checkpoint noon --restore
"""

_TIMES = ("%H:%M", "%H:%M:%S", "%Y-%m-%d", "%Y-%m-%dT%H:%M:%S", "%Y-%m-%d %H:%M:%S")


class _Time(click.DateTime):
    """Local time of a day; without a day of today."""

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> datetime:
        """Return the time; raise click.BadParameter for words that are none."""
        try:
            found: datetime = super().convert(value, param, ctx)
        except click.BadParameter:
            self.fail(f"{value!r} is no time; write 14:30, 14:30:05, 2026-11-24 or '2026-11-24 14:30:05'", param, ctx)
        return found if "-" in str(value) else datetime.combine(datetime.now().date(), found.time())


_KINDS = ("edit", "undo", "redo", "motion", "signal", "other", "restore")


@click.command(epilog=_EXAMPLES)
@click.option("--node", type=NODE, help="Only what changed this node.")
@click.option("--author", default="", metavar="WORDS", help="Only what was done by somebody called so.")
@click.option("--mine", is_flag=True, help="Only what you did on this machine by this command line.")
@click.option(
    "--kind", "kinds", multiple=True, type=click.Choice(_KINDS), help="Only these kinds; several go together."
)
@click.option("--since", type=_Time(_TIMES), metavar="TIME", help="Only at this local time or later, such as 14:30.")
@click.option("--until", type=_Time(_TIMES), metavar="TIME", help="Only before it; '2026-11-24 14:30:00' is one, too.")
@click.option("--last", type=WholeRange(1), default=20, show_default=True, help="At most so many.")
@click.option("--watch", is_flag=True, help="Show steps as they are done, until Ctrl-C.")
@target_options
def history(
    target: Target,
    node: str | None,
    author: str,
    mine: bool,
    kinds: tuple[str, ...],
    since: datetime | None,
    until: datetime | None,
    last: int,
    watch: bool,
) -> None:
    """Show what was changed and by whom, oldest first."""
    some = bool(node or author or mine or kinds or since or until)
    if watch and some:
        raise click.UsageError("--watch shows all steps; it goes with no other option")
    with target.connect() as client:
        if watch:
            for step in client.history.watch():
                click.echo("  ".join(_row(step)))
            return
        steps = client.history.list(
            node=node, author=author, mine=mine, kinds=kinds, since=since, until=until, limit=last
        )
    rows = [_row(step) for step in reversed(steps)]
    nothing = "no step is so" if some else "nothing was changed yet"
    click.echo("\n".join(aligned(rows, left=4)) if rows else nothing)


def _clock(time: datetime) -> str:
    """Return a local time, with its day unless that is today."""
    local = time.astimezone()
    return local.strftime("%H:%M:%S" if local.date() == datetime.now().date() else "%Y-%m-%d %H:%M:%S")


def _row(step: Step) -> list[str]:
    author = step.author.rpartition(" at ")[0] or step.author
    return [str(step.number), _clock(step.time), author, f"{step.label}{' (undone)' if step.undone else ''}"]


@click.command(epilog=_EXAMPLES)
@click.argument("step", type=WholeRange(1), required=False)
@click.option("--mine", is_flag=True, help="Only what you did on this machine by this command line.")
@target_options
def undo(target: Target, step: int | None, mine: bool) -> None:
    """Take back the newest change that stands, or the STEP of this number, as 'virtualrobot history' shows it.

    It changes back what the step changed and nothing else. Motion is not undone: see 'virtualrobot checkpoint'.
    """
    with target.connect() as client:
        click.echo(client.undo(step, mine=mine).label)


@click.command(epilog=_EXAMPLES)
@click.argument("step", type=WholeRange(1), required=False)
@click.option("--mine", is_flag=True, help="Only what you undid on this machine by this command line.")
@target_options
def redo(target: Target, step: int | None, mine: bool) -> None:
    """Do again what was undone last, or the STEP of this number."""
    with target.connect() as client:
        click.echo(client.redo(step, mine=mine).label)


@click.command(epilog=_EXAMPLES)
@click.argument("name", type=CHECKPOINT, required=False)
@click.option("--restore", is_flag=True, help="Put the world back to how it was; robots stand where they stood.")
@click.option("--remove", is_flag=True, help="Forget the checkpoint.")
@target_options
def checkpoint(target: Target, name: str | None, restore: bool, remove: bool) -> None:
    """Show the checkpoints; or keep the world as it is as the checkpoint NAME, or go back to one."""
    if restore and remove:
        raise click.UsageError("--restore and --remove do not go together")
    if name is None and (restore or remove):
        raise click.UsageError("say which checkpoint")
    with target.connect() as client:
        if name is None:
            checkpoints = client.history.checkpoints.values()
            for known in checkpoints:
                click.echo(f"{known.name}  {_clock(known.time)}, tick {known.tick}, {known.node_count} nodes")
            if not checkpoints:
                click.echo("there is no checkpoint")
        elif restore:
            before = client.history.restore(name)
            click.echo(f"went back to {name}; the world as it was before is the checkpoint '{before.name}'")
        elif remove:
            client.history.remove_checkpoint(name)
        else:
            made = client.history.checkpoint(name)
            click.echo(f"kept {made.node_count} nodes at tick {made.tick} as {made.name}")
