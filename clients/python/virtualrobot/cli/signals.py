"""`virtualrobot signal`: digital signals."""

from __future__ import annotations

import click

from virtualrobot.cli.options import Target, target_options

_EXAMPLES = """
\b
Examples:
  virtualrobot signal
  virtualrobot signal "box arrived" on
  virtualrobot signal "box arrived" --wait --timeout 10
"""


@click.command(epilog=_EXAMPLES)
@click.argument("name", required=False)
@click.argument("value", required=False, type=click.Choice(["on", "off"]))
@click.option("--create", is_flag=True, help="Add the signal.")
@click.option("--remove", is_flag=True, help="Take the signal out of the world.")
@click.option("--wait", is_flag=True, help="Wait until the signal is on (or off) instead of setting it.")
@click.option("--timeout", type=float, help="With --wait: for at most so many seconds.")
@target_options
def signal(
    target: Target, name: str | None, value: str | None, create: bool, remove: bool, wait: bool, timeout: float | None
) -> None:
    """Show all signals, or show, set, create, remove or wait for the signal NAME."""
    if create + remove + wait > 1:
        raise click.UsageError("--create, --remove and --wait do not go together")
    if name is None and (create or remove or wait):
        raise click.UsageError("say which signal")
    if remove and value:
        raise click.UsageError("--remove takes no value")
    with target.connect() as client:
        if name is None:
            for entry in client.signals.read():
                note = f"  {entry.description}" if entry.description else ""
                click.echo(f"{entry.name}: {_word(entry.value)}{note}")
        elif create:
            client.signals.create(name, value == "on")
        elif remove:
            del client.signals[name]
        elif wait:
            client.signals.wait_for(name, value != "off", timeout)
        elif value:
            client.signals[name] = value == "on"
        else:
            click.echo(_word(client.signals[name]))


def _word(value: bool) -> str:
    return "on" if value else "off"
