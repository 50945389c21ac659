"""A bare PLC: `python plc_server.py opcua|modbus` serves two booleans, and copies one to the other each 10 ms."""

from __future__ import annotations

import asyncio
import socket
import sys

CYCLE_SECONDS = 0.01


def free_port() -> int:
    """Return a port at which nobody listens."""
    with socket.create_server(("127.0.0.1", 0)) as listening:
        return listening.getsockname()[1]


async def opcua() -> None:
    """Serve OPC UA: ns=2;s=ask is copied to ns=2;s=answer."""
    from asyncua import ua
    from asyncua.server.server import Server

    server = Server()
    await server.init()
    url = f"opc.tcp://127.0.0.1:{free_port()}"
    server.set_endpoint(url)
    server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
    await server.register_namespace("urn:plc")
    ask, answer = [await server.nodes.objects.add_variable(f"ns=2;s={name}", name, False) for name in ("ask", "answer")]
    await ask.set_writable()
    async with server:
        print(f"listening on {url}", flush=True)
        while True:
            await answer.write_value(await ask.read_value())
            await asyncio.sleep(CYCLE_SECONDS)


async def modbus() -> None:
    """Serve Modbus: holding register 0 is copied to holding register 1."""
    from pymodbus.server import ModbusTcpServer
    from pymodbus.simulator import DataType, SimData, SimDevice

    port = free_port()
    device = SimDevice(1, simdata=SimData(0, count=2, datatype=DataType.REGISTERS))
    server = ModbusTcpServer(device, address=("127.0.0.1", port))
    await server.serve_forever(background=True)
    print(f"listening on tcp://127.0.0.1:{port}", flush=True)
    while True:
        values = await server.async_getValues(1, 3, 0, 1)
        await server.async_setValues(1, 16, 1, values)
        await asyncio.sleep(CYCLE_SECONDS)


if __name__ == "__main__":
    asyncio.run({"opcua": opcua, "modbus": modbus}[sys.argv[1]]())
