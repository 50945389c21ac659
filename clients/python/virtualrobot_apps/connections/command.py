"""`virtualrobot connections`: runs the connections of a file between the signals of a kernel."""

from __future__ import annotations

from pathlib import Path

import click
from virtualrobot.cli.options import Target, WholeRange, target_options


@click.command(short_help="Run connections between signals, with logic, from a file.")
@click.argument("file", type=click.Path(path_type=Path, dir_okay=False))
@click.option("--check", is_flag=True, help="Look whether the file fits the kernel, and run nothing.")
@click.option("--steps", type=WholeRange(1), help="In stepped time: make so many ticks, and end.")
@target_options
def connections(target: Target, file: Path, check: bool, steps: int | None) -> None:
    """Run the connections between signals that FILE says, until Ctrl-C.

    Signals become others by logic (and, or, not, edges, delays, counters, ...), and tools and belts move as
    signals say.
    """
    from virtualrobot_apps.connections.devices import fitted
    from virtualrobot_apps.connections.file import read_connections
    from virtualrobot_apps.connections.runner import Connections

    if check and steps:
        raise click.UsageError("--check runs nothing, so that --steps has no meaning")
    read = read_connections(file)
    with target.connect() as client:
        if check:
            fitted(client, read, {one.name: one.value for one in client.signals.read()}, click.echo)
            drives = _counted(len(read.driven()), "signal")
            click.echo(f"{file} fits: {_counted(len(read.connections), 'connection')}; it drives {drives}")
            return
        with Connections(client, read, click.echo) as running:
            click.echo(f"{file}: {_counted(len(read.connections), 'connection')} running")
            if steps:
                running.step(steps)
            else:
                running.run()


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
