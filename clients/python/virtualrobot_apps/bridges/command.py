"""`virtualrobot bridge`: signals of a kernel to OPC UA, Modbus or MQTT and back."""

from __future__ import annotations

import logging
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

import click
from virtualrobot.cli.options import Target, target_options

if TYPE_CHECKING:
    from virtualrobot_apps.bridges.mapping import BridgeMapping
    from virtualrobot_apps.bridges.peer import Peer

_PEERS = {
    ("opcua", False): "OpcUaClient",
    ("opcua", True): "OpcUaServer",
    ("modbus", False): "ModbusClient",
    ("modbus", True): "ModbusServer",
    ("mqtt", False): "MqttClient",
}


@click.command(short_help="Bridge signals to OPC UA, Modbus or MQTT, as a file maps them.")
@click.argument("protocol", type=click.Choice(["opcua", "modbus", "mqtt"]))
@click.argument("mapping", type=click.Path(path_type=Path, dir_okay=False))
@click.option("--connect", "to", metavar="URL", help="Connect to a server, slave or broker.")
@click.option("--serve", "at", metavar="URL", help="Serve there, as an OPC UA server or a Modbus slave.")
@click.option("--check", is_flag=True, help="Look at the file and at the signals, and connect nothing; no URL needed.")
@target_options
def bridge(target: Target, protocol: str, mapping: Path, to: str | None, at: str | None, check: bool) -> None:
    """Bridge the signals that the file MAPPING names to PROTOCOL, until Ctrl-C.

    URLs are opc.tcp://HOST:PORT, tcp://HOST:PORT or rtu:///dev/ttyUSB0 for Modbus, and mqtt://HOST:PORT.
    """
    from virtualrobot_apps.bridges.bridge import Bridge
    from virtualrobot_apps.bridges.mapping import read_mapping

    if (to is None) == (at is None) and not (check and to is None):
        raise click.UsageError("say --connect URL or --serve URL, one of the two")
    if protocol == "mqtt" and at is not None:
        raise click.UsageError("a bridge is no broker of MQTT: --connect URL says which one it goes to")
    read = read_mapping(mapping, protocol, serves=at is not None)
    # What matters of what libraries log is told by the bridge, once and in words.
    for library in ("asyncua", "pymodbus"):
        logging.getLogger(library).setLevel(logging.CRITICAL)
    with target.connect() as client:
        if check:
            read.check_signals({one.name: one.value for one in client.signals.read()})
            click.echo(f"{mapping} fits: {len(read.entries)} signals")
            return
        Bridge(client, read, peer_of(protocol, read, to, at), click.echo).run()


def peer_of(protocol: str, mapping: BridgeMapping, to: str | None, at: str | None) -> Peer:
    """Return the other side of a bridge; raise UsageError where its library is not installed."""
    try:
        module = import_module(f"virtualrobot_apps.bridges.{protocol}")
    except ModuleNotFoundError as error:
        raise click.UsageError(f"{error}; install it: pip install 'virtualrobot[{protocol}]'") from error
    return getattr(module, _PEERS[protocol, at is not None])(mapping, at if at is not None else to)
