"""Modbus TCP and RTU: master (client) and slave (server), by pymodbus."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable, Mapping
from itertools import pairwise
from urllib.parse import urlsplit

from pymodbus import FramerType
from pymodbus.client import AsyncModbusSerialClient, AsyncModbusTcpClient
from pymodbus.constants import ExcCodes
from pymodbus.exceptions import ModbusException
from pymodbus.server import ModbusSerialServer, ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice
from virtualrobot.errors import InvalidArgumentError

from virtualrobot_apps.bridges.mapping import READ_ONLY, TABLES, BridgeMapping, Entry
from virtualrobot_apps.bridges.peer import Peer, PeerError
from virtualrobot_apps.bridges.words import Raw, from_registers, to_registers

MOST_WORDS = {"coil": 2000, "discrete_input": 2000, "holding_register": 125, "input_register": 125}
"""Most bits or registers of one request, by the Modbus specification."""

_TABLE_OF_FUNCTION = {
    **{1: "coil", 5: "coil", 15: "coil", 2: "discrete_input", 4: "input_register"},
    **{code: "holding_register" for code in (3, 6, 16, 22, 23)},
}


def _place(url: str, usual_port: int = 502) -> tuple[str, int] | str:
    """Return host and port, or the name of a serial line; raise InvalidArgumentError for what is neither."""
    parts = urlsplit(url)
    try:
        if parts.scheme == "tcp" and parts.hostname:
            return parts.hostname, parts.port if parts.port is not None else usual_port
    except ValueError as error:
        raise InvalidArgumentError(f"{url!r}: {error}") from error
    if parts.scheme == "rtu" and parts.path + parts.netloc:
        return parts.netloc + parts.path
    raise InvalidArgumentError(f"{url!r} is neither tcp://HOST:PORT nor rtu:///dev/ttyUSB0 (rtu://COM3)")


def blocks(entries: Iterable[Entry], most: Mapping[str, int] = MOST_WORDS) -> list[list[Entry]]:
    """Return entries in groups that one request reaches: of one table, and without a gap between their addresses."""
    ordered = sorted(entries, key=lambda entry: (TABLES.index(entry.table), entry.number))
    found = [ordered[:1]] if ordered else []
    for before, entry in pairwise(ordered):
        adjacent = (before.table, before.number + before.words) == (entry.table, entry.number)
        if adjacent and entry.number + entry.words - found[-1][0].number <= most[entry.table]:
            found[-1].append(entry)
        else:
            found.append([entry])
    return found


def cells_of(block: list[Entry], values: Mapping[Entry, Raw]) -> list[int]:
    """Return the bits or registers of a block."""
    return [word for entry in block for word in words_of(entry, values[entry])]


def words_of(entry: Entry, raw: Raw) -> list[int]:
    """Return the registers, or the one bit, of a value."""
    return [int(bool(raw))] if entry.type == "boolean" else to_registers(entry, raw)


def value_of(entry: Entry, words: list[int]) -> Raw:
    """Return the value of registers, or of one bit."""
    return bool(words[0]) if entry.type == "boolean" else from_registers(entry, words)


class ModbusClient(Peer):
    """Master that polls a slave; what is not there, refuses or is silent once is an error at once."""

    def __init__(self, mapping: BridgeMapping, url: str) -> None:
        """Talk to `tcp://HOST:PORT` or over the serial line `rtu:///dev/...`."""
        self.name = url
        self._mapping, self._place = mapping, _place(url)
        self._blocks = blocks(entry for entry in mapping.entries if entry.incoming)
        self._client: AsyncModbusTcpClient | AsyncModbusSerialClient | None = None
        self._lock = asyncio.Lock()
        self._first = True

    async def open(self) -> None:
        """Connect."""
        timeout = self._mapping.timeout
        # Reconnecting is the bridge's, which says so; and a request that is not answered is not asked thrice more.
        again = {"reconnect_delay": 0, "retries": 0, "timeout": timeout}
        if isinstance(self._place, tuple):
            host, port = self._place
            self._client = AsyncModbusTcpClient(host, port=port, **again)  # type: ignore[arg-type]
        else:
            baud, parity, stop = self._mapping.serial
            self._client = AsyncModbusSerialClient(
                self._place,
                baudrate=baud,
                parity=parity,
                stopbits=stop,
                **again,  # type: ignore[arg-type]
            )
        try:
            connected = await asyncio.wait_for(self._client.connect(), timeout)
        except (OSError, TimeoutError, ModbusException) as error:
            raise PeerError(f"nobody answers: {error or 'silent'}") from error
        if not connected:  # pymodbus writes the reason to its log alone
            ask = "does the host listen" if isinstance(self._place, tuple) else "is there such a port, and is it free"
            raise PeerError(f"nobody answers there; {ask}?")
        self._first = True

    async def read(self) -> dict[Entry, object]:
        """Wait for the next cycle and read all that comes in."""
        if not self._first:
            await asyncio.sleep(self._mapping.cycle)
        self._first = False
        found: dict[Entry, object] = {}
        for block in self._blocks:
            start, end = block[0].number, block[-1].number + block[-1].words
            words = await self._ask(f"read_{block[0].table}s", start, block, count=end - start)
            for entry in block:
                at = entry.number - start
                found[entry] = value_of(entry, words[at : at + entry.words])
        return found

    async def write(self, values: Mapping[Entry, Raw]) -> None:
        """Write."""
        for block in blocks(values, {"coil": 1968, "holding_register": 123}):
            words = cells_of(block, values)
            if block[0].table == "coil":
                await self._ask("write_coils", block[0].number, block, values=list(map(bool, words)))
            else:
                await self._ask("write_registers", block[0].number, block, values=words)

    async def close(self) -> None:
        """Disconnect."""
        if self._client is not None:
            self._client.close()
            self._client = None

    async def _ask(self, what: str, start: int, block: list[Entry], **options: object) -> list[int]:
        if self._client is None:
            raise PeerError("it is not connected")
        places = block[0].place if len(block) == 1 else f"{block[0].place} to {block[-1].number}"
        try:
            async with self._lock:
                ask = getattr(self._client, what)
                answer = await asyncio.wait_for(
                    ask(start, device_id=self._mapping.unit, **options), 2 * self._mapping.timeout
                )
        except (ModbusException, OSError, TimeoutError) as error:
            raise PeerError(f"{places}: no answer within {self._mapping.timeout:g} s ({error})") from error
        if answer.isError():
            code = answer.exception_code
            known = code in list(ExcCodes)
            raise PeerError(f"{places}: refused with code {code}{' ' + ExcCodes(code).name if known else ''}")
        words = answer.bits if block[0].table in TABLES[:2] else answer.registers
        wanted = options.get("count")
        if isinstance(wanted, int) and len(words) < wanted:
            raise PeerError(f"{places}: {len(words)} values came, and {wanted} were asked for")
        return list(map(int, words))


class _Cells:
    """Tables that a slave holds: what is mapped, and nothing else; masters write what comes in."""

    def __init__(self, mapping: BridgeMapping, written: asyncio.Queue[dict[Entry, object]]) -> None:
        self.simdevices: list[SimDevice] = []
        self._unit, self._written = mapping.unit, written
        self._entry = {(one.table, one.number + word): one for one in mapping.entries for word in range(one.words)}
        self._words: dict[tuple[str, int], int] = dict.fromkeys(self._entry, 0)

    def device_ids(self) -> list[int]:
        """Return the units that it is."""
        return [self._unit]

    async def async_getValues(self, device_id: int, func_code: int, address: int, count: int = 1) -> object:
        """Return bits or registers, or a refusal."""
        table = _TABLE_OF_FUNCTION[func_code]
        if device_id != self._unit:
            return ExcCodes.GATEWAY_NO_RESPONSE
        places = [(table, address + number) for number in range(count)]
        if any(place not in self._words for place in places):
            return ExcCodes.ILLEGAL_ADDRESS
        words = [self._words[place] for place in places]
        return list(map(bool, words)) if table in TABLES[:2] else words

    async def async_setValues(self, device_id: int, func_code: int, address: int, values: list[int]) -> object:
        """Take what a master writes, all or nothing, or return a refusal."""
        table = _TABLE_OF_FUNCTION[func_code]
        places = [(table, address + number) for number in range(len(values))]
        if device_id not in (self._unit, 0):
            return ExcCodes.GATEWAY_NO_RESPONSE
        if table in READ_ONLY or any(place not in self._entry or not self._entry[place].incoming for place in places):
            return ExcCodes.ILLEGAL_ADDRESS
        self._words.update(zip(places, map(int, values), strict=True))
        touched = {self._entry[place]: None for place in places}
        self._written.put_nowait({entry: self.value(entry) for entry in touched})
        return None

    def value(self, entry: Entry) -> Raw:
        """Return what an entry's cells hold."""
        return value_of(entry, [self._words[(entry.table, entry.number + word)] for word in range(entry.words)])

    def put(self, entry: Entry, raw: Raw) -> None:
        """Let masters read a value."""
        for number, word in enumerate(words_of(entry, raw)):
            self._words[(entry.table, entry.number + number)] = word


class ModbusServer(Peer):
    """Slave whose tables masters read and write; each write is told, so that none is lost."""

    def __init__(self, mapping: BridgeMapping, url: str) -> None:
        """Serve at `tcp://HOST:PORT` or on the serial line `rtu:///dev/...`."""
        self.name = url
        self._mapping, self._place = mapping, _place(url)
        self._server: ModbusTcpServer | ModbusSerialServer | None = None
        self._written: asyncio.Queue[dict[Entry, object]] = asyncio.Queue()
        self._cells = _Cells(mapping, self._written)

    @property
    def port(self) -> int:
        """Port that it serves at, once it is open."""
        transport = self._server.transport if self._server is not None else None
        return transport.sockets[0].getsockname()[1] if transport is not None else 0  # type: ignore[attr-defined]

    async def open(self) -> None:
        """Begin to serve."""
        nothing = SimDevice(self._mapping.unit, simdata=SimData(0, datatype=DataType.REGISTERS))
        if isinstance(self._place, tuple):
            self._server = ModbusTcpServer(nothing, address=self._place)
        else:
            baud, parity, stop = self._mapping.serial
            self._server = ModbusSerialServer(
                nothing, framer=FramerType.RTU, port=self._place, baudrate=baud, parity=parity, stopbits=stop
            )
        # The tables of pymodbus tell nobody when a master writes.
        self._server.context = self._cells  # type: ignore[assignment]
        try:
            await self._server.serve_forever(background=True)
        except (OSError, RuntimeError, ModbusException) as error:
            raise PeerError(f"it cannot be served there: {error}") from error

    async def read(self) -> dict[Entry, object]:
        """Wait for the next request that writes."""
        return await self._written.get()

    async def write(self, values: Mapping[Entry, Raw]) -> None:
        """Let masters read values."""
        for entry, raw in values.items():
            self._cells.put(entry, raw)

    async def close(self) -> None:
        """Serve no more."""
        if self._server is not None:
            await self._server.shutdown()
            self._server = None
