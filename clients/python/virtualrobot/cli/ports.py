"""`virtualrobot driver ports`: the serial ports at which a robot may be."""

from __future__ import annotations

from importlib.util import find_spec

import click


@click.command()
def ports() -> None:
    """Show this machine's serial ports, each with what hangs on it."""
    if find_spec("serial") is None:
        raise click.ClickException("serial ports need pyserial: pip install 'virtualrobot[serial]'")
    from serial.tools.list_ports import comports

    found = sorted((port.device, port.description) for port in comports())
    click.echo("\n".join(f"{device}  {said}" for device, said in found) or "this machine has no serial port")
