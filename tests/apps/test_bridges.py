"""Bridges over real sockets and pseudo terminals, each against the other end of its own library."""

from __future__ import annotations

import asyncio
import os
import select
import signal
import socket
import struct
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import virtualrobot
from click.testing import CliRunner
from virtualrobot_apps.bridges.command import bridge as command
from virtualrobot_apps.bridges.command import peer_of
from virtualrobot_apps.bridges.mapping import BridgeMapping
from virtualrobot_apps.bridges.peer import Peer

from tests.apps.bridging import GUARD, PLACES, check_values, create_signals, entries, free_port, mapping, running
from tests.kernels import KernelProcess, Stubs


@pytest.fixture
def client(kernel: KernelProcess, stubs: Stubs) -> Iterator[virtualrobot.Client]:
    """Return a client of a kernel with the signals of these tests."""
    with virtualrobot.connect(kernel.address) as client:
        create_signals(client)
        yield client


def test_modbus_tcp_both_ends(client: virtualrobot.Client) -> None:
    from virtualrobot_apps.bridges.modbus import ModbusClient, ModbusServer

    url = f"tcp://127.0.0.1:{free_port()}"
    slave = mapping("modbus", entries("modbus", False), serves=True, more="connected: peer there\n")
    master = mapping("modbus", entries("modbus", True), more="connected: there\n")
    with running(client, master, ModbusClient(master, url)) as said:
        with running(client, slave, ModbusServer(slave, url)):
            check_values(client)
            client.signals.set({"start": True, "speed": 1e300})
            client.signals.wait_for("started", timeout=GUARD)
        # The slave is gone: the master says so, and what it read is not trusted.
        client.signals.wait_for("there", False, timeout=GUARD)
        client.signals.wait_for("started", False, timeout=GUARD)
        assert client.signals["read speed"] == 1.5, "it has no 'lost', and 1e300 is no float32"
        with running(client, slave, ModbusServer(slave, url)) as served:
            client.signals.wait_for("there", timeout=GUARD)
            client.signals.wait_for("started", timeout=GUARD)
    assert any("lost: " in line and "it is tried again each 1 s" in line for line in said), said
    assert [line.partition(": ")[2] for line in served][1:] == [
        "'speed' (input_register 20) is not sent: 1e+300 is 1e+300 there, "
        "and float32 goes from -3.40282e+38 to 3.40282e+38"
    ]


def test_a_slave_refuses_what_is_not_mapped_and_loses_no_pulse(client: virtualrobot.Client) -> None:
    """A bare pymodbus master writes; each write counts, however fast."""
    from pymodbus.client import ModbusTcpClient
    from virtualrobot_apps.bridges.modbus import ModbusServer

    mapped = """
{signal: started, direction: in, address: coil 3}
{signal: read speed, direction: in, address: holding_register 8, type: float32}
{signal: start, direction: out, address: discrete_input 0}
"""
    port = free_port()
    read = mapping("modbus", mapped, serves=True, more="connected: there\n")
    seen: list[bool] = []
    with running(client, read, ModbusServer(read, f"tcp://127.0.0.1:{port}")) as said:
        client.signals.wait_for("there", timeout=GUARD)
        with (
            client.signals.follow(["started"]) as watch,
            ModbusTcpClient("127.0.0.1", port=port, timeout=GUARD) as master,
        ):
            changes = iter(watch)
            next(changes)
            for number in range(20):
                assert not master.write_coil(3, number % 2 == 0).isError()
            seen = [bool(next(changes).values["started"]) for _ in range(20)]
            assert master.write_coil(4, True).exception_code == 2
            assert master.write_register(8, 0, device_id=7).isError()
            assert master.read_holding_registers(7, count=3).exception_code == 2
            nan = list(struct.unpack(">2H", struct.pack(">f", float("nan"))))
            assert not master.write_registers(8, nan).isError()
            good = list(struct.unpack(">2H", struct.pack(">f", 2.5)))
            assert not master.write_registers(8, good).isError()
            client.signals.wait_for("read speed", 2.5, timeout=GUARD)
            assert master.read_discrete_inputs(0).bits[0] is False
    assert seen == [True, False] * 10
    assert [line.partition(": ")[2] for line in said][1:] == [
        "'read speed' (holding_register 8) is not taken: nan is no finite number",
        "'read speed' (holding_register 8) is fine again",
    ]


def frozen_peers(read: BridgeMapping, protocol: str, port: int) -> Peer:
    """Return the client of a protocol to a port."""
    from virtualrobot_apps.bridges.modbus import ModbusClient
    from virtualrobot_apps.bridges.mqtt import MqttClient
    from virtualrobot_apps.bridges.opcua import OpcUaClient

    made: dict[str, Callable[[], Peer]] = {
        "modbus": lambda: ModbusClient(read, f"tcp://127.0.0.1:{port}"),
        "opcua": lambda: OpcUaClient(read, f"opc.tcp://127.0.0.1:{port}"),
        "mqtt": lambda: MqttClient(read, f"mqtt://127.0.0.1:{port}"),
    }
    return made[protocol]()


@pytest.mark.parametrize(
    "protocol", ["modbus", *(pytest.param(one, marks=pytest.mark.long) for one in ("opcua", "mqtt"))]
)
@pytest.mark.parametrize("frozen", [True, False])
def test_who_is_silent_or_not_there_is_told_once(client: virtualrobot.Client, protocol: str, frozen: bool) -> None:
    """A peer that accepts and says nothing, or none at all: words, and nothing goes into the world."""
    client.signals["started"] = True
    entry = f"{{signal: started, direction: in, {PLACES[protocol][0]}, lost: false}}"
    read = mapping(protocol, entry, more="timeout_seconds: 0.2\nconnected: there\n")
    with socket.create_server(("127.0.0.1", 0)) as listening:
        port = listening.getsockname()[1]
        if not frozen:
            listening.close()
        with running(client, read, frozen_peers(read, protocol, port)) as said:
            client.signals.wait_for("started", False, timeout=GUARD)
    assert said and "it is tried again each 1 s" in said[-1], said
    assert client.signals["there"] is False


@contextmanager
def joined_terminals() -> Iterator[tuple[str, str]]:
    """Give the names of two pseudo terminals; what is written to one is read from the other one."""
    ends = [os.openpty() for _ in range(2)]
    stop = threading.Event()
    masters = [master for master, _ in ends]

    def carry() -> None:
        while not stop.is_set():
            for master in select.select(masters, [], [], 0.05)[0]:
                os.write(masters[1 - masters.index(master)], os.read(master, 4096))

    thread = threading.Thread(target=carry)
    thread.start()
    try:
        yield os.ttyname(ends[0][1]), os.ttyname(ends[1][1])
    finally:
        stop.set()
        thread.join()
        for pair in ends:
            for descriptor in pair:
                os.close(descriptor)


@pytest.mark.long
@pytest.mark.skipif(not hasattr(os, "openpty"), reason="needs pseudo terminals")
def test_modbus_rtu_both_ends(client: virtualrobot.Client) -> None:
    from virtualrobot_apps.bridges.modbus import ModbusClient, ModbusServer

    settings = "modbus: {unit: 5, baud_rate: 115200, parity: none}\ntimeout_seconds: 5\n"
    slave = mapping("modbus", entries("modbus", False), serves=True, more=settings)
    master = mapping("modbus", entries("modbus", True), more=f"{settings}connected: there\n")
    with (
        joined_terminals() as (one, other),
        running(client, slave, ModbusServer(slave, f"rtu://{one}")),
        running(client, master, ModbusClient(master, f"rtu://{other}")),
    ):
        check_values(client)


@pytest.mark.long
def test_opc_ua_both_ends(client: virtualrobot.Client) -> None:
    from virtualrobot_apps.bridges.opcua import OpcUaClient, OpcUaServer

    url = f"opc.tcp://127.0.0.1:{free_port()}"
    server = mapping("opcua", entries("opcua", False), serves=True)
    reader = mapping("opcua", entries("opcua", True), more="connected: there\ntimeout_seconds: 5\n")
    with running(client, reader, OpcUaClient(reader, url)) as said:
        with running(client, server, OpcUaServer(server, url)):
            check_values(client)
        client.signals.wait_for("there", False, timeout=GUARD)
        with running(client, server, OpcUaServer(server, url)):
            client.signals["start"] = True
            client.signals.wait_for("there", timeout=GUARD)
            client.signals.wait_for("started", timeout=GUARD)
    assert sum("connected" in line for line in said) == 2, said


@pytest.mark.long
def test_a_bare_opc_ua_client_writes(client: virtualrobot.Client) -> None:
    """NaN and values out of range are told and not taken; nodes are typed, and what goes out is read only."""
    from asyncua import ua
    from asyncua.client.client import Client
    from virtualrobot_apps.bridges.opcua import OpcUaServer

    url = f"opc.tcp://127.0.0.1:{free_port()}"
    mapped = """
{signal: read speed, direction: in, node: ns=2;s=speed, type: float64}
{signal: start, direction: out, node: ns=2;s=start}
"""
    read = mapping("opcua", mapped, serves=True, more="connected: there\n")

    async def write() -> list[object]:
        async with Client(url) as bare:
            speed, start = bare.get_node("ns=2;s=speed"), bare.get_node("ns=2;s=start")
            await speed.write_value(ua.DataValue(ua.Variant(float("nan"), ua.VariantType.Double)))
            await speed.write_value(ua.DataValue(ua.Variant(2.5, ua.VariantType.Double)))
            refused: list[object] = []
            for node, value in ((start, True), (speed, True)):
                try:
                    await node.write_value(ua.DataValue(ua.Variant(value, ua.VariantType.Boolean)))
                except ua.UaError as error:
                    refused.append(type(error).__name__)
            return [*refused, await start.read_value()]

    client.signals["start"] = True
    with running(client, read, OpcUaServer(read, url)) as said:
        client.signals.wait_for("there", timeout=GUARD)
        told = asyncio.run(write())
        client.signals.wait_for("read speed", 2.5, timeout=GUARD)
    assert told == ["BadUserAccessDenied", "BadTypeMismatch", True]
    assert any("'read speed' (ns=2;s=speed) is not taken: nan is no finite number" in line for line in said), said


@pytest.mark.long
def test_mqtt_both_ways_over_a_broker(client: virtualrobot.Client) -> None:
    from virtualrobot_apps.bridges.mqtt import MqttClient

    from tests.apps.mqtt_broker import Broker

    broker = Broker()
    url = f"mqtt://127.0.0.1:{broker.port}"
    out = mapping("mqtt", entries("mqtt", False))
    read = mapping("mqtt", entries("mqtt", True), more="connected: there\n")
    with running(client, read, MqttClient(read, url)) as said, running(client, out, MqttClient(out, url)):
        check_values(client)
        broker.freeze()
        client.signals.wait_for("there", False, timeout=GUARD)
        broker.close()
        broker = Broker(broker.port)
        client.signals["start"] = True
        client.signals.wait_for("there", timeout=GUARD)
        client.signals.wait_for("started", timeout=GUARD)
    broker.close()
    assert any("lost: the broker is gone" in line for line in said), said


def test_the_command_checks_and_tells_what_is_wrong(
    client: virtualrobot.Client, kernel: KernelProcess, tmp_path: Path
) -> None:
    file = tmp_path / "plc.yaml"
    file.write_text("schema_version: 1\nsignals:\n- {signal: start, direction: in, address: coil 1}\n", "utf-8")

    def said(*arguments: str) -> tuple[int, str]:
        done: Any = CliRunner().invoke(command, [*arguments, "--address", kernel.address])
        return done.exit_code, f"{done.output}{done.exception or ''}"

    code, output = said("modbus", str(file), "--connect", "tcp://127.0.0.1:5020", "--check")
    assert (code, output) == (0, f"{file} fits: 1 signals\n")
    assert "say --connect URL or --serve URL" in said("modbus", str(file))[1]
    assert "a bridge is no broker of MQTT" in said("mqtt", str(file), "--serve", "mqtt://127.0.0.1")[1]
    assert "there is no field 'address'" in said("mqtt", str(file), "--connect", "mqtt://127.0.0.1")[1]
    assert "is neither tcp://HOST:PORT nor rtu:" in said("modbus", str(file), "--connect", "127.0.0.1:502")[1]


@pytest.mark.long
@pytest.mark.parametrize("protocol", ["modbus", "opcua"])
def test_a_port_that_is_taken_is_told(client: virtualrobot.Client, protocol: str) -> None:
    read = mapping(protocol, entries(protocol, False), serves=True, more="connected: there\n")
    scheme = {"modbus": "tcp", "opcua": "opc.tcp"}[protocol]
    with socket.create_server(("127.0.0.1", 0)) as listening:
        url = f"{scheme}://127.0.0.1:{listening.getsockname()[1]}"
        client.signals["there"] = True
        with running(client, read, peer_of(protocol, read, None, url)) as said:
            client.signals.wait_for("there", False, timeout=GUARD)
            listening.close()
            client.signals.wait_for("there", timeout=GUARD)
    assert "it cannot be served there" in said[0] and said[-1].endswith(": connected"), said


@pytest.mark.long
@pytest.mark.parametrize("name", ["bridge", "connections"])
def test_an_interrupt_ends_a_command(
    client: virtualrobot.Client, kernel: KernelProcess, tmp_path: Path, name: str
) -> None:
    file = tmp_path / "io.yaml"
    words = {
        "bridge": "connected: there\nsignals:\n- {signal: started, direction: in, address: coil 1}\n",
        "connections": "connections: {there: {not: start}}\n",
    }
    file.write_text(f"schema_version: 1\n{words[name]}", "utf-8")
    more = ["modbus", str(file), "--serve", f"tcp://127.0.0.1:{free_port()}"] if name == "bridge" else [str(file)]
    line = [sys.executable, "-m", "virtualrobot", name, *more, "--address", kernel.address]
    with subprocess.Popen(line, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        client.signals.wait_for("there", timeout=GUARD)
        process.send_signal(signal.SIGINT)
        output, _ = process.communicate(timeout=GUARD)
    assert process.returncode == 130, output
    assert "Traceback" not in output


def test_a_file_is_checked_without_a_url(client: virtualrobot.Client, kernel: KernelProcess, tmp_path: Path) -> None:
    """A file's mistake is told first; a bridge that is to run names one end."""
    file = tmp_path / "plc.yaml"

    def told(*more: str) -> tuple[int, str]:
        line = [sys.executable, "-m", "virtualrobot", "bridge", "modbus", str(file), *more, "--address", kernel.address]
        done = subprocess.run(line, capture_output=True, text=True, timeout=GUARD)
        return done.returncode, done.stdout + done.stderr

    code, said = told("--check")
    assert code == 1 and str(file) in said, said
    file.write_text("schema_version: 1\nsignals:\n- {signal: opened, direction: in, address: coil 1}\n", "utf-8")
    assert told("--check")[0] == 1
    client.signals.create("opened", False)
    assert told("--check") == (0, f"{file} fits: 1 signals\n")
    assert "say --connect URL or --serve URL" in told()[1]
