"""`virtualrobot signal`: signals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from virtualrobot.cli.names import NODE, SIGNAL
from virtualrobot.cli.options import Target, target_options

if TYPE_CHECKING:
    from virtualrobot._wire.signal_values import SignalValue
    from virtualrobot.signals import Signal

_EXAMPLES = """
\b
Examples:
  virtualrobot signal
  virtualrobot signal "box arrived" on
  virtualrobot signal "box arrived" --wait --timeout 10
  virtualrobot signal pressure 0 --create --type number --unit bar
  virtualrobot signal pressure 5.5 --wait --is ">="
"""

_DEFAULTS = {"boolean": "off", "integer": "0", "number": "0", "text": "", "group": "0"}


@click.command(epilog=_EXAMPLES)
@click.argument("name", required=False, type=SIGNAL)
@click.argument("value", required=False)
@click.option("--create", is_flag=True, help="Add the signal.")
@click.option("--type", "kind", type=click.Choice(list(_DEFAULTS)), help="With --create: its type, else boolean.")
@click.option("--unit", default="", help="With --create: the unit of a number.")
@click.option(
    "--direction", type=click.Choice(["input", "output", "internal"]), help="With --create: which way it goes."
)
@click.option("--owner", type=NODE, help="With --create: the node that it belongs to.")
@click.option("--remove", is_flag=True, help="Take the signal out of the world.")
@click.option("--wait", is_flag=True, help="Wait until the signal is on, or has VALUE, instead of setting it.")
@click.option(
    "--is", "comparison", type=click.Choice(["==", "!=", "<", "<=", ">", ">="]), default="==", help="With --wait: how."
)
@click.option("--timeout", type=float, help="With --wait: for at most so many seconds.")
@target_options
def signal(
    target: Target,
    name: str | None,
    value: str | None,
    create: bool,
    kind: str | None,
    unit: str,
    direction: str | None,
    owner: str | None,
    remove: bool,
    wait: bool,
    comparison: str,
    timeout: float | None,
) -> None:
    """Show all signals, or show, set, create, remove or wait for the signal NAME.

    VALUE is on or off, a number, a text, or for a group a 0 or 1 for each of its booleans, such as 0110.
    """
    if create + remove + wait > 1:
        raise click.UsageError("--create, --remove and --wait do not go together")
    if name is None and (create or remove or wait):
        raise click.UsageError("say which signal")
    if remove and value:
        raise click.UsageError("--remove takes no value")
    if not create and (kind or unit or direction or owner):
        raise click.UsageError("--type, --unit, --direction and --owner go with --create")
    with target.connect() as client:
        if name is None:
            for entry in client.signals.read():
                note = f"  {entry.description}" if entry.description else ""
                click.echo(f"{entry.name}: {signal_text(entry)}{note}")
        elif create:
            kind = kind or "boolean"
            first = _parsed(kind, _DEFAULTS[kind] if value is None else value)
            client.signals.create(name, first, unit=unit, direction=direction, owner=owner)
        elif remove:
            del client.signals[name]
        elif wait:
            wanted = "on" if value is None else value
            client.signals.wait_for(name, signal_value(client.signals[name], wanted), timeout, comparison)
        elif value is not None:
            client.signals[name] = signal_value(client.signals[name], value)
        else:
            click.echo(signal_text(client.signals.read([name])[0]))


def signal_text(signal: Signal) -> str:
    """Return the value of a signal as the command line shows it and takes it."""
    if isinstance(signal.value, bool):
        return "on" if signal.value else "off"
    if isinstance(signal.value, tuple):
        return "".join("1" if one else "0" for one in signal.value)
    return f"{signal.value} {signal.unit}" if signal.unit else str(signal.value)


def signal_value(now: SignalValue, text: str) -> SignalValue:
    """Return the value that a text means for a signal which has some value now; raise UsageError for others."""
    return _parsed(_kind(now), text)


def _kind(value: SignalValue) -> str:
    return {bool: "boolean", int: "integer", float: "number", str: "text", tuple: "group"}[type(value)]


def _parsed(kind: str, text: str) -> SignalValue:
    """Return the value of a kind that a text means."""
    try:
        if kind == "boolean":
            return {"on": True, "off": False}[text]
        if kind == "group":
            return tuple({"1": True, "0": False}[one] for one in text)
        return {"integer": int, "number": float, "text": str}[kind](text)
    except (KeyError, ValueError) as error:
        meant = {"boolean": "on or off", "group": "a 0 or 1 for each boolean", "integer": "a whole number"}
        what = meant.get(kind, "a number")
        raise click.UsageError(f"the value of a signal of type {kind} is {what}, not {text!r}") from error
